"""Judging a force from which its background has been removed: noise, steps of the converter, saturation, adhesion."""

from __future__ import annotations

from typing import Literal

import numpy as np

from flatpunch._support.checks import Array, Flags
from flatpunch.fit.measured.curve import FEWEST, Curve, CurveError

Adhesion = Literal["refuse", "above", "ignore"]

CLEAR = 6.0
"""Noise levels that a rise or a dip must have to count; with 3, four more of 30 synthetic curves are refused."""
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
    if levels.size > 0.5 * force.size or levels.size < 2:
        return 0.0
    gaps = np.diff(levels)
    # levels that differ by rounding are one
    gaps = gaps[gaps > 1e-9 * float(np.abs(levels).max())]
    return float(gaps.min()) if gaps.size else 0.0


def noise_of(force: Array, step: float = 0.0) -> float:
    """Standard deviation of a force without its background, robust; never below that of rounding to steps, step/sqrt(12).

    Most readings of a digitised force may be equal; the median of their deviations then is zero and says nothing.
    """
    if not force.size:
        return float(step / np.sqrt(12))
    if step:
        return max(float(np.std(force)), float(step / np.sqrt(12)))
    return float(1.4826 * np.median(np.abs(force - np.median(force))))


def memory_of(values: Array) -> float:
    """Correlation of neighbours among values about zero: near 0 for independent noise, near 1 for a drift."""
    return float(values[1:] @ values[:-1] / max(float(values @ values), 1e-300))


def without_spikes(force: Array) -> Array:
    """Median of each reading and its two neighbours: a single reading is no rise, no dip and no end of a contact."""
    result = force.copy()
    if force.size > 2:
        result[1:-1] = np.median([force[:-2], force[1:-1], force[2:]], axis=0)
    return result


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
    """The same for the force as it was read, from its least value inwards: a detector stays at a reading.

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
    the rise, is flat: by more than the noise explains (`sure`), or as far as the noise allows to see.
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
    found = []
    for end in np.unique(np.geomspace(_SHORTEST, size - _SHORTEST, _ENDS).astype(int)).tolist():
        onset = force.size - end
        (before, doubt), (after, error) = (
            _steepness(position[part], force[part], noise) for part in (slice(begin, onset), slice(onset, None))
        )
        margin = CLEAR * np.hypot(doubt / _FLATTER, error)
        if before > CLEAR * doubt and before / _FLATTER - after > (margin if sure else -margin):
            found.append(end)
    return found


def saturated(curve: Curve, force: Array, end: int, counted: str = "above its baseline") -> CurveError:
    """The error of a saturated detector, whose force, counted from there, stays over the last `end` readings."""
    return CurveError(
        f"{curve.name}: over the last {end} points the force stays at {float(np.median(force[-end:])):.4g} N {counted} "
        "while the tip goes on: the detector is saturated. Cut the curve below it (force_to=...), or measure again with a "
        "smaller setpoint."
    )


def _steepness(position: Array, force: Array, noise: float) -> tuple[float, float]:
    """Slope of a straight line through readings, and its standard error [N/m]."""
    along = position - position.mean()
    square = float(along @ along)
    if square <= 0:
        return 0.0, np.inf
    return float(along @ force) / square, noise / np.sqrt(square)


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
