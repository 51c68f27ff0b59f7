"""Sphere with its true shape, for contacts that are not small against its radius."""

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
