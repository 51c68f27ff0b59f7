"""Integrals of a non-round indenter over the polar angle, tabulated: many radii are needed, and each takes hundreds of angles.

Panels, three to a decade and cut at the rings and scales of the shape, carry polynomials in s with
r = r_0 + (r_1 - r_0) sin^2(pi s/2). In s such integrals are smooth even where they begin or end like the root of the distance
from a ring, as they do at the corners and sides of a square flat.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import partial

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.ceilings import AT_ONCE
from flatpunch._support.checks import Array
from flatpunch.indenters._common import FULL_TURN, SAME
from flatpunch.indenters.geometry.angle_rule import angular_rule, panel_rule
from flatpunch.indenters.geometry.symmetry import rotational_symmetry
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.piecewise import PiecewiseChebyshev, Sine

ORDER = 32
"""Highest harmonic for which means are integrated at rounding; half as many are not enough for rounded pyramids."""


class AngularRule:
    """Angles and weights for means over one period of a shape, at each radius.

    Where circles cross kinks of the shape (`crossings`) panels of Gauss points end there.

    Parameters
    ----------
    indenter : Indenter
        The tip.
    order : int
        Highest harmonic for which integrals are at rounding where the shape is smooth.
    """

    def __init__(self, indenter: Indenter, order: int = ORDER) -> None:
        self._order = order
        self._crossings = indenter.crossings
        breaks = indenter.split_angles
        self.start, self.period = breaks[0] if breaks else 0.0, FULL_TURN / rotational_symmetry(indenter)
        self._breaks = self._within(np.array(breaks))
        self._fixed = self._one_period(*angular_rule(indenter, order))

    def at(self, r: Array) -> tuple[Array, Array]:
        """Angles [rad] and weights at radii r, shape (n,); (n, angles), or (1, angles) where all radii have the same."""
        crossed = self._crossings(r) if self._crossings is not None else np.empty((r.size, 0))
        if not np.isfinite(crossed).any():
            phi, weights = self._fixed
            return phi[None, :], weights[None, :]
        kinks = np.sort(self._within(np.where(np.isfinite(crossed), crossed, self.start)), axis=1)
        # those of the other periods are the same once more
        kinks = np.column_stack([kinks, np.broadcast_to(self._breaks, (r.size, self._breaks.size))])
        edges = np.sort(np.column_stack([np.zeros(r.size), kinks, np.full(r.size, self.period)]), axis=1)
        phi, weights = panel_rule(edges, self._order)
        return self.start + phi, weights / self.period

    def _within(self, phi: Array) -> Array:
        """Angles from the start of the period; those of other periods lie at its end."""
        turned = np.mod(phi - self.start, FULL_TURN)
        return np.asarray(np.minimum(turned, self.period))

    def _one_period(self, phi: Array, weights: Array) -> tuple[Array, Array]:
        """Of a rule for the whole turn that of one period, or the whole rule if it has no periods."""
        first = np.mod(phi - self.start, FULL_TURN) < self.period * (1 - SAME)
        total = float(weights[first].sum())
        if abs(total * FULL_TURN / self.period - 1) > SAME:
            return phi, weights
        return phi[first], weights[first] / total


class AngularTable(ABC):
    """Functions of the radius that are integrals over the polar angle.

    Parameters
    ----------
    indenter : Indenter
        The tip; meant for shapes that are neither round nor power laws.
    order : int
        Highest harmonic for which these integrals are at rounding where the shape is smooth.
    """

    extra_nodes = 0
    """Nodes of all panels between the smallest and the largest ring besides the usual ones."""

    def __init__(self, indenter: Indenter, order: int = ORDER) -> None:
        self._indenter, self._rule = indenter, AngularRule(indenter, order)
        self._cuts = sorted({*indenter.rings, *indenter.scales})
        self._table = PiecewiseChebyshev(
            lambda r: self._sample(np.minimum(r, indenter.reach)), self._edges, self._nodes, Sine
        )

    @abstractmethod
    def integrals(self, f: Array, slope: Array, phi: Array, weights: Array) -> Array:
        """Columns, shape (n, columns), from heights and slopes at angles with weights, shapes (n, angles) or (1, angles)."""

    def at(self, r: Array) -> Array:
        """Columns at radii r [m] of any shape: (..., columns)."""
        r = np.asarray(r, dtype=float)
        flat = r.ravel()
        outside = (flat <= 0) | (flat > self._indenter.reach)
        parts = []
        # radii in a panel for which it is not made; more are sampled directly at the cost of the panel
        for chosen, read in ((outside, self._sample), (~outside, partial(self._table.at, few=4))):
            if chosen.any():
                parts.append((chosen, read(flat[chosen])))
        result = np.empty((flat.size, parts[0][1].shape[1] if parts else 0))
        for chosen, values in parts:
            result[chosen] = values
        return result.reshape(*r.shape, result.shape[1])

    def _edges(self, r: Array) -> Array:
        """Edges of the panels that hold radii r."""
        # with half as many panels, means of rounded tips lose three digits
        per_decade = 3
        first = int(np.floor(per_decade * np.log10(r.min()) - 1e-9))
        last = int(np.ceil(per_decade * np.log10(r.max()) + 1e-9))
        even = 10 ** (np.arange(first, last + 1) / per_decade)
        reach = self._indenter.reach
        cuts = [cut for cut in self._cuts if even[0] < cut < min(reach, even[-1])]
        edges = np.unique(np.concatenate([even[even < reach], cuts, [min(reach, even[-1])]]))
        # a radius at the reach itself belongs to the last panel
        return np.append(edges[:-1], np.nextafter(reach, np.inf)) if edges[-1] == reach else edges

    def _nodes(self, low: float, high: float) -> int:
        """Nodes of a panel."""
        rings = self._indenter.rings
        between = rings and rings[0] <= low < rings[-1]
        # half as many leave 1e-6 beside the corners of a flat
        return 32 + (int(np.ceil(self.extra_nodes * (high - low) / (rings[-1] - rings[0]))) if between else 0)

    def _sample(self, r: Array) -> Array:
        """Columns by quadrature, shape (n, columns)."""
        parts = []
        step = max(1, AT_ONCE // self._rule.at(r[:1])[0].size)
        for start in range(0, r.size, step):
            radius = r[start : start + step]
            phi, weights = self._rule.at(radius)
            parts.append(self.integrals(*self._indenter.height_and_slope(radius[:, None], phi), phi, weights))
        return np.vstack(parts)


class AngularMean(AngularTable):
    """Mean height and slope, as functions of the radius."""

    def height(self, r: Array) -> Array:
        """f0 [m] at radii r [m] of any shape."""
        return self.at(r)[..., 0]

    def slope(self, r: Array) -> Array:
        """df0/dr [-], same shape."""
        return self.at(r)[..., 1]

    def integrals(self, f: Array, slope: Array, phi: Array, weights: Array) -> Array:
        """Means of height and slope."""
        return np.stack([np.sum(f * weights, axis=1), np.sum(slope * weights, axis=1)], axis=1)


class GeometricMean(AngularTable):
    """f_b = exp<ln f> of an indenter with f > 0 away from the apex, and its slope, as functions of the radius."""

    def height(self, r: Array) -> Array:
        """f_b [m] at radii r [m] of any shape."""
        return np.asarray(np.exp(self.at(r)[..., 0]))

    def slope(self, r: Array) -> Array:
        """df_b/dr [-], same shape."""
        mean, rate, _ = np.moveaxis(self.at(r), -1, 0)
        return np.asarray(np.exp(mean) * rate)

    def integrals(self, f: Array, slope: Array, phi: Array, weights: Array) -> Array:
        """Means of ln f, of its derivative by r, and of the square of ln(f/f_b)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            logarithm = np.log(f)
            mean = np.sum(logarithm * weights, axis=1)
            square = np.sum((logarithm - mean[:, None]) ** 2 * weights, axis=1)
            return np.stack([mean, np.sum(slope / f * weights, axis=1), square], axis=1)


@byte_cached
def angular_mean(indenter: Indenter) -> AngularMean:
    """The mean of an indenter; what is already tabulated is shared."""
    return AngularMean(indenter)


@byte_cached
def geometric_mean(indenter: Indenter) -> GeometricMean:
    """The geometric mean of an indenter; what is already tabulated is shared."""
    return GeometricMean(indenter)
