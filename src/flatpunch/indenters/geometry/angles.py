"""Quadrature over the polar angle, and integrals of an indenter over it as functions of the radius, tabulated.

Smooth outlines take equally spaced angles (exponential convergence), outlines with edges Gauss panels from
edge to edge. The number of angles grows until the angular means of f and of its logarithm no longer
change, to rounding.

Many radii are needed, and each takes hundreds of angles. Panels of the tables, three to a decade and cut at the rings and scales
of the shape, carry polynomials in s with r = r_0 + (r_1 - r_0) sin^2(pi s/2). In s such integrals are smooth even where they
begin or end like the root of the distance from a ring, as they do at the corners and sides of a square flat.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import partial

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import AT_ONCE, Array, Indices
from flatpunch.indenters._common import FULL_TURN, SAME
from flatpunch.indenters.geometry.features import rotational_symmetry
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.gauss import gauss
from flatpunch.numerics.piecewise import PiecewiseChebyshev, Sine

_STILL = float(100 * np.finfo(float).eps)
"""Change of a mean, over its own scale, that counts as rounding: tens of eps, sums of hundreds."""


@byte_cached
def angular_rule(indenter: Indenter, order: int = 32) -> tuple[Array, Array]:
    """Angles in [0, 2 pi) [rad] and weights that sum to 1 for means over the polar angle; read-only, shared between calls.

    Corners and seams of the indenter split the rule. Products of two harmonics up to `order` are integrated at rounding as well.
    """
    breaks = indenter.split_angles
    size = _first_size(breaks, order)
    phi, weights = _nodes(breaks, size)
    if not indenter.round:
        radii, tolerance = _watched(indenter)
        if not radii.size:
            # kinks cross all circles, and between them more angles are no use
            return _kept(phi, weights)
        means, scale = _means(indenter, radii, phi, weights)
        while phi.size < 10_000:
            more = _finer(breaks, size, crossed=tolerance > _STILL)
            finer = _nodes(*more)
            new, scale = _means(indenter, radii, *finer)
            still = bool((np.abs(new - means) <= tolerance * scale).all())
            if still:
                break
            (breaks, size), (phi, weights), means = more, finer, new
    return _kept(phi, weights)


def _kept(phi: Array, weights: Array) -> tuple[Array, Array]:
    """A rule that is shared."""
    phi.setflags(write=False)
    weights.setflags(write=False)
    return phi, weights


def _finer(breaks: list[float], size: int, crossed: bool) -> tuple[list[float], int]:
    """Panels and angles on each for the next trial: more angles, or more panels where kinks cross the rays."""
    if not breaks:
        return breaks, 2 * size
    if not crossed:
        # outlines that vary by orders of magnitude need thousands: few trials reach them
        return breaks, size + max(10, size // 10)
    ends = np.array([*breaks, breaks[0] + FULL_TURN])
    return sorted({*map(float, ends[:-1]), *map(float, (ends[:-1] + ends[1:]) / 2)}), size


def _watched(indenter: Indenter) -> tuple[Array, float]:
    """Radii at which the means must have converged, and the tolerance."""
    tolerance = max(_STILL, indenter.angular_tolerance)
    if indenter.exponent is not None:
        return np.array([1.0]), tolerance
    scales, reach = indenter.scales, indenter.reach if np.isfinite(indenter.reach) else 1.0
    radii = np.array(scales) if scales else reach * np.array([0.05, 0.2, 0.5, 0.8, 1.0])
    crossings = indenter.crossings
    if crossings is None:
        return radii, tolerance
    return radii[~np.isfinite(crossings(radii)).any(axis=1)], tolerance


def _first_size(breaks: list[float], order: int) -> int:
    """Angles of the whole turn, or of one panel: enough for cos(2 order phi)."""
    if not breaks:
        return 4 * (order + 2)
    widest = float(np.diff([*breaks, breaks[0] + FULL_TURN]).max())
    return _gauss_nodes(order * widest) if len(breaks) <= 100 else 10


def _gauss_nodes(z: float) -> int:
    """Gauss nodes that integrate cos(z t) over |t| < 1 at rounding: half of z, and a transition like its cube root."""
    return int(np.ceil(z / 2 + 5 * np.cbrt(z) + 4))


def _nodes(breaks: list[float], size: int) -> tuple[Array, Array]:
    if not breaks:
        return FULL_TURN * np.arange(size) / size, np.full(size, 1 / size)
    edges = np.array([*breaks, breaks[0] + FULL_TURN])
    t, v = gauss(size)
    half = np.diff(edges)[:, None] / 2
    phi = (edges[1:] + edges[:-1])[:, None] / 2 + half * t
    return np.mod(phi.ravel(), FULL_TURN), (half * v).ravel() / FULL_TURN


def panel_rule(edges: Array, order: int) -> tuple[Array, Array]:
    """Gauss points and weights, shape (n, points), on the panels of n integrals between ascending `edges`, shape (n, panels + 1).

    Panels of some integrals may be empty where those of others are not; products of two harmonics up to `order` are exact.
    """
    half, parts = np.diff(edges, axis=1) / 2, []
    for panel, widest in enumerate(half.max(axis=0)):
        if widest > 0:
            # six more, as shapes between kinks are more than a few harmonics
            t, v = gauss(_gauss_nodes(2 * order * float(widest)) + 6)
            middle = (edges[:, panel] + edges[:, panel + 1])[:, None] / 2
            parts.append((middle + half[:, [panel]] * t, half[:, [panel]] * v))
    points, weights = zip(*parts, strict=True)
    return np.hstack(points), np.hstack(weights)


def _means(indenter: Indenter, radii: Array, phi: Array, weights: Array) -> tuple[Array, Array]:
    """Angular means of f and ln f at some radii, and the scales by which their changes are judged."""
    f = indenter.height(radii[:, None], phi)
    touching = ~(f > 0).all(axis=1)
    mean = f @ weights
    with np.errstate(divide="ignore", invalid="ignore"):
        # relative to the mean, so that units do not matter; a radius with f = 0 has no logarithm and is
        # judged by f alone
        logarithm = np.where(touching, 0.0, np.log(f / mean[:, None]) @ weights)
    return np.concatenate([mean, logarithm]), np.concatenate([np.abs(mean), np.ones_like(mean)])


def harmonics(values: Array, phi: Array, weights: Array, order: int) -> tuple[Array, Array]:
    """Angular harmonics v, w: values = v_0 + sum_m v_m cos m phi + w_m sin m phi, shape (..., order + 1); w_0 = 0.

    Angles and weights are those of `angular_rule`.
    """
    m = np.arange(order + 1)
    scaled = np.where(m == 0, 1.0, 2.0) * weights[:, None]
    angle = np.outer(phi, m)
    return np.asarray(values @ (scaled * np.cos(angle))), np.asarray(values @ (scaled * np.sin(angle)))


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
        rings = self._indenter.rings
        between = rings and rings[0] <= low < rings[-1]
        # half as many leave 1e-6 beside the corners of a flat
        return ORDER + (int(np.ceil(self.extra_nodes * (high - low) / (rings[-1] - rings[0]))) if between else 0)

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


class AngularHarmonics(AngularTable):
    """c_m(r) in f = <f> + sum Re(c_m exp(i m (phi - start))) and their derivatives; or of ln f in the place of f.

    Parameters
    ----------
    indenter : Indenter
        The tip; of the logarithm one with f > 0 away from the apex.
    count : int
        Number of orders m: the first so many multiples of the shape's rotational symmetry.
    logarithmic : bool
        Whether the harmonics are those of ln f.
    """

    extra_nodes = 2 * ORDER
    """Between the rings crossings turn by up to half a period, and high orders many times with them."""

    def __init__(self, indenter: Indenter, count: int, *, logarithmic: bool) -> None:
        self.orders: Indices = rotational_symmetry(indenter) * np.arange(1, count + 1)
        super().__init__(indenter, int(self.orders[-1]))
        self._logarithmic, self.start = logarithmic, self._rule.start

    def harmonics(self, r: Array) -> tuple[Array, Array]:
        """c_m of f [m] or ln f, and of its derivative by r, at radii r [m] of shape (...).

        Shape (..., 2 orders): real part and imaginary part of one order after the other.
        """
        value, rise = np.split(self.at(r), 2, axis=-1)
        return value, rise

    def integrals(self, f: Array, slope: Array, phi: Array, weights: Array) -> Array:
        """Amplitudes of height and slope, or of ln f and its derivative; each real part before its imaginary one."""
        if self._logarithmic:
            with np.errstate(divide="ignore", invalid="ignore"):
                f, slope = np.log(f), slope / f
        return np.hstack(self._amplitudes([f * weights, slope * weights], phi)).view(float)

    def _amplitudes(self, fields: list[Array], phi: Array) -> list[Array]:
        """2 sum of each field, shape (n, angles), times exp(-i m (phi - start)); shape (n, orders)."""
        turn = phi - self.start
        if phi.shape[0] == 1:
            wave = 2 * np.exp(-1j * turn[0][:, None] * self.orders)
            return [field @ wave for field in fields]
        # angles differ from radius to radius: wave after wave, each the one before turned once more
        first = np.exp(-1j * self.orders[0] * turn)
        wave, found = 2 * first, [np.empty((turn.shape[0], self.orders.size), dtype=complex) for _ in fields]
        for column in range(self.orders.size):
            for field, amplitudes in zip(fields, found, strict=True):
                amplitudes[:, column] = np.einsum("np,np->n", field, wave)
            wave *= first
        return found


@byte_cached
def angular_harmonics(indenter: Indenter, count: int, *, logarithmic: bool) -> AngularHarmonics:
    """The harmonics of an indenter; what is already tabulated is shared."""
    return AngularHarmonics(indenter, count, logarithmic=logarithmic)
