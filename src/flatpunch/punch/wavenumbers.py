"""Quadrature over wavenumbers and the spherical Bessel functions on it.

Everything is integrated over x = k a on panels that do not depend on the medium: geometric up to x = 4, uniform above
(the products j_p j_q oscillate with period pi). Only the kernel changes with the punch radius, so the table of Bessel
functions is computed once and one matrix product assembles each punch matrix (T3.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.numerics.gauss import gauss

NODES = 20
"""Gauss nodes per panel. On a panel (x, 4x) a pole at 0 leaves 3^-40; stiff films over sliding or soft layers have sharper
peaks in L and leave 1e-12 (16 nodes: 1.5e-10). On (x, x + 8) the product j_p j_q leaves 1e-15."""

_FIRST_UNIFORM = 4.0
_FINE_UNTIL = 64.0


@dataclass(frozen=True, slots=True)
class BesselTable:
    """Nodes x, weights w, shapes (n,), and j_p(x) for p = parity, parity + 2, ...; shape (terms, n)."""

    x: Array
    w: Array
    j: Array


def panel_edges(first: int, x_high: float) -> Array:
    """Edges 0, 4^first, ..., 1, 4, 8, ..., 64, 72, ... up to the first one at or above x_high."""
    geometric = 4.0 ** np.arange(first, 2)
    fine = np.arange(_FIRST_UNIFORM + 4, _FINE_UNTIL + 1, 4.0)
    coarse = np.arange(_FINE_UNTIL + 8, x_high + 8, 8.0)
    edges = np.concatenate([[0.0], geometric, fine, coarse])
    stop = int(np.searchsorted(edges, x_high)) + 1
    return edges[: max(stop, 2)]


@lru_cache(maxsize=64)
def bessel_table(parity: int, terms: int, first: int, x_high: float) -> BesselTable:
    """Quadrature on (0, x_high) with the spherical Bessel functions of one parity.

    Parameters
    ----------
    parity : int
        0 for even orders, 1 for odd ones.
    terms : int
        Number of orders.
    first : int
        The lowest geometric panel starts at 4^first; below it lies one panel (0, 4^first).
    x_high : float
        Upper end of the integral; rounded up to a panel edge.
    """
    x, w = composite_gauss(panel_edges(first, x_high))
    return BesselTable(x, w, spherical_bessel(parity + 2 * terms, x)[parity::2][:terms].copy())


def composite_gauss(edges: Array) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on consecutive panels."""
    t, v = gauss(NODES)
    half = np.diff(edges)[:, None] / 2
    middle = (edges[1:] + edges[:-1])[:, None] / 2
    return (middle + half * t).ravel(), (half * v).ravel()


def spherical_bessel(orders: int, x: Array) -> Array:
    """j_0 ... j_(orders-1) at x > 0, shape (orders, n).

    Upward recurrence where the order is below x, ratios from a downward recurrence (Miller) above, each in its stable
    direction.
    """
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
    j[0] = np.sinc(x / np.pi)
    if orders > 1:
        with np.errstate(under="ignore"):
            upward = np.where(x > 1, (j[0] - np.cos(x)) / x, 0.0)
            j[1] = np.where(x > 1, upward, ratios[1] * j[0])
            for n in range(2, orders):
                j[n] = np.where(n <= x, (2 * n - 1) / x * j[n - 1] - j[n - 2], ratios[n] * j[n - 1])
    return j
