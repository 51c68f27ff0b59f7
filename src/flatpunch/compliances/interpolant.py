"""A response L(kappa) that is expensive to evaluate, replaced by pieces of Chebyshev series.

L is smooth in the logarithm of kappa, so there log L is interpolated piece by piece; below all pieces L/kappa^p is smooth
in kappa itself (p = 0 on an elastic base), above them kappa (L - 1) is smooth in 1/kappa. Pieces are halved and both
ends pushed outwards until the last coefficients vanish, all new points of a round being evaluated in one call. The short
waves come from their series, so L - 1 has no cancellation there, and derivatives are those of the series.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._support.checks import Array
from flatpunch.compliances.layered import SATURATION
from flatpunch.numerics.chebyshev import NODES, Numbers, nodal_transform, polynomials, unit_nodes

TOLERANCE = 2e-12
"""Size of the last coefficients, relative to L: what the response itself is good for."""


class SmoothResponse(Protocol):
    """A response as series: what the punch matrices of a graded surface need."""

    @property
    def cutoff(self) -> float:
        """Kappa above which L - 1 is its short-wave series."""

    @property
    def floor(self) -> float:
        """Kappa below which L is smooth in kappa."""

    @property
    def tail(self) -> float:
        """Limit of kappa (L - 1) at short waves."""

    @property
    def sharpness(self) -> float:
        """The medium's length over the shortest one at its surface, at least 1."""

    def derivatives(self, kappa: Numbers, order: int = 2) -> Numbers:
        """L - 1 and its derivatives by log kappa; shape (order + 1, *kappa.shape)."""


@dataclass(frozen=True, eq=False)
class Combined:
    """Two bodies: L - 1 is the sum of share times (L_i - 1) at stretch times kappa.

    Attributes
    ----------
    parts : tuple of (share, stretch, series)
    """

    parts: tuple[tuple[float, float, SmoothResponse], ...]

    @property
    def cutoff(self) -> float:
        """Kappa above which L - 1 is its short-wave series."""
        return max(series.cutoff / stretch for _, stretch, series in self.parts)

    @property
    def floor(self) -> float:
        """Kappa below which L is smooth in kappa."""
        return min(series.floor / stretch for _, stretch, series in self.parts)

    @property
    def tail(self) -> float:
        """Limit of kappa (L - 1) at short waves."""
        return sum(share * series.tail / stretch for share, stretch, series in self.parts)

    @property
    def sharpness(self) -> float:
        """The medium's length over the shortest one at its surface, at least 1."""
        return max(1.0, *(series.sharpness / stretch for _, stretch, series in self.parts))

    def derivatives(self, kappa: Numbers, order: int = 2) -> Numbers:
        """L - 1 and its derivatives by log kappa; shape (order + 1, *kappa.shape)."""
        return np.asarray(
            sum(share * series.derivatives(stretch * kappa, order) for share, stretch, series in self.parts)
        )


