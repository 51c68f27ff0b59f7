"""Several records in one table, one below the other: where one ends and the next begins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.measured.columns import Table, chosen_columns, column_numbers
from flatpunch.fit.measured.curve import FEWEST, CurveError


def records_in(table: Table, columns: Mapping[str, str | int] | None) -> list[Table]:
    """The records of a table, or the table if it holds one.

    A record ends where the position jumps by more than half of its range from one reading to the next, which with times may be a
    fast step, and at blank lines and where time begins again, except where the tip goes on as before and between approach, pause
    and retract of one cycle.
    """
    try:
        positions = chosen_columns(table, columns)
        way = column_numbers(table, positions["depth" if "depth" in positions else "piezo"])
        time = column_numbers(table, positions["time"]) if "time" in positions else None
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
    edges = [0, *jumps.tolist(), way.size]
    if min(np.diff(edges)) < FEWEST:
        # a spike, or a single reading before the start
        edges = [0, way.size]
    edges = sorted({*edges, *_ends(way, sorted(breaks), span)})
    if len(edges) == 2 or min(np.diff(edges)) < FEWEST:
        return [table]
    return [
        replace(
            table,
            source=f"{table.source}, record {i + 1}",
            rows=table.rows[begin:end],
            first_row=table.first_row + begin,
            breaks=(),
        )
        for i, (begin, end) in enumerate(pairwise(edges))
    ]


def _goes_on(way: Array, at: int) -> bool:
    """Whether the tip moves across a break as before and after it: one way, without a gap."""
    few = max(FEWEST, way.size // 50)
    steps = [float(part[-1] - part[0]) for part in (way[max(at - few, 0) : at], way[at : at + few])]
    across = float(way[at] - way[at - 1])
    return steps[0] * steps[1] > 0 and abs(across) < min(map(abs, steps))


def _ends(way: Array, breaks: list[int], span: float) -> list[int]:
    """Breaks at which a record ends, which are not those between approach, pause and retract of one cycle."""
    blocks = list(pairwise([0, *(at for at in breaks if not _goes_on(way, at)), way.size]))
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
