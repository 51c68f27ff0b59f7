"""Loading cycles of a record: where the tip turns, its positions without their noise, and where loads are taken back."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import scipy
from scipy.ndimage import uniform_filter1d

from flatpunch._support.checks import Array
from flatpunch.fits.measured.curve import Curve
from flatpunch.fits.measured.signal import CLEAR, wander

TAKEN_BACK = 0.1
"""Share of a load by which the force must fall to count as unloading, and rise again to count as another cycle."""
TURN = 0.05
"""Share of their range by which positions must come back to count as a turn; shorter ways back are noise or drift."""


def smoothed(values: Array) -> Array:
    """Moving average over half a per cent of the points."""
    return np.asarray(uniform_filter1d(values, max(values.size // 200, 1), mode="nearest"))


def turns(position: Array) -> list[int]:
    """Points at which positions turn: deepest, furthest out, deepest, ..., an odd number of them.

    Parameters
    ----------
    position : ndarray, shape (n,)
        Growing into the sample; the history begins and ends outside its deepest points.
    """
    smooth = smoothed(position)
    # a history may begin or end at a deepest point
    padded = np.concatenate([[-np.inf], smooth, [-np.inf]])
    least = TURN * float(np.ptp(smooth))
    deepest = (scipy.signal.find_peaks(padded, prominence=least)[0] - 1).tolist()
    found: list[int] = deepest[:1]
    for after in deepest[1:]:
        valley = found[-1] + int(np.argmin(smooth[found[-1] : after]))
        # equal values of a hold are peaks of the same prominence
        if smooth[found[-1]] - smooth[valley] > least:
            found += [valley, after]
    return found


def levelled(values: Array, at: list[int]) -> Array:
    """Least squares to values that rise to the first turn, fall to the second, and so on."""
    result = np.empty(values.size)
    ends = [0, *at, values.size - 1]
    for i, (begin, end) in enumerate(pairwise(ends)):
        piece = scipy.optimize.isotonic_regression(values[begin : end + 1], increasing=i % 2 == 0).x
        if i:
            # both sides end at the same value, the more extreme one
            piece[0] = (max if i % 2 else min)(piece[0], result[begin])
        result[begin : end + 1] = piece
    return result


def load_cycles(curve: Curve) -> list[tuple[int, int, int]]:
    """Loading and unloading, again and again, to loads of any size: beginning, largest force and end of each cycle.

    The force of a cycle rises while the tip advances, and falls by a tenth of its rise, and by more than its noise, while the
    tip goes back. A force that drifts or waves before the contact, while the tip only advances, makes no cycle, and neither
    does a pop-in.

    Parameters
    ----------
    curve : Curve
        A record whose depth grows into the sample; its force may count from any zero.
    """
    averaged = max(curve.force.size // 200, 1)
    # means over neighbouring stretches that overlap by three quarters lose nothing that those of every reading have
    at = np.append(np.arange(0, curve.force.size - 1, max(averaged // 4, 1)), curve.force.size - 1)
    force, depth = smoothed(curve.force)[at], smoothed(curve.depth)[at]
    least = CLEAR * wander(curve.force)
    way = CLEAR * wander(curve.depth) / np.sqrt(averaged)
    found: list[tuple[int, int, int]] = []
    begin = peak = valley = 0
    # the largest force without a contact, as far as the record shows one
    lowest = without = float(force[0])
    falling = False

    def taken_back() -> bool:
        # the tip may creep on between the largest load and the unloading
        return bool(depth[peak : valley + 1].max() - max(depth[begin], depth[valley]) > way)

    def cycle() -> tuple[int, int, int]:
        free = np.flatnonzero(force[begin:peak] <= without)
        first = begin + int(free[-1]) if free.size else begin
        return int(at[first]), int(at[peak]), int(at[valley])

    for i, value in enumerate(force.tolist()):
        lowest = min(lowest, value)
        step = max(TAKEN_BACK * (force[peak] - lowest), least)
        if not falling and value > force[peak]:
            peak = i
        elif not falling and force[peak] - value > step:
            falling, valley = True, i
        elif falling and value < force[valley]:
            valley = i
        elif falling and value - force[valley] > step:
            if taken_back():
                found.append(cycle())
                begin = valley
            else:
                without = max(without, float(force[peak])) if not found else without
                # a tip without contact may go anywhere
                begin = valley if depth[valley] < depth[begin] else begin
            peak, falling = i, False
    return [*found, cycle()] if falling and taken_back() else found
