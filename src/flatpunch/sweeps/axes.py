"""What is varied: a path into a case file, "layers.0.thickness", and its values as people write them.

    "0.2um:5um:40"          40 values, evenly spaced
    "0.2um:5um:40:log"      evenly spaced in their logarithm
    "15deg, 20deg, 25deg"   these
    [1e-6, 2e-6]            numbers are in SI units

The value in the file says what a path holds: a quantity of some dimension, a number, a text, true or false.
"""

from __future__ import annotations

import difflib
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from flatpunch._support.checks import POINTS, BadValue, follows, shown
from flatpunch._support.declared import KINDS, number_of
from flatpunch._support.paths import FORMS, dotted, entries, spaced
from flatpunch.files import units

Entry = Any
"""A single value of a case file."""

_LISTED = 60
"""Values of a case file that a message lists."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One varied value of a case file.

    Attributes
    ----------
    path : str
        Where it stands, "layers.0.thickness".
    values : tuple
        Its values: floats in SI units, whole numbers, texts, or flags.
    written : tuple
        The same as they stand in a case file.
    unit : str
        SI unit, empty for what has none.
    log : bool
        Whether they are evenly spaced in their logarithm.
    """

    path: str
    values: tuple[Entry, ...]
    written: tuple[Entry, ...]
    unit: str
    log: bool

    def text(self, i: int) -> str:
        """Return a value as people read it."""
        return value_in_words(self.values[i], self.unit)


def value_in_words(value: Entry, unit: str) -> str:
    """A value of a parameter as people read it."""
    if unit == "rad":
        return f"{math.degrees(value):.4g}°"
    if unit:
        return units.text(float(value), unit)
    return f"{value:.4g}" if isinstance(value, float) else str(value).lower()


def axes_of(data: Mapping[str, object], vary: Mapping[str, object]) -> list[Axis]:
    """Read what is varied: path -> range, values with commas between them, or a sequence; checked against the case file."""
    if not follows(vary, Mapping) or not vary:
        raise BadValue(
            "vary",
            shown(vary),
            "must say which values to vary, e.g. {'layers.0.thickness': '0.2um:5um:40:log'}, here or in a table "
            "[vary] of the case file.",
        )
    there = dict(entries(data))
    axes = [_axis(path, spec, there) for path, spec in vary.items()]
    count = math.prod(len(axis.values) for axis in axes)
    if count > POINTS:
        raise ValueError(
            f"vary makes {count} combinations; a study has at most {POINTS} points. Vary fewer values, or split the study."
        )
    for i, axis in enumerate(axes):
        if axis.path in [other.path for other in axes[:i]]:
            raise BadValue(axis.path, "", "is varied twice; give all its values at once.")
    return axes


def _axis(path: str, spec: object, there: Mapping[str, object]) -> Axis:
    path = dotted(path)
    if path not in there:
        raise BadValue(path, "", _unknown(path, there))
    if path.startswith("slip."):
        raise BadValue(
            path,
            "",
            "changes no normal contact, which is all that a study solves. Solve each value with `flatpunch slip`.",
        )
    current = there[path]
    dimension = dimension_of(current)
    found, log = _range(path, spec, current, dimension) or (_listed(path, spec, current, dimension), False)
    if len(set(found)) < len(found):
        twice = max(found, key=Counter(found).__getitem__)
        raise BadValue(path, shown(spec), f"holds {shown(twice)} twice; give each value once.")
    written = tuple(f"{value!r} {dimension.unit}" for value in found) if dimension else found
    return Axis(path, found, written, dimension.unit if dimension else "", log)


def _unknown(path: str, there: Mapping[str, object]) -> str:
    below = [name for name in there if name.startswith(path + ".")] if path else []
    if below:
        return f"is a table or a list; vary a value in it: {', '.join(below)}."
    near = difflib.get_close_matches(path, there, n=1)
    advice = f"; did you mean {near[0]!r}?" if near else "."
    listed = [f"{name} = {shown(value)}" for name, value in islice(there.items(), _LISTED) if name != "title"]
    have = ", ".join(listed) + (f" and {len(there) - _LISTED} more" if len(there) > _LISTED else "")
    return (
        f"is not in the case file{advice} It holds {have}. A field that the file leaves at its default "
        "can be varied once it is written there."
    )


