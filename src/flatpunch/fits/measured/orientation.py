"""Which way the tip goes, and where approach, hold and retract of a record are, from the positions alone.

The running median of the position, mirrored at its ends, has no single bad readings. Its turning points, or the segments of the
file, divide the record into legs; an approach is a leg that goes at least half as far as the longest. No offset, tilt or noise
of the force changes them. Where several legs are long enough the first in which a contact is seen is the approach.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.ndimage import median_filter

from flatpunch._support.checks import TINY, Array
from flatpunch._support.prefixes import text
from flatpunch.fits.measured.curve import FEWEST, Curve, CurveError
from flatpunch.fits.measured.signal import CALM, EXACT, LITTLE, wander

Direction = Literal["auto", "growing", "falling"]

_LEG = 0.5
"""Share of the longest leg from which a leg can be the approach."""
_NOISE = 8.0
"""Noise levels of the position that are no turn: noise makes no longer way back in 1e5 readings."""
FALLS = "The force falls while the tip presses; it was taken with its sign turned (positive when pressing)."
_TURNED = "The depth falls while the tip approaches; it was taken with its sign turned (growing into the sample)."


@dataclass(frozen=True, eq=False)
class Approach:
    """A record with a depth that grows on the approach, and its parts.

    Attributes
    ----------
    whole : Curve
        All of the record, oriented.
    begin, end, leaves, stop : int
        Points of the record: the approach is begin:end, the hold end:leaves, the retract leaves:stop.
    turned : float
        -1 where the sign of the depth was turned.
    pressing : float
        -1 where the noise of tip and force show that the force is negative when pressing.
    found : tuple of str
        What was found, and why.
    notes : tuple of str
        What users of a fit must know of it.
    """

    whole: Curve
    begin: int
    end: int
    leaves: int
    stop: int
    turned: float
    pressing: float
    found: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def cycle(self) -> Curve:
        """Approach, hold and retract."""
        return self.whole.taken(slice(self.begin, self.stop))

    @property
    def part(self) -> Curve:
        """The approach."""
        return self.whole.taken(slice(self.begin, self.end))

    @property
    def behind(self) -> Curve | None:
        """What follows the approach; None if next to nothing does."""
        return self.whole.taken(slice(self.end, self.stop)) if self.stop - self.end > FEWEST else None

    @property
    def retract(self) -> Curve | None:
        """The way back; None if there is next to none."""
        return self.whole.taken(slice(self.leaves, self.stop)) if self.stop - self.leaves >= FEWEST else None

    def signed(self, force: float) -> Approach:
        """Return the approach with the sign of the force turned if `force` is -1."""
        return self if force > 0 else replace(self, whole=self.whole.turned(force=-1.0))


def approach_of(curve: Curve, direction: Direction = "auto", *, back: bool = False) -> Approach:
    """The first leg that can be the approach, see `approaches`."""
    return next(approaches(curve, direction, back=back))


def approaches(curve: Curve, direction: Direction = "auto", *, back: bool = False) -> Iterator[Approach]:
    """Legs of a record that can be its approach, in the order of time.

    Parameters
    ----------
    curve : Curve
        As measured.
    direction : {"auto", "growing", "falling"}
        How the depth changes on the approach.
    back : bool
        A record of a single way is a retract: its depth falls.

    Raises
    ------
    CurveError
        If force or depth never change, or the tip nowhere advances over enough readings.
    """
    for name, column, unit in (("force", curve.force, "N"), ("depth", curve.depth, "m")):
        if np.ptp(column) == 0:
            raise CurveError(
                f"{curve.name}: the {name} is {column[0]:.4g} {unit} at every point; is this the right column?"
            )
    curve, notes = _in_time(curve)
    relative = _relative_sign(curve)
    position = curve.turned(force=relative).position
    unordered = CurveError(
        f"{curve.name}: the tip turns every few readings: the rows are not in the order of the measurement. Sort them, or "
        "add a column of times."
    )
    # from one reading to the next the tip goes nowhere near as far as over the record
    if curve.segment is None and _NOISE * wander(position) > float(np.ptp(position)) / 2:
        raise unordered
    ends, smooth = _legs(curve, position)
    ways = np.diff(smooth[ends])
    longest, legs = float(np.abs(ways).max()), list(pairwise(ends))
    chosen = [i for i, way in enumerate(ways) if abs(way) >= _LEG * longest and legs[i][1] - legs[i][0] >= FEWEST - 1]
    if back and len(chosen) == 1 and direction == "auto" and ways[chosen[0]] < 0:
        # the only way is the retract, and nothing comes before it
        yield _found(curve, relative, 1.0, [], chosen[0], "a single way, taken for a retract", notes)
        return
    if direction != "auto":
        sign = 1.0 if direction == "growing" else -1.0
        chosen = [i for i in chosen if sign * ways[i] > 0]
        if not chosen:
            raise CurveError(
                f"{curve.name}: the depth is nowhere {direction} over half of the longest way: this is a retract. Give the "
                "approach, or the whole cycle; direction = 'auto' lets the longest way decide."
            )
    if not chosen:
        raise unordered
    several = sum(np.sign(ways[i]) == np.sign(ways[chosen[0]]) for i in chosen)
    for i in chosen:
        why = (
            f"direction = '{direction}' is given"
            if direction != "auto"
            else "the first way of at least half of the longest"
        )
        before = sum(j < i and ways[j] * ways[i] > 0 for j in chosen)
        more = (f"The record has {several} loading cycles; cycle {1 + before} is fitted.",)
        yield _found(curve, relative, float(np.sign(ways[i])), legs, i, why, (*notes, *(more if several > 1 else ())))


def _found(
    curve: Curve,
    relative: float,
    sign: float,
    legs: list[tuple[int, int]],
    leg: int,
    why: str,
    notes: tuple[str, ...],
) -> Approach:
    """The record oriented for one leg as its approach."""
    n = curve.depth.size
    turned = curve.turned(depth=sign)
    pressing = sign * relative if curve.spring_constant and not curve.meta.get("piezo") else 1.0
    position = turned.turned(force=pressing).position
    if legs:
        begin, last = legs[leg]
        # legs share their turning points, segments do not
        begin += leg > 0 and curve.segment is not None
        # noise of the position at which the tip has arrived; readings of a pause are short of it by noise only
        near = max(2 * wander(position), EXACT * float(np.ptp(position)))
        stop = legs[leg + 1][1] + 1 if leg + 1 < len(legs) else n
        if curve.segment is not None:
            # a cycle ends where a segment goes as far the same way again
            ways = [float(turned.depth[b] - turned.depth[a]) for a, b in legs]
            stop = next((a + 1 for (a, _), w in zip(legs, ways, strict=True) if a > begin and w > _LEG * ways[leg]), n)
        elif leg + 2 >= len(legs):
            stop = n
        way = position[begin : last + 1]
        end = last + 1 if curve.segment is not None else begin + int(np.argmax(way >= way.max() - near)) + 1
        deepest = float(position[begin:stop].max())
        leaves = max(int(np.flatnonzero(position[begin:stop] >= deepest - 2 * near)[-1]) + 1 + begin, end)
        if curve.segment is not None:
            leaves = _leaves(turned, pressing, end, stop)
    else:
        begin, end, leaves, stop = 0, 1, 1, n
    found: tuple[str, ...] = (
        f"direction: the depth {'grows' if sign > 0 else 'falls'} on the approach ({why})",
        f"approach: points {begin} to {end - 1} of {n}",
    )
    if leaves > end:
        found += (f"hold: points {end} to {leaves - 1}",)
    if stop - leaves >= FEWEST:
        found += (f"retract: points {leaves} to {stop - 1}",)
    said = (*notes, _TURNED) if sign < 0 else notes
    return Approach(turned, begin, end, leaves, stop, sign, pressing, (*notes, *found), said)


def _legs(curve: Curve, position: Array) -> tuple[list[int], Array]:
    """Ends of the legs of a record, readings from the first to the last, and the position without single bad readings."""
    smooth = median_filter(position, CALM, mode="mirror")
    if curve.segment is not None and np.ptp(curve.segment) > 0:
        edges = (np.flatnonzero(np.diff(curve.segment))).tolist()
        return [0, *edges, position.size - 1], smooth
    # shorter ways back are no turn
    least = max(LITTLE * float(np.ptp(smooth)), _NOISE * wander(position))
    # readings that jump away are no turn
    usual = np.where(np.abs(position - smooth) <= least, position, np.nan)
    # the first reading is the end of a leg, but no turn
    turns = [_around(usual, turn) for turn in _turns(smooth.tolist(), least) if turn[0] > 0]
    return sorted({0, *turns, position.size - 1}), smooth


def _around(position: Array, turn: tuple[int, int]) -> int:
    """The extreme reading near a turning point of smooth positions."""
    i, way = turn
    low = max(i - 2, 0)
    return low + int(np.nanargmax(way * position[low : i + 3]))


def _turns(values: list[float], least: float) -> list[tuple[int, int]]:
    """Places where values turn by more than `least`, and 1 for a maximum or -1 for a minimum."""
    found: list[tuple[int, int]] = []
    low = high = way = 0
    for i, value in enumerate(values):
        if value > values[high]:
            high = i
        if value < values[low]:
            low = i
        if way >= 0 and values[high] - value > least:
            found.append((high, 1))
            way, low = -1, i
        elif way <= 0 and value - values[low] > least:
            found.append((low, -1))
            way, high = 1, i
    return found


def _in_time(curve: Curve) -> tuple[Curve, tuple[str, ...]]:
    """The readings in the order of their times, and a note, where the tip then goes a shorter way than in the order of the file.

    Times may begin again at the retract.
    """
    if curve.time is None or curve.segment is not None or (np.diff(curve.time) >= 0).all():
        return curve, ()
    order = np.argsort(curve.time, kind="stable")
    if np.abs(np.diff(curve.position[order])).sum() >= np.abs(np.diff(curve.position)).sum():
        return curve, ()
    return curve.taken(order), ("The readings are not in the order of their times; they were sorted.",)


def pieces(curve: Curve) -> list[slice]:
    """The segments that a curve knows, or all of it as one."""
    edges = [0, curve.depth.size] if curve.segment is None else _edges(curve.segment)
    return [slice(begin, end) for begin, end in pairwise(edges)]


def _edges(segment: Array) -> list[int]:
    """Where segments begin, and the number of points."""
    return [0, *(np.flatnonzero(np.diff(segment)) + 1).tolist(), segment.size]


def _leaves(turned: Curve, pressing: float, end: int, stop: int) -> int:
    """Where the retract begins among the segments after the approach; where the cycle stops if all of them are holds.

    Both tip and base of the cantilever go back: at a held depth the base alone does, at a held position the tip.
    """
    curve = turned.turned(force=pressing)
    assert curve.segment is not None
    ways = [(each, max(_NOISE * wander(each), 0.01 * float(np.ptp(each)))) for each in (curve.position, curve.depth)]
    later = [(a, b) for a, b in pairwise(_edges(curve.segment)) if end <= a < stop]
    return next((a for a, b in later if all(way[a] - way[b - 1] > least for way, least in ways)), stop)


def _relative_sign(curve: Curve) -> float:
    """-1 where the depth of a tip behind a cantilever and its force have opposite signs, so that only one of them grows.

    Noise of the force moves the tip by -noise/k, or by nothing where the tip has a sensor of its own: the nearest of -1, 0 and 1
    to the slope of the second differences of k depth over those of the force decides. Without such noise the way of the base is
    the longer one: in contact tip and cantilever both go on.
    """
    if curve.spring_constant is None or curve.meta.get("piezo"):
        return 1.0
    bent = curve.force / curve.spring_constant
    tip, force = (np.diff(each, 2) for each in (curve.depth, bent))
    if abs(slope := float(tip @ force) / max(float(force @ force), TINY)) > 0.5:
        return -1.0 if slope > 0 else 1.0
    return 1.0 if np.ptp(curve.depth + bent) >= np.ptp(curve.depth - bent) else -1.0


def leap_note(curve: Curve) -> tuple[str, ...]:
    """A position that is farther from its neighbours than all others are apart."""
    calm = median_filter(curve.position, CALM, mode="mirror")
    size = np.abs(curve.position - calm)
    far = np.flatnonzero(size > float(np.ptp(calm)))
    if not far.size:
        return ()
    return (
        f"The depth of {far.size} reading{'s' if far.size > 1 else ''} (the first is reading {int(far[0])}, counted from 0) is "
        f"up to {text(float(size.max()), 'm')} away from its neighbours, farther than all others are apart: left out.",
    )
