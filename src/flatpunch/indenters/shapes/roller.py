"""Rollers of finite length: bearing rollers with a crown or rounded ends, and cylinders that end sharply."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.case_kinds import in_case_files
from flatpunch._support.checks import Array, BadValue
from flatpunch._support.numbers import a_length
from flatpunch._support.readable import readable
from flatpunch.indenters.profile import Indenter


@in_case_files("indenter")
@readable
@dataclass(frozen=True, slots=True)
class Roller(Indenter):
    """Roller along y, f = x^2/(2 R) + g(y); solved by boundary elements.

    Parameters
    ----------
    radius : float
        Radius R of the roller [m], > 0.
    length : float
        Its length along y [m], > 0; beyond it nothing touches.
    crown : float, optional
        Radius of curvature of its profile along y [m]: g = y^2/(2 crown).
    end_radius : float, optional
        Radius of the rounding of its ends [m], at most half of the length: g = 0 on the straight part between, and grows as
        s^2/(2 end_radius) at a distance s beyond it. Without a crown and rounded ends the roller ends in a sharp edge, along
        which the pressure is infinite.

    Raises
    ------
    ValueError, TypeError
        If a value is outside its range, or crown and end_radius are both given.

    See Also
    --------
    EllipticParaboloid : A crowned roller without an end.
    RoundedPunch : Flat in both directions.

    Examples
    --------
    >>> roller = fp.Roller(radius=5e-3, length=2.4e-3, end_radius=0.3e-3)
    >>> contact = fp.indent(fp.HalfSpace(young=210e9, poisson=0.3), roller, force=100.0)
    >>> print(f"{float(contact.depth[0]) * 1e6:.2f} um")
    0.71 um
    """

    radius: Annotated[float, a_length("radius", example="5 um")]
    length: Annotated[float, a_length("length", example="20 um")]
    crown: Annotated[float | None, a_length("radius of the crown")] = None
    end_radius: Annotated[float | None, a_length("radius of the ends")] = None

    def _together_(self) -> None:
        if self.crown is not None and self.end_radius is not None:
            raise BadValue(
                "Roller.crown", "", "and Roller.end_radius are both given; a roller has one or the other, or neither."
            )
        if self.end_radius is not None and self.end_radius > self.length / 2:
            raise BadValue(
                "Roller.end_radius",
                repr(self.end_radius),
                f"is more than half of length = {self.length!r}: the ends would overlap.",
            )

    @property
    def rising(self) -> bool:
        """Whether it rises along y too: with a crown."""
        return self.crown is not None

    @property
    def why_not_rising(self) -> str:
        """Why only boundary elements solve it."""
        return "Roller is straight along y, so its contact has no outline about one apex. It is solved by method='bem'."

    @property
    def reach(self) -> float:
        """Half of the length [m]."""
        return self.length / 2

    def reach_along(self, phi: Array) -> Array:
        """Distance to the ends in directions phi [m]."""
        with np.errstate(divide="ignore"):
            return np.asarray(self.length / 2 / np.abs(np.sin(phi)))

    def box(self, depth: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Half-widths and centre [m] of the rectangle around all that is lower than a depth [m]."""
        across = self.radius if math.isinf(depth) else math.sqrt(2 * self.radius * depth)
        return (across, self.length / 2), (0.0, 0.0)

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        x, beyond, curvature = self._parts(r, phi)
        return np.asarray(x**2 / (2 * self.radius) + beyond**2 * (curvature / 2))

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        x, beyond, curvature = self._parts(r, phi)
        return np.asarray(x * np.cos(phi) / self.radius + beyond * np.abs(np.sin(phi)) * curvature)

    def _parts(self, r: Array, phi: Array) -> tuple[Array, Array, float]:
        """x, the distance beyond the straight part along y, and the curvature there."""
        x, y = r * np.cos(phi), np.abs(r * np.sin(phi))
        if self.crown is not None:
            return x, y, 1 / self.crown
        if self.end_radius is None:
            return x, np.zeros_like(y), 0.0
        return x, np.maximum(y - (self.length / 2 - self.end_radius), 0.0), 1 / self.end_radius
