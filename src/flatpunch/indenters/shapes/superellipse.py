"""Superellipse: level lines between a rhombus, an ellipse and a rectangle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.case_kinds import in_case_files
from flatpunch._support.checks import Array
from flatpunch._support.numbers import a_length, a_ratio
from flatpunch._support.readable import readable
from flatpunch.indenters._common import Exponent, check_slender, power
from flatpunch.indenters.profile import Indenter


@in_case_files("indenter")
@readable
@dataclass(frozen=True, slots=True)
class Superellipse(Indenter):
    """Power law with superelliptic level lines, ``f = height_at_axes (|x/half_x|^p + |y/half_y|^p)^(n/p)``.

    Parameters
    ----------
    half_x, half_y : float
        Half-axes of the level line f = height_at_axes along x and y [m], > 0.
    height_at_axes : float
        Height of that level line above the apex [m], > 0.
    power : float
        p [-], >= 1: 1 is a rhombus, 2 an ellipse, larger ones approach a rectangle.
    exponent : float
        n of f ~ r^n [-], > 0: 1 for pointed tips, 2 for rounded ones.

    See Also
    --------
    PowerLaw : Angular factors of any form.
    EllipticParaboloid : Ellipses as level lines.

    Examples
    --------
    >>> tip = fp.Superellipse(half_x=1e-6, half_y=1.5e-6, height_at_axes=0.2e-6)
    >>> curve = fp.indent(fp.HalfSpace(young=1e9, poisson=0.3), tip, depth=50e-9, method="second-order")
    >>> print(f"{float(curve.force[0]) * 1e6:.1f} uN, within {100 * float(curve.force_error[0]):.1f} %")
    35.3 uN, within 0.5 %
    """

    half_x: Annotated[float, a_length("half-axis x", example="10 um")]
    half_y: Annotated[float, a_length("half-axis y", example="6 um")]
    height_at_axes: Annotated[float, a_length("height at the axes", example="1 um")]
    power: Annotated[
        float,
        a_ratio(
            "power",
            least=1.0,
            most=1000.0,
            outside="must lie between 1 and 1000: below, the level lines are hollow between the axes, and the contact would "
            "not be convex; beyond, they are rectangles.",
        ),
    ] = 4.0
    exponent: Exponent = 2.0

    def _together_(self) -> None:
        check_slender("Superellipse", self.half_x, self.half_y)

    @property
    def corners(self) -> tuple[float, ...]:
        """The axes, for a rhombus (power 1); otherwise none."""
        return _AXES if self.power == 1 else ()

    @property
    def seams(self) -> tuple[float, ...]:
        """The axes, where ``|x|^p`` is not analytic unless p is even, and the corners that a large p nearly has."""
        if self.power <= 2:
            return () if self.power in (1, 2) else _AXES
        diagonal = math.atan2(self.half_y, self.half_x)
        return tuple(sorted({*_AXES, diagonal, math.pi - diagonal, math.pi + diagonal, 2 * math.pi - diagonal}))

    @property
    def round(self) -> bool:
        """Whether the level lines are circles: power 2 and equal half-axes."""
        return self.power == 2 and self.half_x == self.half_y

    def angular(self, phi: Array) -> Array:
        """psi(phi) [m^(1-n)], in the shape of phi [rad]."""
        if self.round:
            return np.full(np.shape(phi), self.height_at_axes * self.half_x**-self.exponent)
        x, y = np.abs(np.cos(phi)) / self.half_x, np.abs(np.sin(phi)) / self.half_y
        larger = np.maximum(x, y)
        # the larger one in front, so that no power overflows
        norm = larger * (1 + (np.minimum(x, y) / larger) ** self.power) ** (1 / self.power)
        return np.asarray(self.height_at_axes * norm**self.exponent)

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        return np.asarray(power(r, self.exponent) * self.angular(phi))

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        return np.asarray(self.exponent * power(r, self.exponent - 1) * self.angular(phi))


_AXES = (0.0, math.pi / 2, math.pi, 3 * math.pi / 2)