def dimension_of(current: object) -> units.Dimension | None:
    """What kind of quantity a text of the file is, if it is one."""
    if not isinstance(current, str):
        return None
    found = []
    for dimension in units.DIMENSIONS:
        with suppress(ValueError):
            units.to_si(current, dimension)
            found.append(dimension)
    # J/m^2 and N/m are the same: the one as which the file has it
    return min(found, key=lambda each: not current.endswith(each.unit), default=None)


def _range(
    path: str, spec: object, current: object, dimension: units.Dimension | None
) -> tuple[tuple[Entry, ...], bool] | None:
    """Values of "start:stop:count:log"; None if it is no range."""
    if not isinstance(spec, str) or ":" not in spec or (isinstance(current, str) and dimension is None):
        return None
    if isinstance(current, bool):
        raise BadValue(path, shown(spec), f"is no range. {FORMS}.")
    values, log = spaced(path, spec, lambda end: _value(path, end, current, dimension))
    if isinstance(current, int) and all(float(value).is_integer() for value in values):
        values = [int(value) for value in values]
    return tuple(values), log


def _listed(path: str, spec: object, current: object, dimension: units.Dimension | None) -> tuple[Entry, ...]:
    if isinstance(spec, str):
        spec = [entry.strip() for entry in spec.split(",")]
    if not isinstance(spec, (Sequence, np.ndarray)) or len(spec) == 0 or "" in list(spec):
        raise BadValue(path, shown(spec), f"holds no values. {FORMS}.")
    if len(spec) > POINTS:
        raise BadValue(path, "", f"holds {len(spec)} values; a study has at most {POINTS} points.")
    return tuple(
        _value(path, entry.item() if isinstance(entry, np.generic) else entry, current, dimension) for entry in spec
    )


def _value(path: str, entry: Entry, current: object, dimension: units.Dimension | None) -> Entry:
    hint = f"The case file holds {shown(current)}."
    if dimension is not None:
        if isinstance(entry, (int, float)) and not isinstance(entry, bool):
            return float(entry)  # Python's numbers are in SI units
        try:
            return units.to_si(entry, dimension)
        except ValueError as error:
            raise BadValue(path, shown(entry), f"{error} {hint}") from None
    if isinstance(current, bool):
        flags = {"true": True, "false": False}
        if str(entry).lower() not in flags:
            raise BadValue(path, shown(entry), f"must be true or false. {hint}")
        return flags[str(entry).lower()]
    if isinstance(current, str):
        if not isinstance(entry, str):
            raise BadValue(path, shown(entry), f"must be a text. {hint}")
        return entry
    if isinstance(entry, bool):
        raise BadValue(path, shown(entry), f"must be a plain number. {hint}")
    try:
        return int(entry) if isinstance(entry, int) or re.fullmatch(r"[+-]?\d+", str(entry)) else float(entry)
    except (TypeError, ValueError):
        raise BadValue(path, shown(entry), f"must be a plain number, without a unit. {hint}") from None


def in_words(path: str) -> str:
    """Path of a parameter as it is read: thickness of layer 1 for layers.0.thickness, which counts from 0."""
    *owner, name = path.split(".")
    kinds = [kind for section in ("layers", "base") if section in owner for kind in KINDS[section].values()]
    declared = (found.what for kind in kinds for way in kind.ways if (found := number_of(way, name)))
    name = next(declared, name.replace("_", " "))
    match owner:
        case [*body, "layers", at]:
            return " of the ".join([f"{name} of layer {int(at) + 1}", *(f"{each} body" for each in body)])
        case _:
            return " ".join([*owner, name])
