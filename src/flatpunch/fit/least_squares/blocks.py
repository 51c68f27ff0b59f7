"""Means over stretches of a curve: a force that is smooth within a stretch loses nothing by it, and few points cost little.

The background is a straight line and needs few; over the contact a stretch of 1/200 of its depth errs by (1/200)^2/24 of the
curvature, 1e-6 of the force. Curves with a wave or with drag in their background are not averaged.
"""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import TINY, Array, Indices
from flatpunch.fit.least_squares.objective import Objective

CONTACT, FREE = 200, 50
"""Stretches over the contact and over the background before it; half as many move E by up to 0.24 and 0.02 standard errors."""


def blocked(objective: Objective, contact: float) -> Objective:
    """The problem on block means, fine from somewhat before `contact` (a position) on; itself where that saves nothing."""
    if objective.depth.size < 3 * (CONTACT + FREE) or {"wavelength", "drag"} & set(objective.nuisance):
        return objective
    position = objective.position
    first, last = float(position.min()), float(position.max())
    begin = min(max(contact - 0.3 * (last - contact), first), last)
    free = np.minimum((position - first) * (FREE / max(begin - first, TINY)), FREE - 1)
    inside = FREE + np.minimum((position - begin) * (CONTACT / max(last - begin, TINY)), CONTACT - 1)
    return objective.averaged(np.where(position < begin, free, inside).astype(np.intp))


def towards_the_end(objective: Objective) -> Objective:
    """The problem on block means that get shorter towards the deepest point, so that the shortest contact is seen; ascending.

    With a wave in the background they are equal: a mean over much of a wave is no value of it.
    """
    if "wavelength" in objective.nuisance:
        return objective.averaged(uniform(objective.position, min(CONTACT, objective.position.size // 4)))
    left = objective.position.max() - objective.position
    shortest = 1.5 * float(left.max()) / left.size
    # stretches for each doubling of the distance to the deepest point, where the contact point is looked for
    index = (6 * np.log2(1 + left / max(shortest, TINY))).astype(np.intp)
    return objective.averaged(index.max() - index)


def uniform(position: Array, count: int) -> Indices:
    """Index of equal stretches of position."""
    low, way = float(position.min()), float(np.ptp(position))
    return np.minimum((position - low) * (count / max(way, TINY)), count - 1).astype(np.intp)
