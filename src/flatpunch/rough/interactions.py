"""What asperities do to each other: the surface's Green's function G(r) and its derivatives, as matrices over pairs.

G is tabulated over ln r once, with its Laplacians up to the third, so that a pair takes the time of one cubic.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline
from scipy.special import gamma

from flatpunch._support.checks import Array, Indices
from flatpunch.bem.operator.influence import power_exponent
from flatpunch.bem.operator.radial import remainder_table
from flatpunch.compliances import Kernel

_POWERS = np.array([1, 3, 5, 7, 2])
"""Powers of r with which G, its three Laplacians and dG/dr fall on a half-space."""

_STEPS = 256
"""Points of the table in a factor e of distance: cubics between them are exact to 1e-11."""

_BLOCK = 256
"""Rows of a matrix that are made at once."""


@dataclass(frozen=True, slots=True)
class Interactions:
    """Matrices (n, n) of G [m/N], its Laplacian, that of the latter, and its gradient along x and y; zero on the diagonal."""

    places: Array
    table: CubicSpline | None
    g: Array
    lap: Array
    twice: Array
    slopes: tuple[Array, Array]

    @classmethod
    def of(cls, kernel: Kernel, places: Array, nearest: float) -> Interactions:
        """Interactions in a body of asperities at places [m], the nearest two so far apart."""
        n = len(places)
        g, lap, twice, along_x, along_y = (np.zeros((n, n)) for _ in range(5))
        farthest = float(np.hypot(*np.ptp(places, axis=0)))
        made = cls(places, _table(kernel, nearest, farthest) if n > 1 else None, g, lap, twice, (along_x, along_y))
        if n > 1:
            for rows, away, r, found in made.blocks(np.arange(n)):
                g[rows], lap[rows], twice[rows] = found[:3]
                along_x[rows], along_y[rows] = (found[4] * away[..., i] / r for i in (0, 1))
        return made

    def blocks(self, chosen: Indices) -> Iterator[tuple[slice, Array, Array, Array]]:
        """Rows among those chosen, with vectors and distances to all chosen, and the five functions, zero on the diagonal."""
        assert self.table is not None
        places = self.places[chosen]
        for first in range(0, len(places), _BLOCK):
            rows = slice(first, first + _BLOCK)
            away = places[rows, None] - places
            r = np.hypot(away[..., 0], away[..., 1])
            own = r == 0
            r[own] = np.exp(self.table.x[0])
            found = np.moveaxis(self.table(np.log(r)), -1, 0) / r ** _POWERS[:, None, None]
            found[:, own] = 0.0
            yield rows, away, r, found


def _table(kernel: Kernel, nearest: float, farthest: float) -> CubicSpline:
    """G, its first three Laplacians and dG/dr over ln r, times the powers of r with which they fall."""
    t = np.arange(np.log(0.99 * nearest), np.log(1.01 * farthest) + 4 / _STEPS, 1 / _STEPS)
    r = np.exp(t)
    exponent = power_exponent(kernel)
    if exponent:
        scale = (
            float(kernel(1.0)[0]) / (2 * np.pi) * 2**exponent * gamma((1 + exponent) / 2) / gamma((1 - exponent) / 2)
        )
        factors = [1.0, *np.cumprod([(power + exponent) ** 2 for power in (1, 3, 5)]), -1 - exponent]
        return CubicSpline(t, scale * np.outer(r**-exponent, factors))
    columns = np.outer(np.ones(r.size), [1.0, 1.0, 9.0, 225.0, -1.0])
    if not kernel.homogeneous:
        table = remainder_table(kernel, 0.9 * nearest, 1.1 * farthest)
        spline = make_interp_spline(table.first + np.arange(table.values.size) / 64, table.values, k=9)
        d = [spline(t, order) for order in range(7)]
        laps = d[2], d[4] - 4 * d[3] + 4 * d[2], d[6] - 12 * d[5] + 52 * d[4] - 96 * d[3] + 64 * d[2]
        columns += r[:, None] * np.column_stack([d[0], *laps, d[1]])
    return CubicSpline(t, columns / (np.pi * kernel.modulus))
