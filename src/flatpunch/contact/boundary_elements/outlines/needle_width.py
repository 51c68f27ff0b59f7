"""Half-width of a needle beside an edge, from the load that it carries.

Across, an edge is pressed into a half-plane like any even profile g(|y|). With H(b) the integral of g(b sin t) over t from 0
to pi/2, a contact of half-width b carries the load per length q = E* G(b), G = b H'(b), whatever lies far away: E* m b for a
wedge of slope m. What is near bends the surface a little. A curvature k of the gap adds E* k pi/4 b^2 to the load and
E* k pi/16 b^4 to the second moment M of the pressure, so that the two tell b without k: with b_0 from q = E* G(b_0), M_0 the
moment that belongs to it and n = dln G/dln b,

    b = b_0 (1 + 4 (M - M_0)/(n q b_0^2)).

It is known to a fraction of a cell, where counting cells is off by half of one along hundreds that are equally wide. A few
cells have another moment than the pressure that they stand for; which one, wedges on such cells tell.

Along the edge the profile may change: tips that are cut off are flat up to the corner of their flat, and wedges from there on.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.bem.height import IndenterHeight
from flatpunch.compliance import Kernel
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.gauss import gauss

_THIN = 0.25
"""Half-widths over the depth of the surface's modulus up to which that is a half-plane's, but for a curvature."""
_WIDTHS = np.geomspace(1e-3, 1e2, 51)
"""Half-widths at which the load is known, in cells."""
_STEP = 0.02
"""Step of ln b over which H is differentiated."""
_NODES, _WEIGHTS = gauss(8)
_MOST = 48
"""Cells of a half-width up to which their moment differs from the pressure's (there by 3e-4)."""
_LEAST, _LARGEST = 0.5, 2.0
"""What curvature may make of a half-width."""
_NEXT = 1.15
"""Ratio of neighbouring places along the edge at which its profile is taken where that changes."""


@dataclass(frozen=True, slots=True)
class Across:
    """Profile across an edge.

    Attributes
    ----------
    modulus : float
        E* at the surface [Pa].
    spacing : float
        Cells across [m].
    places : ndarray, shape (n,)
        Places along the edge [m] between which the profile changes evenly.
    loads : ndarray, shape (n, widths)
        ln G there, G in cells, at half-widths of 0.001 to 100 cells.
    widest : float
        Half-width up to which the surface is a half-plane's [m].
    """

    modulus: float
    spacing: float
    places: Array
    loads: Array
    widest: float

    def half_widths(self, along: Array, load: Array, moment: Array) -> tuple[Array, Array]:
        """Half-widths without curvature and with it [m], shape (n,) each; NaN on a flat and where they exceed the table.

        Parameters
        ----------
        along : ndarray, shape (n,)
            Places along the edge [m].
        load, moment : ndarray, shape (n,)
            Sum of the pressure [Pa] over the cells of one side, and of their pressure times the square of their distance from
            the edge [Pa m^2].
        """
        some = load > 0
        q, second = 2 * load[some] / self.modulus, 2 * moment[some] / (self.modulus * self.spacing**2)
        gap = np.clip(np.searchsorted(self.places, along[some]) - 1, 0, self.places.size - 2)
        share = (along[some] - self.places[gap]) / np.diff(self.places)[gap]
        ln_q, ln_b = np.log(q), np.log(_WIDTHS)
        # ln b, n and M_0/(q b^2), by those at the places on either side
        sought = np.zeros((3, q.size))
        for place, ln_g in enumerate(self.loads):
            tables = ln_b, np.gradient(ln_g, ln_b), _moments(ln_g)
            for beside, weight in ((gap == place, 1 - share), (gap == place - 1, share)):
                if beside.any():
                    found = [np.interp(ln_q[beside], ln_g, table, right=np.nan) for table in tables]
                    sought[:, beside] += weight[beside] * found
        width, power, straight = np.exp(sought[0]), sought[1], sought[2]
        bent = 1 + 4 * (second * _whole(width) / (q * width**2) - straight) / power
        half_widths = np.zeros((2, load.size))
        half_widths[:, some] = self.spacing * width * np.array([np.ones_like(bent), np.clip(bent, _LEAST, _LARGEST)])
        return half_widths[0], half_widths[1]


def across(kernel: Kernel, indenter: Indenter, angle: float, ends: Array, spacing: float) -> Across:
    """Profile across an edge at a polar angle [rad] between two places along it [m], of a medium whose surface has a modulus."""
    height, angle = IndenterHeight(indenter), np.mod(angle, 2 * np.pi)
    # beside the edges of pyramids it is a wedge, the same everywhere
    count = 2 if indenter.exponent == 1 else 2 + int(np.log(ends[1] / ends[0]) / np.log(_NEXT))
    places = np.geomspace(ends[0], ends[1], count)
    steps = np.exp([[-_STEP], [_STEP]]) * _WIDTHS
    beside, along = spacing * steps[..., None] * np.sin(np.pi / 4 * (1 + _NODES)), places[:, None, None, None]
    gap = height.at(np.hypot(along, beside), np.mod(angle + np.arctan2(beside, along), 2 * np.pi))
    gap -= height.at(places, np.full(count, angle))[:, None, None, None]
    load = np.diff(gap @ _WEIGHTS, axis=1)[:, 0] * np.pi / 4 / (2 * _STEP * spacing)
    # far beside the edge there are others
    loads = np.log(np.maximum.accumulate(np.maximum(load, np.finfo(float).tiny), axis=1))
    return Across(kernel.modulus, spacing, places, loads, _THIN * kernel.surface_length)


def _moments(ln_g: Array) -> Array:
    """M/(q b^2) at all half-widths: flat punches of half-width c, of which b consists, have the moment c^2/2 of their load."""
    ln_b = np.log(_WIDTHS)
    power = np.diff(ln_g) / np.diff(ln_b)
    # between half-widths the load goes as a power of them
    grown = np.diff(np.exp(ln_g + 2 * ln_b)) * power / (power + 2) / 2
    first = np.exp(ln_g[0] + 2 * ln_b[0]) * power[0] / (power[0] + 2) / 2
    return np.asarray((first + np.concatenate([[0.0], np.cumsum(grown)])) / np.exp(ln_g + 2 * ln_b))


def _whole(width: Array) -> Array:
    """Second moment of a wedge's pressure over that of its cells, at half-widths in cells."""
    widths, moments = _wedges_on_cells()
    return np.where(width < widths[-1], width**3 / 6 / np.interp(width, widths, moments), 1.0)


@cache
def _wedges_on_cells() -> tuple[Array, Array]:
    """Half-width and moment of wedges that just reach another cell on either side, in cells; between, the moment is linear."""
    y = np.arange(_MOST + 1) + 0.5

    def logarithm(distance: Array) -> Array:
        """Integral of ln|distance - eta| over a cell."""
        ends = distance + 0.5, distance - 0.5
        upper, lower = (end * np.log(np.maximum(np.abs(end), np.finfo(float).tiny)) for end in ends)
        return np.asarray(upper - lower - 1)

    sinking = -2 / np.pi * (logarithm(y[:, None] - y) + logarithm(y[:, None] + y))
    found = [(0.0, 0.0)]
    for cells in range(1, _MOST + 1):
        # as many pressures and the depth, from the centres of these cells and of the next
        system = np.column_stack([sinking[: cells + 1, :cells], -np.ones(cells + 1)])
        pressure = np.linalg.solve(system, -y[: cells + 1])[:-1]
        found.append((2 * pressure.sum(), 2 * pressure @ y[:cells] ** 2))
    widths, moments = np.array(found).T
    return widths, moments
