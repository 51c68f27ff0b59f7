"""Flat punches, round with a sharp edge or polygonal with rounded ones, and rollers of finite length, flat along their axis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.checks import SIDES, Array, BadValue
from flatpunch._support.declared import a_count, a_length, in_case_files
from flatpunch._support.readable import readable
from flatpunch.indenters._common import spread
from flatpunch.indenters.profile import Indenter, RoundShape


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
    flat = True

    @property
    def reach(self) -> float:
        """R [m]."""
        return self.radius

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together; infinite for r > R."""
        return spread(np.where(np.asarray(r) <= self.radius, 0.0, np.inf), phi)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting; infinite for r > R."""
        return self.height(r, phi)


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
    why_not_rising = "RoundedPunch has a flat end that is not round. It is solved by method='bem'."
    rising = False

    def _together_(self) -> None:
        if self.corner_radius >= self.half_width:
            raise BadValue(
                "RoundedPunch.corner_radius",
                repr(self.corner_radius),
                f"must be less than half_width = {self.half_width!r}, else nothing of it is flat.",
            )

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
    why_not_rising = (
        "Roller is straight along y, so its contact has no outline about one apex. It is solved by method='bem'."
    )

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
