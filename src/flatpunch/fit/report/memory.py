"""Residuals that are no independent noise."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import TINY, Array
from flatpunch.fit.measured.signal import CLEAR, spread_of


def correlated(memory: float, size: int) -> tuple[str, ...]:
    """A note about residuals that are no independent noise, from the correlation of neighbours among so many."""
    # correlation of neighbouring residuals above which intervals that are wider for it need a word
    if memory <= 0.3 or size <= 30:
        return ()
    factor = np.sqrt((1 + memory) / (1 - memory))
    return (
        f"Neighbouring residuals are correlated ({memory:.2f}): drift, or a model that does not fit. The intervals are wider for "
        f"it by a factor of {factor:.1f}; what a wrong model adds is not in them.",
    )


def outliers(residual: Array) -> tuple[str, ...]:
    """A note about single readings that are far off and make up most of the sum of squares."""
    off = np.abs(residual - np.median(residual))
    far = off > CLEAR * spread_of(off)
    beside = np.convolve(far, [1, 0, 1], "same") > 0
    alone = far & ~beside
    share = float(np.sum(off[alone] ** 2)) / max(float(off @ off), TINY)
    if share < 0.5:
        return ()
    return (
        f"Outliers: {int(alone.sum())} single readings, more than {CLEAR:.0f} noise levels off, make up {share:.0%} of the sum "
        "of squares and widen the intervals. Drop them, or fit with loss = 'cauchy', which they hardly disturb.",
    )
