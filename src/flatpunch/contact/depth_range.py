"""Between which depths dear solutions are worth making, where not the depth but the force or the mean radius is prescribed."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from flatpunch._validation import Array

_TRIES = 12
_GROWTH = (0.3, 6.0)
"""Least and most that the logarithm of a force or a radius is thought to grow by that of the depth, beyond what is known."""
_BEYOND = (1.05, 0.02)
"""By how much of the way, and of ln d, the next solution lies beyond where it is expected to be needed."""
_STEP = 0.3
"""Farthest that it lies beyond what is known, in ln d, the first time: contacts that come apart grow three times faster."""


def depth_range(
    known: Callable[[], Mapping[float, float]],
    solve: Callable[[float, float], None],
    wanted: tuple[float, float],
    guess: tuple[float, float],
    least: float = -np.inf,
) -> tuple[float, float] | None:
    """Solutions between which a growing quantity q runs through all that is wanted, by their positions x = ln d.

    Parameters
    ----------
    known : callable
        () -> ln q at the positions of all solutions that there are.
    solve : callable
        Makes those that are missing between two positions.
    wanted : (float, float)
        Least and largest ln q.
    guess : (float, float)
        Positions between which these are expected.
    least : float
        Position below which no solution is needed.

    Returns
    -------
    (float, float) or None
        The first solution that has reached the largest, and the last before q exceeds the least; None if q is not found to
        reach it.
    """
    low, high = max(guess[0], least), guess[1]
    for tried in range(_TRIES):
        solutions = known()
        if solutions:
            x = np.array(sorted(solutions))
            q = np.maximum.accumulate(np.array([solutions[at] for at in x.tolist()]))
            before, reached = int(np.searchsorted(q, wanted[0], side="right")) - 1, int(np.searchsorted(q, wanted[1]))
            if (before >= 0 or low <= least) and reached < x.size:
                return max(least, float(x[before])) if before >= 0 else least, float(x[reached])
            if tried or before >= 0:
                low = (
                    float(x[before])
                    if before >= 0
                    else max(least, _further(x[:2], q[:2], wanted[0], _STEP * (tried + 1)))
                )
            if tried or reached < x.size:
                high = (
                    float(x[reached])
                    if reached < x.size
                    else _further(x[-2:][::-1], q[-2:][::-1], wanted[1], _STEP * (tried + 1))
                )
        solve(low, high)
    return None


def _further(x: Array, q: Array, wanted: float, farthest: float) -> float:
    """Beyond where a power law through the outermost solutions, the last of them first, reaches what is wanted."""
    growth = float(np.clip((q[1] - q[0]) / (x[1] - x[0]), *_GROWTH)) if x.size > 1 else 1.0
    way = (wanted - float(q[0])) / growth
    return float(x[0] + np.clip(_BEYOND[0] * way + np.copysign(_BEYOND[1], way), -farthest, farthest))
