"""Functions that are expensive to evaluate, as piecewise Chebyshev series that are made where they are first read.

The axis is divided into spans. A span is sampled at Chebyshev nodes when a point in it is first read, halved where its series
does not end, and kept. Beside kinks the polynomials are in another variable than x, in which the function is smooth.

`log_table` makes functions of ln a that are cut at the radii at which they have kinks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from flatpunch._support.byte_cache import PROCESS
from flatpunch._support.checks import Array, Indices
from flatpunch.numerics.chebyshev import derivative, nodal_transform, polynomials, unit_nodes


class Variable(Protocol):
    """An increasing function v(x) in which a piece is a polynomial."""

    def of(self, x: Array) -> Array:
        """v at x."""

    def inverse(self, v: Array) -> Array:
        """x at v."""

    def rate(self, x: Array) -> Array:
        """dv/dx at x."""


class Plain:
    """x itself, for smooth functions."""

    def of(self, x: Array) -> Array:
        """v at x."""
        return x

    def inverse(self, v: Array) -> Array:
        """x at v."""
        return v

    def rate(self, x: Array) -> Array:
        """dv/dx at x."""
        return np.ones_like(x)


@dataclass(frozen=True, slots=True)
class Root:
    """Root of the distance from a kink below the piece, the behaviour of contacts that pass a ring of the indenter.

    Parameters
    ----------
    kink : float
        Position of the kink.
    steepest : float
        Root below which slopes are those of this root: functions of contacts have finite slopes at a kink, their series has not.
    """

    kink: float
    steepest: float

    def of(self, x: Array) -> Array:
        """v at x."""
        return np.sqrt(np.maximum(x - self.kink, 0.0))

    def inverse(self, v: Array) -> Array:
        """x at v."""
        return self.kink + v * v

    def rate(self, x: Array) -> Array:
        """dv/dx at x."""
        return 0.5 / np.maximum(self.of(x), self.steepest)


@dataclass(frozen=True, slots=True)
class Sine:
    """v in x = low + (high - low) sin^2 v, for roots of the distance from either end."""

    low: float
    high: float

    def of(self, x: Array) -> Array:
        """v at x."""
        return np.arcsin(np.sqrt(np.clip((x - self.low) / (self.high - self.low), 0.0, 1.0)))

    def inverse(self, v: Array) -> Array:
        """x at v."""
        return self.low + (self.high - self.low) * np.sin(v) ** 2

    def rate(self, x: Array) -> Array:
        """dv/dx at x, infinite at the ends."""
        with np.errstate(divide="ignore"):
            return 1 / ((self.high - self.low) * np.sin(2 * self.of(x)))


@dataclass(frozen=True, slots=True)
class Piece:
    """Chebyshev series over [low, high].

    Attributes
    ----------
    low, high : float
        Ends.
    series : ndarray, shape (nodes, outputs)
        Coefficients.
    error : float
        What `PiecewiseChebyshev.judge` makes of them.
    variable : Variable
        What the polynomials are in.
    """

    low: float
    high: float
    series: Array
    error: float = 0.0
    variable: Variable = field(default_factory=Plain)

    @property
    def nodes(self) -> int:
        """Number of nodes and coefficients."""
        return int(self.series.shape[0])

    def unit(self, x: Array) -> Array:
        """Coordinate in [-1, 1]."""
        start, end = self.variable.of(np.array([self.low, self.high]))
        return np.asarray((2 * self.variable.of(x) - start - end) / (end - start))

    def at(self, x: Array, outputs: int | None = None) -> Array:
        """Values of the first `outputs` columns (all by default), shape (n, outputs)."""
        return np.asarray(polynomials(self.unit(x), self.nodes - 1).T @ self.series[:, :outputs])

    def with_slope(self, x: Array) -> Array:
        """Values and derivatives by x side by side, shape (n, 2 outputs)."""
        start, end = self.variable.of(np.array([self.low, self.high]))
        basis = polynomials(self.unit(x), self.nodes - 1).T
        slopes = basis[:, :-1] @ (derivative(self.nodes) @ self.series * (2 / (end - start)))
        return np.hstack([basis @ self.series, slopes * self.variable.rate(x)[:, None]])


@dataclass(eq=False)
class PiecewiseChebyshev:
    """A vector function of x.

    Parameters
    ----------
    sample : callable
        Positions, shape (n,) -> values, shape (n, outputs).
    edges : callable
        Positions -> ascending ends of the spans that hold them all.
    nodes : callable
        Ends of a span -> its number of nodes.
    variable : callable
        Ends of a span -> variable of its polynomials, x itself by default.
    judge : callable
        Coefficients, shape (nodes, outputs) -> size of their tail.
    rough : callable
        Whether a piece is halved.
    together : bool
        Whether the nodes of all new spans are sampled in one call.
    noise : float
        Largest error that may be noise of the samples: a piece below is not halved again when halving has not halved its error.
    """

    sample: Callable[[Array], Array]
    edges: Callable[[Array], Array]
    nodes: Callable[[float, float], int]
    variable: Callable[[float, float], Variable] = lambda low, high: Plain()
    judge: Callable[[Array], float] = lambda series: 0.0
    rough: Callable[[Piece], bool] = lambda piece: False
    together: bool = False
    noise: float = 0.0
    _pieces: dict[tuple[float, float], list[Piece]] = field(default_factory=dict)

    def at(self, x: Array, *, few: int = 0) -> Array:
        """Values at x, shape (n, outputs); spans with no more than `few` points are not made, these are sampled directly."""
        spans = self._spans(x)
        lonely = [at for ends, at in spans.items() if at.size <= few and ends not in self._pieces]
        parts = [(at, values) for at, values in self._read(x, spans, Piece.at, few)]
        if lonely:
            at = np.concatenate(lonely)
            parts.append((at, self.sample(x[at])))
        return _gathered(x.size, parts)

    def with_slope(self, x: Array) -> tuple[Array, Array]:
        """Values and derivatives by x, shapes (n, outputs)."""
        both = _gathered(x.size, self._read(x, self._spans(x), Piece.with_slope))
        outputs = both.shape[1] // 2
        return both[:, :outputs], both[:, outputs:]

    def parts(self, x: Array) -> list[tuple[Piece, Indices]]:
        """Pieces that hold the points x, made where they are missing, each with the numbers of what it holds."""
        return self._parts(x, self._spans(x))

    def _spans(self, x: Array) -> dict[tuple[float, float], Indices]:
        if not x.size:
            return {}
        edges = self.edges(x)
        span = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, edges.size - 2)
        return {(float(edges[i]), float(edges[i + 1])): np.flatnonzero(span == i) for i in np.unique(span)}

    def _parts(self, x: Array, spans: dict[tuple[float, float], Indices], few: int = 0) -> list[tuple[Piece, Indices]]:
        wanted = {ends: at for ends, at in spans.items() if at.size > few or ends in self._pieces}
        self._make([ends for ends in wanted if ends not in self._pieces])
        found = []
        for ends, at in wanted.items():
            pieces = self._pieces[ends]
            which = np.searchsorted([piece.low for piece in pieces[1:]], x[at], side="right")
            found += [(piece, at[which == i]) for i, piece in enumerate(pieces)]
        return [(piece, at) for piece, at in found if at.size]

    def _read(
        self,
        x: Array,
        spans: dict[tuple[float, float], Indices],
        take: Callable[[Piece, Array], Array],
        few: int = 0,
    ) -> list[tuple[Indices, Array]]:
        return [(at, take(piece, x[at])) for piece, at in self._parts(x, spans, few)]

    def _make(self, spans: list[tuple[float, float]]) -> None:
        if self.together and len(spans) > 1:
            places = [self._places(*ends, self.nodes(*ends)) for ends in spans]
            values = np.split(self.sample(np.concatenate(places)), np.cumsum([p.size for p in places])[:-1])
        for i, ends in enumerate(spans):
            count = self.nodes(*ends)
            known = values[i] if self.together and len(spans) > 1 else None
            self._pieces[ends] = self._built(*ends, count, known)
            PROCESS.grown(sum(piece.series.nbytes for piece in self._pieces[ends]))

    def _built(
        self, low: float, high: float, count: int, values: Array | None = None, before: float = np.inf
    ) -> list[Piece]:
        """Pieces of a span: one, or those of both halves.

        `before` is the error of the piece it is half of: a small tail that halving has not halved is noise of the samples.
        """
        if values is None:
            values = self.sample(self._places(low, high, count))
        series = nodal_transform(count) @ values
        piece = Piece(low, high, series, self.judge(series), self.variable(low, high))
        if not self.rough(piece) or before / 2 < piece.error < self.noise:
            return [piece]
        middle = (low + high) / 2
        return self._built(low, middle, count, before=piece.error) + self._built(
            middle, high, count, before=piece.error
        )

    def _places(self, low: float, high: float, count: int) -> Array:
        variable = self.variable(low, high)
        start, end = variable.of(np.array([low, high]))
        return variable.inverse((start + end) / 2 + (end - start) / 2 * unit_nodes(count))


def _gathered(size: int, parts: list[tuple[Indices, Array]]) -> Array:
    """Rows of all parts in the order of the points, shape (size, outputs)."""
    result = np.empty((size, parts[0][1].shape[1] if parts else 0))
    for at, values in parts:
        result[at] = values
    return result


def log_table(
    sample: Callable[[Array], Array],
    reach: float = np.inf,
    kinks: tuple[float, ...] = (),
    nodes: int = 11,
    steepest: float = 0.1,
) -> PiecewiseChebyshev:
    """A vector function of x = ln a, from values (n, outputs) at radii a (n,) [m].

    Spans of a quarter of a decade have `nodes` each: 11 leave 1e-10 of smooth functions. No radius beyond `reach` [m] is sampled.
    At `kinks` [m] the function has kinks, beyond which it is a series in the root of the distance in ln a. Slopes rise no further
    below the root `steepest`; half of 0.1 doubles them at a kink of contacts.
    """
    end, cuts = float(np.log(reach)), np.log(kinks) if kinks else np.empty(0)

    def edges(x: Array) -> Array:
        return _edges(float(x.min()), float(x.max()), end, cuts)

    def variable(low: float, high: float) -> Variable:
        before = cuts[cuts <= low]
        return Root(float(before.max()), steepest) if before.size else Plain()

    return PiecewiseChebyshev(
        lambda x: sample(np.minimum(np.exp(x), reach)), edges, lambda low, high: nodes, variable, together=True
    )


def _edges(low: float, high: float, end: float, kinks: Array) -> Array:
    # spans per decade; half as many leave 1e-7 of smooth functions in the place of 1e-10
    step, narrowest = np.log(10) / 4, 1e-6
    # one of the even ends may be next to the reach, and make way for it below
    first = min(np.floor(low / step), np.ceil((end - 2 * narrowest) / step) - 1)
    even = np.arange(first, np.floor(high / step) + 2) * step
    kinks = kinks[(kinks > even[0]) & (kinks < min(even[-1], end))]
    # what is next to a kink or to the reach makes way for it
    fixed = np.append(kinks, end) if end <= even[-1] else kinks
    even = even[even < end]
    if fixed.size:
        even = even[np.abs(even[:, None] - fixed).min(axis=1) > narrowest]
    return np.unique(np.concatenate([even, fixed]))
