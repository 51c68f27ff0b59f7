"""Loads as sources of fields: round ones, and pressures on cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fields.axisymmetric.round_load import RoundLoad, round_fields
from flatpunch.fields.axisymmetric.uniform_disc import UniformDisc
from flatpunch.fields.bodies import Located
from flatpunch.fields.cells import Cells, cell_fields
from flatpunch.fields.loads import DiscLoad, Load
from flatpunch.media import GradedLayer, Medium, PowerLawHalfSpace

_GRADED_ERROR, _BLURRED_ERROR = 1e-4, 2e-3
"""The same under a graded surface, where what it adds to the half-space decays slowly; and there close to the rim, or under
discs, whose pressure jumps at the rim."""

_FINEST = 64**2
"""Cells into which a prescribed pressure on fewer is cut: what layers add is that of a disc in the place of each."""


class Source(Protocol):
    """A load that knows its fields."""

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress (6, n), displacement (3, n), and the estimated error of stress over the largest pressure."""


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
    """

    load: RoundLoad
    pressure: float = 1.0
    traction: float = 0.0
    center: tuple[float, float] = (0.0, 0.0)

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress, displacement and error at points of one body."""
        stress, displacement = round_fields(
            self.load,
            at,
            x - self.center[0],
            y - self.center[1],
            pressure=self.pressure,
            # on the upper body the friction of the lower one acts backwards
            traction=-self.traction if at.upper else self.traction,
            direction=direction,
        )
        return stress, displacement, self._error(at, np.hypot(x - self.center[0], y - self.center[1]))

    def _error(self, at: Located, r: Array) -> float:
        layers = at.body.layers if isinstance(at.body, Medium) else ()
        if not (isinstance(at.body, PowerLawHalfSpace) or (layers and isinstance(layers[0], GradedLayer))):
            # error of round loads on homogeneous surfaces over the largest pressure, away from the rim (tests measure it)
            return 1e-8
        # distance from the rim over the radius within which short waves are missed under a graded surface
        near = np.hypot(r - self.load.radius, at.depth) < (1 / 12) * self.load.radius
        return _BLURRED_ERROR if near.any() or isinstance(self.load, UniformDisc) else _GRADED_ERROR


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
            cells = Cells(pressure, traction_of_cells + friction * pressure, load.spacing, load.center)
            found.append(CellSource(cells.split(_FINEST)))
    return found
