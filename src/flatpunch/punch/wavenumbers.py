"""Quadrature over wavenumbers and the spherical Bessel functions on it.

Everything is integrated over x = k a on panels that do not depend on the medium: geometric up to x = 4, uniform above
(the products j_p j_q oscillate with period pi). Only the kernel changes with the punch radius, so the table of Bessel
functions is computed once and one matrix product assembles each punch matrix (T3.2).

Where the layers act far beyond all orders, the oscillation need not be resolved. With y the spherical Bessel functions
of the second kind,

    j_p j_q = (j_p j_q + y_p y_q)/2 + (j_p j_q - y_p y_q)/2:

the first half is smooth and is integrated on panels that double in length; the second oscillates like cos 2x and, switched
on by a smooth window, integrates to nothing against a smooth L - 1. Functions cos x and sin x in the place of j_p have the
companions sin x and -cos x in the place of y_p.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.numerics.gauss import NODES, gauss

_SHORT_UNTIL = 128.0
"""Upper end, in x, of the panels of length 4 and 8; above, panels are 32 long."""

WINDOW = _SHORT_UNTIL
"""Length in x of the window that switches the oscillating half off: some of the longest panels."""

_APART = 12
"""Phase by which the highest order and order 0 part on one panel; twice as much leaves 1e-8 of the responses."""


@dataclass(frozen=True, slots=True)
class BesselTable:
    """Nodes, weights and spherical Bessel functions of one parity.

    Attributes
    ----------
    x, w : ndarray, shape (n,)
        Nodes and weights.
    j : ndarray, shape (terms, n)
        j_p(x) for p = parity, parity + 2, ...; y_p(x) at the nodes from number `direct` on.
    waves : ndarray, shape (2, n)
        cos x and sin x, or their companions where `j` holds y_p.
    direct : int
        Number of nodes with j_p.
    """

    x: Array
    w: Array
    j: Array
    waves: Array
    direct: int

    @property
    def split(self) -> bool:
        """Whether only the smooth half of the products is integrated far out."""
        return self.direct < self.x.size


def panel_edges(first: int, x_high: float) -> Array:
    """Edges 0, 4^first, ..., 1, 4, 8, ..., 64, 72, ..., 128, 160, ... up to the first one at or above x_high."""
    geometric = 4.0 ** np.arange(first, 2)
    step, half, long = 4.0, _SHORT_UNTIL / 2, _SHORT_UNTIL / 4
    fine, coarse = np.arange(step, half, step) + step, np.arange(half, _SHORT_UNTIL, 2 * step) + 2 * step
    edges = np.concatenate([[0.0], geometric, fine, coarse, np.arange(_SHORT_UNTIL, x_high, long) + long])
    stop = int(np.searchsorted(edges, x_high)) + 1
    return edges[: max(stop, 2)]


@byte_cached
def bessel_table(parity: int, terms: int, first: int, x_high: float) -> BesselTable:
    """Quadrature on (0, x_high) with the spherical Bessel functions of even (parity 0) or odd orders.

    The lowest geometric panel starts at 4^first; below it lies one panel (0, 4^first). x_high is rounded up to a panel edge.
    """
    edges = panel_edges(first, x_high)
    short, long = edges[edges <= _SHORT_UNTIL], edges[edges >= _SHORT_UNTIL]
    parts = zip(_exact_gauss(short, NODES), _exact_gauss(long, 2 * NODES), strict=True)
    x, w, rest = (np.concatenate(part) for part in parts)
    # sine and cosine of the nodes before rounding: 1e-13 of x = 1000 would count in sums over thousands of nodes
    cos, sin = np.cos(x), np.sin(x)
    waves = np.stack([cos - rest * sin, sin + rest * cos])
    return BesselTable(x, w, spherical_bessel(parity + 2 * terms, x, waves)[parity::2][:terms].copy(), waves, x.size)


def window_start(parity: int, terms: int) -> float:
    """Where the window begins: an edge of the longest panels, beyond the turning points of all orders."""
    return float(panel_edges(0, max(above_orders(parity, terms), _SHORT_UNTIL))[-1])


def above_orders(parity: int, terms: int) -> float:
    """Where the Bessel functions of all orders have left their turning point: half as far above the highest of them."""
    return 1.5 * (parity + 2 * terms) + 20.0


@byte_cached
def split_table(parity: int, terms: int, first: int, doublings: int) -> BesselTable:
    """Quadrature on (0, inf) whose panels reach 2^doublings (start + WINDOW) or further; one in 1/x follows."""
    start = window_start(parity, terms)
    end = start + WINDOW
    highest = parity + 2 * terms
    near = bessel_table(parity, terms, first, end)
    # farther out the phases of all orders are nearly those of order 0, and one panel in 1/x does the rest
    edges = far_edges(end, highest, max(end * 2.0**doublings, highest**2 / _APART), 1.0)
    far, far_weight = composite_gauss(edges)
    inverse, rest = composite_gauss(np.array([0.0, 1 / edges[-1]]))
    far, far_weight = np.concatenate([far, 1 / inverse[::-1]]), np.concatenate([far_weight, (rest / inverse**2)[::-1]])
    # width of the window's erfc: 1e-14 is left at its ends, and less of what oscillates at x = 1.5 times the highest order
    whole = np.where(near.x > start, scipy.special.erfc((near.x - start - WINDOW / 2) / 11.0) / 2, 1.0)
    # nodes of the window and beyond: there both kinds are stable upwards
    inside = near.x > start
    beyond = np.concatenate([near.x[inside], far])
    half = np.concatenate([(near.w * (1 - whole) / 2)[inside], far_weight / 2])
    weights = np.concatenate([near.w * (1 + whole) / 2, far_weight / 2])
    waves = np.hstack([near.waves, [np.cos(far), np.sin(far)]])
    cos, sin = waves[:, -beyond.size :]
    j = np.hstack([near.j, _upward(np.sin(far) / far, -np.cos(far) / far, far, highest)[parity::2][:terms]])
    y = _upward(-cos / beyond, -sin / beyond, beyond, highest)[parity::2][:terms]
    x = np.concatenate([near.x, far])
    return BesselTable(
        np.concatenate([x, beyond]),
        np.concatenate([weights, half]),
        np.hstack([j, y]),
        np.hstack([waves, [sin, -cos]]),
        x.size,
    )


def far_edges(start: float, highest: int, end: float, growth: float) -> Array:
    """Panels beginning at `start` that grow by (1 + growth), shorter where the phases of orders p and 0 still part.

    Those part by p^2/(2 x^2) per x.
    """
    edges = [start]
    while edges[-1] < end:
        x = edges[-1]
        edges.append(x + min(growth * x, _APART * x * x / max(highest, 1) ** 2))
    return np.array(edges)


def _upward(first: Array, side: Array, x: Array, orders: int) -> Array:
    """Spherical Bessel functions at x above the orders, (orders, n), by recurrence from f_0 and f_1 = f_0/x + `side`."""
    f = np.empty((max(orders, 2), x.size))
    f[0] = first
    f[1] = first / x + side
    for n in range(2, orders):
        f[n] = (2 * n - 1) / x * f[n - 1] - f[n - 2]
    return f[:orders]


def composite_gauss(edges: Array) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on consecutive panels, `NODES` on each."""
    x, w, _ = _exact_gauss(edges, NODES)
    return x, w


