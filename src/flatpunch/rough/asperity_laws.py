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

from flatpunch._support.checks import Array
from flatpunch.bem.operator.radial import STEP, remainder_table
from flatpunch.compliances import Kernel
from flatpunch.contact.indentation import indent
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.punch import solved_punch

_DECADES, _POINTS = 6, 181
"""Depths of the curve of one asperity, downwards from the largest, and their number: cubics between them are exact to 1e-7."""

_BEYOND = 3e-4
"""Share of its largest depth by which a law is taken beyond it: powers are exact to 1e-7 there."""

_RADII = 24
"""Radii at which flat punches are solved for their moments, which vary slowly."""


@dataclass(frozen=True, slots=True)
class Law:
    """One asperity alone: logarithms of force and radius over that of depth, and shape factors.

    These are mean r^2 and r^4 of punch and contact over a^2 and a^4, and the radius of curvature over a^2.

    Outside the range of depths they are powers: exact below it, and above it until the law is tabulated farther.
    """

    medium: Body
    tip: Indenter
    force: CubicSpline
    radius: CubicSpline
    moments: PchipInterpolator
    first: float
    last: float

    @classmethod
    def of(cls, medium: Body, tip: Indenter, deepest: float) -> Law:
        """The law of a tip up to a depth [m]."""
        depth = deepest * np.geomspace(10.0**-_DECADES, 1.0, _POINTS)
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
        punches = [solved_punch(medium, float(radius)) for radius in radii]
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
        splines = CubicSpline(x, np.log(force)), CubicSpline(x, np.log(a)), moments
        return cls(medium, tip, *splines, float(x[0]), float(x[-1]))

    def reaching(self, depth: float) -> Law:
        """Itself, or the law tabulated up to a depth [m] beyond its range."""
        return Law.of(self.medium, self.tip, depth) if depth > (1 + _BEYOND) * np.exp(self.last) else self

    def __call__(self, depth: Array) -> tuple[Array, ...]:
        """Force [N], stiffness [N/m], radius [m], d ln a/dd [1/m] and moments, shape (n, 5), at depths > 0 [m]."""
        x = np.log(depth)
        inside = np.clip(x, self.first, self.last)
        slope, growth = self.force(inside, 1), self.radius(inside, 1)
        force = np.exp(self.force(inside) + slope * (x - inside))
        radius = np.exp(self.radius(inside) + growth * (x - inside))
        return force, force * slope / depth, radius, growth / depth, np.asarray(self.moments(inside))


_STEPS = 256
"""Points of the table in a factor e of distance: cubics between them are exact to 1e-11."""

_BLOCK = 100_000
"""Numbers of a part of a matrix: twenty times as many take twice the time, a fifth as well as many."""


@dataclass(frozen=True, slots=True)
class Interactions:
    """Matrices (n, n) of G [m/N], its three Laplacians and its slope over distance, zero on the diagonal; places (n, 2) [m]."""

    places: Array
    g: Array
    lap: Array
    twice: Array
    thrice: Array
    pull: Array

    @classmethod
    def of(cls, kernel: Kernel, places: Array, nearest: float) -> Interactions:
        """Interactions in a body of asperities at places [m], the nearest two so far apart."""
        n = len(places)
        places = places - places.mean(axis=0)
        made = cls(places, *(np.zeros((n, n)) for _ in range(5)))
        if n == 1:
            return made
        table = _table(kernel, nearest, float(np.hypot(*np.ptp(places, axis=0))))
        for rows in blocks(n):
            left = slice(rows.start, None)
            r = np.hypot(*np.moveaxis(places[rows, None] - places[left], -1, 0))
            own = r == 0
            r[own] = nearest
            g, lap, twice, thrice, pull = np.moveaxis(table(np.log(r)), -1, 0)
            inverse = np.where(own, 0.0, 1 / r)
            square = inverse**2
            cube = inverse * square
            parts = (g * inverse, lap * cube, twice * cube * square, thrice * cube * square**2, pull * cube)
            for whole, part in zip((made.g, made.lap, made.twice, made.thrice, made.pull), parts, strict=True):
                whole[rows, left] = part
                whole[left, rows] = part.T
        return made

    def gradients(self, force: Array) -> Array:
        """Gradient of the displacement of point forces along x and y at every place, shape (2, n)."""
        x = self.places.T
        return np.asarray(x * (self.pull @ force) - np.array([self.pull @ (each * force) for each in x]))

    def couples(self, moved: Array) -> Array:
        """Displacement by point forces that move, which are given times the ways along x and y, shape (2, n), downwards."""
        x = self.places.T
        return np.asarray(
            sum(each * (self.pull @ by) for each, by in zip(x, moved, strict=True))
            - self.pull @ (x * moved).sum(axis=0)
        )


def blocks(n: int) -> Iterator[slice]:
    """Rows of a matrix (n, n), as many at once as the cache takes."""
    count = max(_BLOCK // n, 1)
    return (slice(first, first + count) for first in range(0, n, count))


def _table(kernel: Kernel, nearest: float, farthest: float) -> CubicSpline:
    """G, its first three Laplacians and dG/dr over ln r, times the powers r, r^3, r^5, r^7 and r^2 with which they fall."""
    t = np.arange(np.log(nearest) - 4 / _STEPS, np.log(farthest) + 4 / _STEPS, 1 / _STEPS)
    r = np.exp(t)
    exponent = kernel.exponent
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
