"""The retraction far from the surface: no contact, and another speed than on the approach, which shows the drag of the liquid."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Flags, Indices
from flatpunch.fit.elastic.background import over_line
from flatpunch.fit.measured.curve import FEWEST, Curve
from flatpunch.fit.measured.segments import approach_end, leaves
from flatpunch.fit.measured.signal import noise_of


def free_retract(curve: Curve, part: Curve, before: Flags) -> Indices:
    """Points of the retraction that are as far out as the background of the approach; none where the tip still sticks there.

    Parameters
    ----------
    curve : Curve
        The whole cycle, of which `part` is the beginning.
    part : Curve
        The approach.
    before : ndarray of bool
        Its points that show the background alone.
    """
    begin = max(leaves(curve), approach_end(curve))
    if before.sum() < FEWEST or curve.depth.size - begin < FEWEST:
        return np.zeros(0, dtype=np.intp)
    out = curve.position[begin:] <= float(part.position[before].max())
    found = np.arange(begin + int(np.argmax(out)), curve.depth.size) if out.any() else np.zeros(0, dtype=np.intp)
    if found.size < FEWEST:
        return found[:0]
    back = curve.taken(found)
    noises = [noise_of(over_line(c, few)[few]) for c, few in ((part, before), (back, np.ones(found.size, dtype=bool)))]
    # a tip that still sticks bends the force; rounding of clean data bends it by 1e-9
    return found if noises[1] < 2 * noises[0] + 1e-9 * float(np.ptp(part.force)) else found[:0]