@dataclass(frozen=True, eq=False)
class Interpolant:
    """Piecewise Chebyshev series of a response.

    Attributes
    ----------
    edges : ndarray, shape (n + 1,)
        log kappa at the ends of the pieces.
    pieces : ndarray, shape (n, 24)
        Chebyshev coefficients of log L over log kappa.
    long_waves : ndarray
        Coefficients of log(L/kappa^power) over kappa/kappa_0 in (0, 1), kappa_0 the lowest edge.
    power : int
        L ~ kappa^power at long waves.
    short_waves : ndarray
        Coefficients of kappa (L - 1) over kappa_1/kappa in (0, 1), kappa_1 the highest edge.
    error : float
        Largest error of L, as the last coefficients say.
    """

    edges: Array
    pieces: Array
    long_waves: Array
    power: int
    short_waves: Array
    error: float

    _piece_series: Array = field(init=False, repr=False)
    _long_series: Array = field(init=False, repr=False)
    _short_series: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        widths = np.diff(self.edges)[:, None]
        series = [_derived(self.pieces, n) * (2 / widths) ** n for n in range(3)]
        object.__setattr__(self, "_piece_series", np.stack(series, axis=1))
        for name, ends in (("_long_series", self.long_waves), ("_short_series", self.short_waves)):
            object.__setattr__(self, name, np.stack([_derived(ends[None], n)[0] * 2.0**n for n in range(3)]))

    @property
    def cutoff(self) -> float:
        """Kappa above which L - 1 is its short-wave series."""
        return float(np.exp(self.edges[-1]))

    @property
    def floor(self) -> float:
        """Kappa below which L/kappa^power is smooth in kappa."""
        return float(np.exp(self.edges[0]))

    @property
    def tail(self) -> float:
        """Limit of kappa (L - 1) at short waves."""
        return float(chebyshev.chebval(-1.0, self.short_waves))

    @property
    def sharpness(self) -> float:
        """The medium's length over the shortest one at its surface, at least 1."""
        return max(1.0, abs(self.tail))

    def __call__(self, kappa: Array) -> Array:
        """L at real kappa > 0, shape (n,); its relative error is small even where L itself vanishes."""
        result = np.empty(kappa.shape)
        below, above = kappa < self.floor, kappa > self.cutoff
        inside = ~(below | above)
        result[inside] = np.exp(self._log_middle(kappa[inside], 0)[0])
        result[below] = np.exp(self._log_low(kappa[below], 0)[0])
        result[above] = 1.0 + self._high(kappa[above], 0)[0]
        return result

    def remainder(self, kappa: Array) -> Array:
        """L - 1 at kappa > 0, without cancellation at short waves; kappa may have a small imaginary part."""
        return np.asarray(self.derivatives(kappa, 0)[0])

    def derivatives(self, kappa: Numbers, order: int = 2) -> Numbers:
        """L - 1 and its derivatives by log kappa up to `order` <= 2; shape (order + 1, *kappa.shape)."""
        kappa = np.asarray(kappa)
        result = np.zeros((order + 1, *kappa.shape), dtype=kappa.dtype)
        size = kappa.real
        below, above = size < self.floor, size > self.cutoff
        inside = ~(below | above)
        if inside.any():
            result[:, inside] = _from_logs(self._log_middle(kappa[inside], order))
        if below.any():
            result[:, below] = _from_logs(self._log_low(kappa[below], order))
        if above.any():
            result[:, above] = self._high(kappa[above], order)
        return result

    def _log_middle(self, kappa: Numbers, order: int) -> Numbers:
        s = np.log(kappa)
        piece = np.clip(np.searchsorted(self.edges, s.real) - 1, 0, len(self.pieces) - 1)
        result = np.empty((order + 1, kappa.size), dtype=s.dtype)
        for i in np.unique(piece).tolist():
            chosen = piece == i
            low, high = self.edges[i], self.edges[i + 1]
            # the polynomials are the same for all derivatives
            basis = polynomials((2 * s[chosen] - low - high) / (high - low))
            result[:, chosen] = self._piece_series[i, : order + 1] @ basis
        return result

    def _log_low(self, kappa: Numbers, order: int) -> Numbers:
        v = kappa / self.floor
        g = _euler(self._long_series, v, order)
        g[0] = g[0] + self.power * np.log(kappa)
        if order:
            g[1] = g[1] + self.power
        return g

    def _high(self, kappa: Numbers, order: int) -> Numbers:
        v = self.cutoff / kappa
        f = _euler(self._short_series, v, order)
        # L - 1 = f(v)/kappa; by log kappa, v d/dv counts with the opposite sign
        if order > 1:
            f[2] += 2 * f[1] + f[0]
        if order > 0:
            f[1] = -f[1] - f[0]
        return np.asarray(f / kappa)


