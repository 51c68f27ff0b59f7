"""Load cycles of a record: where the tip turns, where loads are taken back, and the imprint, the depth that is not given back.

An elastic body gives back all of the depth that a load presses it in, along whatever curve it was loaded. Force and depth of the
first loading and of the unloading are each described by depth = d0 + a force^(1/m); what counts is the depth between zero force
and the same largest force on either way. The depth of the hold in between, and the zero of depths, cancel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy
from scipy.ndimage import uniform_filter1d

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.orientation import Approach
from flatpunch.fits.measured.signal import CLEAR, wander

TAKEN_BACK = 0.1
"""Share of a load by which the force must fall to count as unloading, and rise again to count as another cycle."""
TURN = 0.05
"""Share of their range by which positions must come back to count as a turn; shorter ways back are noise or drift."""


def smoothed(values: Array) -> Array:
    """Moving average over half a per cent of the points."""
    return np.asarray(uniform_filter1d(values, _averaged(values), mode="nearest"))


def _averaged(values: Array) -> int:
    return max(values.size // 200, 1)


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
    averaged = _averaged(curve.force)
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


IMPRINT = 0.2
"""Share of the depth above which an imprint is reported; drift and slow recovery of elastic bodies leave less."""
HARD = 1e8
"""Modulus [Pa] above which bodies yield rather than flow; softer ones keep their depth by viscosity."""
ENDS = TURN
"""Share of the largest force at either end in which the ways are not compared: noise and adhesion below, hold and creep above."""
LEVELS = 40
"""Force levels at which the depth is averaged, so that a hold counts no more than a ramp."""
FEWEST_LEVELS = 4
"""Levels that a way must have; three numbers of it are fitted."""
EXPONENTS = np.arange(1.0, 3.0 + 0.1 / 2, 0.1)
"""Exponents m of force over depth: 1 of flat ends, 2 of cones, more of layers on stiff bases."""
PLASTIC = (
    "an imprint is left, the loading was plastic, and an elastic fit of it gives no modulus. `flatpunch fit-film` (fit_film) "
    "takes the modulus from the unloading or from continuous stiffness."
)


@dataclass(frozen=True, slots=True)
class Imprint:
    """Share of the depth that is left after the unloading.

    Attributes
    ----------
    share, error : float
        Depth that is not given back over the depth that was pressed in, and its standard error [-].
    load : float
        Largest force of the load cycle [N].
    down_to : float
        Share of that force down to which the unloading was measured.
    """

    share: float
    error: float
    load: float
    down_to: float

    @property
    def seen(self) -> bool:
        """Whether the share is above IMPRINT by more than its error."""
        return self.share - self.error > IMPRINT


def imprint(curve: Curve) -> Imprint | None:
    """Judge the load cycle with the largest force of a whole record; None if no load is taken back, or too little of it.

    Parameters
    ----------
    curve : Curve
        Depth that grows into the sample, and force over its background.
    """
    cycles = load_cycles(curve)
    if not cycles:
        return None
    _, peak, end = max(cycles, key=lambda cycle: float(curve.force[cycle[1]]))
    force, depth = smoothed(curve.force), smoothed(curve.depth)
    load, noise = float(force[peak]), wander(curve.force)
    if load <= 0:
        return None
    # unloading begins where the force falls for good, or, at a held position, where the tip goes back
    back = peak + int(np.flatnonzero(force[peak : end + 1] > (1 - ENDS) * load)[-1])
    back += int(np.argmax(depth[back : end + 1]))
    low, high = max(ENDS * load, CLEAR / 2 * noise), min((1 - ENDS) * load, float(force[back]))
    highest, lowest = np.maximum.accumulate(force[: peak + 1]), np.minimum.accumulate(force[back : end + 1])
    slack = max(CLEAR * noise, 0.01 * load)
    virgin = np.flatnonzero(_between(highest, low, high) & (force[: peak + 1] > highest - slack))
    falling = np.flatnonzero(_between(lowest, low, high))
    loading = _extent(curve, virgin, highest[virgin], high, noise)
    unloading = _extent(curve, back + falling, lowest[falling], high, noise)
    if loading is None or unloading is None:
        return None
    (pressed, doubt), (returned, error) = loading, unloading
    ratio = returned / pressed
    down_to = max(float(lowest[-1]), 0.0) / load
    return Imprint(1 - ratio, ratio * float(np.hypot(doubt / pressed, error / returned)), load, down_to)


def _between(force: Array, low: float, high: float) -> Flags:
    return (force > low) & (force < high)


def _extent(curve: Curve, at: Indices, smooth: Array, high: float, noise: float) -> tuple[float, float] | None:
    """Depth between zero force and `high` on one way, and its standard error [m]; None from too few readings.

    `smooth` is the force of the readings `at`, in order, without noise.
    """
    level = (LEVELS * smooth / high).astype(int)
    count = np.bincount(level, minlength=1)
    if (there := count > 0).sum() < FEWEST_LEVELS:
        return None
    force, depth = (np.bincount(level, column[at])[there] / count[there] for column in (curve.force, curve.depth))
    force = np.maximum(force / high, 0.0)
    # notation: depth = d0 + a x with x = (P/P_high)^(1/m), a straight line for each exponent
    x = force ** (1 / EXPONENTS[:, None])
    x -= x.mean(axis=1, keepdims=True)
    square = (x**2).sum(axis=1)
    a = x @ depth / square
    misfit = ((depth - depth.mean() - a[:, None] * x) ** 2).sum(axis=1)
    freedom = max(depth.size - 3, 1)
    best = int(np.argmin(misfit))
    variance = max(misfit[best] / freedom, (a[best] * noise / high) ** 2 / count[there].mean())
    # exponents that describe the way as well, within two standard errors
    alike = np.abs(a[misfit <= misfit[best] + 4 * variance] - a[best]).max() / 2
    return (float(a[best]), float(np.hypot(np.sqrt(variance / square[best]), alike))) if a[best] > 0 else None


def _from_zero(read: Array, over: Array) -> Array:
    """Force of a record over its background, as far as the fit of a part of it shows one; else over its lowest force [N]."""
    # a line through the contact is no background
    if np.ptp(over) < np.ptp(read) / 2:
        return np.asarray(read - smoothed(read).min())
    # data that begin in contact leave the zero open, and no force is counted from below all that was measured
    return over - max(float(smoothed(over).min()), 0.0)


def refuse_plastic(part: Curve, found: Approach, over: Callable[[Curve], Array], young: float) -> tuple[str, ...]:
    """Load cycles that leave an imprint in a stiff body were plastic on loading; in soft ones that is one of the reasons noted.

    `part` is the approach as it is fitted, `over` gives the force of a curve over its background, `young` is the largest
    modulus that is fitted [Pa].
    """
    whole = found.whole
    left = imprint(replace(whole, force=_from_zero(whole.force, over(whole))))
    if left is None and found.turned < 0:
        # the fitted leg may be an unloading, over no background of the loading
        left = imprint(replace(whole.turned(depth=-1.0), force=whole.force - smoothed(whole.force).min()))
    if left is None or not left.seen:
        return ()
    share = left.share
    # the same force over the part of the depth that comes back: the body is that much harder than the loading shows
    if young >= HARD * (1 - share):
        raise CurveError(
            f"{part.name}: the unloading ends {share:.0%} of the depth short of where the loading began: {PLASTIC}"
        )
    return (
        f"The unloading ends {share:.0%} of the depth short of where the loading began: the body is viscous (relaxation= "
        "fits it), liquid drags at the cantilever (drag=), or the body yielded. If it yielded, the modulus is too low by a "
        f"factor of about {1 / (1 - share):.2g}.",
    )
