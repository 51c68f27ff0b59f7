"""Approach and retract side by side: columns such as `Defl_nm_Ex` and `Defl_nm_Rt`, one below the other in the order of time."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flatpunch.fit.measured.columns import Table, chosen_columns, column_numbers, names_a_curve, split_name
from flatpunch.fit.measured.curve import CurveError

_FORTH = {"ex", "extend", "approach", "appr", "trace", "forward"}
_BACK = {"rt", "retract", "retr", "withdraw", "retrace", "backward"}


def without_sides(table: Table, columns: Mapping[str, str | int] | None) -> Table:
    """A table whose columns of approach and of retract are joined, with their segments; other tables are left as they are.

    Columns that the user names by their number, or with the words for a side, are meant as they stand in the file.
    """
    sides = [_side(name) for name in table.names]
    forth = [i for i, (_, way) in enumerate(sides) if way > 0]
    back = [i for i, (_, way) in enumerate(sides) if way < 0]
    by_hand = any(
        isinstance(title, int) or _side(split_name(title)[0])[1] or _side(title)[1]
        for title in (columns or {}).values()
    )
    if not forth or by_hand:
        return table
    titles = [_titled(sides[i][0], table.units[i]) for i in range(len(sides))]
    partner = {titles[i]: i for i in back}
    if not all(titles[i] in partner for i in forth) or not names_a_curve(titles[i] for i in forth):
        return table
    # columns without a side, such as a number of the reading, belong to both
    kept = [i for i, (_, way) in enumerate(sides) if way >= 0]
    ways = [kept, [partner[titles[i]] if sides[i][1] else i for i in kept]]
    parts = [_rows(table, way, [at for at, i in enumerate(kept) if sides[i][1]]) for way in ways]
    joined = replace(
        table,
        names=tuple(titles[i][0] for i in kept),
        units=tuple(titles[i][1] for i in kept),
        rows=parts[0],
        breaks=(),
    )
    second = replace(joined, rows=parts[1])
    if _ends_first(joined, second, columns):
        parts[1] = parts[1][::-1]
    return replace(joined, rows=[*parts[0], *parts[1]], segment=np.repeat([0.0, 1.0], [len(part) for part in parts]))


def _side(title: str) -> tuple[str, int]:
    """A title without the word for a side, and 1 for the approach, -1 for the retract, 0 without such a word."""
    words = re.split(r"([ _]+)", title.strip())
    for way, names in ((1, _FORTH), (-1, _BACK)):
        at = next((i for i, word in enumerate(words) if word.lower() in names), None)
        if at is not None and len(words) > 1:
            rest = words[: max(at - 1, 0)] + (words[at + 1 :] if at else words[2:])
            return "".join(rest).strip(" _"), way
    return title, 0


def _titled(name: str, unit: str | None) -> tuple[str, str | None]:
    """Name and unit; the unit may have been hidden by the word for the side."""
    return (name.replace("_", " "), unit) if unit else split_name(name)


def _rows(table: Table, way: list[int], own: list[int]) -> list[list[object]]:
    """Rows of one side that are not empty."""
    rows = [[row[i] if i < len(row) else "" for i in way] for row in table.rows]
    return [row for row in rows if any(str(row[at] or "").strip() for at in own)]


def _ends_first(approach: Table, retract: Table, columns: Mapping[str, str | int] | None) -> bool:
    """Whether the last row of the retract is where the approach ended."""
    try:
        positions = chosen_columns(approach, columns)
    except CurveError:
        return False
    at = positions.get("piezo", positions.get("depth"))
    if at is None:
        return False
    ends, way = column_numbers(approach, at), column_numbers(retract, at)
    ends, way = ends[np.isfinite(ends)], way[np.isfinite(way)]
    return bool(ends.size and way.size and abs(way[-1] - ends[-1]) < abs(way[0] - ends[-1]))
