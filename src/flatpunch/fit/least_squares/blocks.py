"""Means over stretches of a curve: a force that is smooth within a stretch loses nothing by it, and few points cost little.

The background is a straight line and needs few; over the contact a stretch of 1/200 of its depth errs by (1/200)^2/24 of the
curvature, 1e-6 of the force. Curves with drag in their background are not averaged.
"""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import TINY
from flatpunch.fit.least_squares.objective import Objective

CONTACT, FREE = 200, 50
"""Stretches over the contact and over the background before it; half as many move E by up to 0.24 and 0.02 standard errors."""


def blocked(objective: Objective, contact: float) -> Objective:
    """The problem on block means, fine from somewhat before `contact` (a position) on; itself where that saves nothing."""
    if objective.depth.size < 3 * (CONTACT + FREE) or "drag" in objective.nuisance:
        return objective
    position = objective.position
    first, last = float(position.min()), float(position.max())
    begin = min(max(contact - 0.3 * (last - contact), first), last)
    free = np.minimum((position - first) * (FREE / max(begin - first, TINY)), FREE - 1)
    inside = FREE + np.minimum((position - begin) * (CONTACT / max(last - begin, TINY)), CONTACT - 1)
    return objective.averaged(np.where(position < begin, free, inside).astype(np.intp))