def _exact_gauss(edges: Array, nodes: int) -> tuple[Array, Array, Array]:
    """Nodes and weights on consecutive panels, and what rounding took from the nodes."""
    t, v = gauss(nodes)
    half = np.diff(edges)[:, None] / 2
    middle = (edges[1:] + edges[:-1])[:, None] / 2
    x = middle + half * t
    return x.ravel(), (half * v).ravel(), (half * t - (x - middle)).ravel()


def spherical_bessel(orders: int, x: Array, waves: Array | None = None) -> Array:
    """j_0 ... j_(orders-1) at x > 0, shape (orders, n); `waves` are cos x, sin x where these are known to more digits than x.

    Upward recurrence where the order is below x, ratios from a downward recurrence (Miller) above, each in its stable
    direction.
    """
    cos, sin = (np.cos(x), np.sin(x)) if waves is None else waves
    start = orders + 32 + int(4 * np.sqrt(orders))
    ratios = np.empty((orders, x.size))
    ratio = x / (2 * start + 1)
    for n in range(start - 1, 0, -1):
        denominator = (2 * n + 1) / x - ratio
        # a zero of j_(n-1) inside the oscillating range is harmless: there the upward recurrence is used
        ratio = 1.0 / np.where(denominator == 0, np.finfo(float).tiny, denominator)
        if n < orders:
            ratios[n] = ratio
    j = np.empty((orders, x.size))
    j[0] = sin / x
    if orders > 1:
        with np.errstate(under="ignore"):
            upward = np.where(x > 1, (j[0] - cos) / x, 0.0)
            j[1] = np.where(x > 1, upward, ratios[1] * j[0])
            for n in range(2, orders):
                j[n] = np.where(n <= x, (2 * n - 1) / x * j[n - 1] - j[n - 2], ratios[n] * j[n - 1])
    return j
