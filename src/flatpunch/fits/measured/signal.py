"""Noise of readings: its size whatever they follow, steps of a digitised force, and how many readings are independent."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.special import ndtri

from flatpunch._support.checks import TINY, Array

Adhesion = Literal["refuse", "above", "ignore"]
"""What to do about a dip of the force below its background: refuse the curve, leave the dip out, or fit it."""

CLEAR = 6.0
"""Noise levels that a reading or a dip must have to count; with 3, four more of 30 synthetic curves are refused."""
ROUNDED = float(1 / np.sqrt(12))
"""Standard deviation of what is rounded to steps, over the step."""
EXACT = 1e-9
"""Relative differences of data without noise, which were computed or printed, that are rounding."""


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
        return step * ROUNDED
    if step:
        return max(float(np.std(force)), step * ROUNDED)
    return spread_of(force - np.median(force))


def spread_of(values: Array) -> float:
    """Standard deviation of normal values about zero, from the median of their sizes, which single ones far off do not move."""
    return float(np.median(np.abs(values))) / float(ndtri(3 / 4)) if values.size else 0.0


def wander(position: Array) -> float:
    """Standard deviation of the noise of readings, from second differences, in which steady motion cancels."""
    return spread_of(np.diff(position, 2)) / float(np.sqrt(6))


def memory_of(values: Array) -> float:
    """Correlation of neighbours among values about zero: near 0 for independent noise, near 1 for a drift."""
    return float(values[1:] @ values[:-1] / max(float(values @ values), TINY))


def independent(values: Array) -> float:
    """Number of independent values about zero whose mean is as certain: n (1 - m)/(1 + m), m the correlation of neighbours."""
    memory = max(memory_of(values), 0.0)
    return values.size * (1 - memory) / (1 + memory)
