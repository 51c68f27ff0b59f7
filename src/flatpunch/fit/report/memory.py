"""Residuals that are no independent noise."""

from __future__ import annotations

import numpy as np


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
