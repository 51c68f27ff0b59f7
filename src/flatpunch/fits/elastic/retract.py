"""The retraction far from the surface: no contact, and another speed than on the approach, which shows the drag of the liquid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.fits.judge.readings import white_noise
from flatpunch.fits.least_squares.speed import shows_drag, speed_of
from flatpunch.fits.measured.curve import FEWEST, Curve
from flatpunch.fits.measured.orientation import Approach
from flatpunch.fits.measured.signal import EXACT
from flatpunch.fits.parameters.settings import Settings


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
    speed: tuple[Array, Array]
    level: float
    drag: float


def free_of_contact(
    cycle: Approach, part: Curve, before: Flags, background: Callable[[Curve], Array], settings: Settings
) -> FreeOfContact | None:
    """What the parts of approach and retraction without contact show of a drag that is free; None if they do not.

    `part` is the approach in `cycle`, `before` marks its readings without contact; the retraction has none as far out as these,
    unless the tip still sticks there, which bends the force. `background` gives its force at a curve's positions, without level
    and drag [N].
    """
    curve, begin = cycle.cycle, cycle.leaves - cycle.begin
    if before.sum() < FEWEST or curve.depth.size - begin < FEWEST:
        return None
    out = curve.position[begin:] <= float(part.position[before].max())
    found = np.arange(begin + int(np.argmax(out)), curve.depth.size) if out.any() else np.zeros(0, dtype=np.intp)
    if found.size < FEWEST:
        return None
    back, here = curve.taken(found), part.taken(before)
    left = [c.force - np.polynomial.Polynomial.fit(c.position, c.force, 1)(c.position) for c in (here, back)]
    # rounding of clean data bends it by 1e-9
    least = EXACT * float(np.ptp(part.force)) + white_noise(here.force, 0.0)
    if not np.std(left[1]) < 2 * max(float(np.std(left[0])), least) or not shows_drag([here, back], settings):
        return None
    speeds = [speed_of(c, settings) for c in (part, back)]
    assert speeds[0] is not None
    assert speeds[1] is not None
    over = np.concatenate([c.force - background(c) for c in (here, back)])
    moving = np.concatenate([speeds[0][before], speeds[1]])
    level, drag = np.linalg.lstsq(np.array([np.ones(moving.size), moving]).T, over, rcond=None)[0]
    return FreeOfContact(found, (speeds[0], speeds[1]), float(level), float(drag))
