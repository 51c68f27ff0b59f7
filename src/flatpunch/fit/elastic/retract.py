"""The retraction far from the surface: no contact, and another speed than on the approach, which shows the drag of the liquid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.fit.elastic.background import over_line
from flatpunch.fit.least_squares.speed import shows_drag, speed_of
from flatpunch.fit.judge.orientation import Approach
from flatpunch.fit.measured.curve import FEWEST, Curve
from flatpunch.fit.measured.signal import EXACT, noise_of
from flatpunch.fit.parameters.settings import Settings


def free_retract(cycle: Approach, part: Curve, before: Flags) -> Indices:
    """Points of the retraction that are as far out as the background of the approach; none where the tip still sticks there.

    `part` is the approach in `cycle`, `before` marks its points that show the background alone.
    """
    curve, begin = cycle.cycle, cycle.leaves - cycle.begin
    if before.sum() < FEWEST or curve.depth.size - begin < FEWEST:
        return np.zeros(0, dtype=np.intp)
    out = curve.position[begin:] <= float(part.position[before].max())
    found = np.arange(begin + int(np.argmax(out)), curve.depth.size) if out.any() else np.zeros(0, dtype=np.intp)
    if found.size < FEWEST:
        return found[:0]
    back = curve.taken(found)
    noises = [noise_of(over_line(c, few)[few]) for c, few in ((part, before), (back, np.ones(found.size, dtype=bool)))]
    # a tip that still sticks bends the force; rounding of clean data bends it by 1e-9
    return found if noises[1] < 2 * noises[0] + EXACT * float(np.ptp(part.force)) else found[:0]


@dataclass(frozen=True, eq=False)
class FreeOfContact:
    """Points of a retraction without contact, and the drag that they show beside the approach.

    Attributes
    ----------
    points : ndarray of int
        Indices into the cycle.
    speed : ndarray
        Of the approach and of these points [m/s].
    level, drag : float
        Baseline [N] and drag [N s/m] through all that is free of contact.
    """

    points: Indices
    speed: Array
    level: float
    drag: float


def free_of_contact(
    cycle: Approach, part: Curve, before: Flags, background: Callable[[Curve], Array], settings: Settings
) -> FreeOfContact | None:
    """What the parts of approach and retraction without contact show of a drag that is free; None if they do not.

    `background` gives its force at a curve's positions, without level and drag [N]; other arguments as for `free_retract`.
    """
    found = free_retract(cycle, part, before)
    back = cycle.cycle.taken(found) if found.size else None
    if back is None or not shows_drag([part.taken(before), back], settings):
        return None
    approaching, leaving = speed_of(part, settings), speed_of(back, settings)
    assert approaching is not None
    assert leaving is not None
    over = np.concatenate([c.force - background(c) for c in (part.taken(before), back)])
    moving = np.concatenate([approaching[before], leaving])
    level, drag = np.linalg.lstsq(np.array([np.ones(moving.size), moving]).T, over, rcond=None)[0]
    return FreeOfContact(found, np.concatenate([approaching, leaving]), float(level), float(drag))
