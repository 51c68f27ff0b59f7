"""Columns of measured files: which is which, in which unit, and what is wrong with them."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.files import units
from flatpunch.fit.measured.curve import CurveError

STIFFNESS = units.Dimension("stiffness", "N/m", "120 N/m", ("N/m", "mN/nm", "uN/nm", "N/mm", "mN/um"))
TIME = units.Dimension("time", "s", "0.5 s", ("s", "ms", "min", "us"))

ROLES: dict[str, tuple[units.Dimension, str]] = {
    "depth": (units.LENGTH, r"indentation|displacement.*(surface|sample)|tip.*position|\bdepth\b|^h$"),
    "force": (units.FORCE, r"\bforce\b|\bload\b|^[fp]$"),
    "piezo": (units.LENGTH, r"\bpiezo\b|\bheight\b|\bz\b"),
    "deflection": (units.LENGTH, r"deflection|cantilever"),
    "stiffness": (STIFFNESS, r"stiffness"),
    "time": (TIME, r"\btime\b|^t$"),
}
"""What a column can be: its dimension, and how its name is recognised."""

_UNIT = re.compile(r"^(.*?)\s*(?:\(([^()]*)\)|\[([^\[\]]*)\]|/\s*([^/\s]+)|,\s*(\S+))\s*$")
_NO_VALUE = 1e300
_COMMA = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?\s*")


@dataclass(frozen=True)
class Table:
    """Columns as they stand in a file: names, units where given, cells (text or numbers) by row."""

    source: str
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    rows: Sequence[Sequence[Any]]
    first_row: int = 1


def split_name(title: str) -> tuple[str, str | None]:
    """Name and unit of a column's title: "Load (uN)", "force [nN]", "depth / nm"."""
    match = _UNIT.match(title.strip())
    if match is None:
        return title.strip(), None
    unit = next(group for group in match.groups()[1:] if group is not None).strip()
    return match[1].strip(), unit or None


def chosen_columns(table: Table, wanted: Mapping[str, str | int] | None) -> dict[str, int]:
    """Position of the column of each role: as named by the user, or recognised by its title."""
    found: dict[str, int] = {}
    lowered = [name.lower() for name in table.names]
    for role, title in (wanted or {}).items():
        if role not in ROLES:
            raise CurveError(f"columns: {role!r} is no kind of column; known are {', '.join(ROLES)}.")
        found[role] = _named(table, role, title)
    for role, (_, pattern) in ROLES.items():
        if role in found:
            continue
        hits = [i for i, name in enumerate(lowered) if re.search(pattern, name) and i not in found.values()]
        if hits:
            found[role] = hits[0]
    return found


def _named(table: Table, role: str, title: str | int) -> int:
    known = ", ".join(repr(name) for name in table.names) or "none"
    if isinstance(title, int):
        if not 0 <= title < len(table.names):
            raise CurveError(f"{table.source}: column {title} for {role} does not exist; there are {len(table.names)}.")
        return title
    bare = split_name(title)[0].lower()
    for i, name in enumerate(table.names):
        if name.lower() in (title.lower(), bare):
            return i
    near = difflib.get_close_matches(title, table.names, n=1, cutoff=0.5)
    advice = f" Did you mean {near[0]!r}?" if near else ""
    raise CurveError(f"{table.source}: there is no column {title!r} for {role}; there are {known}.{advice}")


def in_si(table: Table, role: str, index: int, given: Mapping[str, str] | None) -> Array:
    """One column in SI units; empty cells and text that is no number become NaN."""
    dimension = ROLES[role][0]
    unit = (given or {}).get(role) or table.units[index]
    name = table.names[index]
    if unit is None:
        raise CurveError(
            f"{table.source}: column {name!r} ({role}) has no unit. Write it into the header, '{name} ({dimension.common[0]})', "
            f"or pass units={{'{role}': '{dimension.common[-2 if len(dimension.common) > 4 else 0]}'}}."
        )
    try:
        scale = units.to_si(f"1 {unit}", dimension)
    except ValueError as error:
        raise CurveError(f"{table.source}: column {name!r} ({role}) {error}") from None
    return scale * _numbers(table, index)


def _numbers(table: Table, index: int) -> Array:
    cells = [row[index] if index < len(row) else "" for row in table.rows]
    commas = [i for i, cell in enumerate(cells) if isinstance(cell, str) and _COMMA.fullmatch(cell)]
    if commas:
        raise CurveError(
            f"{table.source}: row {table.first_row + commas[0]} of column {table.names[index]!r} reads {cells[commas[0]]!r}: "
            "decimal commas. Read the file with decimal=','."
        )
    return np.array([_number(cell) for cell in cells])


def _number(cell: Any) -> float:
    try:
        number = float(cell)
    except (TypeError, ValueError):
        return float("nan")
    # instruments write the largest float where there is no value
    return number if abs(number) < _NO_VALUE else float("nan")
