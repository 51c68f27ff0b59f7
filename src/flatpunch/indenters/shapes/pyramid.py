"""Regular pyramid: AFM tips and hardness indenters before they wear."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.case_kinds import in_case_files
from flatpunch._support.ceilings import SIDES
from flatpunch._support.checks import Array
from flatpunch._support.numbers import HalfOpeningAngle, Inclination, a_count, checked
from flatpunch._support.readable import readable
from flatpunch.indenters._common import FULL_TURN, spread
from flatpunch.indenters.profile import Indenter

Sides = Annotated[
    int,
    a_count(
        "sides", 3, SIDES, remedy="A pyramid has 3 faces or more; the round limit is Cone(inclination).", example="4"
    ),
]


@in_case_files("indenter", None, "", "of_opening", wear="wears")
@readable
@dataclass(frozen=True, slots=True)
class Pyramid(Indenter):
    """Regular pyramid, f = tan(inclination) max_j (x·n_j).

    The horizontal normals of the faces are n_j = (cos 2 pi j/N, sin 2 pi j/N): the first face looks along +x,
    the edges lie half-way between the normals.

    Parameters
    ----------
    sides : int
        Number of faces N, >= 3.
    inclination : float
        Angle between the surface and each face [rad], between 0 and pi/2.

    See Also
    --------
    FacetedPyramid : Faces of any inclination.
    Rounded, Truncated : Worn tips.
    Vickers, Berkovich, Knoop, CubeCorner : The standard ones.

    Examples
    --------
    >>> print(fp.Pyramid(sides=4, inclination=np.radians(55)))
    Pyramid
      sides        4
      inclination  55 deg
    """

    sides: Sides
    inclination: Inclination

    @classmethod
    @checked
    def of_opening(cls, sides: Sides, half_opening_angle: HalfOpeningAngle) -> Pyramid:
        """Pyramid by the angle between its axis and each face.

        Parameters
        ----------
        sides : int
            Number of faces, >= 3.
        half_opening_angle : float
            Angle [rad], between 0 and pi/2; the inclination is pi/2 less this.
        """
        return cls(sides, math.pi / 2 - half_opening_angle)

    @property
    def exponent(self) -> float:
        """Exponent n = 1 of f = r^n psi(phi)."""
        return 1.0

    @property
    def corners(self) -> tuple[float, ...]:
        """Directions of the edges, (2 j + 1) pi/N [rad]."""
        return tuple((2 * j + 1) * math.pi / self.sides for j in range(self.sides))

    def angular(self, phi: Array) -> Array:
        """psi(phi) = tan(inclination) cos(angle to the nearest face normal), in the shape of phi [rad]."""
        width = FULL_TURN / self.sides
        off = phi - width * np.round(np.asarray(phi) / width)
        return np.asarray(math.tan(self.inclination) * np.cos(off))

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        return np.asarray(np.asarray(r) * self.angular(phi))

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        return spread(self.angular(phi), r)
