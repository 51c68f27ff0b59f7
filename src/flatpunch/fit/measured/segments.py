"""Segments of a curve: which way the tip goes, and where the approach ends.

Judged by positions alone (the piezo's where it is known), which no offset, tilt or noise of the force changes. Where the file
knows its segments these are used; otherwise the approach ends where the position turns.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.measured.curve import FEWEST, Curve, CurveError

_CREEP = 0.5
"""Advance per reading, over that before, below which the tip may pause.

With half of it nine more of 80 random pauses that creep on at up to half of the speed are refused as saturated; with 1 none
fewer, but the flat end of a saturated detector at a steady speed would be a pause as well.
"""


def forwards(curve: Curve) -> tuple[Curve, tuple[str, ...]]:
    """The curve with a depth that grows on the approach, and a note if its sign had to be turned.

    Of a whole cycle the position has its turning point at the deepest place; a single segment moves towards the sample (whether
    it does is judged by `flatpunch.fit.elastic.setup`, which knows the shape of a contact).

    Raises
    ------
    CurveError
        If force or depth never change.
    """
    for name, column in (("force", curve.force), ("depth", curve.depth)):
        if np.ptp(column) == 0:
            unit = "N" if name == "force" else "m"
            raise CurveError(
                f"{curve.name}: the {name} is {column[0]:.4g} {unit} at every point; is this the right column?"
            )
    if _direction(curve) > 0:
        return curve, ()
    return curve.turned(depth=-1.0), (
        "The depth falls while the tip approaches; it was taken with its sign turned (growing into the sample).",
    )


def _middle(values: Array) -> float:
    """Median; a fifth of the time of NumPy's, which is what reading thousands of curves costs."""
    half = values.size // 2
    if values.size % 2:
        return float(np.partition(values, half)[half])
    ordered = np.partition(values, (half - 1, half))
    return float(ordered[half - 1] + ordered[half]) / 2


def turning(curve: Curve) -> int:
    """1 if the position grows to a turning point and falls, -1 for the opposite, 0 for a single segment."""
    position = curve.position
    few = max(position.size // 100, 1)
    # the outermost of the readings at both ends: a fast ramp has gone far within a hundredth of all readings
    ends = position[:few], position[-few:]
    above = float(position.max()) - max(float(e.max()) for e in ends)
    below = min(float(e.min()) for e in ends) - float(position.min())
    # noise alone makes neither a turning point
    if max(above, below) > max(8 * wander(position), 0.01 * float(np.ptp(position))):
        return 1 if above >= below else -1
    return 0


def _direction(curve: Curve) -> int:
    """1 if the position grows on the approach, else -1."""
    few = max(curve.position.size // 100, 1)
    grows = _middle(curve.position[-few:]) >= _middle(curve.position[:few])
    return turning(curve) or (1 if grows else -1)


def wander(position: Array) -> float:
    """Standard deviation of the noise of readings, from second differences, in which steady motion cancels."""
    # neighbours of a thousand points show as much as those of all
    # points from which the noise of a position is taken
    at = np.arange(0, max(position.size - 2, 0), max(position.size // 1000, 1))
    second = position[at + 2] - 2 * position[at + 1] + position[at]
    return float(1.4826 * _middle(np.abs(second)) / np.sqrt(6)) if second.size else 0.0


def approach(curve: Curve) -> Curve:
    """The part of a curve up to where its position turns, or its approach segment.

    Parameters
    ----------
    curve : Curve
        With a depth that grows on the approach.

    Raises
    ------
    CurveError
        If next to nothing is left.
    """
    end = approach_end(curve)
    if end < FEWEST:
        raise CurveError(
            f"{curve.name}: the tip only withdraws (deepest at point {end - 1} of {curve.depth.size}): this is a retract. Give "
            "the approach, or the whole cycle."
        )
    return curve if end == curve.depth.size else curve.taken(slice(0, end))


def approach_end(curve: Curve) -> int:
    """Number of points up to the end of the approach."""
    position = curve.position
    if curve.segment is not None and np.ptp(curve.segment) > 0:
        edges = _edges(curve.segment)
        return edges[int(np.argmax([position[b - 1] - position[a] for a, b in pairwise(edges)])) + 1]
    # pauses are short of the largest position by noise only, and are no approach
    return int(np.argmax(position >= float(position.max()) - arrival(position))) + 1


def retract_start(curve: Curve) -> int:
    """First point of the segment in which the position falls most, of a curve that knows its segments."""
    assert curve.segment is not None
    position, edges = curve.position, _edges(curve.segment)
    return edges[int(np.argmax([position[a] - position[b - 1] for a, b in pairwise(edges)]))]


def _edges(segment: Array) -> list[int]:
    """Where segments begin, and the number of points."""
    return [0, *(np.flatnonzero(np.diff(segment)) + 1).tolist(), segment.size]


def pieces(curve: Curve) -> list[slice]:
    """The segments that a curve knows, or all of it as one."""
    edges = [0, curve.depth.size] if curve.segment is None else _edges(curve.segment)
    return [slice(begin, end) for begin, end in pairwise(edges)]


def leaves(curve: Curve) -> int:
    """First point of the retract: that of its segment, or the last one near the largest position."""
    if curve.segment is not None and np.ptp(curve.segment) > 0:
        return retract_start(curve)
    position = curve.position
    return int(np.flatnonzero(position >= float(position.max()) - 2 * arrival(position))[-1]) + 1


def arrival(position: Array) -> float:
    """How far below its largest value a position counts as having arrived there [m].

    Positions without noise still differ by rounding, where they are computed from tip and force.
    """
    # noise levels of the position below its largest value at which the tip has arrived
    return max(2.0 * wander(position), 1e-9 * float(np.ptp(position)))


def without_pause(curve: Curve) -> Curve:
    """An approach without a pause at its end, in which the tip creeps on: where the file does not know its segments.

    The pause begins at the reading that is farthest above the straight line from the first to the last, the corner of a motion
    at two speeds. It is a pause where the position then advances, per reading, less than half of what it did before, and the
    force goes no further; slow contact after a fast way to the surface is none.
    """
    if curve.segment is not None:
        return curve
    position, n = curve.position, curve.depth.size
    at = np.arange(n)
    begin = int(np.argmax(position - position[0] - (position[-1] - position[0]) * at / (n - 1)))
    if begin < FEWEST or n - 1 - begin < max(FEWEST, n // 50):
        return curve
    before, after = (position[begin] - position[0]) / begin, (position[-1] - position[begin]) / (n - 1 - begin)
    few = max((n - begin) // 20, 3)
    start, corner, end = (_middle(curve.force[p]) for p in (slice(few), slice(begin, begin + few), slice(-few, None)))
    # a tip that creeps on by a few per cent of the depth presses a little more
    if after > _CREEP * before or abs(end - start) > 1.1 * abs(corner - start):
        return curve
    return curve.taken(slice(0, begin + 1))
