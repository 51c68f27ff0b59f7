"""The force without contact: over its straight line, tilted, or waving."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array, Flags
from flatpunch.fit.least_squares.blocks import uniform
from flatpunch.fit.measured.curve import Curve
from flatpunch.fit.measured.signal import memory_of

WAVES = 160
"""Stretches of the background in which a wave is looked for."""


def over_line(part: Curve, before: Flags) -> Array:
    """Force over the straight line through the points before the contact [N]."""
    position = part.position - part.position[before].mean()
    here, force = position[before], part.force[before]
    level = force.mean()
    slope = float(here @ (force - level)) / max(float(here @ here), 1e-300)
    return np.asarray(part.force - level - slope * position)


def line_error(part: Curve, before: Flags) -> Array:
    """Standard error of the straight line through the points before the contact, at all points, over that of a reading."""
    position = part.position - part.position[before].mean()
    here = position[before]
    return np.asarray(np.sqrt(1 / here.size + position**2 / max(float(here @ here), 1e-300)))


def tilt_note(position: Array, force: Array, deepest: float, rise: float) -> tuple[str, ...]:
    """A tilted background that is fitted as a constant moves contact point and modulus.

    Parameters
    ----------
    position, force : ndarray, shape (n,)
        Readings, or means of equal numbers of readings, before the contact [m, N].
    deepest, rise : float
        Of the contact [m, N].
    """
    here, level = position - position.mean(), force - force.mean()
    slope = float(here @ level) / max(float(here @ here), 1e-300)
    error = float(np.std(level - slope * here)) / max(float(np.sqrt(here @ here)), 1e-300)
    share = slope * deepest / rise
    # tilt over the depth of the contact, as a share of the rise, that is worth a note when none is fitted
    if abs(share) < 0.02 or abs(slope) < 5 * error:
        return ()
    return (
        f"The force without contact is tilted: {share:+.1%} of the rise over the depth of the contact. baseline = 'linear' fits "
        "the tilt; a constant baseline biases contact point and modulus.",
    )


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
