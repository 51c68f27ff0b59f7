"""From a table to the tests in it, side by side or one below the other, each with its segments in the order of time."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.fits.measured.columns import (
    FORCES,
    POSITIONS,
    WORDS,
    Table,
    chosen_columns,
    column_numbers,
    listed,
    roles_of,
    split_name,
    way_of,
    words,
)
from flatpunch.fits.measured.curve import FEWEST, CurveError

Wanted = Mapping[str, str | int] | None
Label = Callable[[str, int], tuple[str, str]]
"""From a title, and how often it was there before, to the title of a part of the table, and which part; "" for all parts."""

_TEST = re.compile(rf"(?:\b(?:{'|'.join(WORDS['tests']['before'])})\W*)?\d+\b", re.IGNORECASE)


def tests_in(table: Table, columns: Wanted) -> list[Table]:
    """The tests of a table: side by side, then one below the other; approach and retract side by side are segments of one."""
    numbered, again = _parts(table, _by_number, columns), _parts(table, _by_repetition, columns)
    beside = next((list(parts.values()) for parts in (numbered, again) if len(parts) > 1), [table])
    return [test for each in beside for test in _below(_with_segments(_with_sides(each, columns)), columns)]


def _by_number(title: str, before: int) -> tuple[str, str]:
    found = _TEST.search(text := title.replace("_", " "))
    plain = _TEST.sub("", text, count=1).strip(" -:#,")
    return (plain, re.sub(r"\D", "", found[0])) if found and plain else (title, "")


def _by_repetition(title: str, before: int) -> tuple[str, str]:
    return title, str(before + 1)


def _by_side(title: str, before: int) -> tuple[str, str]:
    parts = re.split(r"([\s_:(\[,-]+)", title)
    at = next((i for i, part in enumerate(parts) if i % 2 == 0 and way_of(part) in ("forth", "back")), None)
    if at is None or len(parts) == 1:
        return title, ""
    rest = parts[: max(at - 1, 0)] + (parts[at + 1 :] if at else parts[2:])
    return "".join(rest).strip(" _:()[],-"), way_of(parts[at])


def _parts(table: Table, label: Label, columns: Wanted) -> dict[str, Table]:
    """Parts of a table that have forces of their own, and positions; none if the user names columns as they stand in the file."""
    titles = list(zip(table.names, table.units, strict=True))
    titled = [label(title[0], titles[:i].count(title)) for i, title in enumerate(titles)]
    if label is _by_repetition:
        titled = [
            (name, part if titles.count(title) > 1 else "") for title, (name, part) in zip(titles, titled, strict=True)
        ]
    plain = [(name, unit) if unit else split_name(name) for (name, _), (_, unit) in zip(titled, titles, strict=True)]
    known = {words(name) for name, _ in plain}
    if any(isinstance(title, int) or words(split_name(title)[0]) not in known for title in (columns or {}).values()):
        return {}
    parts: dict[str, Table] = {}
    for part in dict.fromkeys(part for _, part in titled if part):
        at = [i for i, (_, its) in enumerate(titled) if its in ("", part)]
        own = [i for i in at if titled[i][1]]
        roles, around = roles_of([plain[i] for i in own]), roles_of([plain[i] for i in at])
        if not roles & FORCES or not (around if label is _by_side else roles) & POSITIONS:
            continue
        kept = np.flatnonzero(np.isin(table.rows[:, own].astype(str), ("", "None"), invert=True).any(axis=1))
        parts[part] = replace(
            table,
            source=f"{table.source}, test {part}",
            names=tuple(plain[i][0].replace("_", " ") for i in at),
            units=tuple(plain[i][1] for i in at),
            rows=table.rows[kept][:, at],
            breaks=tuple(sorted({int(np.searchsorted(kept, b)) for b in table.breaks} - {0, kept.size})),
            segment=None if table.segment is None else table.segment[kept],
        )
    return parts


def _with_sides(table: Table, columns: Wanted) -> Table:
    """A table whose columns of approach and of retract are one below the other; other tables are left as they are."""
    sides = _parts(table, _by_side, columns)
    if set(sides) != {"forth", "back"}:
        return table
    mine, other = (list(zip(sides[way].names, sides[way].units, strict=True)) for way in ("forth", "back"))
    if not set(mine) <= set(other):
        return table
    rows = [sides["forth"].rows, sides["back"].rows[:, [other.index(title) for title in mine]]]
    number = np.repeat([0.0, 1.0], [len(part) for part in rows])
    found = replace(sides["forth"], source=table.source, rows=np.concatenate(rows), breaks=())
    return replace(found, segment=number, ways=("forth", "back"), segmented="approach and retract side by side")


def _with_segments(table: Table) -> Table:
    """A table with the segments that a column of it numbers or names.

    Segments are runs of equal cells; words stand at the first reading of a segment, or at all of them. A column that changes all
    the time is none of segments.
    """
    about = WORDS["segments"]
    titles = [] if table.segment is not None else about["titles"] + about["worded"]
    for index in (i for i, name in enumerate(table.names) if listed(name, titles)):
        cells = ["" if cell is None else str(cell).strip() for cell in table.rows[:, index]]
        for i, cell in enumerate(cells[1:], 1):
            cells[i] = cell or cells[i - 1]
        number = np.cumsum([0, *(a != b for a, b in pairwise(cells))])
        ways = tuple(way_of(cells[i]) for i in np.unique(number, return_index=True)[1])
        known = listed(table.names[index], about["titles"]) or any(ways)
        if known and 0 < number[-1] <= len(cells) // FEWEST:
            return replace(table, segment=number.astype(float), ways=ways, segmented=repr(table.names[index]))
    return table


def _below(table: Table, columns: Wanted) -> list[Table]:
    """The records of a table one below the other, or the table if it holds one.

    A record ends where a column numbers another test, where the position jumps by more than half of its range from one reading to
    the next, which with times may be a fast step, and at blank lines and where time begins again unless the tip goes on there.
    """
    try:
        at = chosen_columns(table, columns)
        way = column_numbers(table, at["depth" if "depth" in at else "piezo"])
        time = column_numbers(table, at["time"]) if "time" in at else None
    except (CurveError, KeyError):
        # without a column of positions there is no curve, which `curve_of` reports
        return [table]
    if not np.isfinite(way).any():
        return [table]
    span = float(np.nanmax(way) - np.nanmin(way))
    breaks, jumps = set(table.breaks), np.zeros(0, dtype=np.intp)
    if time is not None and np.isfinite(time).all():
        since = time - time.min()
        breaks |= set((np.flatnonzero(since[1:] < since[:-1] / 2) + 1).tolist())
    else:
        jumps = np.flatnonzero(np.abs(np.diff(way)) > span / 2) + 1
    inside, cells = _inside(table), _tests(table)
    other = np.flatnonzero(cells[1:] != cells[:-1]) + 1
    edges: list[int] = []
    blocks = [0, *sorted(breaks - inside), way.size]
    # blank lines for readability, a spike, a single reading before the start, a number of each reading are none
    for found in (jumps, other):
        ends = [at for at in found.tolist() if at not in inside]
        edges += ends if min(np.diff([0, *ends, way.size])) >= FEWEST else []
    for end in blocks[1:-1] if min(np.diff(blocks)) >= FEWEST else []:
        edges += [end] if _ends(way, max([0, *(e for e in edges if e < end)]), end, span) else []
    edges = sorted({0, *edges, way.size})
    if len(edges) == 2 or min(np.diff(edges)) < FEWEST:
        return [table]
    return [_record(table, f"{table.source}, record {i + 1}", *ends) for i, ends in enumerate(pairwise(edges))]


def _record(table: Table, source: str, begin: int, end: int) -> Table:
    found = replace(table, source=source, rows=table.rows[begin:end], first_row=table.first_row + begin, breaks=())
    if table.segment is None:
        return found
    own, segment = np.unique(table.segment[begin:end], return_inverse=True)
    return replace(found, segment=segment.astype(float), ways=tuple(table.ways[int(i)] for i in own))


def _inside(table: Table) -> set[int]:
    """Rows at which another segment of the same cycle begins, wherever its own first reading is."""
    if table.segment is None:
        return set()
    at = (np.flatnonzero(np.diff(table.segment)) + 1).tolist()
    whole = table.segmented == "blocks of the file" or table.ways == ("back", "forth")
    return {
        i
        for i, (a, b) in zip(at, pairwise(table.ways), strict=True)
        if whole or b != "forth" or a not in ("back", "forth")
    }


def _tests(table: Table) -> Array:
    """The column that numbers or names tests; without one, all cells are the same."""
    at = next((i for i, name in enumerate(table.names) if listed(name, WORDS["tests"]["titles"])), None)
    return np.full(len(table.rows), "") if at is None else table.rows[:, at].astype(str)


def _ends(way: Array, begin: int, at: int, span: float) -> bool:
    """Whether a record that began there ends at a break: the tip is elsewhere, or it has come back and turns."""
    # share of the range within which a tip goes on where it was
    if abs(way[at] - way[at - 1]) > 0.1 * span:
        return True
    few, far = FEWEST // 2, float(np.abs(way[begin:at] - way[begin]).max())
    turns = (way[at - 1] - way[at - few]) * (way[min(at + few, way.size - 1)] - way[at]) <= 0
    return far > span / 2 and abs(way[at] - way[begin]) < far / 2 and bool(turns)


def in_time(data: dict[str, Array], ways: tuple[str, ...]) -> dict[str, Array]:
    """Columns of a curve with its segments in the order of time, in whichever they are stored.

    An approach ends in contact, and each segment begins where the one before it ended; times go on growing.
    """
    time, segment = data.get("time"), data.get("segment")
    timed = time is not None and bool((np.diff(time) > 0).all())
    if segment is None or (timed and "back" not in ways):
        return data
    way, force = (
        next(data[role] for role in roles if role in data) for roles in (("piezo", "depth"), ("force", "deflection"))
    )
    pieces = [(np.flatnonzero(segment == i), ways[int(i)]) for i in np.unique(segment)]
    called = [each for _, each in pieces]
    if called.count("back") == 1 and called[0] == "back" and "forth" in called:
        pieces = pieces[::-1]
    order: list[Indices] = []
    for piece, each in pieces:
        if not order:
            turned = each == "forth" and not timed and begins_free(force[piece[::-1]]) and not begins_free(force[piece])
        else:
            first, last = (abs(way[piece[at]] - way[order[-1][-1]]) for at in (0, -1))
            turned = each in ("back", "") and last < first and first > np.ptp(way) / 2
        order.append(piece[::-1] if turned else piece)
    at = np.concatenate(order)
    found = {name: column[at] for name, column in data.items()}
    found["segment"] = np.repeat(np.arange(float(len(order))), [len(piece) for piece in order])
    if time is not None:
        # a segment that is stored backwards has the times of its rows
        found["time"] = np.concatenate([time[np.sort(piece)] for piece in order])
    return found


def begins_free(force: Array) -> bool:
    """Whether the first readings are those of a free tip and the last ones the deepest contact.

    The force of a contact is convex in the depth. Over the last twentieth of the way in it covers more than a twentieth of its
    rise, at the free end less.
    """
    few = max(force.size // 20, 1)
    begin, end = (abs(float(part[-1] - part[0])) for part in (force[: few + 1], force[-few - 1 :]))
    return end > begin and end > few / force.size * float(np.ptp(force))


def curves_among(tables: list[Table], columns: Wanted) -> list[Table]:
    """The tables of several that are curves: positions and forces, and not one row a test; CurveError if none is."""
    if len(tables) < 2:
        return tables

    def measures(table: Table) -> bool:
        try:
            roles = set(chosen_columns(table, columns))
        except CurveError:
            # several columns could have a role, or the one that the user names is in other tables
            roles = set() if columns else roles_of(zip(table.names, table.units, strict=True))
        return bool(roles & FORCES and roles & POSITIONS)

    # a test that was cut off has the titles of the others, a short sheet of results has its own
    titles = {table.names for table in tables if len(table.rows) >= FEWEST}
    found = [table for table in tables if table.names in titles and measures(table)]
    if not found:
        names = "; ".join(f"{t.source}: {', '.join(t.names)}" for t in tables)
        raise CurveError(f"No table with a column of forces. Found {names}. Name the columns with columns=....")
    return [table for table in found if not _of_results(table)] or found


def _of_results(table: Table) -> bool:
    """Whether a sheet has one row a test: by its name, or by a column that numbers or names the tests."""
    cells = [cell for cell in _tests(table) if cell not in ("", "None")]
    # a number of the test beside each reading is the same all the time
    return (
        listed(table.source.partition("sheet ")[2], WORDS["tests"]["results"]) or 2 * len(set(cells)) > len(cells) > 0
    )
