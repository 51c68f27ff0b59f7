"""One asperity alone, and what one does to another.

Force, radius and moments of the pressures of an asperity are tabulated once over its depth. The Green's function G(r) is
tabulated over ln r once, with its Laplacians up to the third, so that a pair takes the time of one cubic.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator, make_interp_spline
from scipy.special import gamma

from flatpunch._support.checks import AT_ONCE, Array, Indices
from flatpunch.bem.operator.influence import power_exponent
from flatpunch.bem.operator.radial import STEP, remainder_table
from flatpunch.compliances import Kernel
from flatpunch.contact.indentation import indent
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.punch import flat_punch

_DECADES, _POINTS = 6, 181
"""Depths of the curve of one asperity, downwards from the largest, and their number: cubics between them are exact to 1e-7."""

_RADII = 24
"""Radii at which flat punches are solved for their moments, which vary slowly."""


@dataclass(frozen=True, slots=True)
class Law:
    """One asperity alone: logarithms of force and radius over that of depth, and shape factors.

    These are mean r^2 and r^4 of punch and contact over a^2 and a^4, and the radius of curvature over a^2.

    Below the smallest depth they are powers; above the largest nothing is known.
    """

    force: CubicSpline
    radius: CubicSpline
    moments: PchipInterpolator
    first: float
    last: float

    @classmethod
    def of(cls, medium: Body, tip: Indenter, name: str, largest: float, beyond: float) -> Law:
        """The law of a tip up to `beyond` times a depth [m] or that of a force [N]."""
        if largest == 0:
            name, largest = "depth", 1e-9
        deepest = largest if name == "depth" else float(indent(medium, tip, force=largest)["depth"][0])
        depth = beyond * deepest * np.geomspace(10.0**-_DECADES, 1.0, _POINTS)
        curve = indent(medium, tip, depth=depth)
        x, a, force = np.log(depth), curve["radius"].values, curve["force"].values
        phi = np.linspace(0, 2 * np.pi, 36, endpoint=False)
        slope = np.mean(np.broadcast_to(tip.slope(a[:, None], phi), (a.size, phi.size)), axis=1)
        if not ((slope > 0).all() and (np.diff(a) > 0).all()):
            raise ValueError(
                f"tips contains {type(tip).__name__}, which has a flat end: asperities take tips that are curved or pointed at "
                "their apex. rough_contact takes flat tops."
            )
        radii = np.geomspace(a[0], a[-1], _RADII)
        punches = [flat_punch(medium, float(radius)) for radius in radii]
        own = [[punch.moment(k) / ((k + 1) * punch.normalized_stiffness) for punch in punches] for k in (2, 4)]
        punch = PchipInterpolator(np.log(radii), np.transpose(own))(np.log(a))
        # F m = int K s dd, K dd = dF; powers below the first depth
        powers = np.gradient(np.log(force), x)[0] / np.gradient(np.log(a), x)[0]
        contact = []
        for k, shape in zip((2, 4), punch.T, strict=True):
            grown = shape * a**k
            steps = (grown[1:] + grown[:-1]) / 2 * np.diff(force)
            total = np.cumsum(np.append(grown[0] * force[0] * powers / (powers + k), steps))
            contact.append(total / (force * a**k))
        moments = PchipInterpolator(x, np.column_stack([punch, *contact, 1 / (slope * a)]))
        return cls(CubicSpline(x, np.log(force)), CubicSpline(x, np.log(a)), moments, float(x[0]), float(x[-1]))

    def __call__(self, depth: Array) -> tuple[Array, ...]:
        """Force [N], stiffness [N/m], radius [m], d ln a/dd [1/m] and moments, shape (n, 5), at depths > 0 [m]."""
        x = np.log(depth)
        inside = np.clip(x, self.first, self.last)
        slope, growth = self.force(inside, 1), self.radius(inside, 1)
        force = np.exp(self.force(inside) + slope * (x - inside))
        radius = np.exp(self.radius(inside) + growth * (x - inside))
        return force, force * slope / depth, radius, growth / depth, np.asarray(self.moments(inside))


_POWERS = np.array([1, 3, 5, 7, 2])
"""Powers of r with which G, its three Laplacians and dG/dr fall on a half-space."""

_STEPS = 256
"""Points of the table in a factor e of distance: cubics between them are exact to 1e-11."""


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
        count = max(AT_ONCE // len(places), 1)
        for first in range(0, len(places), count):
            rows = slice(first, first + count)
            away = places[rows, None] - places
            r = np.hypot(away[..., 0], away[..., 1])
            own = r == 0
            r[own] = np.exp(self.table.x[0])
            found = np.moveaxis(self.table(np.log(r)), -1, 0) / r ** _POWERS[:, None, None]
            found[:, own] = 0.0
            yield rows, away, r, found


def _table(kernel: Kernel, nearest: float, farthest: float) -> CubicSpline:
    """G, its first three Laplacians and dG/dr over ln r, times the powers of r with which they fall."""
    t = np.arange(np.log(nearest) - 4 / _STEPS, np.log(farthest) + 4 / _STEPS, 1 / _STEPS)
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
        table = remainder_table(kernel, nearest / 2, 2 * farthest)
        spline = make_interp_spline(table.first + np.arange(table.values.size) * STEP, table.values, k=9)
        d = [spline(t, order) for order in range(7)]
        laps = d[2], d[4] - 4 * d[3] + 4 * d[2], d[6] - 12 * d[5] + 52 * d[4] - 96 * d[3] + 64 * d[2]
        columns += r[:, None] * np.column_stack([d[0], *laps, d[1]])
    return CubicSpline(t, columns / (np.pi * kernel.modulus))
