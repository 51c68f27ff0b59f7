"""Between which depths dear solutions are worth making, where not the depth but the force or the mean radius is prescribed."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from flatpunch._support.checks import Array

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
    far: Callable[[float, float], bool],
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
        Makes those that are missing between two positions, and at these.
    far : callable
        Whether two positions are so far apart that solutions are wanted between them.
    wanted : (float, float)
        Least and largest ln q.
    guess : (float, float)
        Positions between which these are expected.
    least : float
        Position below which no solution is needed.

    Returns
    -------
    (float, float) or None
        Where q is expected to have the least and the largest value, between solutions that are not far from there; None if it is
        not found to reach them.
    """
    low, high = np.maximum(guess, least).tolist()
    for tried in range(_TRIES):
        solutions = known()
        if solutions:
            x = np.array(sorted(solutions))
            q = np.maximum.accumulate(np.array([solutions[at] for at in x.tolist()]))
            before, reached = int(np.searchsorted(q, wanted[0], side="right")) - 1, int(np.searchsorted(q, wanted[1]))
            begins = low <= least if before < 0 else not far(float(x[before]), low)
            ends = reached < x.size and not far(float(x[reached]), high)
            farthest = _STEP * (tried + 1)
            if begins or tried or (before + 1 < x.size and x[before + 1] <= low):
                low = low if begins and before < 0 else max(least, _crossing(x, q, before, wanted[0], farthest))
            if ends or tried or (reached > 0 and x[reached - 1] >= high):
                high = max(least, _crossing(x, q, reached - 1, wanted[1], farthest))
            if begins and ends:
                return low, high
            # on the safe side of where they are expected
            solve(max(least, low - _BEYOND[1] * (before >= 0)), high + _BEYOND[1] * (reached < x.size))
        else:
            solve(low, high)
    return None


def _crossing(x: Array, q: Array, before: int, wanted: float, farthest: float) -> float:
    """Where q is expected to have the wanted value: after the solution number `before`, or beyond the first or last of them."""
    if 0 <= before < x.size - 1:
        return float(np.interp(wanted, q[before : before + 2], x[before : before + 2]))
    return (
        _further(x[:2], q[:2], wanted, farthest)
        if before < 0
        else _further(x[-2:][::-1], q[-2:][::-1], wanted, farthest)
    )


def _further(x: Array, q: Array, wanted: float, farthest: float) -> float:
    """Beyond where a power law through the outermost solutions, the last of them first, reaches what is wanted."""
    growth = float(np.clip((q[1] - q[0]) / (x[1] - x[0]), *_GROWTH)) if x.size > 1 else 1.0
    way = (wanted - float(q[0])) / growth
    return float(x[0] + np.clip(_BEYOND[0] * way + np.copysign(_BEYOND[1], way), -farthest, farthest))
