"""Closed propagator of homogeneous isotropic layers.

Pressure p at wavenumber k pushes the surface in by u = C(k) p with C = 2 L/(E* k); L -> 1 for k -> infinity. What lies
below a depth enters only through its flexibility H, (u_r, u_z) = H (s_rz, s_zz)/k, a 2x2 matrix: zero on a rigid base,
constant over k on a half-space. H is carried up layer by layer. With the stresses divided by k, the fields of a layer
obey y' = A y in the depth k z, and A has the double eigenvalues +-1, so (A^2 - 1)^2 = 0 and

    exp(-A x) = cosh x + (x/2) sinh x P - A [sinh x + (x cosh x - sinh x) P / 2],      P = A^2 - 1.

The growth exp(x) is divided out, so nothing overflows; every coefficient of A is finite at nu = 1/2. Where x is large both
carried states are nearly the growing ones, so there the two decaying solutions and what is reflected from below are added.
Valid for any -1 < nu <= 1/2, any number of layers, sticking or sliding interfaces.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliances.transverse import REACH, divided, flexibility_of, system_of
from flatpunch.media import AnyLayer, Material
from flatpunch.media.plane import isotropic_plane, over

SATURATION = REACH
"""k h from which a layer hides what lies below it: exp(-2 k h) (k h)^2 < 1e-18."""

_DEEP = 2.0
"""k h above which a layer is solved by reflection: carried states lose (k h)^2 of their digits, small at any smaller k h."""


_SERIES = [2 * (j + 1) / factorial(2 * j + 3) for j in range(9, -1, -1)]
"""x cosh x - sinh x = x^3 sum_j 2(j+1)/(2j+3)! x^(2j), highest power first: ten terms leave 1e-18 at x = 1."""


def half_space_flexibility(material: Material, scale: float, shape: tuple[int, ...]) -> Array:
    """Flexibility of a homogeneous half-space times `scale`: the subspace of fields that decay with depth, zero if rigid."""
    if material.rigid:
        return np.zeros((2, 2, *shape))
    if material.isotropic:
        mu, nu = material.isotropic
        g = scale / mu
        constant = g * np.array([[nu - 1, 0.5 - nu], [0.5 - nu, nu - 1]])
    else:
        constant = flexibility_of(over(scale, material.plane))
    return np.broadcast_to(constant[:, :, None], (2, 2, *shape)).copy()


@dataclass(frozen=True, slots=True)
class Depths:
    """Ascending x = k h of one thickness: below `shallow` states are carried, up to `deep` waves are reflected.

    Attributes
    ----------
    shallow, deep : int
        Numbers of x up to `_DEEP`, and up to `SATURATION`, beyond which a layer hides what lies below it.
    x : ndarray
        k h where it is deep.
    functions : ndarray, shape (4, shallow)
        Functions of the depth where it is shallow.
    """

    shallow: int
    deep: int
    x: Array
    functions: Array

    @classmethod
    def of(cls, x: Array) -> Depths:
        """Ranges and functions of ascending x."""
        shallow, deep = np.searchsorted(x, [_DEEP, SATURATION]).tolist()
        return cls(shallow, deep, x[shallow:deep], depth_functions(x[:shallow]))


def carry(layer: AnyLayer, flexibility: Array, depths: Depths, scale: float) -> None:
    """Replace the flexibility at the lower face of an isotropic layer by that at its upper face."""
    shallow, deep = depths.shallow, depths.deep
    if shallow:
        flexibility[..., :shallow] = _propagate(layer, flexibility[..., :shallow], depths.functions, scale)
    if deep > shallow:
        flexibility[..., shallow:deep] = _reflect(layer, flexibility[..., shallow:deep], depths.x, scale)
    flexibility[..., deep:] = half_space_flexibility(layer, scale, (1,))


def _propagate(layer: AnyLayer, below: Array, functions: Array, scale: float) -> Array:
    """Flexibility above a layer at small x = k h, from the `functions` of the depth, shape (4, n), by two states."""
    mu, nu = constants_of(layer)
    system = sagittal_system(mu / scale, nu)
    nilpotent = system @ system - np.eye(4)
    states = states_below(bool(layer.bonded), below)
    parts = np.concatenate([nilpotent, system, system @ nilpotent]) @ states.reshape(4, -1)
    first, second, third = parts.reshape(3, *states.shape)
    # notation: rows (u_r, u_z, s_rz/k, s_zz/k), columns the two admissible states
    cosh, f1, sinh, f3 = functions
    carried = cosh * states + f1 * first - sinh * second - f3 * third
    return divided(carried[:2], carried[2:])


def _reflect(layer: AnyLayer, below: Array, x: Array, scale: float) -> Array:
    """Flexibility above a layer at large x = k h: decaying solutions, and the growing ones that the lower face sends back.

    Both are exp(-+x) (v, w + v x) and pass through the layer as exp(-x) N and exp(-x)/N with N = (1 x; 0 1).
    """
    mu, nu = constants_of(layer)
    m, c = mu / scale, 3 - 4 * nu
    # notation: columns are two decaying and two growing solutions at their own face
    solutions = np.array(
        [
            [1, 0, 1, 0],
            [1, c, -1, c],
            [-2 * m, m * (1 - c), 2 * m, m * (1 - c)],
            [-2 * m, -m * (1 + c), -2 * m, m * (1 + c)],
        ]
    )
    first, second = _mismatch(layer, below, solutions)
    (p, q), (r, s) = first[2:], second[2:]
    back = np.empty((2, 2, x.size))
    back[0], back[1] = first[:2] * s - second[:2] * q, second[:2] * p - first[:2] * r
    back *= np.exp(-2 * x) / (q * r - p * s)
    back[0] -= x * back[1]
    back[:, 1] += x * back[:, 0]
    fields = solutions[:, :2, None] + (solutions[:, 2:] @ back.reshape(2, -1)).reshape(4, 2, -1)
    return divided(fields[:2], fields[2:])


def _mismatch(layer: AnyLayer, below: Array, states: Array) -> Array:
    """What states, shape (4, s), leave of the two conditions at the lower face; shape (2, s, n)."""
    if layer.bonded:
        return np.asarray(states[:2, :, None] - states[2:].T @ below)
    normal = states[1, :, None] - below[1, 1] * states[3, :, None]
    return np.stack([np.broadcast_to(states[2, :, None], normal.shape), normal])


def states_below(bonded: bool, below: Array) -> Array:
    """Two states that span what a lower face admits that sticks, or slides; shape (4, 2, n)."""
    states = np.zeros((4, 2, below.shape[-1]))
    if bonded:
        states[:2] = below
        states[2, 0] = states[3, 1] = 1
    else:
        states[0, 0] = 1
        states[1, 1] = below[1, 1]
        states[3, 1] = 1
    return states


def depth_functions(x: Array) -> Array:
    """cosh x, (x/2) sinh x, sinh x and (x cosh x - sinh x)/2, each times exp(-x); shape (4, n)."""
    decay = np.exp(-2 * x)
    cosh, sinh = (1 + decay) / 2, -np.expm1(-2 * x) / 2
    return np.stack([cosh, x * sinh / 2, sinh, _x_cosh_minus_sinh(x, cosh, sinh) / 2])


def constants_of(part: Material) -> tuple[float, float]:
    """Shear modulus [Pa] and Poisson ratio of a layer or base that is isotropic and does not vary."""
    assert part.isotropic is not None
    return part.isotropic


def sagittal_system(mu: float, nu: float) -> Array:
    """Matrix A of dy/d(kz) = A y; mu in the unit of the stresses."""
    return system_of(isotropic_plane(2 * (1 + nu) * mu, nu))


def _x_cosh_minus_sinh(x: Array, cosh: Array, sinh: Array) -> Array:
    """(x cosh x - sinh x) exp(-x) without cancellation; `cosh`, `sinh` carry the factor exp(-x) already."""
    result = x * cosh - sinh
    small = x < 1
    if small.any():
        t = x[small]
        y = t * t
        series = np.zeros_like(t)
        for coefficient in _SERIES:
            series *= y
            series += coefficient
        result[small] = t * y * series * np.exp(-t)
    return result
