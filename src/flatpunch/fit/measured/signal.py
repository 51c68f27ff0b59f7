"""Judging a force from which its background has been removed: noise, steps of the converter, saturation, adhesion."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.ndimage import median_filter
from scipy.special import ndtri

from flatpunch._support.checks import TINY, Array, Flags, Indices
from flatpunch.fit.measured.curve import FEWEST, Curve, CurveError

Adhesion = Literal["refuse", "above", "ignore"]

CLEAR = 6.0
"""Noise levels that a rise or a dip must have to count; with 3, four more of 30 synthetic curves are refused."""
EXACT = 1e-9
"""Relative differences of data without noise, which were computed or printed, that are rounding."""
DIP = 0.03
"""Share of the rise below which a dip is no adhesion worth refusing.

Of 80 random curves with dips of 0.5 to 10 % of the rise 56 are refused; the modulus of the others is off by 2.1 % in the median.
With half of it 63 and 1.7 %, with twice 35 and 2.6 %.
"""
_SHORTEST, _ENDS = 8, 16
"""Readings of the shortest end in which saturation is looked for, and ends tried; fewer ends cost sensitivity only.

Of 120 random curves whose detector saturates at 30 to 95 % of the rise 3 are not recognised, with 4 readings 2, with 16
readings 4; of the same without saturation none is refused with any.
"""
_FLATTER = 4.0
"""How many times less steep than before the end of a saturated curve is; 2 and 8 refuse the same of these 240 curves.

It need only be clear of 1: a force grows ever faster, but behind a soft cantilever its slope hardly grows at last.
"""


def converter_step(force: Array) -> float:
    """Step of a digitised force [N]; zero where hardly any two readings are equal."""
    # readings in which steps are looked for before all are
    few = force[:400]
    if np.unique(few).size > 0.5 * few.size:
        return 0.0
    levels = np.unique(force)
    # levels that differ by rounding are one
    exact = EXACT * float(np.abs(levels).max())
    gaps = np.diff(levels)
    if not (gaps := gaps[gaps > exact]).size:
        return 0.0
    step, above = float(gaps.min()), levels - levels[0]
    # readings of a steep force differ as well, by whole steps
    whole = np.abs(above - step * np.round(above / step)).max() <= 2 * exact
    return step if whole or levels.size <= 0.5 * force.size else 0.0


def noise_of(force: Array, step: float = 0.0) -> float:
    """Standard deviation of a force without its background, robust; never below that of rounding to steps, step/sqrt(12).

    Most readings of a digitised force may be equal; the median of their deviations then is zero and says nothing.
    """
    if not force.size:
        return float(step / np.sqrt(12))
    if step:
        return max(float(np.std(force)), float(step / np.sqrt(12)))
    return spread_of(force - np.median(force))


def middle(values: Array) -> float:
    """Median; a fifth of the time of NumPy's, which is what reading thousands of curves costs."""
    half = values.size // 2
    if values.size % 2:
        return float(np.partition(values, half)[half])
    ordered = np.partition(values, (half - 1, half))
    return float(ordered[half - 1] + ordered[half]) / 2


def spread_of(values: Array) -> float:
    """Standard deviation of normal values about zero, from the median of their sizes, which single ones far off do not move."""
    return middle(np.abs(values)) / float(ndtri(0.75))