def interpolate(
    response: Callable[[Array], Array], start: float, power: int, *, vanishing: bool, last: float = SATURATION
) -> Interpolant:
    """Interpolant of a response kappa -> L, shape (n,) each, with L ~ kappa^power at long waves.

    From `start` down L is expected to be smooth in kappa; it is moved down where it is not. `vanishing` says that L - 1 decays
    exponentially, under a homogeneous surface layer, so that it is zero from `last` on.
    """
    # graded surfaces: pieces that end at the reach of 25 leave 2e-11 under steep linear laws
    low, high = np.log(start), np.log(last if vanishing else 32.0)
    pieces: dict[tuple[float, float], Array] = {}
    ends = np.exp([low, high])
    wanted = _split(low, high)
    long_waves, short_waves = None, np.zeros(1) if vanishing else None
    error, fit = 0.0, nodal_transform(NODES)
    while wanted or long_waves is None or short_waves is None:
        points = [np.exp(_nodes(a, b)) for a, b in wanted]
        if long_waves is None:
            points.append(ends[0] * (unit_nodes(NODES) + 1) / 2)
        if short_waves is None:
            points.append(ends[1] / _short_nodes())
        values = response(np.concatenate(points))
        parts = np.split(values, np.cumsum([len(p) for p in points])[:-1])
        next_round: list[tuple[float, float]] = []
        for (a, b), part in zip(wanted, parts, strict=False):
            series = fit @ np.log(part)
            tail = float(np.abs(series[-2:]).max() * min(part.max(), 1.0))
            if tail > TOLERANCE and b - a > np.log(4.0) / 64:
                next_round += [(a, (a + b) / 2), ((a + b) / 2, b)]
            else:
                pieces[a, b] = series
                error = max(error, tail)
        index = len(wanted)
        if long_waves is None:
            series = fit @ (np.log(parts[index]) - power * np.log(points[index]))
            index += 1
            if np.abs(series[-2:]).max() < TOLERANCE or ends[0] < 1e-12:
                long_waves = series
            else:
                next_round += _split(np.log(ends[0] / 10), np.log(ends[0]))
                ends[0] /= 10
        if short_waves is None:
            series, misfit = _fit_short(parts[index] - 1, ends[1])
            if misfit < TOLERANCE or ends[1] > 1e9:
                short_waves = series
                error = max(error, misfit)
            else:
                next_round += _split(np.log(ends[1]), np.log(ends[1] * 4))
                ends[1] *= 4
        wanted = next_round
    order = sorted(pieces)
    edges = np.array([order[0][0], *(b for _, b in order)])
    coefficients = np.stack([pieces[key] for key in order])
    return Interpolant(edges, coefficients, long_waves, power, short_waves, error)


def _split(low: float, high: float) -> list[tuple[float, float]]:
    count = max(1, round((high - low) / np.log(4.0)))
    edges = np.linspace(low, high, count + 1)
    edges[0], edges[-1] = low, high
    return [(a, b) for a, b in pairwise(edges.tolist())]


def _nodes(a: float, b: float) -> Array:
    return (a + b) / 2 + (b - a) / 2 * unit_nodes(NODES)


def _short_nodes() -> Array:
    """kappa_1/kappa of the fit, denser towards kappa_1; far below it L - 1 drowns in rounding."""
    least = 0.01
    return np.asarray(least + (1 - least) * (1 + unit_nodes(NODES)) / 2)


def _fit_short(remainder: Array, end: float) -> tuple[Array, float]:
    """Chebyshev coefficients of kappa (L - 1) over kappa_1/kappa, and the largest misfit of L."""
    v = _short_nodes()
    basis = chebyshev.chebvander(2 * v - 1, v.size // 2 - 1)
    # weighted so that the misfit is that of L - 1 = f(v) v/kappa_1
    weights = v / end
    series, *_ = np.linalg.lstsq(basis * weights[:, None], remainder, rcond=1e-15)
    misfit = np.abs((basis @ series) * weights - remainder).max()
    return np.asarray(series), float(misfit)


def _derived(series: Array, n: int) -> Array:
    """Chebyshev coefficients of n-th derivatives, shape (pieces, terms) like those of the functions."""
    result = np.zeros_like(series)
    if n < series.shape[1]:
        result[:, : series.shape[1] - n] = chebyshev.chebder(series, n, axis=1)
    return result


def _euler(series: Array, v: Numbers, order: int) -> Numbers:
    """A function of v and its derivatives v d/dv, shape (order + 1, n), from series of it and its derivatives by v."""
    values = series[: order + 1] @ polynomials(2 * v - 1, series.shape[1] - 1)
    if order > 0:
        values[1] *= v
    if order > 1:
        values[2] = values[1] + v * v * values[2]
    return np.asarray(values)


def _from_logs(logs: Numbers) -> Numbers:
    result = np.empty_like(logs)
    result[0] = np.expm1(logs[0])
    if len(logs) > 1:
        response = result[0] + 1
        result[1] = logs[1] * response
    if len(logs) > 2:
        result[2] = (logs[2] + logs[1] ** 2) * response
    return result
