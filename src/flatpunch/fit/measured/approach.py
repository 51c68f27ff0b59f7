"""Which way the tip goes, and where approach, hold and retract of a curve are: found once, with the reasons.

Positions decide (the piezo's where it is known), which no offset, tilt or noise of the force changes. Segments of the file are
used where there are any. The force is asked twice: which end of a long way is in contact, and where a load stops growing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from flatpunch._support.checks import TINY, Array
from flatpunch._support.prefixes import text
from flatpunch.fit.measured.bursts import without_bursts
from flatpunch.fit.measured.curve import FEWEST, Curve, CurveError
from flatpunch.fit.measured.cycles import turns
from flatpunch.fit.measured.signal import EXACT, middle, noise_of_readings, wander, without_spikes

Direction = Literal["auto", "growing", "falling"]

_SLOW = 0.5
"""Speed over that before, below which the tip rests.

With half of it nine more of 80 random pauses that creep on at up to half of the speed are refused as saturated; with 1 none
fewer, but the flat end of a saturated detector at a steady speed would be a pause as well.
"""
_TURNED = "The depth falls while the tip approaches; it was taken with its sign turned (growing into the sample)."


@dataclass(frozen=True, eq=False)
class Approach:
    """A curve with a depth that grows on the approach, and its parts.

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
    turns : bool
        Whether the tip comes back; otherwise there is one way only.
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
    turns: bool
    found: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def cycle(self) -> Curve:
        """Approach, hold and retract."""
        return _points(self.whole, self.begin, self.stop)

    @property
    def part(self) -> Curve:
        """The approach.

        Raises
        ------
        CurveError
            If next to nothing is left.
        """
        if self.end - self.begin < FEWEST:
            raise CurveError(
                f"{self.whole.name}: the tip only withdraws (deepest at point {self.end - 1} of {self.whole.depth.size}): this "
                "is a retract. Give the approach, or the whole cycle; direction = 'growing' or 'falling' overrides which way the "
                "depth goes on the approach."
            )
        return _points(self.whole, self.begin, self.end)

    @property
    def behind(self) -> Curve | None:
        """What follows the approach; None if next to nothing does."""
        return _points(self.whole, self.end, self.stop) if self.stop - self.end > FEWEST else None

    @property
    def retract(self) -> Curve | None:
        """The way back; None if there is next to none."""
        return _points(self.whole, self.leaves, self.stop) if self.stop - self.leaves >= FEWEST else None

    def signed(self, force: float) -> Approach:
        """Return the approach with the sign of the force turned if `force` is -1."""
        return self if force > 0 else replace(self, whole=self.whole.turned(force=-1.0))

    def backwards(self) -> Approach:
        """What follows the approach as an approach, with the depth turned: for a tip in contact at both ends of a curve."""
        rest = replace(_points(self.whole, self.end, self.stop), segment=None).turned(depth=-1.0)
        return replace(approach_of(rest, "growing"), turned=-self.turned)


def approach_of(curve: Curve, direction: Direction = "auto", *, first: bool = False, back: bool = False) -> Approach:
    """Find the parts of a curve.

    Parameters
    ----------
    curve : Curve
        As measured.
    direction : {"auto", "growing", "falling"}
        How the depth changes on the approach; by itself the long way decides.
    first : bool
        Of several loading cycles, the first instead of the one with the largest approach.
    back : bool
        A single way is a retract: its depth falls.

    Raises
    ------
    CurveError
        If force or depth never change.
    """
    for name, column, unit in (("force", curve.force, "N"), ("depth", curve.depth, "m")):
        if np.ptp(column) == 0:
            raise CurveError(
                f"{curve.name}: the {name} is {column[0]:.4g} {unit} at every point; is this the right column?"
            )
    # a force that is far off moves only one of them
    leaps = [(np.abs(c - (calm := without_spikes(c, 1))), float(np.ptp(calm))) for c in (curve.position, curve.depth)]
    leap = min((size for size, _ in leaps), key=np.max)
    if all(size.max() > way for size, way in leaps):
        raise CurveError(
            f"{curve.name}: the depth of reading {int(np.argmax(leap))}, counted from 0, is {text(float(leap.max()), 'm')} away "
            "from its neighbours, farther than all others are apart: was a decimal mark lost? Correct or drop this row."
        )
    curve, sorted_ = _in_time(curve)
    curve, bursts = without_bursts(curve)
    sorted_ += bursts
    relative = _relative_sign(curve)
    way, turn, why = _direction(curve, relative)
    if direction != "auto":
        way, why = (1 if direction == "growing" else -1), f"direction = '{direction}' is given"
    elif back and not turn:
        way, why = 1, "a single way, taken for a retract"
    curve = curve if way > 0 else curve.turned(depth=-1.0)
    notes: tuple[str, ...] = () if way > 0 else (_TURNED,)
    turned = 1.0 if way > 0 else -1.0
    pressing = turned * relative if curve.spring_constant and not curve.meta.get("piezo") else 1.0
    # the position of the base needs the sign of the force
    pressed = curve.turned(force=pressing)
    begin, stop, more = _cycle(pressed, first)
    if stop - begin < min(FEWEST, curve.depth.size):
        raise CurveError(
            f"{curve.name}: the tip turns every few readings, the largest approach has {stop - begin} of {curve.depth.size}: the "
            "rows are not in the order of the measurement. Sort them, or add a column of times."
        )
    end, leaves, reason = _parts(_points(pressed, begin, stop))
    found: tuple[str, ...] = (
        f"direction: the depth {'grows' if way > 0 else 'falls'} on the approach ({why})",
        f"approach: points {begin} to {begin + end - 1} of {curve.depth.size}, {reason}",
    )
    if leaves > end:
        found += (f"hold: points {begin + end} to {begin + leaves - 1}",)
    if stop - begin - leaves >= FEWEST:
        found += (f"retract: points {begin + leaves} to {stop - 1}",)
    return Approach(
        curve,
        begin,
        begin + end,
        begin + leaves,
        stop,
        turned,
        pressing,
        bool(turn),
        (*sorted_, *found, *more),
        (*sorted_, *notes, *more),
    )


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