def wander(position: Array, lag: int = 1) -> float:
    """Standard deviation of the noise of readings, from second differences at a lag, in which steady motion cancels."""
    # neighbours of a thousand points show as much as those of all
    # points from which the noise of a position is taken
    at = np.arange(0, max(position.size - 2 * lag, 0), max(position.size // 1000, 1))
    second = position[at + 2 * lag] - 2 * position[at + lag] + position[at]
    return spread_of(second) / float(np.sqrt(6)) if second.size else 0.0


def noise_of_readings(force: Array) -> float:
    """Noise of a force as neighbouring readings show it, whatever the background [N]; never below that of rounding."""
    return max(wander(force), float(converter_step(force) / np.sqrt(12)))


def memory_of(values: Array) -> float:
    """Correlation of neighbours among values about zero: near 0 for independent noise, near 1 for a drift."""
    return float(values[1:] @ values[:-1] / max(float(values @ values), TINY))


def independent(values: Array) -> float:
    """Number of independent values about zero whose mean is as certain: n (1 - m)/(1 + m), m the correlation of neighbours."""
    memory = max(memory_of(values), 0.0)
    return values.size * (1 - memory) / (1 + memory)


def without_spikes(readings: Array, adjacent: int = 2) -> Array:
    """Running median: so many adjacent readings are no rise, no dip and no end of a contact; both ends stay as they are."""
    return np.asarray(median_filter(readings, 2 * adjacent + 1, mode="nearest"))


def check_rise(curve: Curve, rise: float, noise: float, tilted: float = 0.0) -> None:
    """Refuse a curve whose force does not leave its noise.

    Parameters
    ----------
    curve : Curve
        For the message.
    rise, noise : float
        Of the force over its background [N].
    tilted : float
        Growth of the fitted background over the curve [N].

    Raises
    ------
    CurveError
        If it does not.
    """
    if rise >= CLEAR * noise and rise > 0:
        return
    over = f"{curve.name}: the force rises {max(rise, 0.0):.3g} N above its baseline, the noise is {noise:.3g} N. "
    if tilted > rise:
        raise CurveError(
            f"{over}The fitted tilt of the baseline takes {tilted:.3g} N of the force: data that begin in contact show no "
            "background, and a straight line describes most of what they show. Record from further out, or choose baseline = "
            "'constant' or 'none'."
        )
    raise CurveError(f"{over}Nothing can be fitted; press deeper or average.")


def check_saturation(curve: Curve, position: Array, force: Array, noise: float) -> None:
    """Refuse an approach whose force stays where it is while the tip goes on, by more than its noise explains.

    Parameters
    ----------
    curve : Curve
        For the message.
    position, force : ndarray, shape (n,)
        Ascending positions [m] and the force over its background [N].
    noise : float
        [N].

    Raises
    ------
    CurveError
        If the detector is saturated.
    """
    for end in flat_ends(position, force, noise, sure=True):
        raise saturated(curve, force, end)


def check_reading(curve: Curve, position: Array, force: Array, noise: float) -> None:
    """Refuse saturation of the force as it was read, from its least value inwards: a detector stays at a reading.

    A long flat end falsifies the fitted background, over which the end then is not flat. A tilt adds the same slope everywhere.

    Parameters
    ----------
    curve, position, force, noise
        As for `check_saturation`, the force with its background.
    """
    lowest = int(np.argmin(force))
    for end in flat_ends(position[lowest:], force[lowest:] - force[lowest], noise, sure=True):
        raise saturated(curve, force, end, "as read")


def flat_ends(position: Array, force: Array, noise: float, *, sure: bool) -> list[int]:
    """Lengths of the ends of an approach, in readings, over which the force stays where it is.

    The force of a contact grows ever faster. An end that is less steep than a quarter of what is before it, in the upper half of
    the rise, is flat if the force is constant within its noise: by more than the noise explains (`sure`), or as far as the noise
    allows to see.
    """
    if force.size < 2 * _SHORTEST:
        return []
    # the second largest of a few: less than the largest moved by noise
    top = float(np.partition(force, -3)[-2])
    # data may begin in contact, above half of the rise
    low = max(0.5 * top, float(np.median(force[: max(force.size // 50, 3)])))
    begin = int(np.argmax(force >= low))
    size = force.size - begin
    if size < 2 * _SHORTEST:
        return []
    ends = np.unique(np.geomspace(_SHORTEST, size - _SHORTEST, _ENDS).astype(int))
    before, doubt = _steepness(position[begin:], force[begin:], noise, size - ends)
    after, error = _steepness(position[begin:][::-1], force[begin:][::-1], noise, ends)
    margin = CLEAR * np.hypot(doubt / _FLATTER, error)
    # constant within the noise, or within rounding
    constant = np.abs(after) <= np.maximum(CLEAR * error, EXACT * before)
    less = before / _FLATTER - after > (margin if sure else -margin)
    return [int(end) for end in ends[constant & (before > CLEAR * doubt) & less]]


def saturated(curve: Curve, force: Array, end: int, counted: str = "above its baseline") -> CurveError:
    """The error of a saturated detector, whose force, counted from there, stays over the last `end` readings."""
    return CurveError(
        f"{curve.name}: over the last {end} points the force stays at {float(np.median(force[-end:])):.4g} N {counted} "
        "while the tip goes on: the detector is saturated. Cut the curve below it (force_to=...), or measure again with a "
        "smaller setpoint."
    )


def _steepness(position: Array, force: Array, noise: float, counts: Indices) -> tuple[Array, Array]:
    """Slopes of straight lines through so many first readings, and their standard errors [N/m]."""
    x, y = position - position[0], force - force[0]
    sums = [np.cumsum(column)[counts - 1] for column in (x, y, x * x, x * y)]
    square = sums[2] - sums[0] ** 2 / counts
    flat = square <= 0
    square = np.where(flat, 1.0, square)
    return np.where(flat, 0.0, (sums[3] - sums[0] * sums[1] / counts) / square), np.where(
        flat, np.inf, noise / np.sqrt(square)
    )


def adhesion_dip(
    curve: Curve, force: Array, noise: Array, rise: float, before: Flags, adhesion: Adhesion
) -> tuple[Flags, tuple[str, ...]]:
    """Which points of an approach can be used in spite of a dip below the background, and notes.

    Parameters
    ----------
    curve : Curve
        An approach.
    force : ndarray, shape (n,)
        Force over its background [N].
    noise : ndarray, shape (n,)
        Standard deviation of this force, with that of its background [N].
    rise : float
        [N].
    before : ndarray of bool, shape (n,)
        The points that the background was taken from: no dip is looked for there.
    adhesion : {"refuse", "above", "ignore"}
        What to do about it: refuse the curve, leave out the dip up to where the force is back at the background, or fit it.

    Raises
    ------
    CurveError
        If there is a dip and it is refused.
    """
    keep = np.ones(force.size, dtype=bool)
    looked = np.where(before, np.inf, force)
    lowest = int(np.argmin(looked))
    dip = -float(looked[lowest])
    if adhesion == "ignore" or not dip > max(CLEAR * noise[lowest], DIP * rise) or before.sum() < FEWEST:
        return keep, ()
    if adhesion == "refuse":
        raise CurveError(
            f"{curve.name}: the force dips {dip:.3g} N below the baseline before it rises, {dip / rise:.1%} of the largest "
            f"force and {_times(dip, float(noise[lowest]))} the noise: the tip is pulled in. A model without adhesion would put "
            "the contact point wrong. Use adhesion='above' to fit the part above the baseline only (the modulus is then still "
            "biased by the adhesive force), or measure in a liquid that screens it. If the curve has a retract, "
            "work_of_adhesion fits the adhesion with the rest."
        )
    back = lowest + int(np.argmax(force[lowest:] >= 0))
    calm = np.flatnonzero(force[:lowest] >= -3 * noise[:lowest])
    start = int(calm[-1]) + 1 if calm.size else 0
    keep[start:back] = False
    return keep, (
        f"Adhesion: {dip:.3g} N below the baseline; {back - start} points of the dip are left out. The modulus is biased by the "
        "adhesive force that remains.",
    )


def _times(value: float, noise: float) -> str:
    return f"{value / noise:.0f} times" if value < 1e6 * noise else "far above"
