"""Fields at depth under a load wave on the surface of a stack: one sweep up, one sweep down.

Per wavenumber k the sagittal state y = (k u_l, k u_z, s_lz, s_zz) obeys dy/dz = k A y (see `layered`), the transverse one
(k u_t, s_tz) dy/dz = k [[0, 1/mu], [mu, 0]] y. On the way up each layer gets the states S that its lower face admits
(displacement = flexibility times traction, or no shear traction on a sliding interface) and V, the tractions that they become
at its upper face, exp(-kh) divided out. On the way down only the tractions t travel:

    state(z) = exp(-k (z - z_top)) [exp(-A k (z_bottom - z)) S] V^-1 t(z_top).

Nothing grows, so it is stable for every k h, nu = 1/2 and sliding interfaces included. Graded layers are crossed in short
steps of order 8, transversely isotropic ones by their own propagator (`transverse`). Stresses are positive in tension; u_z, s_zz
go like cos(k l) and u_l, s_lz like sin(k l), l along the wave.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from math import sqrt

import numpy as np
import scipy

from flatpunch._support.checks import ROUNDING, Array, Flags, Indices
from flatpunch.compliances.layered import SATURATION, depth_functions, states_below
from flatpunch.compliances.response import passed_across, stiffened, yielding, yielding_across
from flatpunch.compliances.stack import Decay, attenuation, interfaces, plane_at
from flatpunch.compliances.transverse import Sheet, Solid, divided, flexibility_of, inverse, system_of
from flatpunch.media import AnyLayer, Interface, Membrane, Stack
from flatpunch.media.plane import Plane, exponents, over

_CHANGE = 0.2
"""Largest relative change of a coefficient over a step through a graded layer: order 8 leaves 1e-9."""

_STEP = 0.08
"""Steps through a graded layer over the depth that a wave has come down: order 8 leaves 1e-10 of what reaches that depth; a tenth
of it leaves 1e-9."""


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


def waves_at(medium: Stack, k: Array, z: Array, layer: Indices, *, shear: bool = True) -> Waves:
    """Fields at depths z >= 0 [m], shape (nz,), under unit load waves of wavenumbers k > 0 [1/m], shape (nk,).

    `layer` is the layer of each depth, counted from the surface; len(layers) is the base. Without `shear` the fields under shear
    loads, `shear` and `transverse`, are empty.
    """
    # moduli and stresses over the shear modulus of the surface
    scale = float(1 / plane_at(medium, np.zeros(1), np.zeros(1, dtype=int)).shear[0])
    loads = 2 if shear else 1
    states, across = np.zeros((4, loads, k.size, z.size)), np.zeros((2, k.size, z.size))
    last = _last_reached(medium, k, z)
    for end in np.unique(last).tolist():
        here = last == end
        parts = _parts(medium, k[here], z, layer, end, scale)
        base = medium.parts[end] if end < len(medium.layers) else medium.base
        elastic = None if base.rigid else over(scale, base.plane)
        surface = _sweep_up(parts, elastic, k[here], scale)
        passed = _passed(medium.membrane, *surface, k[here], scale)
        below = np.flatnonzero(layer == end)
        states[:, :, here], across[:, here] = _sweep_down(parts, elastic, k[here], z, below, shear, passed)
    return named_waves(states, across, plane_at(medium, z, layer), scale)


def _last_reached(medium: Stack, k: Array, z: Array) -> Indices:
    """The homogeneous layer, or the base, that is a half-space to each wave, which does not return from below it to any z.

    They are rounded up to the base and to halves, quarters, ... of the layers above it, so that sweeps are few.
    """
    count = len(medium.layers)
    reached = attenuation(medium, z).max(initial=0.0) + SATURATION / k
    last = np.searchsorted(attenuation(medium, interfaces(medium)), reached, side="right")
    ends = np.array([i for i in range(count) if not medium.layers[i].varies] + [count])
    ends = ends[np.unique((ends.size - 1) // 2 ** np.arange(ends.size.bit_length() + 1))]
    return np.asarray(ends[np.searchsorted(ends, last)])


def decaying_waves(plane: Plane[float], k: Array, z: Array, *, shear: bool) -> Waves:
    """Fields at depths z under unit load waves on a half-space of material with these coefficients; arguments of `waves_at`."""
    scale = 1 / plane.shear
    states, across = _sweep_down([], over(scale, plane), k, z, np.arange(z.size), shear)
    return named_waves(states, across, Plane(*(np.full(z.size, each) for each in plane)), scale)


Passed = tuple[Array, Array]
"""Tractions below a membrane per those above it: along the wave (2, 2, nk), and across it (nk,)."""


@dataclass
class _Part:
    """A homogeneous layer, or one step through a graded one, and what the sweep up leaves there."""

    layer: int
    top: float
    thickness: float
    face: Interface
    plane: Plane[float]
    """Coefficients, at the upper face of a step, over the scale."""
    solid: Solid | None = None
    sheet: Sheet | None = None
    graded: AnyLayer | None = None
    origin: float = 0.0
    slow: float = 1.0
    fast: float = 1.0
    depths: Indices = field(default_factory=lambda: np.zeros(0, dtype=int))
    states: Array = field(default_factory=lambda: np.zeros(0))
    across: Array = field(default_factory=lambda: np.zeros(0))
    raised: Array = field(default_factory=lambda: np.zeros(0))
    lifted: Array = field(default_factory=lambda: np.zeros(0))
    passed: Passed = (np.zeros(0), np.zeros(0))


def _below(passed: Passed, traction: Array, sideways: Array) -> tuple[Array, Array]:
    """Tractions below a membrane, shapes (2, loads, nk) and (nk,), from those above it."""
    return np.einsum("ijn,jkn->ikn", passed[0], traction), passed[1] * sideways


def _parts(medium: Stack, k: Array, z: Array, layer: Indices, count: int, scale: float) -> list[_Part]:
    """The first `count` layers from the surface down, graded ones in steps that begin and end at the given depths."""
    parts: list[_Part] = []
    top = 0.0
    for i, body in enumerate(medium.layers[:count]):
        mine = np.flatnonzero(layer == i)
        if body.varies:
            above = float(attenuation(medium, np.array([top]))[0])
            parts += _graded_parts(body, i, top, above, k, z, mine, scale)
        else:
            plane = over(scale, body.plane)
            solid = None if body.isotropic else Solid(plane)
            parts.append(_Part(i, top, body.thickness, body.face, plane, solid, depths=mine))
        top += body.thickness
    return parts


def _graded_parts(
    body: AnyLayer, i: int, top: float, above: float, k: Array, z: Array, mine: Indices, scale: float
) -> list[_Part]:
    """Steps through a graded layer; `above` is the attenuation of all that lies over it [m]."""
    bottom, decay, (depths, varied) = top + body.thickness, Decay.of(body), _variation(body)
    ends = [top]
    while ends[-1] < bottom:
        # the reach is that of the slower rate, the step that of the faster one
        down = ends[-1] - top
        reach = max(_STEP * (above + float(decay.down_to(np.array(down)))), 0.5 / float(k.max()))
        step = reach / float(np.interp(down, decay.depths, decay.fast))
        steep = float(np.interp(np.interp(down, depths, varied) + _CHANGE, varied, depths)) - down
        ends.append(min(ends[-1] + min(step, steep), bottom))
    wanted = np.clip(z[mine], top, bottom)
    cuts = np.unique(np.concatenate([ends, wanted, top + np.asarray(body.breaks)]))
    # steps that differ from none by rounding only
    cuts = cuts[np.concatenate([[True], np.diff(cuts) > ROUNDING * bottom])]
    cuts[-1] = bottom
    planes = over(scale, body.plane_at(cuts[:-1] - top))
    slow, fast = (np.interp(cuts - top, decay.depths, each) for each in (decay.slow, decay.fast))
    parts = []
    for j, (upper, lower) in enumerate(pairwise(cuts)):
        plane = Plane(*(float(each[j]) for each in planes))
        # slides or springs are at the lower face of the layer alone
        face = Interface() if lower < bottom else body.face
        here = (wanted >= upper - ROUNDING * bottom) & (wanted < lower - ROUNDING * bottom)
        part = _Part(i, upper, lower - upper, face, plane, graded=body, origin=top, depths=mine[here])
        part.slow, part.fast = float(slow[j : j + 2].min()), float(fast[j : j + 2].max())
        parts.append(part)
    # the lower face itself belongs to the last step
    parts[-1].depths = np.concatenate([parts[-1].depths, mine[wanted >= bottom - ROUNDING * bottom]])
    return parts


def _variation(body: AnyLayer) -> tuple[Array, Array]:
    """Depths, denser at both faces, and the sum of all relative changes of the coefficients from the top down to there."""
    near = body.thickness * np.geomspace(1e-9, 1e-3, 100)
    depths = np.unique(np.concatenate([body.sampled_depths, near, body.thickness - near]))
    plane = body.plane_at(depths)
    product = exponents(plane)[1]
    logs = np.log([plane.shear, plane.stiffness, plane.across, product])
    changes = [*np.abs(np.diff(logs)), np.abs(np.diff(plane.coupling)) / product[1:]]
    return depths, np.append(0.0, np.cumsum(np.max(changes, axis=0)))


def _passed(membrane: Membrane | None, below: Array, across: Array, k: Array, scale: float) -> Passed:
    return stiffened(membrane, below, k, scale)[1], passed_across(membrane, across, k, scale)


def _sweep_up(parts: list[_Part], base: Plane[float] | None, k: Array, scale: float) -> tuple[Array, Array]:
    """Give each part the states that its lower face admits: sagittal (4, 2, nk), transverse (2, nk).

    Returns the flexibilities at the surface.
    """
    if base is None:
        flexibility, transverse = np.zeros((2, 2, k.size)), np.zeros(k.size)
    else:
        flexibility, transverse = _own_flexibility(base, k.size)
    for part in reversed(parts):
        part.passed = _passed(part.face.membrane, flexibility, transverse, k, scale)
        flexibility = yielding(part.face, flexibility, k, scale)
        if part.face:
            transverse = yielding_across(part.face, transverse, k, scale)
        part.states, part.across = _admitted(bool(part.face), flexibility, transverse)
        if part.solid is not None:
            part.sheet = Sheet(part.solid, part.thickness, k, part.states, part.across)
            flexibility, transverse = part.sheet.flexibility, part.sheet.flexibility_across
            continue
        hidden = _hidden(part, k)
        own, own_across = _own_flexibility(part.plane, k.size)
        if hidden.any():
            part.states[:, :, hidden] = _admitted(True, own, own_across)[0][:, :, hidden]
            part.across[:, hidden] = _admitted(True, own, own_across)[1][:, hidden]
        part.raised, part.lifted = (
            _raised(part, k, 0.0) if part.graded is None else _stepped(part, part.graded, k, scale)
        )
        flexibility, transverse = divided(part.raised[:2], part.raised[2:]), part.lifted[0] / part.lifted[1]
        flexibility[:, :, hidden], transverse[hidden] = own[:, :, hidden], own_across[hidden]
    return flexibility, transverse


def _hidden(part: _Part, k: Array) -> Flags:
    # a step is a share of the depth: the wave reaches neither where it does not cross the step
    return np.asarray(k * part.thickness * part.fast > (SATURATION if part.graded is None else _STEP * SATURATION))


def _own_flexibility(plane: Plane[float], count: int) -> tuple[Array, Array]:
    return np.repeat(flexibility_of(plane)[:, :, None], count, axis=2), np.full(
        count, -sqrt(plane.shear / plane.across)
    )


def _admitted(bonded: bool, flexibility: Array, transverse: Array) -> tuple[Array, Array]:
    """States at a lower face: [H; 1] where it sticks, free sliding (1, 0, 0, 0) and (0, H_22, 0, 1) where it slides."""
    ones = np.ones_like(transverse)
    across = np.stack([transverse, ones] if bonded else [ones, 0 * ones])
    return states_below(bonded, flexibility), across


def _raised(part: _Part, k: Array, depth: float | Array) -> tuple[Array, Array]:
    """States of the lower face as they are at depths below the upper one, times exp(-k height); (4, 2, nk) or (4, 2, nk, nz).

    Below the depth that a wave reaches, the layer is its own half-space: heights are counted from there. Counted from the lower
    face of a layer a million times as thick, they would cost all digits.
    """
    x = np.minimum(k * part.thickness, SATURATION)
    if np.ndim(depth):
        x = np.maximum(x[:, None] - np.multiply.outer(k, depth), 0.0)
    states, sideways = part.states, part.across
    mu, system = part.plane.across, system_of(part.plane)
    nilpotent = system @ system - np.eye(4)
    turned = [states, *(_times(a, states) for a in (system, nilpotent, system @ nilpotent))]
    if x.ndim == 2:
        turned, sideways = [each[..., None] for each in turned], sideways[..., None]
    cosh, half, sinh, difference = depth_functions(x)
    # (A^2 - 1)^2 = 0: exp(-Ax) = cosh x + (x/2) sinh x P - A [sinh x + (x cosh x - sinh x) P/2], P = A^2 - 1
    raised = cosh * turned[0] + half * turned[2] - sinh * turned[1] - difference * turned[3]
    u, s = sideways
    return raised, np.stack([cosh * u - sinh * s / mu, cosh * s - sinh * mu * u])


def _stepped(part: _Part, layer: AnyLayer, k: Array, scale: float) -> tuple[Array, Array]:
    """One Runge-Kutta step (Dormand and Prince, order 8) up through a slice of a graded layer.

    States that the wave does not reach stay what they are in the layer's own half-space.
    """
    rule = scipy.integrate.DOP853
    count = rule.n_stages
    z = part.top - part.origin + part.thickness * (1 - rule.C[:count])
    planes = over(scale, layer.plane_at(z))
    systems = system_of(planes)
    reached = ~_hidden(part, k)
    x, start, start_across = k[reached] * part.thickness, part.states[..., reached], part.across[..., reached]
    slopes, lateral = np.empty((count, *start.shape)), np.empty((count, *start_across.shape))
    for i in range(count):
        y = start + x * _times(rule.A[i : i + 1, :i], slopes[:i])[0]
        w = start_across + x * _times(rule.A[i : i + 1, :i], lateral[:i])[0]
        slopes[i] = -_times(systems[..., i], y)
        lateral[i, 0], lateral[i, 1] = -w[1] * planes.shear[i], -planes.across[i] * w[0]
    decay = np.exp(-part.slow * x)
    states, across = part.states.copy(), part.across.copy()
    states[..., reached] = (start + x * _times(rule.B[None], slopes)[0]) * decay
    across[..., reached] = (start_across + x * _times(rule.B[None], lateral)[0]) * decay
    return states, across


def _times(matrix: Array, states: Array) -> Array:
    rest = states.shape[1:]
    return np.asarray((matrix @ states.reshape(len(states), math.prod(rest))).reshape(len(matrix), *rest))


def _sweep_down(
    parts: list[_Part],
    base: Plane[float] | None,
    k: Array,
    z: Array,
    below: Indices,
    shear: bool,
    passed: Passed | None = None,
) -> tuple[Array, Array]:
    """States at all depths from the tractions that the loads have at the surface."""
    # notation: columns are the two loads, s_zz = -1 and s_lz = 1
    loads = 2 if shear else 1
    traction = np.zeros((2, loads, k.size))
    traction[1, 0] = -1
    traction[0, 1:] = 1
    sideways = np.ones(k.size)
    if passed is not None:
        traction, sideways = _below(passed, traction, sideways)
    states, across = np.zeros((4, loads, k.size, z.size)), np.zeros((2, k.size, z.size))
    for part in parts:
        if part.sheet is not None:
            down = np.append(np.clip(z[part.depths] - part.top, 0.0, part.thickness), part.thickness)
            y, w = part.sheet.at(down, traction), part.sheet.at_across(down, sideways)
            states[..., part.depths], across[..., part.depths] = y[..., :-1], w[..., :-1]
            traction, sideways = _below(part.passed, y[2:, ..., -1], w[1, ..., -1])
            continue
        raised, lifted = part.raised, part.lifted
        amplitude = np.einsum("ijn,jkn->ikn", inverse(raised[2:]), traction)
        wave = sideways / lifted[1]
        if part.depths.size and part.graded is None:
            down = np.clip(z[part.depths] - part.top, 0.0, part.thickness)
            y, w = _raised(part, k, down)
            decay = np.exp(-k[:, None] * down)
            states[..., part.depths] = np.einsum("ijnz,jkn->iknz", y, amplitude) * decay
            across[..., part.depths] = w * (wave[:, None] * decay)
        decay = np.exp(-part.slow * k * part.thickness)
        end, end_across = np.einsum("ijn,jkn->ikn", part.states, amplitude) * decay, part.across * wave * decay
        if part.depths.size and part.graded is not None:
            # steps through a graded layer begin or end at these depths
            upper = z[part.depths] - part.top < part.thickness / 2
            states[..., part.depths[upper]] = np.einsum("ijn,jkn->ikn", raised, amplitude)[..., None]
            across[..., part.depths[upper]] = (lifted * wave)[..., None]
            states[..., part.depths[~upper]] = end[..., None]
            across[..., part.depths[~upper]] = end_across[..., None]
        traction, sideways = _below(part.passed, end[2:], end_across[1])
    if base is not None and below.size:
        top = parts[-1].top + parts[-1].thickness if parts else 0.0
        states[..., below], across[..., below] = _in_base(base, k, z[below] - top, traction, sideways)
    return states, across


def _in_base(base: Plane[float], k: Array, depth: Array, traction: Array, sideways: Array) -> tuple[Array, Array]:
    solid, x = Solid(base), k[:, None] * np.maximum(depth, 0.0)
    rate, impedance = solid.sideways
    along = np.einsum("ijnz,jkn->iknz", solid.decaying(x), traction)
    return along, np.stack([-sideways / impedance, sideways])[..., None] * np.exp(-rate * x)


def named_waves(states: Array, across: Array, plane: Plane[Array], scale: float) -> Waves:
    """Waves from states (4, loads, nk, nz) and transverse ones (2, nk, nz): in-plane stresses added, displacements scaled."""
    along, szz = states[0], states[3]
    difference = plane.across / scale * along
    mean = plane.coupling * szz + (plane.stiffness - plane.across) / scale * along
    fields = np.stack([along / scale, states[1] / scale, states[2], szz, mean, difference])
    transverse = np.stack([across[0] / scale, across[1], plane.across / scale * across[0]])
    if states.shape[1] == 1:
        return Waves(fields[:, 0], fields[:, 0, :0], transverse[:, :0])
    return Waves(fields[:, 0], fields[:, 1], transverse)
