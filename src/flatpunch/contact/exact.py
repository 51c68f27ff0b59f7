"""Contacts with closed solutions besides round tips: flat ends of cylinders, and elliptic paraboloids on half-spaces.

Under a flat end F = K d on every medium.

Under f = A x^2 + B y^2 the contact is an ellipse with half-axes a and b and the pressure p_0 (1 - x^2/a^2 - y^2/b^2)^((1+e)/2), e
the exponent of the modulus, E ~ z^e (e = 0: Hertz 1882). The transform of that pressure is a function of k sigma(psi) alone,
sigma^2 = a^2 cos^2 psi + b^2 sin^2 psi, and C ~ k^(e-1), so that the integrals over k separate from those over the angle psi:

    S_0 = int sigma^(-1-e) dpsi,     S_x = int cos^2 psi sigma^(-3-e) dpsi,     S_y = int sin^2 psi sigma^(-3-e) dpsi,
    A/B = S_x/S_y,     A/d = (1 + e) S_x/S_0,     K = K_1 2 pi/S_0,     F = 2 K d/(3 + e),

over one turn, with K_1 the stiffness of the round punch of radius 1. With tan(pi/2 - psi) = (b/a) sinh y the integrands are
analytic in y and decay exponentially, so that the trapezoidal rule is exact to rounding for every ratio of the axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import Control, Curve, Extra, PressureField, first_failure
from flatpunch.contact.round.superposition import flat_pressure
from flatpunch.indenters import EllipticParaboloid
from flatpunch.indenters.profile import Indenter
from flatpunch.punch.family import punch_family


def solve_flat_end(kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
    """Force and depth in proportion, F = K d."""
    a = np.full_like(control.values, indenter.reach)
    stiffness = punch_stiffness(kernel, a)
    depth = _flat_end_depth(control, stiffness)
    valid = np.ones(a.size, dtype=bool)
    if punch_family(kernel).lowest_pressure(a[:1] / kernel.length) < 0:
        valid[:] = depth <= 0
    return Curve(
        depth=depth,
        force=stiffness * depth,
        radius=a,
        area=np.pi * a**2,
        stiffness=stiffness,
        contour=np.repeat(a[:, None], phi.size, axis=1),
        valid=valid,
        notes=first_failure(
            ~valid, depth, "the pressure under the flat end is negative in part, so it lifts off there."
        ),
    )


def flat_end_pressure(kernel: Kernel, indenter: Indenter, control: Control, r: Array) -> tuple[Array, Array]:
    """Pressure of the flat punch at distances r, and its error, shape (n,) each [Pa]."""
    a = np.full(1, indenter.reach)
    depth = float(_flat_end_depth(control, punch_stiffness(kernel, a))[0])
    return flat_pressure(kernel, indenter.reach, depth, r)


def punch_stiffness(kernel: Kernel, radius: Array) -> Array:
    """K = 2 E* a Kbar at radii of shape (n,) [N/m]."""
    return np.asarray(2 * np.pi * kernel.modulus * radius * punch_family(kernel).at(radius / kernel.length).flat[:, 0])


def _flat_end_depth(control: Control, stiffness: Array) -> Array:
    if control.name == "radius":
        raise ValueError(
            "radius cannot control a cylinder with a flat end: its contact radius never changes. Give depth or force."
        )
    return control.values if control.name == "depth" else control.values / stiffness


_STEP = 0.25
"""Step of the trapezoidal rule in y: the error is exp(-pi^2/step), 1e-17; half doubles the time, twice leaves 3e-9."""

_TAIL = -np.log(np.finfo(float).eps)
"""Length over which integrands decay like exp(-y): below rounding."""


@dataclass(frozen=True, slots=True)
class Ellipse:
    """Contact ellipse of depth 1 m along its axes.

    Attributes
    ----------
    long, short : float
        Half-axes [m].
    turned : bool
        Whether the long one is along y.
    stiffness : float
        K [N/m].
    error : float
        Relative error: what a coarser rule changes.
    exponent : float
        e of the body.
    """

    long: float
    short: float
    turned: bool
    stiffness: float
    error: float
    exponent: float

    def radius(self, phi: Array) -> Array:
        """Distance of the outline from the centre at polar angles phi [m]."""
        along, across = np.cos(phi), np.sin(phi)
        if self.turned:
            along, across = across, along
        return np.asarray(self.long * self.short / np.hypot(self.short * along, self.long * across))

    @property
    def mean_radius(self) -> float:
        """Mean of the outline over the polar angle [m]."""
        return float(2 / np.pi * self.short * scipy.special.ellipkm1((self.short / self.long) ** 2))


def has_ellipse(kernel: Kernel, indenter: Indenter) -> bool:
    """Whether tip and body have this solution."""
    return isinstance(indenter, EllipticParaboloid) and (kernel.homogeneous or kernel.exponent != 0)


def solve_ellipse(kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
    """Solve a whole curve, with the outline at polar angles phi, shape (p,)."""
    unit = _unit(kernel, indenter)
    e = unit.exponent
    depth = _ellipse_depth(unit, control)
    # a ~ d^(1/2), K ~ a^(1 + e)
    grown = np.sqrt(depth)
    stiffness = unit.stiffness * grown ** (1 + e)
    found = (("force_error", (1 + e) * unit.error), ("contour_error", unit.error))
    extra: Extra = {
        name: (("step",), np.full(depth.size, max(error, np.finfo(float).eps)), "1", "estimated relative error")
        for name, error in found
    }
    return Curve(
        depth=depth,
        force=2 / (3 + e) * stiffness * depth,
        radius=unit.mean_radius * grown,
        area=np.pi * unit.long * unit.short * depth,
        stiffness=stiffness,
        contour=grown[:, None] * unit.radius(phi),
        valid=np.ones(depth.size, dtype=bool),
        extra=extra,
    )


def ellipse_pressure(kernel: Kernel, indenter: Indenter, control: Control, r: Array, phi: Array) -> PressureField:
    """Pressure at polar coordinates, shape (n,) each, of the one contact that `control` prescribes."""
    unit = _unit(kernel, indenter)
    (depth,) = _ellipse_depth(unit, control)
    if depth == 0:
        return PressureField(np.zeros_like(r), np.zeros_like(r))
    e, grown = unit.exponent, float(np.sqrt(depth))
    force = 2 / (3 + e) * unit.stiffness * grown ** (1 + e) * depth
    highest = force * (3 + e) / (2 * np.pi * unit.long * unit.short * depth)
    inside = np.maximum(1 - (r / (grown * unit.radius(phi))) ** 2, 0.0)
    field = highest * inside ** ((1 + e) / 2)
    return PressureField(field, max(unit.error, np.finfo(float).eps) * field)


def _ellipse_depth(unit: Ellipse, control: Control) -> Array:
    """Depths of the prescribed steps [m]."""
    e = unit.exponent
    if control.name == "radius":
        return np.asarray((control.values / unit.mean_radius) ** 2)
    if control.name == "force":
        return np.asarray(((3 + e) / 2 * control.values / unit.stiffness) ** (2 / (3 + e)))
    return control.values


def _unit(kernel: Kernel, indenter: Indenter) -> Ellipse:
    """The contact of depth 1 m."""
    assert isinstance(indenter, EllipticParaboloid)
    e, (flat, steep) = kernel.exponent, sorted((indenter.A, indenter.B))

    def misfit(log_axes: float) -> float:
        _, along, across = _integrals(np.exp(log_axes), e, _STEP)
        return float(np.log(along / across) - np.log(flat / steep))

    # b/a lies between (A/B)^(1/2), the level lines of the tip, and A/B
    ratio = np.log(flat / steep)
    axes = (
        float(np.exp(scipy.optimize.brentq(misfit, ratio, ratio / 2, xtol=1e-15, rtol=4 * np.finfo(float).eps)))
        if ratio
        else 1.0
    )
    fine, coarse = (_integrals(axes, e, step) for step in (_STEP, 4 / 3 * _STEP))
    long = float(np.sqrt((1 + e) * fine[1] / (fine[0] * flat)))
    stiffness = float(punch_stiffness(kernel, np.ones(1))[0]) * 2 * np.pi / (fine[0] * long ** (-1 - e))
    error = float(np.abs(coarse / fine - 1).max()) + abs(misfit(np.log(axes)))
    return Ellipse(long, axes * long, indenter.A > indenter.B, stiffness, error, e)


def _integrals(axes: float, e: float, step: float) -> Array:
    """S_0, S_x, S_y for a = 1 and b = `axes`."""
    # from the middle to where tan = (b/a) sinh y is large, and on until nothing is left
    y = step * np.arange(int((np.log(2 / axes) + _TAIL) / step) + 1)
    weight = np.full(y.size, 4 * step)
    weight[0] /= 2
    tangent, cosh = axes * np.sinh(y), axes * np.cosh(y)
    square = 1 + tangent**2
    # notation: s = sigma^2, dpsi = cosh/square dy
    s = cosh**2 / square
    each = weight * cosh / square * s ** (-(3 + e) / 2)
    return np.array([np.sum(each * s), np.sum(each * tangent**2 / square), np.sum(each / square)])
