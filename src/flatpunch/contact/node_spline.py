"""Splines through a few dear solutions over ln a, and how far they may be trusted."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline

from flatpunch._validation import Array, Flags


def spline_through(nodes: Array, table: Array) -> CubicSpline:
    """Spline through the solutions: not-a-knot cubic, lower degree where there are few."""
    if nodes.size > 3:
        return CubicSpline(nodes, table)
    return make_interp_spline(nodes, table, k=nodes.size - 1)


def left_out(nodes: Array, table: Array) -> Array:
    """Estimated error of the spline beside each node, shape of table: a fifth of what the cubic through four neighbours misses.

    Leaving a node out doubles the local spacing, so the error of a cubic grows sixteenfold where it is resolved; five is on
    the safe side. Only neighbours are asked, so that a rough stretch asks for no solutions elsewhere. At the ends, where leaving
    out extrapolates, the next node's value stands.
    """
    wrong = np.zeros_like(table)
    for i in range(1, nodes.size - 1):
        first = max(0, min(i - 2, nodes.size - 5))
        near = [j for j in range(first, min(first + 5, nodes.size)) if j != i]
        wrong[i] = np.abs(_lagrange_weights(nodes[near], nodes[i]) @ table[near] - table[i]) / 5
    wrong[0], wrong[-1] = wrong[1], wrong[-2]
    return wrong


def _lagrange_weights(nodes: Array, at: float) -> Array:
    """Weights of values at the nodes, shape (n,), in the value at a point of the polynomial through them."""
    distance = nodes[:, None] - nodes
    np.fill_diagonal(distance, 1.0)
    away = np.broadcast_to(at - nodes, distance.shape).copy()
    np.fill_diagonal(away, 1.0)
    return np.asarray(np.prod(away / distance, axis=1))


def between_good(nodes: Array, good: Flags, x: Array) -> Flags:
    """Whether both nodes around each point are good, or the one node it coincides with."""
    upper = np.clip(np.searchsorted(nodes, x), 1, nodes.size - 1)
    at = np.abs(nodes[upper] - x) < 1e-9
    return np.asarray((good[upper - 1] | at) & (good[upper] | (np.abs(nodes[upper - 1] - x) < 1e-9)))
