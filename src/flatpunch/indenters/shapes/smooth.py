"""Tips with a round apex: paraboloids, and spheres and ellipsoids with their true shape.

Paraboloids, round and elliptic, are what every smooth convex body looks like close to its apex; the true shapes are for contacts
that are not small against their radii.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.declared import a_curvature, a_length, checked, in_case_files
from flatpunch._support.readable import readable
from flatpunch.indenters._common import check_slender, spread
from flatpunch.indenters.profile import Indenter, PowerLawShape, RoundShape


@in_case_files("indenter")
@readable
@dataclass(frozen=True, slots=True)
class Paraboloid(PowerLawShape, RoundShape):
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
    exponent = 2.0

    def angular(self, phi: Array) -> Array:
        """psi(phi) = 1/(2 R) [1/m], in the shape of phi [rad]."""
        return np.full(np.shape(phi), 0.5 / self.radius)


_HALF = "A and B are half the principal curvatures, 1/(2 R)."
_LEVELS = "f = A x^2 + B y^2"


@in_case_files("indenter", None, "", "of_radii")
@readable
@dataclass(frozen=True, slots=True)
class EllipticParaboloid(PowerLawShape):
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
    exponent = 2.0

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
    def round(self) -> bool:
        """Whether A equals B."""
        return self.A == self.B

    def angular(self, phi: Array) -> Array:
        """psi(phi) = A cos^2 phi + B sin^2 phi [1/m], in the shape of phi [rad]."""
        return np.asarray(self.A * np.cos(phi) ** 2 + self.B * np.sin(phi) ** 2)


USABLE = 0.95
"""Largest contact radius over R: beyond it slopes exceed 3, which the theory does not cover."""


@in_case_files("indenter")
@readable
@dataclass(frozen=True, slots=True)
class Sphere(RoundShape):
    """Sphere, f = R - sqrt(R^2 - r^2); `Paraboloid` is its small-contact limit.

    Parameters
    ----------
    radius : float
        Radius R [m], > 0.

    See Also
    --------
    Paraboloid : Its small-slope form.

    Examples
    --------
    >>> fp.Sphere(radius=5e-6)
    Sphere(radius=5e-06)
    """

    radius: Annotated[float, a_length("radius", example="5 um")]

    @property
    def reach(self) -> float:
        """0.95 R; the height is defined up to R and infinite beyond, where the sphere has no surface."""
        return USABLE * self.radius

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together; infinite for r > R."""
        r = np.asarray(r, dtype=float)
        # r^2/(R + root) instead of R - root: no cancellation at the apex
        gap = r**2 / (self.radius + self._root(r))
        return spread(np.where(r <= self.radius, gap, np.inf), phi)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting; infinite for r >= R."""
        r = np.asarray(r, dtype=float)
        with np.errstate(divide="ignore"):
            return spread(np.asarray(r / self._root(r)), phi)

    def _root(self, r: Array) -> Array:
        return np.sqrt(np.maximum((self.radius - r) * (self.radius + r), 0.0))


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
