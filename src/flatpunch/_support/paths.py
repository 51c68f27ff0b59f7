"""Paths and ranges of values, as people write them.

Paths in nested tables, lists and objects: "layers[0].young", or "layers.0.young". Ranges: "0.1:10:21", or "0.1:10:21:log" for
values evenly spaced in their logarithm.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from flatpunch._support.checks import POINTS, BadValue, shown

Plain = dict[str, Any]
"""Plain data by name, as TOML and JSON hold it: texts, numbers, truth values, lists, and more of these."""

_PLACE = re.compile(r"\[(\d+)\]")
FORMS = "Write start:stop:count, start:stop:count:log, or values with commas between them"


def dotted(path: str) -> str:
    """Path with points alone, as case files and sweeps write it."""
    return _PLACE.sub(r".\1", path.strip())


def steps(path: str) -> list[str | int]:
    """Names and places on the way, in either spelling."""
    return [int(step) if step.isdecimal() else step for step in dotted(path).split(".")]


def entries(thing: object, path: str = "") -> Iterator[tuple[str, object]]:
    """Yield all single values of nested tables and lists with their paths."""
    found = thing.items() if isinstance(thing, Mapping) else enumerate(thing) if isinstance(thing, list) else None
    if found is None:
        yield path, thing
        return
    for key, value in found:
        yield from entries(value, f"{path}.{key}" if path else str(key))


def put(data: Any, path: str, value: object) -> None:
    """Set a value of nested tables and lists."""
    *way, last = steps(path)
    for step in way:
        data = data[step if isinstance(data, list) else str(step)]
    data[last if isinstance(data, list) else str(last)] = value


def spaced(name: str, text: str, value: Callable[[str], float]) -> tuple[list[float], bool]:
    """Values of a range, and whether they are evenly spaced in their logarithm; `value` reads an end."""
    parts = [part.strip() for part in text.split(":")]
    if len(parts) not in (3, 4) or not all(parts):
        raise BadValue(name, shown(text), f"is no range. {FORMS}.")
    start, stop = map(value, parts[:2])
    count, spacing = parts[2], "".join(parts[3:]) or "lin"
    if not re.fullmatch("[0-9]{1,9}", count) or not 2 <= int(count) <= POINTS:
        raise BadValue(
            name, shown(text), f": the count {shown(count)} must be a whole number from 2 to {POINTS}. {FORMS}."
        )
    if spacing not in ("lin", "log"):
        raise BadValue(name, shown(text), f": the spacing {shown(spacing)} must be 'log' or 'lin'. {FORMS}.")
    if start == stop:
        raise BadValue(name, shown(text), f"starts where it stops. {FORMS}.")
    if spacing == "log" and not min(start, stop) > 0:
        raise BadValue(name, shown(text), ": spacing 'log' has no zero and no negative numbers; take 'lin'.")
    values: list[float] = (np.geomspace if spacing == "log" else np.linspace)(start, stop, int(count)).tolist()
    return values, spacing == "log"
