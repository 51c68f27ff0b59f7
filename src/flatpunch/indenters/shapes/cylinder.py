"""Cylinder with a flat end: the punch itself as an indenter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.case_kinds import in_case_files
from flatpunch._support.checks import Array
from flatpunch._support.numbers import a_length
from flatpunch._support.readable import readable
from flatpunch.indenters._common import spread
from flatpunch.indenters.shape import RoundShape


@in_case_files("indenter")
@readable
@dataclass(frozen=True, slots=True)
class Cylinder(RoundShape):
    """Flat-ended cylinder, f = 0 for r <= R and no surface beyond; its contact radius is R at every depth.

    Parameters
    ----------
    radius : float
        Radius R [m], > 0.

    See Also
    --------
    flat_punch : Stiffness and pressure of the same contact.
    Truncated : A flat end on any tip.

    Examples
    --------
    >>> fp.Cylinder(radius=1e-6)
    Cylinder(radius=1e-06)
    """

    radius: Annotated[float, a_length("radius", example="5 um")]

    @property
    def reach(self) -> float:
        """R [m]."""
        return self.radius

    @property
    def flat(self) -> bool:
        """True."""
        return True

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together; infinite for r > R."""
        return spread(np.where(np.asarray(r) <= self.radius, 0.0, np.inf), phi)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting; infinite for r > R."""
        return self.height(r, phi)
