"""Paraboloids, round and elliptic: what every smooth convex body looks like close to its apex."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.case_kinds import in_case_files
from flatpunch._support.checks import Array
from flatpunch._support.numbers import a_curvature, a_length, checked
from flatpunch._support.readable import readable
from flatpunch.indenters._common import check_slender, spread
from flatpunch.indenters.profile import Indenter
from flatpunch.indenters.shape import RoundShape


@in_case_files("indenter")
@readable
@dataclass(frozen=True, slots=True)
class Paraboloid(RoundShape):
    """Paraboloid of revolution, f = r^2/(2 R).

    Parameters
    ----------
    radius : float
        Radius of curvature R at the apex [m], > 0.

    See Also
    --------
    Sphere : The shape without the approximation.
    EllipticParaboloid : Two radii of curvature.

    Examples
    --------
    >>> fp.Paraboloid(radius=5e-6)
    Paraboloid(radius=5e-06)
    """

    radius: Annotated[float, a_length("radius", example="5 um")]

    @property
    def exponent(self) -> float:
        """Exponent n = 2 of f = r^n psi."""
        return 2.0

    def angular(self, phi: Array) -> Array:
        """psi(phi) = 1/(2 R) [1/m], in the shape of phi [rad]."""
        return np.full(np.shape(phi), 0.5 / self.radius)

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        return spread(np.square(r) * (0.5 / self.radius), phi)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        return spread(np.asarray(r) / self.radius, phi)


_HALF = "A and B are half the principal curvatures, 1/(2 R)."
_LEVELS = "f = A x^2 + B y^2"


@in_case_files("indenter", None, "", "of_radii")
@readable
@dataclass(frozen=True, slots=True)
class EllipticParaboloid(Indenter):
    """Paraboloid with elliptic level lines, f = A x^2 + B y^2.

    Parameters
    ----------
    A, B : float
        Half the principal curvatures along x and y [1/m], > 0: A = 1/(2 R_x), B = 1/(2 R_y).

    See Also
    --------
    Paraboloid : The round one.
    Ellipsoid : The shape without the approximation.

    Examples
    --------
    >>> fp.EllipticParaboloid(A=1e5, B=2e5)
    EllipticParaboloid(A=100000, B=200000)
    """

    A: Annotated[float, a_curvature("curvature A", remedy=_HALF, about=_LEVELS)]
    B: Annotated[float, a_curvature("curvature B", remedy=_HALF, about=_LEVELS)]

    def _together_(self) -> None:
        check_slender("EllipticParaboloid", self.A, self.B)

    @classmethod
    @checked
    def of_radii(
        cls,
        radius_x: Annotated[float, a_length("radius along x", remedy="The tip is convex.", example="20 um")],
        radius_y: Annotated[float, a_length("radius along y", remedy="The tip is convex.", example="12 um")],
    ) -> EllipticParaboloid:
        """Paraboloid by its principal radii of curvature at the apex.

        Parameters
        ----------
        radius_x, radius_y : float
            Radii in the planes of x and y [m], > 0; A = 1/(2 radius_x).
        """
        return cls(0.5 / radius_x, 0.5 / radius_y)

    @property
    def exponent(self) -> float:
        """Exponent n = 2 of f = r^n psi(phi)."""
        return 2.0

    @property
    def round(self) -> bool:
        """Whether A equals B."""
        return self.A == self.B

    def angular(self, phi: Array) -> Array:
        """psi(phi) = A cos^2 phi + B sin^2 phi [1/m], in the shape of phi [rad]."""
        return np.asarray(self.A * np.cos(phi) ** 2 + self.B * np.sin(phi) ** 2)

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        return np.asarray(np.square(r) * self.angular(phi))

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        return np.asarray(2 * np.asarray(r) * self.angular(phi))
