"""Flat ends of tips that are not round, which are in contact as a whole or not at all."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from flatpunch._support.checks import Array, Flags
from flatpunch.indenters._common import FULL_TURN
from flatpunch.indenters.profile import Indenter

_ANGLES, _HALVINGS = 1440, 50
_WITHIN = 0.999
"""Share of the innermost ring within which all of a flat end is."""


@lru_cache(maxsize=256)
def flat_radius(indenter: Indenter) -> float:
    """Mean radius of the flat end [m] that a tip begins with; 0 if it has none."""
    rings = indenter.rings
    phi = np.asarray(np.arange(_ANGLES) * (FULL_TURN / _ANGLES))
    if len(rings) < 2 or np.any(indenter.height(np.array(_WITHIN * rings[0]), phi)):
        return 0.0
    inside, outside = np.zeros(phi.size), np.full(phi.size, rings[-1])
    for _ in range(_HALVINGS):
        middle = (inside + outside) / 2
        flat = indenter.height(middle, phi) <= 0
        inside, outside = np.where(flat, middle, inside), np.where(flat, outside, middle)
    return float(inside.mean())


def beside_flat_end(indenter: Indenter, radius: Array) -> Flags:
    """Where contacts hardly exceed a flat end that is not round, so that its edge rules the pressure; shape (n,)."""
    if flat_radius(indenter) == 0:
        return np.zeros(radius.shape, dtype=bool)
    return np.asarray(radius < 1.2 * indenter.rings[-1])