def _points(curve: Curve, begin: int, end: int) -> Curve:
    """Consecutive points of a curve."""
    return curve if begin == 0 and end == curve.depth.size else curve.taken(slice(begin, end))


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


def _direction(curve: Curve, relative: float) -> tuple[int, int, str]:
    """1 if the position grows on the approach, else -1; 1 or -1 for the way of a first part that the tip comes back from; why."""
    position = curve.depth + curve.force / curve.spring_constant * relative if curve.spring_constant else curve.depth
    few = max(position.size // 100, 1)
    # the outermost of the readings at both ends: a fast ramp has gone far within a hundredth of all readings
    ends = position[:few], position[-few:]
    above = float(position.max()) - max(float(e.max()) for e in ends)
    below = min(float(e.min()) for e in ends) - float(position.min())
    if not max(above, below) > _least_return(position):
        return (1 if middle(ends[1]) >= middle(ends[0]) else -1), 0, "there is one way only"
    turn = 1 if above >= below else -1
    place = int(np.argmax(turn * position))
    there, back = (abs(float(position[place] - position[i])) for i in (0, -1))
    # a tip that starts by going back is free of contact where it turns, and the force changes most at the end of the long way
    if there < back / 2:
        rest = curve.force[place:]
        half = int(np.argmax(np.abs(position[place:] - position[place]) > back / 2))
        if np.ptp(rest[: half + 1]) < np.ptp(rest[half:]):
            return -turn, 0, f"the long way decides; the tip first goes back by {text(there, 'm')}"
    return turn, turn, "the tip turns at its deepest place"


def _cycle(curve: Curve, first: bool) -> tuple[int, int, tuple[str, ...]]:
    """Points of the loading cycle that is used, and a note where there are several."""
    n = curve.depth.size
    if curve.segment is not None or len(at := turns(curve.position)) < 2:
        return 0, n, ()
    ends = [0, *at, n - 1]
    advance = np.diff(curve.position[ends])[::2]
    if advance[0] <= 0:
        # the tip starts by going back
        ends, advance = ends[2:], advance[1:]
    chosen = 0 if first else 2 * int(np.argmax(advance))
    stop = n if chosen + 2 >= len(ends) - 1 else ends[chosen + 2] + 1
    if advance.size == 1:
        return ends[0], n, ()
    which = f"The curve has {advance.size} loading cycles; the largest approach, of cycle {chosen // 2 + 1}, is fitted."
    return ends[chosen], stop, () if first else (which,)


def _parts(curve: Curve) -> tuple[int, int, str]:
    """Where the approach of an oriented cycle ends, where its retract begins, and why."""
    position = curve.position
    near = _arrival(position)
    if curve.segment is not None and np.ptp(curve.segment) > 0:
        edges = list(pairwise(_edges(curve.segment)))
        at = int(np.argmax([position[b - 1] - position[a] for a, b in edges]))
        begin, last = edges[at]
        end = begin + _arrives(position[begin:last], near)
        # a tip that goes on at its mean speed is as close for the last readings without a pause
        if (last - end) * (position[last - 1] - position[begin]) <= near * (last - begin):
            end = last
        return end, _leaves(curve, edges[at + 1 :]), "the segment of the file in which the tip advances most"
    end = _arrives(position, near)
    leaves = max(int(np.flatnonzero(position >= float(position.max()) - 2 * near)[-1]) + 1, end)
    if (stops := _load_stops(curve, end)) < end:
        return (
            stops,
            leaves,
            "up to where the load stops growing, while the tip slows down (a hold, or a late unloading)",
        )
    if (rests := _rests(curve, end)) < end:
        return rests, leaves, "up to where the tip rests (a pause in which it creeps on)"
    return end, leaves, "up to the deepest position"


def _arrives(position: Array, near: float) -> int:
    """Readings up to the first at the largest position; those of a pause are short of it by noise only, and are no approach."""
    return int(np.argmax(position >= float(position.max()) - near)) + 1


def _leaves(curve: Curve, later: list[tuple[int, int]]) -> int:
    """Where the retract begins among the segments after the approach; the number of points where all of them are holds.

    Both tip and base of the cantilever go back: at a held depth the base alone does, at a held position the tip.
    """
    ways = [(each, _least_return(each)) for each in (curve.position, curve.depth)]
    return next((a for a, b in later if all(way[a] - way[b - 1] > least for way, least in ways)), curve.depth.size)


def _least_return(position: Array) -> float:
    """Way back that shows that the tip returns [m]; noise of the position and drift of a hold make a shorter one."""
    return max(8 * wander(position), 0.01 * float(np.ptp(position)))


def _edges(segment: Array) -> list[int]:
    """Where segments begin, and the number of points."""
    return [0, *(np.flatnonzero(np.diff(segment)) + 1).tolist(), segment.size]


def _arrival(position: Array) -> float:
    """How far below its largest value a position counts as having arrived there [m].

    Positions without noise still differ by rounding, where they are computed from tip and force.
    """
    # noise levels of the position below its largest value at which the tip has arrived
    return max(2.0 * wander(position), EXACT * float(np.ptp(position)))


def _pace(curve: Curve, begin: int, end: int) -> float:
    """Advance of the tip over the time between two points, or over the number of readings."""
    time = curve.time
    lasts = float(end - begin) if time is None or not time[end] > time[begin] else float(time[end] - time[begin])
    return float(curve.position[end] - curve.position[begin]) / lasts


def _bend(values: Array) -> int:
    """The reading at which values stop growing, by least squares to a straight line that ends in a constant."""
    # among as many of them as show the place to half a per cent; then among those around it
    step = max(values.size // 200, 1)
    at = np.arange(0, values.size, step)
    lines = np.minimum(at - at[1:-1, None], 0.0)
    lines -= lines.mean(axis=1, keepdims=True)
    place = int(at[1 + np.argmax(lines @ values[at] / np.linalg.norm(lines, axis=1))])
    if step == 1:
        return place
    around = 100 * max(step // 10, 1)
    begin = max(place - around, 0)
    return begin + _bend(values[begin : place + around])


def _load_stops(curve: Curve, end: int) -> int:
    """Where the force of an approach arrives at its largest value and the tip slows down; the end where it does not.

    A load that is held or taken back stops the tip; a detector that saturates does not, and neither does a slip of the sample.
    """
    force = curve.force[:end]
    few = max(end // 100, 3)
    sign = 1.0 if middle(force[-few:]) >= middle(force[: 10 * few]) else -1.0
    calm, noise = without_spikes(sign * force), noise_of_readings(force)
    # noise levels below the largest force at which the load has arrived; then the bend there, as noise crosses them on the ramp
    near = np.flatnonzero(calm >= float(calm.max()) - 4 * noise)
    reached, last = int(near[0]), int(near[-1])
    if last - reached > 1:
        # the upper half of a ramp of load is straight, what is before the contact is not
        begin = max(2 * reached - last, int(np.argmax(calm >= (calm.min() + calm.max()) / 2)))
        reached = max(reached, begin + _bend(calm[begin : last + 1]))
    if reached < FEWEST or (rest := end - 1 - reached) < 3:
        return end
    # the tip may be faster than before where creep begins or the load is taken back, and stops until it turns
    *before, latest = (
        _pace(curve, max(a, 0), b) for a, b in pairwise(reached + rest * np.array([-4, 0, 2, 3, 4]) // 4)
    )
    return end if latest > _SLOW * max(before) else reached + 1


def _rests(curve: Curve, end: int) -> int:
    """Where a pause begins in which the tip creeps on; the end where there is none.

    The pause begins at the reading that is farthest above the straight line from the first to the last, the corner of a motion
    at two speeds. It is a pause where the position then advances, per reading, less than half of what it did before, and the
    force goes no further; slow contact after a fast way to the surface is none.
    """
    if curve.segment is not None or end < 2:
        return end
    position, force = curve.position[:end], curve.force[:end]
    begin = int(np.argmax(position - np.linspace(position[0], position[-1], end)))
    if begin < FEWEST or end - 1 - begin < max(FEWEST, end // 50):
        return end
    before, after = (position[begin] - position[0]) / begin, (position[-1] - position[begin]) / (end - 1 - begin)
    few = max((end - begin) // 20, 3)
    start, corner, last = (middle(force[p]) for p in (slice(few), slice(begin, begin + few), slice(-few, None)))
    # a tip that creeps on by a few per cent of the depth presses a little more
    if after > _SLOW * before or abs(last - start) > 1.1 * abs(corner - start):
        return end
    return begin + 1
