"""Exact contact of f = A x^2 + B y^2 with a homogeneous or power-law graded half-space.

Under E(z) = E0 z^k the surface answers a pressure like r^-(1+k), and the pressure

    p = p0 (1 - x^2/a^2 - y^2/b^2)^((1 + k)/2),      F = 2 pi a b p0/(3 + k)

gives a displacement that is quadratic within the ellipse. Taken apart into plane waves of direction t, the
Radon transform of p is (1 - s^2/w^2)^(1 + k/2)/w with w^2 = a^2 cos^2 t + b^2 sin^2 t, and the fractional
derivative of order k of that is 1 - (1 + k) s^2/w^2. Hence, with the constant N of the medium (E* if k = 0),

    d = (1 + k) p0 a b/(4 N) int w^-(1+k) dt,      A = (1 + k)^2 p0 a b/(4 N) int cos^2 t w^-(3+k) dt,      B
    with sin^2 t

over a full turn: for k = 0 the elliptic integrals of Hertz.

See Also
--------
flatpunch.reference.half_space : Round contact.
flatpunch.EllipticParaboloid : The indenter.

Examples
--------
>>> from flatpunch.reference.elliptic import half_axes_ratio
>>> print(f"{half_axes_ratio(1e5, 2e5):.3f}")  # b/a of the contact, not of the level lines
0.631
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class EllipticContact:
    """One contact.

    Attributes
    ----------
    depth, force : float
        d [m], F [N].
    half_axis_x, half_axis_y : float
        a, b [m].
    peak_pressure : float
        p0 [Pa].
    exponent : float
        k of the medium; 0 is homogeneous.
    """

    depth: float
    force: float
    half_axis_x: float
    half_axis_y: float
    peak_pressure: float
    exponent: float

    @property
    def area(self) -> float:
        """Contact area pi a b [m^2]."""
        return float(np.pi * self.half_axis_x * self.half_axis_y)

    @property
    def stiffness(self) -> float:
        """dF/dd = (3 + k) F/(2 d) [N/m], from F ~ d^((3 + k)/2)."""
        return (3 + self.exponent) / 2 * self.force / self.depth

    def pressure(self, x: Array, y: Array) -> Array:
        """p(x, y) [Pa], zero outside."""
        inside = 1 - np.square(x / self.half_axis_x) - np.square(y / self.half_axis_y)
        return np.asarray(self.peak_pressure * np.maximum(inside, 0.0) ** ((1 + self.exponent) / 2))

    def outline(self, phi: Array) -> Array:
        """Contact radius a(phi) [m]."""
        inverse = np.square(np.cos(phi) / self.half_axis_x) + np.square(np.sin(phi) / self.half_axis_y)
        return np.asarray(1 / np.sqrt(inverse))


def elliptic_paraboloid(
    A: float,
    B: float,
    modulus: float,
    *,
    depth: float | None = None,
    force: float | None = None,
    exponent: float = 0.0,
) -> EllipticContact:
    """Contact at a depth or under a force.

    Parameters
    ----------
    A, B : float
        Half the principal curvatures along x and y [1/m].
    modulus : float
        E* [Pa] of a homogeneous half-space; N = h_N E0/(1 - nu^2) [Pa/m^k] of a graded one
        (`power_law.stiffness_constant`).
    depth, force : float
        One of them [m], [N].
    exponent : float
        k, -1 < k < 1.
    """
    if (depth is None) == (force is None):
        raise ValueError("elliptic_paraboloid takes depth or force, one of them.")
    k = exponent
    if A > B:
        turned = elliptic_paraboloid(B, A, modulus, depth=depth, force=force, exponent=exponent)
        return replace(turned, half_axis_x=turned.half_axis_y, half_axis_y=turned.half_axis_x)
    ratio = half_axes_ratio(A, B, k)
    # solve at half-axis a = 1 along x, then scale: d ~ a^2, F ~ a^(3+k)
    depth_integral, along_x, _ = _integrals(ratio, k)
    peak = 4 * modulus * A / ((1 + k) ** 2 * ratio * along_x)
    unit_depth = (1 + k) * peak * ratio / (4 * modulus) * depth_integral
    unit_force = 2 * np.pi * ratio * peak / (3 + k)
    if force is None:
        assert depth is not None
        a = (depth / unit_depth) ** 0.5
    else:
        a = (force / unit_force) ** (1 / (3 + k))
    return EllipticContact(
        depth=float(unit_depth * a**2),
        force=float(unit_force * a ** (3 + k)),
        half_axis_x=float(a),
        half_axis_y=float(ratio * a),
        peak_pressure=float(peak * a ** (1 + k)),
        exponent=k,
    )


def half_axes_ratio(A: float, B: float, exponent: float = 0.0) -> float:
    """Ratio b/a of the contact ellipse."""
    if A == B:
        return 1.0
    if A > B:
        return 1 / half_axes_ratio(B, A, exponent)

    # b < a; B/A grows like (b/a)^-2 for k > 0 and (b/a)^-(2 + k) for k < 0, with constants of order one
    def excess(log_ratio: float) -> float:
        _, along_x, along_y = _integrals(np.exp(log_ratio), exponent)
        return float(np.log(along_y / along_x) - np.log(B / A))

    low = -np.log(B / A) - 5.0
    return float(np.exp(brentq(excess, low, 0.0, xtol=1e-15, rtol=8.9e-16)))


def _integrals(ratio: float, k: float) -> tuple[float, float, float]:
    """Integrals of w^-(1+k), cos^2 t w^-(3+k), sin^2 t w^-(3+k) over a turn for a = 1, b = ratio <= 1.

    With cot t = exp(v) the integrands are analytic for |Im v| < pi/2 at every ratio and fall like exp(-|v|),
    so the trapezoidal rule of step 0.2 leaves exp(-pi^2/0.2).
    """
    step = 0.2
    v = step * np.arange(np.floor((np.log(ratio) - 40.0) / step), 40.0 / step)
    square = np.exp(2 * v)
    width = np.sqrt((square + ratio**2) / (1 + square))
    weight = 4 * step * np.exp(v) / (1 + square)
    cos2, sin2 = square / (1 + square), 1 / (1 + square)
    return (
        float(np.sum(weight * width ** -(1 + k))),
        float(np.sum(weight * cos2 * width ** -(3 + k))),
        float(np.sum(weight * sin2 * width ** -(3 + k))),
    )
