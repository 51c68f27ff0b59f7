"""Where along a loading path dear solutions are worth making, before anything is known of them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliance import Kernel
from flatpunch.contact.round.profile import RoundProfile
from flatpunch.indenters.profile import Indenter

_SPACING = 0.375 * np.log(10)
"""Spacing in ln r, the radius at which the mean profile is as high as the tip is deep."""
_STEEPEST = 4.0
"""Most that ln d counts for over ln r: beginning on a flat end, the radius hardly moves."""
_QUIET, _SPARE = 0.1, 2.0
"""r over the layer's thickness below which ratios move like it for power-law tips, and how much wider spacings are there."""
_UNAIDED = 1.15
"""How much closer solutions lie for tips that are no power law: only the round contact stands beside them."""
_BENDING, _SHARPEST = 2.0, 1.0
"""How much closer again where the exponent of the mean profile changes, over its rate by ln r, and the most that counts."""
_RADII = np.geomspace(1e-15, 1e6, 320)
_SAMPLES = 600
_SAME = 1e-9
_NEXT_TO = 0.005
_SHARE = 1 / 16
"""Distance, in spacings and over the whole range, up to which one of two solutions says it all: curves never put them closer
than 1/160."""


class Spacing:
    """Distance between depths counted in spacings of solutions.

    Parameters
    ----------
    kernel, indenter, profile
        Medium, indenter and its round base.
    """

    def __init__(self, kernel: Kernel, indenter: Indenter, profile: RoundProfile) -> None:
        radius = np.unique(np.minimum(_RADII, indenter.reach))
        depth = np.maximum.accumulate(profile.height(radius))
        rising = (depth > 0) & (np.diff(depth, prepend=0.0) > 0)
        self._x, self._y = np.log(depth[rising]), np.log(radius[rising])
        # caps end in faces, and the outline begins to follow these
        bending = np.abs(np.gradient(np.gradient(self._x, self._y), self._y))
        self._closer = 1 + _BENDING * np.minimum(bending, _SHARPEST)
        power_law = indenter.exponent is not None
        self._quiet = np.log(_QUIET * kernel.length) if power_law else -np.inf
        self._width = _SPACING if power_law else _SPACING / _UNAIDED

    def depth_of(self, radius: float) -> float:
        """ln d of the tip whose mean profile is as high at a radius [m]."""
        return float(np.interp(np.log(radius), self._y, self._x))

    def between(self, x: Array) -> Array:
        """Spacings between neighbouring positions x = ln d, shape (n,) -> (n - 1,)."""
        fine = np.linspace(x[0], x[-1], _SAMPLES)
        # beyond the tip's reach like a paraboloid
        y = np.interp(fine, self._x, self._y) + np.maximum(fine - self._x[-1], 0.0) / 2
        steps = np.maximum(np.diff(y), np.diff(fine) / _STEEPEST) / self._width
        steps *= np.interp(y[1:], self._y, self._closer)
        steps = np.where(y[1:] < self._quiet, steps / _SPARE, steps)
        return np.diff(np.interp(x, fine, np.concatenate([[0.0], np.cumsum(steps)])))

    def missing(self, known: Array, low: float, high: float) -> Array:
        """Positions to add to the known ones (sorted) so that none of [low, high] lies in a gap wider than one spacing."""
        first, last = np.searchsorted(known, low + _SAME) - 1, np.searchsorted(known, high - _SAME)
        marks = known[max(first, 0) : last + 1].tolist()
        for end in (low, high):
            beside = np.searchsorted(marks, end)
            # an end needs no solution of its own where there is one, or between two that are close together
            if any(abs(end - mark) < _SAME for mark in marks):
                continue
            if beside in (0, len(marks)) or self.far(marks[beside - 1], marks[beside]):
                marks.insert(int(beside), end)
        wanted = [x for x in marks if x not in known]
        for left, right in pairwise(marks):
            fine = np.linspace(left, right, _SAMPLES)
            along = np.concatenate([[0.0], np.cumsum(self.between(fine))])
            pieces = int(np.ceil(along[-1] - _SAME))
            wanted += np.interp(np.arange(1, pieces) * along[-1] / max(pieces, 1), along, fine).tolist()
        return np.array(sorted(wanted))

    def apart(self, known: Array) -> Array:
        """Of sorted positions the first and the last, and those between that are not next to one before or to the last.

        Curves through solutions that close together would follow what these scatter by.
        """
        along = np.concatenate([[0.0], np.cumsum(self.between(known))])
        kept, beside = [0], min(_NEXT_TO, _SHARE * along[-1])
        for i in range(1, known.size - 1):
            if along[i] - along[kept[-1]] > beside < along[-1] - along[i]:
                kept.append(i)
        return np.asarray(known[sorted({*kept, known.size - 1})])

    def far(self, one: float, other: float) -> bool:
        """Whether two positions are farther apart than one spacing."""
        return float(self.between(np.sort([one, other]))[0]) >= 1 + _SAME
