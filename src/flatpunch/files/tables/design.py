"""[design] of a case file: what is varied between which bounds, what is prescribed, and limits."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import Field

from flatpunch._support.checks import shown
from flatpunch._support.paths import Plain
from flatpunch.designs import LargestLoad, Limit, Target
from flatpunch.designs.statement import UNITS, unit_of, variables
from flatpunch.files import units
from flatpunch.files.tables.fields import Count, Force, Length, Table
from flatpunch.files.tables.steps import ForceSteps, LengthSteps, steps_of
from flatpunch.files.tables.stress import StressCase
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body

QuantityName = Literal["force", "depth", "stiffness", "radius"]

_DIMENSIONS = {name: units.BY_UNIT[unit] for name, unit in UNITS.items()}
"""What the quantities of a contact are measured in."""


@dataclass(frozen=True)
class DesignCase:
    """What a case file asks of a design.

    Attributes
    ----------
    vary : mapping of str to (float, float)
        Names of numbers and their bounds [SI].
    objective : Target or LargestLoad
    limits : tuple of Limit
    starts : int
    """

    vary: dict[str, tuple[float, float]]
    objective: Target | LargestLoad
    limits: tuple[Limit, ...]
    starts: int


class LimitTable(Table):
    """[[design.limits]]: a bound on a quantity at a depth or a force."""

    quantity: QuantityName
    minimum: str | None = None
    maximum: str | None = None
    depth: Length | None = None
    force: Force | None = None

    def build(self, folder: Path) -> Limit:
        """Return the limit."""
        bounds = {
            name: units.named_si(name, value, _DIMENSIONS[self.quantity])
            for name, value in (("minimum", self.minimum), ("maximum", self.maximum))
            if value is not None
        }
        return Limit(self.quantity, depth=self.depth, force=self.force, **bounds)


class DesignTable(Table):
    """[design]: what is varied, what is prescribed."""

    objective: Literal["target", "largest load"] = "target"
    quantity: QuantityName | None = None
    value: str | list[str] | None = None
    depth: LengthSteps | None = None
    force: ForceSteps | None = None
    vary: Plain
    limits: list[LimitTable] = Field(default=[])
    starts: Count = 4

    def build(self, folder: Path) -> Target | None:
        """Return the target, None for the largest load."""
        given = [name for name in ("quantity", "value", "depth", "force") if getattr(self, name) is not None]
        if self.objective == "largest load":
            if given:
                raise ValueError(
                    f"{given[0]} is given, but the largest load prescribes nothing. Leave it out; strengths are those of "
                    "[stress]."
                )
            return None
        if self.quantity is None or self.value is None:
            raise ValueError("give quantity and value, and the depth or force at which they are meant.")
        listed = self.value if isinstance(self.value, list) else [self.value]
        value = [units.named_si("value", each, _DIMENSIONS[self.quantity]) for each in listed]
        return Target(
            self.quantity,
            value,
            depth=None if self.depth is None else steps_of(self.depth),
            force=None if self.force is None else steps_of(self.force),
        )

    def case(self, medium: Body, indenter: Indenter, stress: StressCase | None) -> DesignCase:
        """What is asked for, of this medium and tip."""
        objective = self.built
        if objective is None:
            if stress is None or not stress.strengths:
                raise ValueError("[design] objective = 'largest load' needs the strengths of a table [stress].")
            objective = LargestLoad(list(stress.strengths), stress.friction, stress.residual_stress)
        if not self.vary:
            raise ValueError(
                '[design] vary is empty; name a number and its bounds, such as "layers[0].young" = ["1 GPa", "9 GPa"].'
            )
        vary = {name: _bounds(name, bounds, unit_of(medium, indenter, name)) for name, bounds in self.vary.items()}
        # refuses bounds in the wrong order, and those that do not hold the value of the case
        variables(medium, indenter, vary)
        return DesignCase(vary, objective, tuple(limit.built for limit in self.limits), self.starts)


def _bounds(name: str, bounds: object, unit: str) -> tuple[float, float]:
    if not isinstance(bounds, list) or len(bounds) != 2:
        raise ValueError(
            f"[design] vary: {name} = {shown(bounds)} must be a list of two bounds, the smaller one first."
        )
    if unit:
        low, high = (units.named_si(f"[design] vary: {name}", each, units.BY_UNIT[unit]) for each in bounds)
        return low, high
    if any(isinstance(each, (bool, str)) or not isinstance(each, (int, float)) for each in bounds):
        raise ValueError(f"[design] vary: {name} = {shown(bounds)} must be two plain numbers: it has no unit.")
    return float(bounds[0]), float(bounds[1])
