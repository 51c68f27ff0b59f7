"""Flat punch of polygonal planform whose edges are rounded."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.case_kinds import in_case_files
from flatpunch._support.ceilings import SIDES
from flatpunch._support.checks import Array, BadValue
from flatpunch._support.numbers import a_count, a_length
from flatpunch._support.readable import readable
from flatpunch.indenters.profile import Indenter


@in_case_files("indenter")
@readable
@dataclass(frozen=True, slots=True)
class RoundedPunch(Indenter):
    """Flat end, a regular polygon, that passes into rounded edges, f = s^2/(2 corner_radius); solved by boundary elements.

    s is the distance from the flat, so that the corners of the polygon are rounded as well.

    Parameters
    ----------
    half_width : float
        Distance of the sides of the punch from its axis [m], > 0: that of the flat is less by corner_radius.
    corner_radius : float
        Radius of the rounding [m], > 0, less than half_width.
    sides : int
        Number of sides, 3 or more; the middle of one lies on the x axis.

    Raises
    ------
    ValueError, TypeError
        If a value is outside its range.

    See Also
    --------
    Cylinder : A round flat end with a sharp edge.
    Truncated : Worn tips.
    bem.solve_punch : Flat ends of any planform with sharp edges.

    Examples
    --------
    >>> punch = fp.RoundedPunch(half_width=1e-3, corner_radius=0.1e-3)
    >>> contact = fp.indent(fp.HalfSpace(young=210e9, poisson=0.3), punch, depth=0.1e-6)
    >>> print(f"{float(contact.force[0]):.0f} N")
    48 N
    """

    half_width: Annotated[float, a_length("half-width", example="5 um")]
    corner_radius: Annotated[float, a_length("corner radius")]
    sides: Annotated[int, a_count("sides", 3, SIDES, remedy="A round end is a Cylinder.")] = 4

    def _together_(self) -> None:
        if self.corner_radius >= self.half_width:
            raise BadValue(
                "RoundedPunch.corner_radius",
                repr(self.corner_radius),
                f"must be less than half_width = {self.half_width!r}, else nothing of it is flat.",
            )

    @property
    def rising(self) -> bool:
        """False: the end is flat."""
        return False

    @property
    def why_not_rising(self) -> str:
        """Why only boundary elements solve it."""
        return "RoundedPunch has a flat end that is not round. It is solved by method='bem'."

    def box(self, depth: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Half-widths and centre [m] of the rectangle around all that is lower than a depth [m]."""
        beyond = self.corner_radius if math.isinf(depth) else math.sqrt(2 * self.corner_radius * depth)
        corners = (2 * np.arange(self.sides) + 1) * (math.pi / self.sides)
        far = self._flat / math.cos(math.pi / self.sides)
        (wx, cx), (wy, cy) = (
            (np.ptp(side) / 2, (side.min() + side.max()) / 2) for side in (far * np.cos(corners), far * np.sin(corners))
        )
        return (float(wx) + beyond, float(wy) + beyond), (float(cx), float(cy))

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        across, along, _ = self._beyond(r, phi)
        return np.asarray((across**2 + along**2) / (2 * self.corner_radius))

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        across, along, turn = self._beyond(r, phi)
        return np.asarray((across * np.cos(turn) + along * np.abs(np.sin(turn))) / self.corner_radius)

    @property
    def _flat(self) -> float:
        """Distance of the sides of the flat from the axis [m]."""
        return self.half_width - self.corner_radius

    def _beyond(self, r: Array, phi: Array) -> tuple[Array, Array, Array]:
        """Distances beyond the flat across and along the nearest side, and the polar angle from the normal of that side."""
        sector = 2 * math.pi / self.sides
        turn = np.asarray(phi) - sector * np.round(np.asarray(phi) / sector)
        across = np.maximum(r * np.cos(turn) - self._flat, 0.0)
        along = np.maximum(np.abs(r * np.sin(turn)) - self._flat * math.tan(sector / 2), 0.0)
        return across, along, turn
