"""Drops of the force of a contact while the tip goes on: breakthrough, slip, pop-in."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.optimize import isotonic_regression
from scipy.special import ndtri

from flatpunch._support.checks import Array, Flags
from flatpunch._support.prefixes import text
from flatpunch.fit.measured.curve import FEWEST
from flatpunch.fit.measured.signal import (
    CLEAR,
    EXACT,
    converter_step,
    noise_of,
    noise_of_readings,
    spread_of,
    wander,
    without_spikes,
)

RARE = 1e-3
"""Probability with which noise alone makes a drop somewhere in a curve; twice as much lowers the smallest drop by 2 %."""

RISEN = 0.1
"""Share of the largest force below which a rise is none of a contact."""


@dataclass(frozen=True)
class Drop:
    """A fall of the force of a contact while the tip goes on.

    Attributes
    ----------
    at : int
        Last point before it.
    size, largest : float
        Of the fall, and of the force over its background [N].
    gradual : bool
        Whether the force falls steadily to the end of the approach.
    """

    at: int
    size: float
    largest: float
    gradual: bool = False

    def note(self, depth: float, cut: bool) -> str:
        """What was found at a depth [m], and what is fitted: what lies before it, or the part that the user gave."""
        size, place = f"{text(self.size, 'N')} ({self.size / self.largest:.1%} of the largest force)", text(depth, "m")
        return (
            (
                f"From {place} on the force falls by {size} until the tip turns (the load is taken back, or the sample yields): "
                if self.gradual
                else f"The force drops by {size} at {place} while the tip goes on (breakthrough, slip or pop-in): "
            )
            + ("what lies before it is fitted; " if cut else "it is in the part that is fitted; ")
            + "depth_to or force_to choose the part."
        )


def _edge(count: int = FEWEST) -> Array:
    """Weights of two times so many readings whose sum is a step in their middle.

    Straight lines through the readings on either side are extended to the step, so that neither a slope nor a corner is one.
    """
    along = np.arange(count) - (count - 1) / 2
    side = 1 / count + count / 2 * along / float(along @ along)
    return np.append(-side, side[::-1])


def steps(force: Array) -> Array:
    """Step of the force over FEWEST readings from each one on [N]; empty if there are too few."""
    return np.asarray(
        np.correlate(without_spikes(force, 1), _edge(), "valid") if force.size >= 2 * FEWEST else force[:0]
    )


def noise_near(force: Array) -> float:
    """Noise of a force as neighbours show it, or steps, which show slower noise as well, whatever slope and curvature [N]."""
    slow = spread_of(steps(force)) / float(np.linalg.norm(_edge())) if force.size >= 2 * FEWEST else 0.0
    return max(noise_of_readings(force), slow)


def breaks(force: Array) -> list[int]:
    """Readings before which a force steps by more than its noise explains, in order; the step is FEWEST readings later.

    The noise is that of these steps. Beside a large step smaller ones of the opposite sign are found as well.
    """
    found = np.abs(steps(force))
    if not found.size:
        return []
    # most steps of a digitised force may be none
    rounding = float(np.linalg.norm(_edge())) * converter_step(force) / np.sqrt(12)
    clear = found > CLEAR * max(spread_of(found), rounding)
    return [int(at) for at in np.flatnonzero(clear & (found == maximum_filter1d(found, FEWEST)))]


def drop_of(read: Array, over: Array, free: Flags, noise: float) -> Drop | None:
    """The fall of the force of a contact by more than its noise explains, the first of several of about the same size.

    Single readings are compared, and means of 4 and of 16, which show smaller falls.

    Parameters
    ----------
    read, over : ndarray, shape (n,)
        Force as read and over its background, in the order of the approach [N]. The reading falls as well: over a
        background that the flat end of a saturated detector falsified the force does, its reading does not.
    free : ndarray of bool, shape (n,)
        Points without contact; they show noise that is slower than readings.
    noise : float
        Of neighbouring readings [N].
    """
    found = []
    for count in (1, 4, 16):
        if read.size < 4 * count:
            break
        means, as_read = (np.convolve(c, np.full(count, 1 / count), "valid") for c in (over, read))
        alone = free[: means.size] & free[-means.size :]
        # neighbours may be equal, or filtered
        own = max(noise / np.sqrt(count), noise_of(means[alone]), wander(means, max(count, 4)))
        # noise makes two of so many independent means differ by this much with the probability RARE
        pairs = (means.size / count) ** 2 / 2
        least, rise = float(-ndtri(RARE / pairs) * np.sqrt(2) * own), float(means.max())
        top, risen = np.maximum.accumulate(means), np.maximum.accumulate(means - np.minimum.accumulate(means))
        fall = np.where(risen > max(least, RISEN * rise), top - means, 0.0)
        # of several drops the first that is half as large as the largest
        fallen = fall > max(least, float(fall.max()) / 2)
        if fallen.any():
            end = int(np.argmax(fallen))
            at = int(np.argmax(means[:end]))
            higher = np.flatnonzero(means[end:] > means[at])
            until = end + int(higher[0]) if higher.size else means.size
            lowest = float(means[at:until].min())
            # below the background the tip is pulled in, which is judged as adhesion
            if as_read[at] - as_read[at:until].min() > least and lowest > -least:
                found.append(Drop(at, float(means[at]) - lowest, rise))
    drop = max(found, key=lambda drop: drop.size, default=None)
    return drop and replace(drop, gradual=_falls_steadily(over[drop.at :]))


def last_drop(over: Array, calm: Array, noise: float) -> Drop | None:
    """A fall among the last readings of a force over its background, where `breaks` has too few readings behind it.

    A parabola with a step before three to FEWEST last readings is compared with one that ends in a constant, a saturated
    detector. Noise is that of the readings [N], a slower one, or what the parabola leaves.
    Single readings far off are those of the running median.
    """
    noise = max(noise, noise_near(over))
    force = np.where(np.abs(over - calm) > CLEAR * noise, calm, over)[-3 * FEWEST :]
    if force.size < 3 * FEWEST:
        return None
    along = np.arange(force.size) / force.size
    fallen = _described([(along, along > along[-m - 1]) for m in range(3, FEWEST + 1)], force)
    flat = _described([(np.minimum(along, along[-m - 1]), np.zeros(force.size)) for m in range(3, 2 * FEWEST)], force)
    left, last, step, error = min(fallen)
    error *= max(noise, float(np.sqrt(left / force.size)), EXACT * float(over.max()))
    # the criterion counts the step as one parameter more
    if -step < CLEAR * error or min(flat)[0] - left < max(noise**2, left / force.size) * np.log(force.size):
        return None
    return Drop(over.size - 4 - last, -step, float(over.max()))


def _described(shapes: list[tuple[Array, Array]], force: Array) -> list[tuple[float, int, float, float]]:
    """Sum of squares, number of the shape, step and its error over the noise, of parabolas with a step."""
    found = []
    for i, (along, step) in enumerate(shapes):
        columns = np.column_stack([step, np.ones(force.size), along, along**2])
        x = np.linalg.lstsq(columns, force, rcond=None)[0]
        left = force - columns @ x
        error = float(np.sqrt(np.linalg.pinv(columns.T @ columns)[0, 0]))
        found.append((float(left @ left), i, float(x[0]), error))
    return found


def weak_drop(read: Array, over: Array, noise: float) -> Drop | None:
    """The first fall of a force over its background that hardly leaves the noise, by straight lines through more readings.

    It is looked for above the bend where a contact begins. Means of more readings have less noise, but as much rounding.
    """
    count, begin = 4 * FEWEST, int(np.argmax(over > RISEN * over.max()))
    if over.size - begin < 4 * count:
        return None
    edge, rounding = _edge(count), converter_step(read) / np.sqrt(12)
    found = np.correlate(over[begin:], edge, "valid")
    least = CLEAR * max(spread_of(found), noise * float(np.linalg.norm(edge)), rounding, EXACT * float(over.max()))
    if not (fallen := found < -max(least, -float(found.min()) / 2)).any():
        return None
    first = int(np.argmax(fallen))
    at = first + int(np.argmin(found[first : first + count]))
    # a corner, as where a detector saturates, is seen as a step beside it
    before, after = over[begin + at + count - FEWEST :][: 2 * FEWEST].reshape(2, FEWEST).mean(axis=1)
    if before - after < CLEAR * noise * np.sqrt(2 / FEWEST):
        return None
    return Drop(begin + at + count - 1, -float(found[at]), float(over.max()))


def _falls_steadily(force: Array) -> bool:
    """Whether a force falls along a parabola from its first value, and not at once to what then stays or rises."""
    along, fallen = np.arange(force.size, dtype=float), force - force[0]
    columns = np.array([along, along**2]).T
    left = fallen - columns @ np.linalg.lstsq(columns, fallen, rcond=None)[0]
    apart = force[1:] - isotonic_regression(force[1:]).x
    return float(left @ left) < float(apart @ apart)


def fall_near(over: Array, near: int) -> Drop | None:
    """The first fall of a force over its background by more than its noise explains, after which it may rise again at once.

    It is looked for within two times FEWEST readings from one of the `breaks`, over the straight line through the first half of
    them. Two adjacent readings are no fall, and neither is what ends below the background, which is judged as adhesion.
    """
    begin, force = max(near - 2, 0), over[near : near + 2 * FEWEST]
    # medians see two readings beyond both ends
    wide = over[begin : near + 2 * FEWEST + 2]
    along = np.arange(wide.size) - (near - begin)
    first = (along >= 0) & (along < FEWEST)
    line = np.polyval(np.polyfit(along[first], without_spikes(wide)[first], 1), along)
    left = without_spikes(wide - line)[near - begin :][: force.size]
    least = CLEAR * noise_near(over)
    fallen = np.maximum.accumulate(left) - left > least
    if not fallen.any():
        return None
    end = int(np.argmax(fallen))
    # the median of five moves a corner by up to two readings
    top = max(int(np.argmax(left[:end])) - 2, 0)
    at = top + int(np.argmax(force[top : end + 1]))
    lowest = float(force[end : end + 3].min())
    if not force[at] - lowest > least or lowest < -least:
        return None
    return Drop(near + at, float(force[at]) - lowest, float(over.max()))
