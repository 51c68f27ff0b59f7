"""Fields at depth under a load wave on the surface of a stack: one sweep up, one sweep down.

Per wavenumber k the sagittal state y = (k u_l, k u_z, s_lz, s_zz) obeys dy/dz = k A y (see `layered`), the transverse one
(k u_t, s_tz) dy/dz = k [[0, 1/mu], [mu, 0]] y. On the way up each layer gets the states S that its lower face admits
(displacement = flexibility times traction, or no shear traction on a sliding interface) and V, the tractions that they become
at its upper face, exp(-kh) divided out. On the way down only the tractions t travel:

    state(z) = exp(-k (z - z_top)) [exp(-A k (z_bottom - z)) S] V^-1 t(z_top).

Nothing grows, so it is stable for every k h, nu = 1/2 and sliding interfaces included. Graded layers are crossed in short
steps of order 8. Stresses are positive in tension; u_z, s_zz go like cos(k l) and u_l, s_lz like sin(k l), l along the wave.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import scipy

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.compliance.layered import SATURATION, depth_functions, sagittal_system
from flatpunch.media import GradedLayer, HalfSpace, Layer, Medium, PowerLawHalfSpace


@dataclass(frozen=True, slots=True)
class Waves:
    """Fields at depths z under unit load waves of wavenumbers k.

    Attributes
    ----------
    normal, shear : ndarray, shape (6, nk, nz)
        k u_l, k u_z [1/Pa], s_lz, s_zz, (s_ll + s_nn)/2, (s_ll - s_nn)/2 [-] under s_zz = -1 (pressure 1), and under
        s_lz = 1; n is across the wave.
    transverse : ndarray, shape (3, nk, nz)
        k u_t [1/Pa], s_tz, and mu k u_t (s_lt without its phase) [-] under s_tz = 1.
    """

    normal: Array
    shear: Array
    transverse: Array


def waves_at(medium: HalfSpace | Medium, k: Array, z: Array, layer: Indices, *, shear: bool = True) -> Waves:
    """Fields at depth under unit load waves.

    Parameters
    ----------
    medium : HalfSpace or Medium
        The body.
    k : ndarray, shape (nk,)
        Wavenumbers [1/m], > 0.
    z : ndarray, shape (nz,)
        Depths [m], >= 0.
    layer : ndarray of int, shape (nz,)
        The layer that each depth belongs to, counted from the surface; len(layers) is the base.
    shear : bool
        Whether the fields under shear loads are wanted too; otherwise `shear` and `transverse` are empty.

    Returns
    -------
    Waves
    """
    parts = _parts(medium, k, z, layer)
    base = medium.base if isinstance(medium, Medium) else medium
    elastic = base if isinstance(base, HalfSpace) else None
    scale = _first_shear_modulus(medium)
    _sweep_up(parts, elastic, k, scale)
    count = len(medium.layers) if isinstance(medium, Medium) else 0
    states, across = _sweep_down(parts, elastic, k, z, np.flatnonzero(layer == count), scale, shear)
    mu, nu = constants_at(medium, z, layer)
    return named_waves(states, across, mu / scale, nu, scale)


def interfaces(medium: HalfSpace | Medium | PowerLawHalfSpace) -> Array:
    """Depths of the lower faces of all layers [m], shape (layers,)."""
    layers = medium.layers if isinstance(medium, Medium) else ()
    return np.cumsum([each.thickness for each in layers]) if layers else np.zeros(0)


def constants_at(medium: HalfSpace | Medium, z: Array, layer: Indices) -> tuple[Array, Array]:
    """Shear modulus [Pa] and Poisson ratio at depths z of the given layers, shape (nz,) each."""
    mu, nu = np.empty((2, z.size))
    layers = medium.layers if isinstance(medium, Medium) else ()
    tops = np.concatenate([[0.0], interfaces(medium)])
    for i in np.unique(layer):
        here = layer == i
        body = layers[i] if i < len(layers) else (medium.base if isinstance(medium, Medium) else medium)
        if isinstance(body, GradedLayer):
            own = np.clip(z[here] - tops[i], 0.0, body.thickness)
            young, poisson = body.young_at(own), body.poisson_at(own)
        elif isinstance(body, (Layer, HalfSpace)):
            young, poisson = np.full(here.sum(), body.young), np.full(here.sum(), body.poisson)
        else:  # a rigid base has no stresses; depths inside it are refused by the caller
            young, poisson = np.full((2, here.sum()), np.nan)
        mu[here], nu[here] = young / (2 * (1 + poisson)), poisson
    return mu, nu


@dataclass
class _Part:
    """A homogeneous layer, or one step through a graded one, and what the sweep up leaves there."""

    layer: int
    top: float
    thickness: float
    bonded: bool
    shear: float
    poisson: float
    graded: GradedLayer | None = None
    origin: float = 0.0
    depths: Indices = field(default_factory=lambda: np.zeros(0, dtype=int))
    states: Array = field(default_factory=lambda: np.zeros(0))
    across: Array = field(default_factory=lambda: np.zeros(0))
    raised: Array = field(default_factory=lambda: np.zeros(0))
    lifted: Array = field(default_factory=lambda: np.zeros(0))


def _parts(medium: HalfSpace | Medium, k: Array, z: Array, layer: Indices) -> list[_Part]:
    """Layers from the surface down, graded ones in steps that begin and end at the given depths."""
    parts: list[_Part] = []
    top = 0.0
    for i, body in enumerate(medium.layers if isinstance(medium, Medium) else ()):
        mine = np.flatnonzero(layer == i)
        if isinstance(body, Layer):
            shear = body.young / (2 * (1 + body.poisson))
            parts.append(_Part(i, top, body.thickness, body.bonded, shear, body.poisson, depths=mine))
        else:
            parts += _graded_parts(body, i, top, k, z, mine)
        top += body.thickness
    return parts


def _graded_parts(body: GradedLayer, i: int, top: float, k: Array, z: Array, mine: Indices) -> list[_Part]:
    bottom = top + body.thickness
    ends = [top]
    first = 0.5 / float(k.max())
    while ends[-1] < bottom:
        # steps of a tenth of the depth: order 8 leaves 1e-9 of what reaches that depth; 24 at least, as the law varies over the
        # thickness
        step = min(max(0.1 * ends[-1], first), body.thickness / 24)
        ends.append(min(ends[-1] + step, bottom))
    wanted = np.clip(z[mine], top, bottom)
    cuts = np.unique(np.concatenate([ends, wanted, top + np.asarray(body.breaks)]))
    # steps that differ from none by rounding only
    cuts = cuts[np.concatenate([[True], np.diff(cuts) > 1e-12 * bottom])]
    cuts[-1] = bottom
    parts = []
    for upper, lower in pairwise(cuts):
        own = np.array([upper - top])
        poisson = float(body.poisson_at(own)[0])
        shear = float(body.young_at(own)[0]) / (2 * (1 + poisson))
        bonded = body.bonded or lower < bottom
        here = (wanted >= upper - 1e-12 * bottom) & (wanted < lower - 1e-12 * bottom)
        parts.append(_Part(i, upper, lower - upper, bonded, shear, poisson, body, top, mine[here]))
    # the lower face itself belongs to the last step
    parts[-1].depths = np.concatenate([parts[-1].depths, mine[wanted >= bottom - 1e-12 * bottom]])
    return parts


def _first_shear_modulus(medium: HalfSpace | Medium) -> float:
    zero = np.zeros(1)
    return float(constants_at(medium, zero, np.zeros(1, dtype=int))[0][0])


def _sweep_up(parts: list[_Part], base: HalfSpace | None, k: Array, scale: float) -> None:
    """Give each part the states that its lower face admits: sagittal (4, 2, nk), transverse (2, nk)."""
    if base is None:
        flexibility, transverse = np.zeros((2, 2, k.size)), np.zeros(k.size)
    else:
        flexibility, transverse = _own_flexibility(base.young / (2 * (1 + base.poisson)) / scale, base.poisson, k.size)
    for part in reversed(parts):
        part.states, part.across = _admitted(part.bonded, flexibility, transverse)
        hidden = _hidden(part, k)
        own, own_across = _own_flexibility(part.shear / scale, part.poisson, k.size)
        if hidden.any():
            part.states[:, :, hidden] = _admitted(True, own, own_across)[0][:, :, hidden]
            part.across[:, hidden] = _admitted(True, own, own_across)[1][:, hidden]
        part.raised, part.lifted = _raised(part, k, 0.0, scale)
        flexibility, transverse = _divided(part.raised[:2], part.raised[2:]), part.lifted[0] / part.lifted[1]
        flexibility[:, :, hidden], transverse[hidden] = own[:, :, hidden], own_across[hidden]


def _hidden(part: _Part, k: Array) -> Flags:
    """Where the part hides what lies below it."""
    # k times the step above which the wave no longer reaches that depth (k z > 30): the layer's own half-space takes its place
    return np.asarray(k * part.thickness > (SATURATION if part.graded is None else 1.5))


def _own_flexibility(mu: float, nu: float, count: int) -> tuple[Array, Array]:
    """Flexibility of a half-space: fields that decay with depth."""
    own = np.array([[nu - 1, 0.5 - nu], [0.5 - nu, nu - 1]]) / mu
    return np.repeat(own[:, :, None], count, axis=2), np.full(count, -1 / mu)


def _admitted(bonded: bool, flexibility: Array, transverse: Array) -> tuple[Array, Array]:
    """States at a lower face: [H; 1] where it sticks, free sliding (1, 0, 0, 0) and (0, H_22, 0, 1) where it slides."""
    count = transverse.size
    states, across = np.zeros((4, 2, count)), np.zeros((2, count))
    if bonded:
        states[:2] = flexibility
        states[2, 0] = states[3, 1] = 1
        across[0], across[1] = transverse, 1
    else:
        states[0, 0] = states[3, 1] = 1
        states[1, 1] = flexibility[1, 1]
        across[0] = 1
    return states, across


def _raised(part: _Part, k: Array, depth: float | Array, scale: float) -> tuple[Array, Array]:
    """States of the lower face as they are at depths below the upper one, times exp(-k height); (4, 2, nk) or (4, 2, nk, nz).

    Below the depth that a wave reaches, the layer is its own half-space: heights are counted from there. Counted from the lower
    face of a layer a million times as thick, they would cost all digits.
    """
    if part.graded is not None:
        # where the wave does not reach the state stays what it is in the layer's own half-space
        return _stepped(part, np.where(_hidden(part, k), 0.0, k * part.thickness), scale)
    x = np.minimum(k * part.thickness, SATURATION)
    if np.ndim(depth):
        x = np.maximum(x[:, None] - np.multiply.outer(k, depth), 0.0)
    states, sideways = part.states, part.across
    mu, nu = part.shear / scale, part.poisson
    system = sagittal_system(mu, nu)
    nilpotent = system @ system - np.eye(4)
    turned = [states, *(_times(a, states) for a in (system, nilpotent, system @ nilpotent))]
    if x.ndim == 2:
        turned, sideways = [each[..., None] for each in turned], sideways[..., None]
    cosh, half, sinh, difference = depth_functions(x)
    # (A^2 - 1)^2 = 0: exp(-Ax) = cosh x + (x/2) sinh x P - A [sinh x + (x cosh x - sinh x) P/2], P = A^2 - 1
    raised = cosh * turned[0] + half * turned[2] - sinh * turned[1] - difference * turned[3]
    u, s = sideways
    return raised, np.stack([cosh * u - sinh * s / mu, cosh * s - sinh * mu * u])


def _stepped(part: _Part, x: Array, scale: float) -> tuple[Array, Array]:
    """One Runge-Kutta step (Dormand and Prince, order 8) up through a slice of a graded layer."""
    assert part.graded is not None
    rule = scipy.integrate.DOP853
    z = part.top - part.origin + part.thickness * (1 - rule.C[:12])
    nu = part.graded.poisson_at(z)
    mu = part.graded.young_at(z) / (2 * (1 + nu)) / scale
    slopes, lateral = np.empty((12, *part.states.shape)), np.empty((12, *part.across.shape))
    for i in range(12):
        y = part.states + x * _times(rule.A[i : i + 1, :i], slopes[:i])[0]
        w = part.across + x * _times(rule.A[i : i + 1, :i], lateral[:i])[0]
        slopes[i] = -_times(sagittal_system(float(mu[i]), float(nu[i])), y)
        lateral[i] = -np.stack([w[1] / mu[i], mu[i] * w[0]])
    decay = np.exp(-x)
    states = part.states + x * _times(rule.B[None], slopes)[0]
    return states * decay, (part.across + x * _times(rule.B[None], lateral)[0]) * decay


def _times(matrix: Array, states: Array) -> Array:
    """`matrix` (m, n) times states (n, ...)."""
    rest = states.shape[1:]
    return np.asarray((matrix @ states.reshape(len(states), math.prod(rest))).reshape(len(matrix), *rest))


def _divided(upper: Array, lower: Array) -> Array:
    """`upper` times the inverse of `lower`, both (2, 2, nk)."""
    return np.asarray(np.einsum("ijn,jkn->ikn", upper, _inverse(lower)))


def _inverse(lower: Array) -> Array:
    determinant = lower[0, 0] * lower[1, 1] - lower[0, 1] * lower[1, 0]
    return np.asarray(np.array([[lower[1, 1], -lower[0, 1]], [-lower[1, 0], lower[0, 0]]]) / determinant)


def _sweep_down(
    parts: list[_Part], base: HalfSpace | None, k: Array, z: Array, below: Indices, scale: float, shear: bool
) -> tuple[Array, Array]:
    """States at all depths from the tractions that the loads have at the surface."""
    # notation: columns are the two loads, s_zz = -1 and s_lz = 1
    loads = 2 if shear else 1
    traction = np.zeros((2, loads, k.size))
    traction[1, 0] = -1
    traction[0, 1:] = 1
    sideways = np.ones(k.size)
    states, across = np.zeros((4, loads, k.size, z.size)), np.zeros((2, k.size, z.size))
    for part in parts:
        raised, lifted = part.raised, part.lifted
        amplitude = np.einsum("ijn,jkn->ikn", _inverse(raised[2:]), traction)
        wave = sideways / lifted[1]
        if part.depths.size and part.graded is None:
            down = np.clip(z[part.depths] - part.top, 0.0, part.thickness)
            y, w = _raised(part, k, down, scale)
            decay = np.exp(-k[:, None] * down)
            states[..., part.depths] = np.einsum("ijnz,jkn->iknz", y, amplitude) * decay
            across[..., part.depths] = w * (wave[:, None] * decay)
        elif part.depths.size:
            # steps through a graded layer begin or end at these depths
            upper = z[part.depths] - part.top < part.thickness / 2
            if upper.any():
                states[..., part.depths[upper]] = np.einsum("ijn,jkn->ikn", raised, amplitude)[..., None]
                across[..., part.depths[upper]] = (lifted * wave)[..., None]
            if not upper.all():
                decay = np.exp(-k * part.thickness)
                states[..., part.depths[~upper]] = (np.einsum("ijn,jkn->ikn", part.states, amplitude) * decay)[
                    ..., None
                ]
                across[..., part.depths[~upper]] = (part.across * wave * decay)[..., None]
        decay = np.exp(-k * part.thickness)
        traction = np.einsum("ijn,jkn->ikn", part.states[2:], amplitude) * decay
        sideways = part.across[1] * wave * decay
    if base is not None and below.size:
        top = parts[-1].top + parts[-1].thickness if parts else 0.0
        states[..., below], across[..., below] = _in_base(base, k, z[below] - top, traction, sideways, scale)
    return states, across


def _in_base(
    base: HalfSpace, k: Array, depth: Array, traction: Array, sideways: Array, scale: float
) -> tuple[Array, Array]:
    """States in the base: exp(A x) = exp(-x) (1 + x (A + 1)) on the fields that decay."""
    mu, nu = base.young / (2 * (1 + base.poisson)) / scale, base.poisson
    flexibility, _ = _own_flexibility(mu, nu, k.size)
    start = np.concatenate([np.einsum("ijn,jkn->ikn", flexibility, traction), traction])
    turned = _times(sagittal_system(mu, nu) + np.eye(4), start)
    x = k[:, None] * np.maximum(depth, 0.0)
    decay = np.exp(-x)
    across = np.stack([-sideways / mu, sideways])
    return (start[..., None] + x * turned[..., None]) * decay, across[..., None] * decay


def named_waves(states: Array, across: Array, mu: Array, nu: Array, scale: float) -> Waves:
    """Waves from states (4, loads, nk, nz) and transverse ones (2, nk, nz): in-plane stresses added, displacements scaled."""
    along, szz = states[0], states[3]
    difference = mu * along
    mean = (nu * szz + (1 + nu) * difference) / (1 - nu)
    fields = np.stack([along / scale, states[1] / scale, states[2], szz, mean, difference])
    transverse = np.stack([across[0] / scale, across[1], mu * across[0]])
    if states.shape[1] == 1:
        return Waves(fields[:, 0], np.zeros((6, 0, 0)), np.zeros((3, 0, 0)))
    return Waves(fields[:, 0], fields[:, 1], transverse)
