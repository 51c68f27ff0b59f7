"""From a table to the tests in it, side by side or one below the other, each with its segments in the order of time."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.fit.measured.columns import (
    WORDS,
    Table,
    chosen_columns,
    column_numbers,
    listed,
    names_a_curve,
    recognised,
    split_name,
    way_of,
    words,
)
from flatpunch.fit.measured.curve import FEWEST, CurveError

Wanted = Mapping[str, str | int] | None

_TEST = re.compile(rf"(?:\b(?:{'|'.join(WORDS['tests']['before'])})\W*)?\d+\b", re.IGNORECASE)


def tests_in(table: Table, columns: Wanted) -> list[Table]:
    """The tests of a table: side by side, then one below the other; approach and retract side by side are segments of one."""
    return [
        record
        for test in _side_by_side(table, columns)
        for record in _one_below_the_other(_segmented(_with_sides(test, columns)), columns)
    ]


def _by_hand(table: Table, plain: list[str], columns: Wanted) -> bool:
    """Whether the user names columns as they stand in the file, by their number or by what a part would not be called."""
    left, stand = set(map(words, plain)), set(map(words, table.names))
    meant = [title if isinstance(title, int) else words(split_name(title)[0]) for title in (columns or {}).values()]
    exact = {title for title in (columns or {}).values() if title in table.names and words(str(title)) not in left}
    return bool(exact) or any(isinstance(m, int) or (m in stand and m not in left) for m in meant)


def _divided(table: Table, label: Callable[[int], tuple[str, str]]) -> dict[str, Table]:
    """Parts of a table by the label of each column, its title without the label and the part; "" is a column of all parts."""
    titled = [label(i) for i in range(len(table.names))]
    parts: dict[str, Table] = {}
    for part in dict.fromkeys(part for _, part in titled if part):
        at = [i for i, (_, its) in enumerate(titled) if its in ("", part)]
        own = [i for i in at if titled[i][1]]
        pairs = [(titled[i][0], table.units[i]) if table.units[i] else split_name(titled[i][0]) for i in at]
        filled = (table.rows[:, own] != "") & (table.rows[:, own] != None)  # noqa: E711
        kept = np.flatnonzero(filled.any(axis=1))
        parts[part] = replace(
            table,
            names=tuple(name.replace("_", " ") for name, _ in pairs),
            units=tuple(unit for _, unit in pairs),
            rows=table.rows[kept][:, at],
            breaks=tuple(sorted({int(np.searchsorted(kept, b)) for b in table.breaks} - {0, kept.size})),
            segment=None if table.segment is None else table.segment[kept],
        )
    return parts


def _side_by_side(table: Table, columns: Wanted) -> list[Table]:
    """Tests that have their own columns of position and force each, numbered or with the same titles again."""
    titles = list(zip(table.names, table.units, strict=True))

    def numbered(i: int) -> tuple[str, str]:
        name = table.names[i]
        found = _TEST.search(name.replace("_", " "))
        plain = _TEST.sub("", name.replace("_", " "), count=1).strip(" -:#,")
        return (plain, re.sub(r"\D", "", found[0])) if found and plain else (name, "")

    def repeated(i: int) -> tuple[str, str]:
        return table.names[i], str(titles[: i + 1].count(titles[i])) if titles.count(titles[i]) > 1 else ""

    for label in (numbered, repeated):
        parts = _divided(table, label)
        ways = {part: [label(i) for i in range(len(titles)) if label(i)[1] == part] for part in parts}
        pairs = {part: [(name, None) for name, _ in own] for part, own in ways.items()}
        whole = [part for part, own in pairs.items() if own and names_a_curve(own)]
        if len(whole) > 1 and not _by_hand(table, [name for own in ways.values() for name, _ in own], columns):
            return [replace(parts[part], source=f"{table.source}, test {part}") for part in whole]
    return [table]


def _with_sides(table: Table, columns: Wanted) -> Table:
    """A table whose columns of approach and of retract are one below the other; other tables are left as they are."""

    def side(i: int) -> tuple[str, str]:
        parts = re.split(r"([\s_:(\[,-]+)", table.names[i])
        at = next((at for at, part in enumerate(parts) if at % 2 == 0 and way_of(part) in ("forth", "back")), None)
        if at is None or len(parts) == 1:
            return table.names[i], ""
        rest = parts[: max(at - 1, 0)] + (parts[at + 1 :] if at else parts[2:])
        return "".join(rest).strip(" _:()[],-"), way_of(parts[at])

    sides = _divided(table, side)
    if set(sides) != {"forth", "back"} or _by_hand(table, [side(i)[0] for i in range(len(table.names))], columns):
        return table
    forth, back = (sides[way] for way in ("forth", "back"))
    own = [side(i)[0] for i in range(len(table.names)) if side(i)[1] == "forth"]
    if not any(recognised(*zip(*map(split_name, own), strict=True), role, set()) for role in ("force", "deflection")):
        return table
    titles = list(zip(back.names, back.units, strict=True))
    mine = list(zip(forth.names, forth.units, strict=True))
    if not names_a_curve(mine) or not set(mine) <= set(titles):
        return table
    rows = [forth.rows, back.rows[:, [titles.index(title) for title in mine]]]
    return replace(
        forth,
        rows=np.concatenate(rows),
        segment=np.repeat([0.0, 1.0], [len(part) for part in rows]),
        ways=("forth", "back"),
        breaks=(),
        segmented="approach and retract side by side",
    )


def _segmented(table: Table) -> Table:
    """A table with the segments that a column of it numbers or names.

    Segments are runs of equal cells; words stand at the first reading of a segment, or at all of them. A column that changes all
    the time is none of segments.
    """
    if table.segment is not None:
        return table
    about = WORDS["segments"]
    for index, name in enumerate(table.names):
        if not listed(name, about["titles"] + about["worded"]):
            continue
        cells = [str(cell if cell is not None else "").strip() for cell in table.rows[:, index]]
        for i, cell in enumerate(cells[1:], 1):
            cells[i] = cell or cells[i - 1]
        number = np.cumsum([0, *(a != b for a, b in pairwise(cells))])
        ways = tuple(way_of(cells[i]) for i in np.unique(number, return_index=True)[1])
        known = listed(name, about["titles"]) or any(ways)
        if known and 0 < number[-1] <= len(cells) // FEWEST:
            return replace(table, segment=number.astype(float), ways=ways, segmented=repr(name))
    return table


def _way(table: Table, columns: Wanted) -> tuple[Array, Array | None]:
    """Positions of a table, and times if it has any; a KeyError without positions."""
    at = chosen_columns(table, columns)
    time = column_numbers(table, at["time"]) if "time" in at else None
    return column_numbers(table, at["depth" if "depth" in at else "piezo"]), time


def _one_below_the_other(table: Table, columns: Wanted) -> list[Table]:
    """The records of a table, or the table if it holds one.

    A record ends where a column numbers another test, where the position jumps by more than half of its range from one reading to
    the next, which with times may be a fast step, and at blank lines and where time begins again, except where the tip goes on as
    before and between approach, pause and retract of one cycle.
    """
    try:
        way, time = _way(table, columns)
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
    inside = _inside(table)
    edges = [0, *(at for at in jumps.tolist() if at not in inside), way.size]
    if min(np.diff(edges)) < FEWEST:
        # a spike, or a single reading before the start
        edges = [0, way.size]
    edges = sorted({*edges, *_ends(way, sorted(breaks - inside), span), *_numbered(table)})
    if len(edges) == 2 or min(np.diff(edges)) < FEWEST:
        return [table]
    parts = [(f"{table.source}, record {i + 1}", slice(a, b)) for i, (a, b) in enumerate(pairwise(edges))]
    return [_part(table, source, rows) for source, rows in parts]


def _part(table: Table, source: str, rows: slice) -> Table:
    found = replace(table, source=source, rows=table.rows[rows], first_row=table.first_row + rows.start, breaks=())
    if table.segment is None:
        return found
    own, segment = np.unique(table.segment[rows], return_inverse=True)
    return replace(found, segment=segment.astype(float), ways=tuple(table.ways[int(i)] for i in own))


def _inside(table: Table) -> set[int]:
    """Rows at which another segment of the same cycle begins, wherever its own first reading is."""
    if table.segment is None:
        return set()
    at = np.flatnonzero(np.diff(table.segment)) + 1
    ways = pairwise(table.ways)
    whole = table.segmented == "blocks of the file"
    return {int(i) for i, (a, b) in zip(at, ways, strict=True) if whole or not (b == "forth" and a in ("back", "forth"))}


def _numbered(table: Table) -> list[int]:
    """Rows at which a column begins to number or name another test."""
    for index, name in enumerate(table.names):
        if listed(name, WORDS["tests"]["titles"]):
            cells = table.rows[:, index].astype(str)
            at = np.flatnonzero(cells[1:] != cells[:-1]) + 1
            if at.size <= len(cells) // FEWEST:
                return [int(i) for i in at]
    return []


def _tip_goes_on(way: Array, at: int) -> bool:
    """Whether the tip moves across a break as before and after it: one way, without a gap."""
    few = max(FEWEST, way.size // 50)
    steps = [float(part[-1] - part[0]) for part in (way[max(at - few, 0) : at], way[at : at + few])]
    across = float(way[at] - way[at - 1])
    return steps[0] * steps[1] > 0 and abs(across) < min(map(abs, steps))


def _ends(way: Array, breaks: list[int], span: float) -> list[int]:
    """Breaks at which a record ends, which are not those between approach, pause and retract of one cycle."""
    blocks = list(pairwise([0, *(at for at in breaks if not _tip_goes_on(way, at)), way.size]))
    if min(end - begin for begin, end in blocks) < FEWEST:
        # blank lines for readability
        return []
    found: list[int] = []
    # way of the record so far, positive inwards; None once the cycle is complete
    going: float | None = None
    for begin, end in blocks:
        part = way[begin:end]
        step, own = float(part[-1] - part[0]), float(np.ptp(part))
        # share of the range within which a tip rests, or goes on where the block before ended
        near = 0.1 * span
        pause = own < near
        joined = begin > 0 and abs(float(part[0] - way[begin - 1])) < near
        if begin and not (joined and (pause or going is not None)):
            found.append(begin)
            going = None
        if abs(step) > own / 2 and not pause:
            # the tip has come back: the cycle is complete
            going = None if going is not None and step * going < 0 else step
        elif not pause:
            going = None
    return found


def in_time(data: dict[str, Array], ways: tuple[str, ...]) -> dict[str, Array]:
    """Columns of a curve with its segments in the order of time, in whichever they are stored.

    An approach ends in contact, and each segment begins where the one before it ended; times go on growing.
    """
    time, segment, force = (data.get(name) for name in ("time", "segment", "force"))
    if segment is None or (time is not None and (np.diff(time) > 0).all()):
        return data
    way = data["piezo" if "piezo" in data else "depth"]
    force = data["deflection"] if force is None else force
    pieces = [(np.flatnonzero(segment == i), ways[int(i)]) for i in np.unique(segment)]
    called = [each for _, each in pieces]
    if called.count("back") == 1 and called[0] == "back" and "forth" in called:
        pieces = pieces[::-1]
    order: list[Indices] = []
    for piece, each in pieces:
        if not order:
            free = [begins_free(force[part]) for part in (piece, piece[::-1])]
            turned = each == "forth" and free == [False, True]
        else:
            first, last = (abs(way[piece[at]] - way[order[-1][-1]]) for at in (0, -1))
            turned = each in ("back", "") and last < first and first > np.ptp(way) / 2
        order.append(piece[::-1] if turned else piece)
    at = np.concatenate(order)
    found = {name: column[at] for name, column in data.items()}
    found["segment"] = np.repeat(np.arange(float(len(order))), [len(piece) for piece in order])
    if time is not None:
        # a segment that is stored backwards may have the times of its rows
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
    """The tables of several that are curves: positions and forces, and not one row a test; all of them if none is.

    Raises
    ------
    CurveError
        If there is no table at all, or none of several with a force; it says what there is.
    """
    if len(tables) < 2:
        return tables
    reasons, found = [], []
    # a test that was cut off has the titles of the others, a short sheet of results has its own
    titles = {table.names for table in tables if len(table.rows) >= FEWEST}
    for table in tables:
        try:
            roles = set(chosen_columns(table, columns))
            if {"force", "deflection"} & roles and {"depth", "piezo"} & roles and table.names in titles:
                found.append(table)
        except CurveError as error:
            if any(test is not table for test in _side_by_side(table, columns)):
                found.append(table)
            reasons.append(str(error))
    if not found:
        names = "; ".join(f"{t.source}: {', '.join(t.names)}" for t in tables)
        why = " ".join(reasons) or "Name the columns with columns=...."
        file = tables[0].source.split(", ")[0]
        raise CurveError(f"{file}: no table with a column of forces. Found {names}. {why}")
    return [table for table in found if not _of_results(table)] or found


def _of_results(table: Table) -> bool:
    """Whether a sheet has one row a test: by its name, or by a column that numbers or names the tests."""
    if listed(table.source.partition("sheet ")[2], WORDS["tests"]["results"]):
        return True
    for index, name in enumerate(table.names):
        if listed(name, WORDS["tests"]["titles"]):
            cells = [str(cell) for cell in table.rows[:, index] if cell not in (None, "")]
            # a number of the test beside each reading is the same all the time
            return 2 * len(set(cells)) > len(cells)
    return False
