"""Mean radius and area along a loading path on which the contact comes apart, and joins again.

Where islands come down beside a star its radius and area begin to rise at once, three to ten times faster. So solutions with an
outline and those without have curves of their own, and in the gap between these the larger of both continuations holds: they
cross at the kink, which is where another solution is worth most. This is Harten's subcell resolution (J. Comput. Phys. 83,
148-184, 1989).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.contact.refined.splines import Curve, curve_through, left_out, runs_of, spline_through

_KNOWN = 3
"""Solutions by which a curve is continued."""
_SAFETY, _SHARE = 3.0, 0.1
"""Over what a continuation changes without the nearest of its solutions, and the least error of the rise after the kink."""
_FINE = np.linspace(0.0, 1.0, 65)
_INSIDE = 0.1
"""Share of a gap that a new solution keeps from its ends."""


@dataclass(frozen=True, slots=True)
class KinkedCurve:
    """Curves through logarithms of radius and area, a column each, over x = ln d.

    Attributes
    ----------
    nodes : ndarray, shape (n,)
        Positions of the solutions.
    curves : list
        What holds in each gap between them.
    error : ndarray, shape (n - 1,)
        Its estimated error.
    kinks : ndarray, shape (n - 1,)
        Where the contact comes apart, NaN for gaps in which it does not.
    """

    nodes: Array
    curves: list[Curve]
    error: Array
    kinks: Array

    def __call__(self, x: Array) -> Array:
        """Logarithms at x, shape (n,) -> (n, 2)."""
        gap = np.clip(np.searchsorted(self.nodes, x) - 1, 0, len(self.curves) - 1)
        values = np.empty((x.size, 2))
        for i in np.unique(gap):
            here = gap == i
            values[here] = self.curves[i](x[here])
        return values


def sizes_through(nodes: Array, sizes: Array, whole: Flags, missed: Array | None = None) -> KinkedCurve:
    """Curves through ln a0 and ln sqrt(A/pi), shape (nodes, 2), of contacts in one part where they are `whole`.

    `missed` is what `left_out` says of them all, where that is known.
    """
    curves: list[Curve] = [curve_through(nodes, sizes)] * (nodes.size - 1)
    error, kinks = _beside(left_out(nodes, sizes) if missed is None else missed), np.full(nodes.size - 1, np.nan)
    runs = runs_of(whole)
    for run in runs:
        if 1 < run.size < nodes.size:
            gaps = slice(run[0], run[-1])
            curves[gaps] = [curve_through(nodes[run], sizes[run])] * (run.size - 1)
            if run.size > _KNOWN:
                error[gaps] = _beside(left_out(nodes[run], sizes[run]))
    for before, after in pairwise(runs):
        if whole[before[0]]:
            i = int(before[-1])
            curves[i], error[i], kinks[i] = _kinked(nodes, sizes, before, after)
    return KinkedCurve(nodes, curves, error, kinks)


def _beside(missed: Array) -> Array:
    """The larger of the errors at the nodes around each gap."""
    worst = np.abs(missed).max(axis=1)
    return np.asarray(np.maximum(worst[1:], worst[:-1]))


def _kinked(nodes: Array, sizes: Array, before: Indices, after: Indices) -> tuple[Curve, float, float]:
    """Curve in the gap in which a contact comes apart, its estimated error, and where it does."""

    def by(few: Indices) -> Curve:
        return spline_through(nodes[few], sizes[few])

    left, right = by(before[-_KNOWN:]), by(after[:_KNOWN])
    start, end = nodes[before[-1]], nodes[after[0]]
    x = start + _FINE * (end - start)
    rise = right(x) - left(x)
    error = _SHARE * float(np.abs(rise[-1]).max())
    if after.size < 2 or np.any(rise[0] > 0) or np.any(rise[-1] < 0):
        return by(np.array([before[-1], after[0]])), error, np.nan
    kink = x[[np.argmax(rise[:, 1] >= 0)]]
    for curve, further in ((left, before[:-1][-_KNOWN:]), (right, after[1:][:_KNOWN])):
        if further.size:
            error = max(error, float(np.abs(curve(kink) - by(further)(kink)).max()) / _SAFETY)
    inside = _INSIDE * (end - start)
    return lambda at: np.maximum(left(at), right(at)), error, float(np.clip(kink[0], start + inside, end - inside))
