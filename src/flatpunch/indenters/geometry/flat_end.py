"""Flat ends of tips that are not round, which are in contact as a whole or not at all."""

from __future__ import annotations

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, Flags
from flatpunch.indenters._common import FULL_TURN, RAYS, SAME
from flatpunch.indenters.profile import Indenter


@byte_cached
def flat_radius(indenter: Indenter) -> float:
    """Mean radius of the flat end [m] that a tip begins with; 0 if it has none."""
    rings = indenter.rings
    # with the rays alone the mean radius of a square changes by 1e-6
    phi = np.asarray(np.arange(2 * RAYS) * (FULL_TURN / 2 / RAYS))
    if len(rings) < 2 or np.any(indenter.height(np.array((1 - 1e-3) * rings[0]), phi)):
        return 0.0

    def beyond(r: Array, phi: Array) -> Array:
        return np.where(indenter.height(r, phi) > 0, 1.0, -1.0)

    from scipy.optimize import elementwise

    return float(elementwise.find_root(beyond, (0.0, (1 + SAME) * rings[-1]), args=(phi,)).x.mean())


def beside_flat_end(indenter: Indenter, radius: Array) -> Flags:
    """Where contacts hardly exceed a flat end that is not round, so that its edge rules the pressure; shape (n,)."""
    if flat_radius(indenter) == 0:
        return np.zeros(radius.shape, dtype=bool)
    return np.asarray(radius < 1.2 * indenter.rings[-1])
