"""[stress] of a case file: where stresses are wanted, friction, residual stresses and strengths."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from pydantic import Field

from flatpunch._support.checks import Array, non_negative
from flatpunch._support.paths import Plain
from flatpunch.files.tables.fields import Angle, Number, Pressure, Table
from flatpunch.files.tables.made import Made, table_of
from flatpunch.files.tables.steps import LengthSteps, steps_of
from flatpunch.media import Body, underlying
from flatpunch.stresses import Strength


@dataclass(frozen=True)
class StressCase:
    """Points, sliding and strengths for the stresses of a case, in SI units.

    Attributes
    ----------
    x, y, z : ndarray or None
        Coordinates of the points [m]; None where the file leaves them open.
    grid : bool
        Whether points are all combinations of x, y and z; otherwise they go together one by one.
    friction, direction : float
        Coefficient of friction [-], direction of the traction [rad].
    side : {"below", "above"}
        Side of an interface on which points are taken.
    residual_stress : tuple of float or None
        Biaxial stress of each layer [Pa].
    strengths, upper_strengths : tuple of Strength
        From the surface down, the base last; empty if none are given. Of two bodies the lower one's and the upper one's.
    """

    x: Array | None
    y: Array | None
    z: Array | None
    grid: bool = True
    friction: float = 0.0
    direction: float = 0.0
    side: Literal["above", "below"] = "below"
    residual_stress: tuple[float, ...] | None = None
    strengths: tuple[Strength, ...] = ()
    upper_strengths: tuple[Strength, ...] = ()

    @property
    def judged(self) -> bool:
        """Whether there is a strength to check."""
        return any(strength != Strength() for strength in self.strengths + self.upper_strengths)

    def critical(self, medium: Body) -> Plain:
        """What `critical_load` takes by name besides the medium and the tip."""
        strengths: Any = list(self.strengths)
        if underlying(medium).pair:
            strengths = [list(each) or None for each in (self.upper_strengths, self.strengths)]
        elif self.upper_strengths:
            raise ValueError(
                "upper_strengths in [stress] belong to the upper of two bodies; there is only one. Give strengths."
            )
        return {"strengths": strengths, "friction": self.friction, "residual_stress": self.residual_stress}

    def points(self, reach: float, deep: float) -> tuple[Array, Array, Array]:
        """Points, broadcastable; by default the plane y = 0 over `reach` on both sides and down to `deep` [m]."""
        x = reach * np.linspace(-1, 1, 201) if self.x is None else self.x
        y = np.zeros(1) if self.y is None else self.y
        z = np.linspace(0, deep, 121) if self.z is None else self.z
        if not self.grid:
            return x, y, z
        found = np.meshgrid(x, y, z, indexing="ij")
        kept = tuple(slice(None) if size > 1 else 0 for size in found[0].shape)
        x, y, z = (np.asarray(axis[kept]) for axis in found)
        return x, y, z

    @property
    def arguments(self) -> Plain:
        """What `fields` takes by name besides the contact."""
        return {
            "friction": self.friction,
            "direction": self.direction,
            "side": self.side,
            "residual_stress": self.residual_stress,
        }


if TYPE_CHECKING:
    StrengthTable = Made
else:
    # [[stress.strengths]]: of one layer, in the order of the layers; the one after the last layer is the base
    StrengthTable = table_of("", "strengths", [Strength])


class StressTable(Table):
    """[stress]: points, sliding, residual stresses, strengths."""

    x: LengthSteps | None = None
    y: LengthSteps | None = None
    z: LengthSteps | None = None
    at: Literal["grid", "points"] = "grid"
    friction: Number = 0.0
    direction: Angle = 0.0
    side: Literal["above", "below"] = "below"
    residual_stress: list[Pressure] | None = None
    strengths: list[StrengthTable] = Field(default=[])
    upper_strengths: list[StrengthTable] = Field(default=[])

    def build(self, folder: Path) -> StressCase:
        """Return the points and settings."""
        given = {name: steps_of(getattr(self, name)) for name in ("x", "y", "z")}
        places = {name: None if found is None else np.atleast_1d(found) for name, found in given.items()}
        if self.at == "points":
            sizes = {value.size for value in places.values() if value is not None} - {1}
            if any(value is None for value in places.values()) or len(sizes) > 1:
                raise ValueError(
                    "at = 'points' takes x, y and z as lists of one length, or single quantities among them."
                )
        return StressCase(
            x=places["x"],
            y=places["y"],
            z=places["z"],
            grid=self.at == "grid",
            friction=non_negative("friction", self.friction),
            direction=self.direction,
            side=self.side,
            residual_stress=None if self.residual_stress is None else tuple(self.residual_stress),
            strengths=tuple(table.built for table in self.strengths),
            upper_strengths=tuple(table.built for table in self.upper_strengths),
        )
