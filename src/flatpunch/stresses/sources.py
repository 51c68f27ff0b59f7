"""Loads as sources of fields: round ones, and pressures on cells."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, Flags
from flatpunch.stresses.axisymmetric.panels import REACH, SECOND_REACH, RoundLoad, missing
from flatpunch.stresses.axisymmetric.round_load import round_fields
from flatpunch.stresses.axisymmetric.uniform_disc import UniformDisc
from flatpunch.stresses.bodies import Located
from flatpunch.stresses.cells import Cells, cell_fields
from flatpunch.stresses.loads import DiscLoad, Load

_CHECKED = 4
"""Points at which round loads are calculated a second time: so many of those closest to the rim and to the middle of the load,
of those with the largest stresses, and of all."""


class Source(Protocol):
    """A load that knows its fields."""

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress (6, n), displacement (3, n), and the estimated error of stress over the size of the pressure."""


@dataclass(frozen=True, slots=True)
class RoundSource:
    """A round load at a place of its own.

    Attributes
    ----------
    load : RoundLoad
        Its pressure.
    pressure, traction : float
        Factors of the load as pressure and as traction.
    center : (float, float)
        Its place [m].
    again : callable, optional
        Makes the same load on other panels and by other rules; without it the load itself is known in closed form.
    own_error : float
        Error of the load itself, as a share of its scale.
    """

    load: RoundLoad
    pressure: float = 1.0
    traction: float = 0.0
    center: tuple[float, float] = (0.0, 0.0)
    again: Callable[[], RoundLoad] | None = None
    own_error: float = 0.0

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress, displacement and error at points of one body; the error as a share of the scale of the pressure."""
        x, y = x - self.center[0], y - self.center[1]
        found = self._at(self.load, at, x, y, direction, REACH)
        stress, displacement = found[:6], found[6:]
        r = np.hypot(x, y)
        stress[:, self._singular(r, at.depth)] = np.nan
        orders = np.hypot(r - self.load.radius, at.depth), np.hypot(r, at.depth), -np.abs(stress).max(axis=0)
        first = [np.argsort(each, kind="stable")[:_CHECKED] for each in orders]
        spread = np.linspace(0, x.size - 1, _CHECKED).astype(int)
        some = np.unique(np.concatenate([*first, spread]))
        part = replace(at, chosen=at.chosen[some], depth=at.depth[some], layer=at.layer[some])
        second = self.load if self.again is None else self.again()
        other = self._at(second, part, x[some], y[some], direction, SECOND_REACH)[:6]
        size = max(abs(self.pressure), abs(self.traction)) * self.load.scale
        with np.errstate(invalid="ignore"):
            apart = np.abs(other - stress[:, some]) * missing(at.body, self.load, r[some], part.depth)
        # infinite stresses agree
        error = float(apart[np.isfinite(apart)].max(initial=0.0))
        return stress, displacement, ROUNDING + self.own_error + (error / size if size > 0 else 0.0)

    def _singular(self, r: Array, depth: Array) -> Flags:
        """Points of the surface at a ring of infinite stress: of infinite pressure, or where a traction jumps."""
        rings = [edge.radius for edge in self.load.edges if edge.power < 0 or (edge.power == 0 and self.traction)]
        at_ring = np.isclose(r[:, None], rings, rtol=ROUNDING, atol=0.0).any(axis=1)
        return np.asarray(at_ring & (depth <= ROUNDING * self.load.radius))

    def _at(self, load: RoundLoad, at: Located, x: Array, y: Array, direction: float, reach: float) -> Array:
        return round_fields(
            load,
            at,
            x,
            y,
            pressure=self.pressure,
            # on the upper body the friction of the lower one acts backwards
            traction=-self.traction if at.upper else self.traction,
            direction=direction,
            reach=reach,
        )


@dataclass(frozen=True, slots=True)
class CellSource:
    """A pressure on cells.

    Attributes
    ----------
    cells : Cells
        Pressure and traction.
    own_error : float
        Error of the pressure over the largest, where it is known otherwise.
    coarser : Cells or None
        The same contact solved on cells twice as wide, for the estimate of the error.
    """

    cells: Cells
    own_error: float = 0.0
    coarser: Cells | None = None

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress, displacement and error at points of one body."""
        stress, displacement, error = cell_fields(self.cells, at, x, y, direction, self.coarser)
        return stress, displacement, error + self.own_error


@dataclass(frozen=True, slots=True)
class Nothing:
    """No contact."""

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Zero."""
        return np.zeros((6, x.size)), np.zeros((3, x.size)), 0.0


def prescribed_sources(loads: Sequence[Load], friction: float) -> list[Source]:
    """Sources of prescribed loads; friction adds to their own traction."""
    found: list[Source] = []
    for load in loads:
        if isinstance(load, DiscLoad):
            traction = load.traction + friction * load.pressure
            found.append(RoundSource(UniformDisc(load.radius), load.pressure, traction, load.center))
        else:
            pressure, traction_of_cells = load.cells
            along = traction_of_cells + friction * pressure
            found.append(CellSource(Cells(pressure, along, load.spacing, load.center, uniform=True)))
    return found
