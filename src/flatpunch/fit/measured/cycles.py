"""Loading cycles of a record: where the tip turns, its positions without their noise, and where loads are taken back."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import scipy

from flatpunch._support.checks import Array
from flatpunch.fit.measured.signal import CLEAR, wander


def smoothed(values: Array) -> Array:
    """Moving average over half a per cent of the points."""
    window = max(values.size // 200, 1)
    return np.convolve(np.pad(values, window // 2, "edge"), np.full(window, 1 / window), "valid")[: values.size]


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
    # share of the range by which positions must come back before it counts as a turn; smaller ways back are noise or drift
    least = 0.05 * float(np.ptp(smooth))
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


def load_cycles(force: Array) -> list[tuple[int, int, int]]:
    """Loading and unloading, again and again, to loads of any size: beginning, largest force and end of each cycle.

    A cycle ends where the force has fallen by a tenth of its largest value and by more than its noise, and rises again by as
    much or is over.

    Parameters
    ----------
    force : ndarray, shape (n,)
        [N], zero or more.
    """
    smooth, least = smoothed(force), CLEAR * wander(force)
    found: list[tuple[int, int, int]] = []
    begin = peak = valley = 0
    falling = False
    for i, value in enumerate(smooth.tolist()):
        # share of a load by which the force must fall, or rise again, to count as unloading, or as another cycle
        step = max(0.1 * smooth[peak], least)
        if not falling and value > smooth[peak]:
            peak = i
        elif not falling and smooth[peak] - value > step:
            falling, valley = True, i
        elif falling and value < smooth[valley]:
            valley = i
        elif falling and value - smooth[valley] > step:
            found.append((begin, peak, valley))
            begin, peak, falling = valley, i, False
    return [*found, (begin, peak, valley)] if falling else found
