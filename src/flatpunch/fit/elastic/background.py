"""The force without contact: over its straight line, tilted, or waving."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import TINY, Array, Flags
from flatpunch.fit.least_squares.blocks import uniform
from flatpunch.fit.measured.curve import FEWEST, Curve
from flatpunch.fit.measured.signal import EXACT, independent, memory_of

WAVES = 160
"""Stretches of the background in which a wave is looked for."""


def over_line(part: Curve, before: Flags) -> Array:
    """Force over the straight line through the points before the contact, or over zero where there are none [N]."""
    if not before.any():
        return part.force
    position = part.position - part.position[before].mean()
    here, force = position[before], part.force[before]
    level = force.mean()
    slope = float(here @ (force - level)) / max(float(here @ here), TINY)
    return np.asarray(part.force - level - slope * position)


def line_error(part: Curve, before: Flags) -> Array:
    """Standard error of the straight line through the points before the contact, at all points, over that of a reading."""
    if not before.any():
        return np.full(part.position.size, np.inf)
    position = part.position - part.position[before].mean()
    here = position[before]
    return np.asarray(np.sqrt(1 / here.size + position**2 / max(float(here @ here), TINY)))


def asks_for_tilt(position: Array, force: Array) -> bool:
    """Whether a line describes the force [N] over positions [m] before contact better than a constant, by the Bayesian criterion.

    Correlated readings count as fewer independent ones.
    """
    if force.size < FEWEST:
        return False
    here, level = position - position.mean(), force - force.mean()
    left = level - float(here @ level) / max(float(here @ here), TINY) * here
    return describes_better(force, left, level)


def describes_better(force: Array, left: Array, other: Array) -> bool:
    """Whether residuals `left` of a force [N] are smaller than `other` by the Bayesian criterion, with one parameter more.

    Correlated readings count as fewer independent ones, and data without noise have their rounding.
    """
    readings = max(independent(left), 2.0)
    least = force.size * (EXACT * float(np.abs(force).max())) ** 2 + TINY
    return bool(readings * np.log((other @ other + least) / (left @ left + least)) > np.log(readings))


def waves(means: Array, rise: float) -> bool:
    """Whether means of the force over its background, over stretches in order, are correlated and change their sign."""
    turns = int(np.sum(np.diff(np.sign(means - means.mean())) != 0))
    # standard deviation of a wave over the rise from which it is worth a note
    return not (memory_of(means) < 0.5 or turns < 3 or np.std(means) < 0.01 * rise)


def wave_note(position: Array, force: Array, rise: float) -> tuple[str, ...]:
    """A wave on the background."""
    index = uniform(position, WAVES)
    size = np.bincount(index)
    means = np.bincount(index, force)[size > 0] / size[size > 0]
    if not waves(means, rise):
        return ()
    return (
        f"The force without contact waves by ±{np.sqrt(2) * np.std(means) / rise:.1%} of the rise (laser interference, or long-"
        "range forces). baseline = 'sine' fits a wave.",
    )


def begins_free(part: Curve) -> bool:
    """Whether the force changes less over the first tenth of the way than on the whole: a retract begins at its steepest."""
    order = np.argsort(part.position, kind="stable")
    tenth = max(order.size // 10, 3)
    last = np.isin(np.arange(order.size), order[-tenth:])
    force = over_line(part, last)[order]
    few = max(tenth // 4, 1)
    change = abs(float(np.median(force[tenth - few : tenth]) - np.median(force[:few])))
    return change < 0.05 * float(np.ptp(force))
