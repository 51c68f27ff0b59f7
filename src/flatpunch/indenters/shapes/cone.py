"""Cone: the sharp tip of revolution."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flatpunch._support.case_kinds import in_case_files
from flatpunch._support.checks import Array
from flatpunch._support.numbers import HalfOpeningAngle, Inclination, checked
from flatpunch._support.readable import readable
from flatpunch.indenters._common import spread
from flatpunch.indenters.shape import RoundShape


@in_case_files("indenter", None, "", "of_opening", wear="wears")
@readable
@dataclass(frozen=True, slots=True)
class Cone(RoundShape):
    """Cone, f = r tan(inclination).

    Parameters
    ----------
    inclination : float
        Angle between the surface and the cone's face [rad], between 0 and pi/2.

    See Also
    --------
    SpheroCone : With a round apex.
    Pyramid : With edges.

    Examples
    --------
    >>> print(fp.Cone(inclination=np.radians(20)))
    Cone
      inclination  20 deg
    """

    inclination: Inclination

    @classmethod
    @checked
    def of_opening(cls, half_opening_angle: HalfOpeningAngle) -> Cone:
        """Cone by the angle between its axis and its face.

        Parameters
        ----------
        half_opening_angle : float
            Angle [rad], between 0 and pi/2; the inclination is pi/2 less this.
        """
        return cls(math.pi / 2 - half_opening_angle)

    @property
    def exponent(self) -> float:
        """Exponent n = 1 of f = r^n psi."""
        return 1.0

    def angular(self, phi: Array) -> Array:
        """psi(phi) = tan(inclination), in the shape of phi [rad]."""
        return np.full(np.shape(phi), math.tan(self.inclination))

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        return spread(np.asarray(r) * math.tan(self.inclination), phi)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        return np.full(np.broadcast_shapes(np.shape(r), np.shape(phi)), math.tan(self.inclination))
