"""Curves through mean radius, area and outline of boundary element solutions over x = ln d.

Over x the length of narrow contact lobes bends where they set in, and solutions hardly resolve it. Over that length x does not:
so outlines are interpolated over t = x + 4 ln(farthest point), and x(t) is a spline through the same solutions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.contact.refined.kinks import sizes_through
from flatpunch.contact.refined.splines import (
    Curve,
    Through,
    continued,
    curve_through,
    left_out,
    runs_of,
    spline_through,
)

_CAUTION = 2.0
"""What is told as interpolation error of outlines over what leaving a solution out tells, which decides on more of them
(catalogue)."""
_DISPUTE = 0.4
"""Error of the outline over what following the round contact changes of it."""
_DEPARTURE = 0.02
"""Departure of the round contact from a smooth curve up to which shapes are thought to share it."""
_CHOICE = 4
"""Power of the ratio of errors with which the better of two curves is preferred."""
_LENIENCE = 3.0
"""How much larger than of outlines errors of radius and area may be, but where contacts come apart."""
_GROWING = 0.1
"""By how much ln of the farthest point over the mean radius rises in gaps in which needles grow."""
_LOST = 0.0125
"""What leaving a solution out may tell of the outline before the way needles grow counts as lost with it."""
_ENOUGH = 5
"""Solutions in a row through which local curves and splines have nothing in common but these."""
_APART, _LEAST = 2.0, 2 / 5
"""Error of the outline over the difference between both, and the least of it over what leaving a solution out tells."""
_INSIDE = np.array([1 / 4, 1 / 2, 3 / 4])
"""Where in a gap they are compared."""
_ROUNDING = 1e-9
_LENGTH = 4.0
"""What ln(farthest point) counts for over ln d."""
_FINE = 64
"""Points in each gap at which t(x) is tabulated."""


@dataclass(frozen=True, slots=True)
class ShapeCurve:
    """Logarithms of shapes over x = ln d, one value per column: ln a0, ln sqrt(A/pi) and ln a(phi).

    Attributes
    ----------
    nodes : ndarray, shape (n,)
        Positions of the solutions.
    sizes, outline, steady : callable
        Curves through the first two columns, through the others, and through the round radii beside them.
    weight : ndarray, shape (n,)
        How far shapes follow what the latter miss of the round contact between solutions.
    error : ndarray, shape (n - 1,)
        Estimated error in each gap: of the outline over its mean radius, or of the logarithms of the sizes.
    kinks : ndarray, shape (n - 1,)
        Where in a gap the contact comes apart, else NaN.
    """

    nodes: Array
    sizes: Curve
    outline: Curve
    steady: Curve
    weight: Array
    error: Array
    kinks: Array

    def blended(self, x: Array, theory: Array) -> tuple[Array, Array]:
        """Logarithms at x, (n, columns), where the round radius has `theory`, and the error that following it tells, (n,)."""
        change = self.change(x, theory)
        blended = np.hstack([self.sizes(x), self.outline(x)]) + change[:, None]
        return blended, _DISPUTE * np.abs(change) * np.exp((blended[:, 2:] - blended[:, :1]).max(axis=1))

    def change(self, x: Array, theory: Array) -> Array:
        """What following the round radius, `theory`, changes of all logarithms at x, shape (n,)."""
        missed = theory - self.steady(x)
        # round contacts jump where others need not
        return np.asarray(np.interp(x, self.nodes, self.weight) * missed / (1 + (missed / _DEPARTURE) ** 4))

    def estimate(self, x: Array) -> Array:
        """Estimated error at points, shape (n,): none at a solution."""
        if self.nodes.size == 1:
            return np.zeros_like(x)
        gap = np.clip(np.searchsorted(self.nodes, x) - 1, 0, self.error.size - 1)
        return np.where(np.abs(self.nodes[:, None] - x).min(axis=0) < _ROUNDING, 0.0, _CAUTION * self.error[gap])


def shape_curve(nodes: Array, rows: Array, round_radius: Array, turned: Flags, sectors: Indices) -> ShapeCurve:
    """Curves through shapes that know of the round contact where that makes them miss less of solutions left out.

    Parameters
    ----------
    nodes : array, shape (n,)
        Positions ln d of the solutions.
    rows : array, shape (n, 2 + angles)
        Their ln a0, ln sqrt(A/pi) and ln a(phi), NaN where a contact has no outline.
    round_radius : array, shape (n,)
        ln a of the round contacts.
    turned : array of bool, shape (n,)
        Whether these have turned back before.
    sectors : array of int, shape (angles,)
        Which kind of edge is nearest to each ray.
    """
    whole = np.isfinite(rows[:, -1])
    outlines = continued(nodes, rows, whole)[:, 2:]
    if nodes.size == 1:
        sizes, outline, steady = (_standing(table) for table in (rows[:, :2], outlines, round_radius))
        return ShapeCurve(nodes, sizes, outline, steady, np.ones(1), np.zeros(0), np.zeros(0))
    through = partial(outlines_through, sectors=sectors)
    # errors of logarithms, across the outline and over the mean radius: rays meet the flanks of needles aslant
    reach = np.exp(outlines - rows[:, :1]) / np.hypot(1.0, _steepness(outlines))
    growing = _growing(outlines - rows[:, :1], whole)
    missed = left_out(nodes, outlines, through)
    wrong, share = (np.abs(missed) * reach).max(axis=1), np.zeros(nodes.size)
    missed_sizes, missed_radius = np.split(left_out(nodes, np.column_stack([rows[:, :2], round_radius])), [2], axis=1)
    if nodes.size > 2:
        beside = (np.abs(missed - missed_radius) * reach).max(axis=1)
        share = 1 / (1 + (beside / (wrong + _ROUNDING)) ** _CHOICE)
        share[turned | ~whole | np.append(growing, False) | np.append(False, growing)] = 0.0
        wrong += share * (beside - wrong)
    kinked = sizes_through(nodes, rows[:, :2], whole, missed_sizes)
    error = np.where(whole[1:] != whole[:-1], kinked.error, kinked.error / _LENIENCE)
    curve = _by_runs(nodes, outlines, whole, through)
    wrong = np.maximum(wrong[1:], wrong[:-1])
    lost = growing & (wrong > _LOST)
    if lost.any():
        smooth = _by_runs(nodes, outlines, whole, partial(through, through=spline_through))
        apart = _APART * _largest_difference(nodes, rows[:, 0], curve, smooth)
        wrong = np.where(lost, np.clip(apart, _LEAST * wrong, wrong), wrong)
    error = np.where(whole[1:] & whole[:-1], np.maximum(wrong, error), error)
    return ShapeCurve(nodes, kinked, curve, curve_through(nodes, round_radius), share, error, kinked.kinks)


def _steepness(outlines: Array) -> Array:
    """|dln a/dphi| of flanks, shape (n, angles): ends of needles are none, whether at a ray or between two."""
    forwards = np.roll(outlines, -1, axis=1) - outlines
    backwards = np.roll(forwards, 1, axis=1)
    least = np.minimum.reduce([np.abs(forwards), np.abs(backwards), np.abs(forwards + backwards) / 2])
    return np.asarray(least * (outlines.shape[1] / (2 * np.pi)))


def _growing(shapes: Array, whole: Flags) -> Flags:
    """Gaps in which needles grow, shape (n - 1,): leaving out a solution there doubles more than the gap.

    None between a few solutions, through which all curves are the same.
    """
    growing = np.diff(shapes.max(axis=1)) > _GROWING
    for run in runs_of(whole):
        if run.size < _ENOUGH or not whole[run[0]]:
            growing[max(run[0] - 1, 0) : run[-1] + 1] = False
    return np.asarray(growing)


def _largest_difference(nodes: Array, radius: Array, one: Curve, other: Curve) -> Array:
    """Distance between two outlines in each gap, across them and over the mean radius, shape (n - 1,)."""
    x = (nodes[:-1, None] + np.diff(nodes)[:, None] * _INSIDE).ravel()
    outlines = one(x)
    reach = np.exp(outlines - np.interp(x, nodes, radius)[:, None]) / np.hypot(1.0, _steepness(outlines))
    apart = (np.abs(outlines - other(x)) * reach).max(axis=1)
    return np.asarray(apart.reshape(-1, _INSIDE.size).max(axis=1))


def _by_runs(nodes: Array, outlines: Array, whole: Flags, through: Through) -> Curve:
    """Outlines of contacts in one part know nothing of what lies beyond others."""
    everywhere, runs = through(nodes, outlines), runs_of(whole)
    if len(runs) == 1:
        return everywhere
    own = [(nodes[run[[0, -1]]], through(nodes[run], outlines[run])) for run in runs if whole[run[0]] and run.size > 1]

    def outline(x: Array) -> Array:
        values = everywhere(x)
        for (first, last), curve in own:
            here = (x >= first) & (x <= last)
            values[here] = curve(x[here])
        return values

    return outline


def _standing(table: Array) -> Curve:
    """Curve through one row."""
    return lambda x: np.repeat(table, x.size, axis=0)


def outlines_through(nodes: Array, outlines: Array, sectors: Indices, through: Through = curve_through) -> Curve:
    """Curve over x through ln a(phi), shape (nodes, angles), which follows the needles of each kind of edge as they grow.

    `sectors` are the kinds of edge that rays belong to, shape (angles,), counted from 0; over t curves are those of `through`.
    """
    kinds = [sectors == kind for kind in range(int(sectors.max()) + 1)]
    curves = [_following(nodes, outlines[:, rays], through) for rays in kinds]

    def outline(x: Array) -> Array:
        values = np.empty((x.size, sectors.size))
        for rays, curve in zip(kinds, curves, strict=True):
            values[:, rays] = curve(x)
        return values

    return outline


def _following(nodes: Array, outlines: Array, through: Through) -> Curve:
    """The same of rays beside one kind of edge."""
    length = np.maximum.accumulate(outlines.max(axis=1))
    along = nodes + _LENGTH * (length - length[0])
    gaps = np.arange(nodes.size)
    fine = np.interp(np.linspace(0, gaps[-1], _FINE * gaps[-1] + 1), gaps, along)
    places = spline_through(along, nodes)(fine)
    if np.any(np.diff(places) <= 0):
        places = scipy.interpolate.PchipInterpolator(along, nodes)(fine)
    curve = through(along, outlines)
    return lambda x: curve(np.interp(x, places, fine))
