"""Curves through a few dear solutions over x = ln d, with or without slopes, and how far they may be trusted."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.numerics.hermite import cubic_hermite

_SAFETY = 8.0
"""Over what cubic Hermite curves miss of a node left out; their error grows sixteenfold where it is resolved."""
_CHANCE, _SLOPE_CHANCE = 0.1, 0.3
"""Least estimate over that of the nodes beside, of values and of slopes."""
_INSIDE = np.arange(1, 8) / 8
"""Where curves are compared between nodes."""
_PLAIN_SAFETY = 5.0
"""The same of local curves through values."""
_ONE_SIDED = 3.0
"""How much less a spline knows of the slopes at its ends."""
_BESIDE = 3
"""Nodes on either side that a local curve knows of."""
_FARTHEST = 10.0
"""By how much logarithms are carried on at most: slopes between solutions close together grow beyond all numbers."""

Curve = Callable[..., Array]
Through = Callable[[Array, Array], Curve]
"""Makes the curve through a table at nodes."""


def spline_through(nodes: Array, table: Array) -> Curve:
    """Spline through the solutions: not-a-knot cubic, lower degree where there are few."""
    few = nodes.size <= 3
    curve: Curve = (
        scipy.interpolate.make_interp_spline(nodes, table, k=nodes.size - 1)
        if few
        else scipy.interpolate.CubicSpline(nodes, table)
    )
    return curve


def curve_through(nodes: Array, table: Array) -> Curve:
    """Local curve through the solutions (Akima, with modified weights): a rough stretch does not reach beyond three nodes."""
    if nodes.size <= 3:
        return spline_through(nodes, table)
    local = scipy.interpolate.Akima1DInterpolator(nodes, table, method="makima")
    # which by itself has no values beyond its ends, not even by rounding
    local.extrapolate = True
    curve: Curve = local
    return curve


def off_smoother(nodes: Array, values: Array, slopes: Array) -> Array:
    """Estimated error of the cubic Hermite curve in each gap, shape (n - 1,): what it differs from a smoother one by.

    That is the quintic spline through the same values and slopes with a continuous third derivative, and without knots at the
    last but one nodes; it is two orders better where solutions lie close enough. Of two nodes there is nothing to tell.
    """
    if nodes.size < 3:
        return np.full(nodes.size - 1, np.inf)
    inner = np.repeat(nodes[1:-1], 2)[1:-1]
    knots = np.concatenate([np.repeat(nodes[0], 6), inner, np.repeat(nodes[-1], 6)])
    basis = scipy.interpolate.BSpline(knots, np.eye(2 * nodes.size), 5)
    matrix = np.concatenate([basis(nodes), basis(nodes, 1)])
    smoother = scipy.interpolate.BSpline(knots, np.linalg.solve(matrix, np.concatenate([values, slopes])), 5)
    # the difference vanishes at the nodes and often once between them
    inside = nodes[:-1, None] + np.diff(nodes)[:, None] * _INSIDE
    return np.asarray(
        np.abs(scipy.interpolate.CubicHermiteSpline(nodes, values, slopes)(inside) - smoother(inside)).max(axis=1)
    )


def settled_slopes(nodes: Array, values: Array, slopes: Array, noise: float) -> tuple[Array, Array]:
    """Slopes at the nodes and their uncertainty, shape (n,): known ones, and those of the spline through the values.

    Each counts by how well it is known: `slopes` to `noise`, the spline's to what its error over a third of the spacing makes,
    and no better than to what they differ by beyond noise.
    """
    gaps = np.diff(nodes)
    gap = np.minimum(np.append(gaps, np.inf), np.insert(gaps, 0, np.inf))
    smooth = spline_through(nodes, values)(nodes, 1)
    wrong = 3 * _beside_too(np.abs(_off_neighbours(nodes, values)) / _PLAIN_SAFETY, _SLOPE_CHANCE) / gap
    # the first and the last have neighbours on one side
    wrong[[0, -1]] *= _ONE_SIDED
    doubt = wrong**2 + np.maximum((slopes - smooth) ** 2 - noise**2, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(np.isfinite(doubt), doubt / (doubt + noise**2), 1.0)
    return np.asarray(smooth + share * (slopes - smooth)), np.sqrt(share) * noise


def left_out_of_hermite(nodes: Array, values: Array, slopes: Array, doubt: Array) -> Array:
    """Estimated error beside each node of the curve through values and slopes, shape (n,).

    It is an eighth of what the curve misses without the node, and what the slopes' `doubt` does to the middle of the gaps. At
    the ends, where leaving out extrapolates, the next node's value stands; of two nodes there is nothing to tell.
    """
    if nodes.size < 3:
        return np.full(nodes.size, np.inf)
    width = nodes[2:] - nodes[:-2]
    share = (nodes[1:-1] - nodes[:-2]) / width
    without = cubic_hermite(share, width, (values[:-2], values[2:]), (slopes[:-2], slopes[2:]))
    wrong = np.pad(np.abs(without - values[1:-1]) / _SAFETY, 1, mode="edge")
    wrong = _beside_too(wrong, _CHANCE)
    gaps = np.diff(nodes)
    return np.asarray(wrong + doubt * np.maximum(np.append(gaps, 0.0), np.insert(gaps, 0, 0.0)) / 8)


def _beside_too(wrong: Array, share: float) -> Array:
    """At least a share of what is told of the nodes beside: what one node misses may vanish by chance."""
    return np.asarray(np.maximum(wrong, share * np.maximum(np.append(wrong[1:], 0.0), np.insert(wrong[:-1], 0, 0.0))))


def left_out(nodes: Array, table: Array, through: Through = curve_through) -> Array:
    """Error of local curves beside each node, shape of table: a fifth of what they miss, with its sign, without that node.

    Leaving a node out doubles the local spacing, so the error grows by eight or sixteen where it is resolved; five is on the
    safe side. At the ends, where leaving out extrapolates, the next node's value stands.
    """
    if nodes.size < 3:
        return np.full_like(table, np.inf)
    wrong = np.zeros_like(table)
    for i in range(1, nodes.size - 1):
        near = _neighbours(i, nodes.size, _BESIDE)
        wrong[i] = (through(nodes[near], table[near])(nodes[i]) - table[i]) / _PLAIN_SAFETY
    wrong[0], wrong[-1] = _ONE_SIDED * wrong[1], _ONE_SIDED * wrong[-2]
    return wrong


def _off_neighbours(nodes: Array, values: Array) -> Array:
    """Cubic through four neighbours minus the value, shape (n,); at the ends that of the next node, infinite for two nodes."""
    if nodes.size < 3:
        return np.full_like(values, np.inf)
    off = np.zeros_like(values)
    for i in range(1, nodes.size - 1):
        near = _neighbours(i, nodes.size, 2)
        away, distance = nodes[i] - nodes[near], nodes[near][:, None] - nodes[near]
        np.fill_diagonal(distance, 1.0)
        # Lagrange's polynomial
        weights = np.prod(away) / (away * np.prod(distance, axis=1))
        off[i] = weights @ values[near] - values[i]
    off[0], off[-1] = off[1], off[-2]
    return off


def _neighbours(i: int, size: int, beside: int) -> list[int]:
    """Numbers of the nodes around node i, so many on either side or more on one near the ends."""
    first = max(0, min(i - beside, size - 2 * beside - 1))
    return [j for j in range(first, min(first + 2 * beside + 1, size)) if j != i]


def continued(nodes: Array, table: Array, good: Flags) -> Array:
    """The table with what is missing at nodes that are not good carried on from the others."""
    if good.all():
        return table
    filled = np.array(table)
    if good.sum() < 2:
        filled[~good] = table[good] if good.any() else table[:, :1]
        return filled
    curve = spline_through(nodes[good], table[good])
    near = np.clip(nodes[~good], nodes[good][0], nodes[good][-1])
    filled[~good] = curve(near) + np.clip(curve(near, 1) * (nodes[~good] - near)[:, None], -_FARTHEST, _FARTHEST)
    return filled


def between_good(nodes: Array, good: Flags, x: Array) -> Flags:
    """Whether both nodes around each point are good, or the one node it coincides with."""
    if nodes.size == 1:
        return np.full(x.size, bool(good[0]))
    upper = np.clip(np.searchsorted(nodes, x), 1, nodes.size - 1)
    at = np.abs(nodes[upper] - x) < 1e-9
    return np.asarray((good[upper - 1] | at) & (good[upper] | (np.abs(nodes[upper - 1] - x) < 1e-9)))


def leading(nodes: Flags, gaps: Flags) -> int:
    """How many nodes there are before the first that is not good, or that follows a gap that is not."""
    return int(min(np.argmin(np.append(nodes, False)), np.argmin(np.append(gaps, False)) + 1))


def runs_of(good: Flags) -> list[Indices]:
    """Numbers of the nodes that follow one another and are all good, or all not."""
    return np.split(np.arange(good.size), np.flatnonzero(np.diff(good)) + 1)
