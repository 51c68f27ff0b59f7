"""Ellipsoid with its true shape, and the spheroid as its body of revolution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.case_kinds import in_case_files
from flatpunch._support.checks import Array
from flatpunch._support.numbers import a_length, checked
from flatpunch._support.readable import readable
from flatpunch.indenters._common import check_slender, spread
from flatpunch.indenters.profile import Indenter
from flatpunch.indenters.shapes.sphere import USABLE


@in_case_files("indenter", wear="tilts")
@readable
@dataclass(frozen=True, slots=True)
class Ellipsoid(Indenter):
    """Lower half of an ellipsoid, f = half_z (1 - sqrt(1 - (x/half_x)^2 - (y/half_y)^2)).

    `EllipticParaboloid(half_z/(2 half_x^2), half_z/(2 half_y^2))` is its small-contact limit.

    Parameters
    ----------
    half_x, half_y : float
        Half-axes along the surface [m], > 0.
    half_z : float
        Half-axis along the direction of indentation [m], > 0.

    See Also
    --------
    Spheroid : A body of revolution.
    EllipticParaboloid : Its shape near the apex.

    Examples
    --------
    >>> tip = fp.Ellipsoid(5e-6, 4e-6, 2e-6)
    >>> tip.round
    False
    """

    half_x: Annotated[float, a_length("half-axis x", example="10 um")]
    half_y: Annotated[float, a_length("half-axis y", example="6 um")]
    half_z: Annotated[float, a_length("half-axis z", example="5 um")]

    def _together_(self) -> None:
        check_slender("Ellipsoid", self.half_x, self.half_y, self.half_z)

    @property
    def reach(self) -> float:
        """0.95 of the shorter half-axis; beyond the equator the height is infinite."""
        return USABLE * min(self.half_x, self.half_y)

    def reach_along(self, phi: Array) -> Array:
        """0.95 of the equator's radius in the directions phi [m]."""
        return USABLE / np.sqrt(self._inverse_square(phi))

    @property
    def round(self) -> bool:
        """Whether the horizontal half-axes are equal."""
        return self.half_x == self.half_y

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together; infinite beyond the equator."""
        square = np.square(r) * self._inverse_square(phi)
        # s/(1 + root) instead of 1 - root: no cancellation at the apex
        gap = self.half_z * square / (1 + np.sqrt(np.maximum(1 - square, 0.0)))
        return spread(np.where(square <= 1, gap, np.inf), phi)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting; infinite at the equator and beyond."""
        inverse = self._inverse_square(phi)
        root = np.sqrt(np.maximum(1 - np.square(r) * inverse, 0.0))
        with np.errstate(divide="ignore"):
            return spread(np.asarray(self.half_z * np.asarray(r) * inverse / root), phi)

    def _inverse_square(self, phi: Array) -> Array:
        """One over the square of the equator's radius in each direction."""
        if self.round:
            return np.asarray(self.half_x**-2.0)
        return np.asarray((np.cos(phi) / self.half_x) ** 2 + (np.sin(phi) / self.half_y) ** 2)


@checked
def Spheroid(
    half_width: Annotated[float, a_length("half-width")], half_height: Annotated[float, a_length("half-height")]
) -> Ellipsoid:
    """Ellipsoid of revolution about the direction of indentation.

    Parameters
    ----------
    half_width : float
        Equatorial radius [m], > 0.
    half_height : float
        Half-axis along the direction of indentation [m], > 0. The radius of curvature at the apex is half_width^2/half_height.

    See Also
    --------
    Sphere : The round one.
    Ellipsoid : Three half-axes.

    Examples
    --------
    >>> tip = fp.Spheroid(5e-6, 2e-6)
    >>> tip.round
    True
    """
    return Ellipsoid(half_width, half_width, half_height)
