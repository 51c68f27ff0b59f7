"""Steps of a case file: what is prescribed, as a quantity, a list or a range, also along the surface, and histories."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationInfo, model_validator

from flatpunch._support.checks import ROUNDING, STEPS, Array, BadValue, positive, shown, values, whole
from flatpunch._support.paths import Plain
from flatpunch.files.tables.fields import Count, Force, Length, Number, Table, Time


class RangeTable(Table):
    """Evenly spaced steps: { start, stop, points, spacing }."""

    start: float
    stop: float
    points: Count
    spacing: Literal["linear", "log"] = "linear"

    def build(self, folder: Path) -> Array:
        """Return the steps."""
        if self.points < 2:
            raise BadValue(
                "points", shown(self.points), "must be 2 or more; for a single step write the quantity itself."
            )
        whole("points", self.points, 2, most=STEPS)
        if self.start == self.stop:
            raise ValueError("start and stop are equal; for a single step write the quantity itself.")
        if self.spacing == "linear":
            steps = np.linspace(self.start, self.stop, self.points)
            # a range that crosses zero has a step at zero, not at a rounding error beside it
            return np.where(np.abs(steps) < ROUNDING * abs(self.stop - self.start), 0.0, steps)
        for name in ("start", "stop"):
            positive(name, getattr(self, name), "spacing = 'log' has no zero; start from a small value.")
        return np.geomspace(self.start, self.stop, self.points)


class LengthRange(RangeTable):
    """Range of depths or radii."""

    start: Length
    stop: Length


class ForceRange(RangeTable):
    """Range of forces."""

    start: Force
    stop: Force


class TimeRange(RangeTable):
    """Range of times."""

    start: Time
    stop: Time


def kind_of_steps(value: object) -> str:
    """Tag of the form in which steps are given."""
    return "a range" if isinstance(value, dict) else "a list" if isinstance(value, list) else "a quantity"


_A_QUANTITY, _A_LIST, _A_RANGE = Tag("a quantity"), Tag("a list"), Tag("a range")
LengthSteps = Annotated[
    Annotated[Length, _A_QUANTITY] | Annotated[list[Length], _A_LIST] | Annotated[LengthRange, _A_RANGE],
    Discriminator(kind_of_steps),
]
ForceSteps = Annotated[
    Annotated[Force, _A_QUANTITY] | Annotated[list[Force], _A_LIST] | Annotated[ForceRange, _A_RANGE],
    Discriminator(kind_of_steps),
]
TimeSteps = Annotated[
    Annotated[list[Time], _A_LIST] | Annotated[TimeRange, _A_RANGE],
    Discriminator(lambda value: "a range" if isinstance(value, dict) else "a list"),
]


def steps_of(value: object) -> Any:
    """Steps of a quantity, a list or a range [SI]."""
    return value.built if isinstance(value, RangeTable) else value


class ControlTable(Table):
    """[control]: exactly one of depth, force and radius, each a quantity, a list of quantities or a range."""

    depth: LengthSteps | None = None
    force: ForceSteps | None = None
    radius: LengthSteps | None = None

    def build(self, folder: Path) -> tuple[str, Array]:
        """Return the name of the given quantity and its steps."""
        name, value = only_one(self, ("depth", "force", "radius"))
        return name, values(name, steps_of(value), minimum=-np.inf)

    @model_validator(mode="after")
    def _signs(self, info: ValidationInfo) -> ControlTable:
        """Refuse tension and tips held above the surface where nothing adheres."""
        name, steps = self.built
        if (info.context or {}).get("adhesive", False) and name != "radius":
            return self
        given = getattr(self, name)
        try:
            values(name, given if isinstance(given, (float, list)) else steps)
        except BadValue as error:
            hint = "" if name == "radius" else " Below zero it takes a work_of_adhesion."
            raise BadValue(error.field, error.value, f"{error.text}{hint}") from None
        return self


def only_one(table: Table, names: tuple[str, ...]) -> tuple[str, Any]:
    """Name and value of the one field that is given."""
    given = {name: value for name in names if (value := getattr(table, name)) is not None}
    if len(given) != 1:
        found = " and ".join(given) if given else "none"
        listed = " and ".join((", ".join(names[:-1]), names[-1]))
        raise ValueError(f"exactly one of {listed} must be given, found {found}.")
    ((name, value),) = given.items()
    return name, value


class SegmentTable(Table):
    """Stretch of a history: "ramp" to a depth or force, "hold", or "retract" (a ramp to zero unless it says otherwise)."""

    kind: Literal["ramp", "hold", "retract"]
    duration: Time
    depth: Length | None = None
    force: Force | None = None
    points: Count = 100

    def build(self, folder: Path) -> dict[str, float]:
        """Return the targets by name: one, or none where the segment leaves it open."""
        positive("duration", self.duration, "A sudden step is written as lists whose first value is not zero.")
        if self.points < 1:
            raise BadValue("points", shown(self.points), "must be 1 or more: the number of time steps of the segment.")
        whole("points", self.points, 1, most=STEPS)
        given = {name: value for name in ("depth", "force") if (value := getattr(self, name)) is not None}
        if self.kind == "hold" and given:
            raise ValueError("a hold keeps the depth or force that the segment before it has reached; leave it out.")
        if self.kind == "ramp" and len(given) != 1:
            raise ValueError("a ramp needs the depth or the force it leads to, one of the two.")
        if len(given) > 1:
            raise ValueError("a segment leads to a depth or to a force, not to both.")
        return given


@dataclass(frozen=True)
class History:
    """Depth [m] or force [N], `control` says which, at times [s], both of shape (steps,)."""

    control: str
    time: Array
    values: Array


class HistoryTable(Table):
    """[history]: time with depth or force as lists or ranges of one length, or segments one after the other from zero."""

    time: TimeSteps | None = None
    depth: LengthSteps | None = None
    force: ForceSteps | None = None
    segments: Annotated[list[SegmentTable], Field(min_length=1)] | None = None

    def build(self, folder: Path) -> History:
        """Return times and values."""
        if self.segments is None:
            return self._listed_values()
        if any(value is not None for value in (self.time, self.depth, self.force)):
            raise ValueError("give either segments, or time with depth or force.")
        return _joined(self.segments)

    def _listed_values(self) -> History:
        if self.time is None:
            raise ValueError("give either time with depth or force, or segments.")
        name, value = only_one(self, ("depth", "force"))
        time = values("time", steps_of(self.time), minimum=-np.inf)
        found = values(name, steps_of(value), minimum=-np.inf if name == "depth" else 0.0)
        if time.size < 2 or time.size != found.size:
            raise ValueError(
                f"time has {time.size} values and {name} {found.size}; two or more times and as many values are needed."
            )
        for i, (before, after) in enumerate(pairwise(time)):
            if after <= before:
                raise BadValue(f"time[{i + 1}]", f"{after:.6g} s", f"must be after time[{i}] = {before:.6g} s.")
        return History(name, time, found)


def _joined(segments: list[SegmentTable]) -> History:
    """Segments one after the other, from time zero and value zero."""
    names = {name for segment in segments for name in segment.built}
    if len(names) != 1:
        found = "none" if not names else "both"
        raise ValueError(f"all segments together lead to depths or to forces, found {found}.")
    (name,) = names
    if sum(segment.points for segment in segments) > STEPS:
        raise ValueError(f"segments have more than {STEPS} points together.")
    time, reached = [np.zeros(1)], [np.zeros(1)]
    for segment in segments:
        before = float(reached[-1][-1])
        target = before if segment.kind == "hold" else segment.built.get(name, 0.0)
        share = np.arange(1, segment.points + 1) / segment.points
        time.append(time[-1][-1] + segment.duration * share)
        reached.append(before + (target - before) * share)
    minimum = -np.inf if name == "depth" else 0.0
    return History(name, np.concatenate(time), values(name, np.concatenate(reached), minimum=minimum))


_ALONG = ("tangential_force", "stick_radius", "displacement")


class SlipTable(Table):
    """[slip]: friction, and at most one of tangential_force, stick_radius and displacement."""

    friction: Number
    tangential_force: ForceSteps | None = None
    stick_radius: LengthSteps | None = None
    displacement: LengthSteps | None = None

    def build(self, folder: Path) -> Plain:
        """Return what `partial_slip` takes by name besides the normal contact."""
        found: Plain = {"friction": positive("friction", self.friction, "It is the coefficient of friction.")}
        if any(getattr(self, name) is not None for name in _ALONG):
            name, given = only_one(self, _ALONG)
            found[name] = values(name, steps_of(given))
        return found
