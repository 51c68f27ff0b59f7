"""Where the pressure under a tip is infinite: at its apex and edges, at the border of a flat end, under the rim of a punch."""

from __future__ import annotations

import numpy as np

from flatpunch.indenters._common import SCATTERED
from flatpunch.indenters.profile import Indenter

_POINTED = 0.5
"""Slope at the apex over the mean slope up to the first point of a table from which the tip is a cone there rather than a
paraboloid, whose ratio is zero: splines of measured heights leave small slopes."""


def singular_place(indenter: Indenter, radius: float) -> tuple[float, float] | None:
    """Place (x, y) of infinite pressure in contacts of that radius [m]; None if there is none."""
    if indenter.flat:
        return indenter.reach, 0.0
    if (indenter.exponent is not None and indenter.exponent <= 1) or is_pointed(indenter, radius):
        return 0.0, 0.0
    if indenter.round:
        return _kink(indenter, radius)
    if border := _border(indenter):
        return border
    if indenter.corners:
        return radius / 2 * float(np.cos(indenter.corners[0])), radius / 2 * float(np.sin(indenter.corners[0]))
    return None


def is_pointed(indenter: Indenter, radius: float) -> bool:
    """Whether a tip that is no power law begins like a cone or a wedge."""
    if indenter.exponent is not None:
        return False
    ends = [*indenter.rings, *indenter.scales, indenter.reach]
    first = min([each for each in ends if 0 < each < np.inf], default=radius)
    # round tips have a slope at the apex; that of others depends on the direction, beside it
    beside = 0.0 if indenter.round else 1e-3 * first
    slope = np.asarray(indenter.slope(np.full(SCATTERED.shape, beside), SCATTERED)).max()
    return bool(
        slope > _POINTED * np.asarray(indenter.height(np.full(SCATTERED.shape, first), SCATTERED)).max() / first
    )


def pointed_table(indenter: Indenter) -> tuple[str, ...]:
    """Note on a load of zero under a tip whose slope at its apex comes from a table."""
    if not (indenter.round and indenter.tabulated):
        return ()
    slope = float(np.asarray(indenter.slope(np.zeros(1), np.zeros(1)))[0])
    if slope == 0:
        return ()
    return (
        f"The table of the tip begins with a slope of {slope:.2g}, like a cone, so that stresses at the apex are large under any "
        "load. If the tip is round there, give more points below the first radius, at heights that grow like its square.",
    )


def _kink(indenter: Indenter, radius: float) -> tuple[float, float] | None:
    """Ring of a round tip at which its slope jumps."""
    rings = np.array([ring for ring in indenter.rings if ring < radius * (1 - 1e-9)])
    if not rings.size:
        return None
    inside, outside = (indenter.slope(rings * (1 + side), np.zeros(1)) for side in (-1e-9, 1e-9))
    # jump of the slope over the slope from which a ring of the tip is an edge
    sharp = np.flatnonzero(np.abs(outside - inside) > 1e-6 * np.abs(outside))
    return (float(rings[sharp[0]]), 0.0) if sharp.size else None


def _border(indenter: Indenter) -> tuple[float, float] | None:
    """Nearest place on the border of a flat end, which is in contact as a whole; None if the tip rises from its apex."""
    if not indenter.rings:
        return None
    low, high = (
        np.full(SCATTERED.shape, ring) for ring in (indenter.rings[0] * (1 - 1e-9), indenter.rings[-1] * (1 + 1e-9))
    )
    if np.any(indenter.slope(low, SCATTERED)):
        return None
    for _ in range(50):
        middle = (low + high) / 2
        flat = np.asarray(indenter.slope(middle, SCATTERED)) == 0
        low, high = np.where(flat, middle, low), np.where(flat, high, middle)
    i = int(np.argmin(high))
    return float(high[i] * np.cos(SCATTERED[i])), float(high[i] * np.sin(SCATTERED[i]))
