"""Round profiles f(r) and their moments in the flat-punch basis."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flatpunch._support.checks import AT_ONCE, ROUNDING, Array, Indices
from flatpunch.numerics.gauss import gauss
from flatpunch.punch.basis import node_count, power_edge, power_moments, projection, quarter_nodes, regular_part

TINY = float(np.finfo(float).tiny)
"""Takes the place of zeros in denominators whose numerators vanish as well."""

NODES = 256
"""Quadrature points of tables of heights, 1e-8 of a hundred heights, and of profiles on power-law half-spaces, 1e-13 of smooth
ones; a quarter of them leaves 1e-9 there."""

_AT_RIM = 1 - ROUNDING
"""Radius of a ring over that of a disc above which the ring is its rim: in between, rounding would count."""


class RoundProfile(Hashable, Protocol):
    """A profile f(r) that turns itself into moments and edge functionals on discs of given radii."""

    def height(self, r: Array) -> Array:
        """Gap f(r) [m] at r [m], any shape."""

    def slope(self, r: Array) -> Array:
        """Derivative df/dr [-]."""

    def moments(self, radius: Array, terms: int) -> Moments:
        """Moments on discs of `radius`, shape (n,)."""


@dataclass(frozen=True, slots=True)
class Moments:
    """Profile on discs of n radii: b_l[f], shape (n, terms), [m]; S0[f] and S0[r f'], shape (n,), [m]."""

    b: Array
    edge: Array
    edge_slope: Array


@dataclass(frozen=True, slots=True)
class PowerProfile:
    """f = factor r^exponent: closed moments.

    Parameters
    ----------
    exponent : float
        n > 0.
    factor : float
        [m^(1-n)].
    """

    exponent: float
    factor: float

    def height(self, r: Array) -> Array:
        """f(r) [m]."""
        return np.asarray(self.factor * r**self.exponent)

    def slope(self, r: Array) -> Array:
        """df/dr [-]."""
        return np.asarray(self.exponent * self.factor * r ** (self.exponent - 1))

    def moments(self, radius: Array, terms: int) -> Moments:
        """Closed forms: b_l by the Beta function, S0 = 1/B((n + 1)/2, 1/2)."""
        height = self.factor * radius**self.exponent
        edge = height * power_edge(self.exponent, 0)
        return Moments(height[:, None] * power_moments(self.exponent, 0, terms), edge, self.exponent * edge)


@dataclass(frozen=True, slots=True)
class SampledProfile:
    """Any f(r), by Gauss quadrature in theta with r = a cos(theta), cut at the radii where the slope or the curvature jumps.

    Parameters
    ----------
    height, slope : callable
        r [m], any shape -> f [m] and df/dr [-].
    rings : tuple of float
        Radii at which the slope or the curvature jumps [m].
    nodes : int
        Least number of quadrature points between two rings. Profiles that are not smooth there need a fixed, larger one:
        256 leave 1e-8 of tables of a hundred points, and the result does not depend on how many terms the medium needs.
    beside : int
        Quadrature points for what f does beside a ring, whatever the distance to the next: three leave 1e-11 of tables.
    """

    height: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    rings: tuple[float, ...] = ()
    nodes: int = 0
    beside: int = 5

    def moments(self, radius: Array, terms: int) -> Moments:
        """Quadrature: exact to rounding for profiles smooth between the rings."""
        nodes = max(node_count(terms), self.nodes)
        at_once = max(1, AT_ONCE // (terms * int(self._counts(radius, nodes).sum())))
        if radius.size > at_once:
            parts = [self.moments(radius[i : i + at_once], terms) for i in range(0, radius.size, at_once)]
            columns = ((part.b, part.edge, part.edge_slope) for part in parts)
            return Moments(*(np.concatenate(column) for column in zip(*columns, strict=True)))
        rho, weight = self.disc_rule(radius, nodes)
        r = radius[:, None] * rho
        f, g = self.height(r), r * self.slope(r)
        g_edge = radius * self.slope(radius)
        counts = self._counts(radius, nodes)
        if counts.size == 1:
            b = f @ projection(0, terms, nodes)[1].T
        else:
            b = np.einsum("lnj,nj->nl", regular_part(0, terms, rho), rho * weight * f)
        edge = np.sum(rho * weight * (f + g), axis=1) / np.pi
        # S0[r f'] = (g(1) - int (g(r) - g(1)) r (1 - r^2)^-3/2 dr)/pi, by parts so that f'' need not exist
        level, tilt, closed = self.lines(radius, g_edge, counts.size)
        left = (g - np.repeat(level, counts, axis=1)) / np.maximum(1 - rho**2, TINY) - np.repeat(tilt, counts, axis=1)
        return Moments(b, edge, (g_edge - np.sum(rho * weight * left, axis=1) - closed) / np.pi)

    def lines(self, radius: Array, g_edge: Array, panels: int, alpha: float = -0.5) -> tuple[Array, Array, Array]:
        """Lines in y = 1 - r^2 to subtract from g = r f' on each panel, and their integral in closed form, shape (n,).

        On the last panel it is the constant g(1). Inside a ring that is close to the edge, y^(alpha-1) is too steep for the
        quadrature: there it is the tangent of g at the ring, so that the steep part is integrated in closed form,
        -2 alpha int (A + B y) r y^(alpha-1) dr = A y^alpha + alpha/(1 + alpha) B y^(1+alpha).

        Returns
        -------
        level, tilt : ndarray, shape (n, panels)
            A and B [m].
        closed : ndarray, shape (n,)
            What is to be subtracted from g(1) for them [m].
        """
        last = g_edge[:, None]
        if panels == 1:
            return last, 0 * last, 0 * g_edge
        rings = np.array(sorted(self.rings))
        inside = radius[:, None] * _AT_RIM > rings
        safe = np.where(inside, radius[:, None], 2 * rings)
        # y at the end of each panel, and at its start
        y = (safe - rings) / safe * (1 + rings / safe)
        before = np.hstack([np.ones_like(y[:, :1]), y[:, :-1]])
        g, growth = self._tangents(rings)
        tilt = np.where(inside, -growth * radius[:, None] ** 2 / (2 * rings), 0.0)
        level = np.where(inside, g - tilt * y, last)
        part = (level - last) * (y**alpha - before**alpha)
        part += alpha / (1 + alpha) * tilt * (y ** (1 + alpha) - before ** (1 + alpha))
        return np.hstack([level, last]), np.hstack([tilt, 0 * last]), np.where(inside, part, 0.0).sum(axis=1)

    def _tangents(self, rings: Array) -> tuple[Array, Array]:
        """g = r f' [m] and dg/dr [-] just inside the rings, shape (rings,)."""
        # a share of the distance to the ring before: rounding leaves 1e-11 of the derivative, the difference 1e-8
        step = 1e-4 * np.maximum(np.diff(rings, prepend=0.0), ROUNDING * rings)
        r = rings * (1 - 4 * np.finfo(float).eps) - np.arange(3)[:, None] * step
        g = r * self.slope(r)
        return g[0], (3 * g[0] - 4 * g[1] + g[2]) / (2 * step)

    def disc_rule(self, radius: Array, nodes: int) -> tuple[Array, Array]:
        """Nodes rho = cos(theta) of unit discs and weights in theta, shape (1, nodes) or, cut at rings, (n, cuts * nodes)."""
        if not any(ring < radius.max() for ring in self.rings):
            rho, weight = quarter_nodes(nodes)
            return rho[None, :], weight[None, :]
        ends, counts = self.ends(radius), self._counts(radius, nodes)
        t, v = (np.concatenate(each) for each in zip(*(gauss(int(count)) for count in counts), strict=True))
        middle, half = (ends[:, :-1] + ends[:, 1:]) / 2, (ends[:, :-1] - ends[:, 1:]) / 2
        panel = np.repeat(np.arange(counts.size), counts)
        return np.cos(middle[:, panel] + half[:, panel] * t), half[:, panel] * v

    def ends(self, radius: Array) -> Array:
        """theta at the axis, at the rings and at the rim of discs, shape (n, cuts + 1), from pi/2 down to 0."""
        rings = np.array([0.0, *sorted(self.rings)])
        share = rings / np.where(radius > 0, radius, 1)[:, None]
        upper = np.arccos(np.where(share < _AT_RIM, share, 1.0))
        return np.concatenate([upper, np.zeros((radius.size, 1))], axis=1)

    def _counts(self, radius: Array, nodes: int) -> Indices:
        """Quadrature points between the cuts, shape (cuts,): `nodes` for a whole disc, fewer for parts of every disc."""
        if not any(ring < radius.max() for ring in self.rings):
            return np.array([nodes])
        widest = -np.diff(self.ends(radius), axis=1).min(axis=0)
        share = np.ceil(nodes * widest / (np.pi / 2)).astype(int) + self.beside
        return np.asarray(np.minimum(nodes, share))
