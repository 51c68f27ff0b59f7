"""Curves through a few dear solutions over x = ln d, with or without slopes, and how far they may be trusted."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline, CubicHermiteSpline, CubicSpline, make_interp_spline

from flatpunch._validation import Array, Flags

_SAFETY = 8.0
"""Over what cubic Hermite curves miss of a node left out; their error grows sixteenfold where it is resolved."""
_CHANCE = 0.1
"""Least estimate over that of the nodes beside."""
_INSIDE = np.arange(1, 8) / 8
"""Where curves are compared between nodes."""
_PLAIN_SAFETY = 5.0
"""The same of the cubic through four values."""


def spline_through(nodes: Array, table: Array) -> CubicSpline:
    """Spline through the solutions: not-a-knot cubic, lower degree where there are few."""
    if nodes.size > 3:
        return CubicSpline(nodes, table)
    return make_interp_spline(nodes, table, k=nodes.size - 1)


def off_smoother(nodes: Array, values: Array, slopes: Array) -> Array:
    """Estimated error of the cubic Hermite curve in each gap, shape (n - 1,): what it differs from a smoother one by.

    That is the quintic spline through the same values and slopes with a continuous third derivative, and without knots at the
    last but one nodes; it is two orders better where solutions lie close enough. Of two nodes there is nothing to tell.
    """
    if nodes.size < 3:
        return np.full(nodes.size - 1, np.inf)
    inner = np.repeat(nodes[1:-1], 2)[1:-1]
    knots = np.concatenate([np.repeat(nodes[0], 6), inner, np.repeat(nodes[-1], 6)])
    basis = BSpline(knots, np.eye(2 * nodes.size), 5)
    matrix = np.concatenate([basis(nodes), basis(nodes, 1)])
    smoother = BSpline(knots, np.linalg.solve(matrix, np.concatenate([values, slopes])), 5)
    # the difference vanishes at the nodes and often once between them
    inside = nodes[:-1, None] + np.diff(nodes)[:, None] * _INSIDE
    return np.asarray(np.abs(CubicHermiteSpline(nodes, values, slopes)(inside) - smoother(inside)).max(axis=1))


def settled_slopes(nodes: Array, values: Array, slopes: Array, noise: float) -> tuple[Array, Array]:
    """Slopes at the nodes and their uncertainty, shape (n,): known ones, and those of the spline through the values.

    Each counts by how well it is known: `slopes` to `noise`, the spline's to what its error over a third of the spacing makes,
    and no better than to what they differ by beyond noise.
    """
    gaps = np.diff(nodes)
    gap = np.minimum(np.append(gaps, np.inf), np.insert(gaps, 0, np.inf))
    smooth = spline_through(nodes, values)(nodes, 1)
    doubt = (3 * left_out(nodes, values[:, None])[:, 0] / gap) ** 2 + np.maximum((slopes - smooth) ** 2 - noise**2, 0.0)
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
    wrong = np.zeros(nodes.size)
    for i in range(1, nodes.size - 1):
        beside = [i - 1, i + 1]
        without = CubicHermiteSpline(nodes[beside], values[beside], slopes[beside])
        wrong[i] = abs(float(without(nodes[i])) - values[i]) / _SAFETY
    wrong[0], wrong[-1] = wrong[1], wrong[-2]
    # what one node misses may vanish by chance
    wrong = np.maximum(wrong, _CHANCE * np.maximum(np.append(wrong[1:], 0.0), np.insert(wrong[:-1], 0, 0.0)))
    gaps = np.diff(nodes)
    return np.asarray(wrong + doubt * np.maximum(np.append(gaps, 0.0), np.insert(gaps, 0, 0.0)) / 8)


def left_out(nodes: Array, table: Array) -> Array:
    """Estimated error of the spline beside each node, shape of table: a fifth of what the cubic through four neighbours misses.

    Leaving a node out doubles the local spacing, so the error of a cubic grows sixteenfold where it is resolved; five is on
    the safe side. Only neighbours are asked, so that a rough stretch asks for no solutions elsewhere. At the ends, where leaving
    out extrapolates, the next node's value stands.
    """
    if nodes.size < 3:
        return np.full_like(table, np.inf)
    wrong = np.abs(_off_neighbours(nodes, table)) / _PLAIN_SAFETY
    wrong[0], wrong[-1] = wrong[1], wrong[-2]
    return wrong


def steadied(nodes: Array, table: Array, noise: float) -> Array:
    """Solutions with scatter, each moved halfway to the cubic through its neighbours as far as the difference is mere `noise`."""
    off = _off_neighbours(nodes, table)
    return np.asarray(table + off / 2 * np.exp(-((off / noise) ** 2)))


def _off_neighbours(nodes: Array, table: Array) -> Array:
    """Cubic through four neighbours minus the value, shape of table; zero at the ends."""
    off = np.zeros_like(table)
    for i in range(1, nodes.size - 1):
        first = max(0, min(i - 2, nodes.size - 5))
        near = [j for j in range(first, min(first + 5, nodes.size)) if j != i]
        off[i] = _lagrange_weights(nodes[near], nodes[i]) @ table[near] - table[i]
    return off


def _lagrange_weights(nodes: Array, at: float) -> Array:
    """Weights of values at the nodes, shape (n,), in the value at a point of the polynomial through them."""
    distance = nodes[:, None] - nodes
    np.fill_diagonal(distance, 1.0)
    away = np.broadcast_to(at - nodes, distance.shape).copy()
    np.fill_diagonal(away, 1.0)
    return np.asarray(np.prod(away / distance, axis=1))


def continued(nodes: Array, table: Array, good: Flags) -> Array:
    """The table with what is missing from its third column on beside nodes that are not good carried on from the others."""
    if good.all():
        return table
    filled = np.array(table)
    if good.sum() < 2:
        filled[~good, 2:] = table[good, 2:] if good.any() else table[:, :1]
        return filled
    curve = spline_through(nodes[good], table[good, 2:])
    near = np.clip(nodes[~good], nodes[good][0], nodes[good][-1])
    filled[~good, 2:] = curve(near) + curve(near, 1) * (nodes[~good] - near)[:, None]
    return filled


def between_good(nodes: Array, good: Flags, x: Array) -> Flags:
    """Whether both nodes around each point are good, or the one node it coincides with."""
    if nodes.size == 1:
        return np.full(x.size, bool(good[0]))
    upper = np.clip(np.searchsorted(nodes, x), 1, nodes.size - 1)
    at = np.abs(nodes[upper] - x) < 1e-9
    return np.asarray((good[upper - 1] | at) & (good[upper] | (np.abs(nodes[upper - 1] - x) < 1e-9)))
