"""Readings: their noise whatever they follow, those that jump away and back, and the stretches over which means are taken."""

from __future__ import annotations

from math import comb

import numpy as np
from scipy.ndimage import median_filter
from scipy.special import ndtri

from flatpunch._support.checks import TINY, Array, Flags, Indices

CLEAR = 6.0
"""Noise levels that a reading or a dip must have to count; with 3, four more of 30 synthetic curves are refused."""
ROUNDED = float(1 / np.sqrt(12))
"""Standard deviation of what is rounded to steps, or uniform, over the width."""
LITTLE = 0.02
"""Share of readings, of their range or of a dip that is next to nothing: drift and settling of a stage are less."""
EXACT = 1e-9
"""Relative differences of data without noise, which were computed or printed, that are rounding."""
CALM = 5
"""Readings of a running median, in which single bad ones vanish."""
NODES = 300
"""Means of a record; more cost time only."""
IN_CONTACT = 6
"""Readings in contact, beside a place where the force is compared, and next to the first and the last, which they judge."""
_LONGEST = 24
"""Readings of a disturbance that may go away again, at most a twelfth of the record."""
SHARE = 0.01
"""Share of the force by which a model may be off without being wrong; few tips and calibrations are better."""


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


def spread_of(values: Array) -> float:
    """Standard deviation of normal values about zero, from the median of their sizes, which single ones far off do not move."""
    return float(np.median(np.abs(values))) / float(ndtri(3 / 4)) if values.size else 0.0


def scatter(values: Array, order: int) -> float:
    """Standard deviation of the noise of readings, from their differences of an order, in which smoother motion cancels."""
    return spread_of(np.diff(values, order)) / float(np.sqrt(comb(2 * order, order)))


def wander(position: Array) -> float:
    """Standard deviation of the noise of readings that move steadily."""
    return scatter(position, 2)


def white_noise(force: Array, step: float, edges: Indices | None = None) -> float:
    """Standard deviation of the noise of readings [N], from their fourth differences, in which a contact cancels.

    `edges` are those of means: the noise of the usual of them, so that the many readings of a hold do not decide.
    """
    order = 4
    fourth = np.diff(force, order)
    cuts = (
        np.zeros(0, dtype=int) if edges is None else np.minimum(edges[:: max(edges.size // 16, 1)][1:-1], fourth.size)
    )
    blocks = [b for b in np.split(fourth, cuts) if b.size > 2 * order]
    spread = (
        float(np.median([spread_of(b) for b in blocks])) / float(np.sqrt(comb(2 * order, order))) if blocks else 0.0
    )
    return float(max(spread, step * ROUNDED, EXACT * float(np.ptp(force))))


def over_line(position: Array, force: Array) -> Array:
    """Force over the straight line through the first fifth of the readings, which holds its tilt if not its waves."""
    first = max(force.size // 5, 3)
    x, y = position[:first] - position[0], force[:first]
    x, x0, y0 = x - x.mean(), position[0] + x.mean(), y.mean()
    return np.asarray(
        force - y0 - float(x @ y) / max(float(x @ x), TINY * float(np.ptp(position)) ** 2) * (position - x0)
    )


def thinned(position: Array, force: Array, *, tilted: bool = False) -> Indices:
    """Where means over stretches of equal length along way and force begin, and the number of readings; the last stays alone.

    A tilt of the background that is fitted in any case is no part of the force.
    """
    n = force.size
    calm = median_filter(over_line(position, force) if tilted else force, CALM, mode="mirror")
    rise = np.maximum.accumulate(np.abs(calm - np.median(calm[: max(n // 5, 3)])))
    way = np.maximum.accumulate(median_filter(position, CALM, mode="mirror"))
    # readings of a hold go nowhere: a tenth of the means
    along = (
        0.1 * np.arange(n) / n + (way - way[0]) / max(float(way[-1] - way[0]), TINY) + rise / max(float(rise[-1]), TINY)
    )
    index = np.minimum((along / along[-1] * NODES).astype(int), NODES - 1)
    index[-1] = NODES
    return np.append(np.flatnonzero(np.diff(index, prepend=-1)), n)


def strays(force: Array, noise: float) -> Flags:
    """Readings that jump away and back, at the first and last reading too.

    The median over a stretch keeps every rise; beside it a reading is far off by more than its noise and the bend of the force
    within the stretch explain. The first and last are judged by the line through their neighbours.
    """
    n = force.size
    half = max(min(_LONGEST, n // (2 * IN_CONTACT)), 1)
    out = np.zeros(n, dtype=bool)
    force = force.copy()
    i = np.arange(1, IN_CONTACT + 1)
    low, high = np.triu_indices(IN_CONTACT, 1)
    for end, last in ((slice(None), 0), (slice(None, None, -1), n - 1)):
        near = force[end][1 : IN_CONTACT + 1]
        slope = np.median((near[high] - near[low]) / (high - low))
        if abs(force[last] - np.median(near - slope * i)) > 2 * CLEAR * noise + 3 * np.ptp(near):
            out[last] = True
            force[last] = near[0]
    calm = median_filter(np.pad(force, half, mode="reflect", reflect_type="odd"), 2 * half + 1)[half:-half]
    off = force - calm
    # noise may differ along the record
    blocks = np.array_split(np.abs(off), min(16, max(n // 50, 1)))
    spread = np.repeat([spread_of(b) for b in blocks], [b.size for b in blocks])
    bend = np.abs(np.gradient(calm)) * half / 3
    away = np.abs(off) > CLEAR * np.maximum(noise, spread) + bend + SHARE * float(np.ptp(calm))
    # the rise before a drop, and that out of a dip, are no jumps
    turns = np.diff(away.astype(int), prepend=0, append=0)
    for a, b in zip(np.flatnonzero(turns > 0).tolist(), np.flatnonzero(turns < 0).tolist(), strict=True):
        jumps = [(a, a - 1, a)] * (a > 0) + [(b, b - 1, b - 1)] * (b < n)
        away[a:b] = all(abs(force[i] - force[j]) > abs(off[k]) / 2 for i, j, k in jumps)
    out |= away
    return out if out.sum() <= 0.1 * n else np.zeros(n, dtype=bool)


def memory_of(values: Array) -> float:
    """Correlation of neighbours among values about zero: near 0 for independent noise, near 1 for a drift."""
    return float(values[1:] @ values[:-1] / max(float(values @ values), TINY))


def independent(values: Array) -> float:
    """Number of independent values about zero whose mean is as certain: n (1 - m)/(1 + m), m the correlation of neighbours."""
    memory = max(memory_of(values), 0.0)
    return values.size * (1 - memory) / (1 + memory)
