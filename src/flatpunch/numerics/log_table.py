"""Functions of ln a that are costly to evaluate, sampled piece by piece and interpolated by polynomials.

Pieces are spans of ln a, cut at the radii at which the function has kinks: there it goes on like a series in the root of the
distance, as contacts do when they reach a ring of the indenter. So beyond a kink the polynomials are in that root.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._support.checks import Array

_SPANS, _DEGREE = 4, 10
"""Spans per decade, and degree of the polynomials: 1e-10 of smooth functions for 40 values a decade, of which few lie beyond what
is asked, where they cost most."""
_POINTS, _INNER_POINTS = chebyshev.chebpts2(_DEGREE + 1), chebyshev.chebpts1(_DEGREE + 1)
"""Where in a piece values are taken: from its left end (-1) to its right one (1), which the next one has as well; and, right
beyond a kink, at which they may jump, from the first place inside on."""
_COEFFICIENTS, _INNER_COEFFICIENTS = (
    np.linalg.inv(chebyshev.chebvander(points, _DEGREE)) for points in (_POINTS, _INNER_POINTS)
)
_STEEPEST = 0.1
"""Root of the distance from a kink below which slopes rise no further: those of roots have no end, those of contacts have."""
_NARROWEST = 1e-6
"""Pieces in ln a too narrow to be worth having."""


@dataclass(frozen=True, slots=True)
class _Piece:
    """Polynomials over ln a from `low` to `high`, or over its root beyond the kink `origin`, if there is one."""

    low: float
    high: float
    origin: float
    coefficients: Array

    def at(self, x: Array) -> tuple[Array, Array]:
        """Values and derivatives at x = ln a, shapes (n, outputs)."""
        start, end = self.ends
        s, rate = x, np.ones_like(x)
        if self.origin > -np.inf:
            s = np.sqrt(np.maximum(x - self.origin, 0.0))
            rate = 0.5 / np.maximum(s, _STEEPEST)
        scale = 2 / (end - start)
        share = (s - start) * scale - 1
        slopes = chebyshev.chebder(self.coefficients)
        values, derivatives = (chebyshev.chebvander(share, len(c) - 1) @ c for c in (self.coefficients, slopes * scale))
        return values, derivatives * rate[:, None]

    @property
    def ends(self) -> tuple[float, float]:
        """Where the variable of the polynomials begins and ends."""
        return _variable(self.low, self.origin), _variable(self.high, self.origin)


def _variable(x: float, origin: float) -> float:
    return x if origin == -np.inf else float(np.sqrt(max(x - origin, 0.0)))


@dataclass(eq=False)
class LogTable:
    """Table of a vector function of ln a.

    Parameters
    ----------
    sample : callable
        Radii, shape (n,) [m] -> values, shape (n, outputs).
    reach : float
        Largest radius [m].
    kinks : tuple of float
        Radii [m] at which the function has kinks.
    """

    sample: Callable[[Array], Array]
    reach: float = float("inf")
    kinks: tuple[float, ...] = ()
    _pieces: dict[tuple[float, float], _Piece] = field(default_factory=dict)
    _known: dict[float, Array] = field(default_factory=dict)

    def at(self, radius: Array) -> tuple[Array, Array]:
        """Values and derivatives by ln a at radii > 0, shapes (n, outputs)."""
        x = np.log(np.minimum(radius, self.reach))
        edges = self._edges(float(x.min()), float(x.max()))
        which = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, edges.size - 2)
        found = np.unique(which)
        pieces = self._made([(float(edges[i]), float(edges[i + 1])) for i in found])
        outputs = pieces[0].coefficients.shape[1]
        values, slopes = np.empty((x.size, outputs)), np.empty((x.size, outputs))
        for i, piece in zip(found, pieces, strict=True):
            chosen = which == i
            values[chosen], slopes[chosen] = piece.at(x[chosen])
        return values, slopes

    def _edges(self, low: float, high: float) -> Array:
        """Ends of the pieces that hold ln a from `low` to `high`."""
        step, end = np.log(10) / _SPANS, np.log(self.reach)
        # one of the even ends may be next to the reach, and make way for it below
        first = min(np.floor(low / step), np.ceil((end - 2 * _NARROWEST) / step) - 1)
        even = np.arange(first, np.floor(high / step) + 2) * step
        kinks = np.log(self.kinks) if self.kinks else np.empty(0)
        kinks = kinks[(kinks > even[0]) & (kinks < min(even[-1], end))]
        # what is next to a kink or to the reach makes way for it
        fixed = np.append(kinks, end) if end <= even[-1] else kinks
        even = even[even < end]
        if fixed.size:
            even = even[np.abs(even[:, None] - fixed).min(axis=1) > _NARROWEST]
        return np.unique(np.concatenate([even, fixed]))

    def _made(self, ends: list[tuple[float, float]]) -> list[_Piece]:
        """Pieces between ends; what is not known is sampled at once."""
        new = [pair for pair in ends if pair not in self._pieces]
        places = {pair: self._places(*pair) for pair in new}
        missing = np.array(sorted({x for at in places.values() for x in at.tolist()} - self._known.keys()))
        if missing.size:
            self._known.update(zip(missing.tolist(), self.sample(np.exp(missing)), strict=True))
        for pair, at in places.items():
            table, origin = np.array([self._known[x] for x in at.tolist()]), self._origin(pair[0])
            matrix = _INNER_COEFFICIENTS if origin == pair[0] else _COEFFICIENTS
            self._pieces[pair] = _Piece(*pair, origin, matrix @ table)
        return [self._pieces[pair] for pair in ends]

    def _places(self, low: float, high: float) -> Array:
        """Where in a piece the function is sampled, as ln a."""
        origin = self._origin(low)
        start, end = _variable(low, origin), _variable(high, origin)
        s = (start + end) / 2 + (end - start) / 2 * (_INNER_POINTS if origin == low else _POINTS)
        places = s if origin == -np.inf else origin + s * s
        if origin != low:
            # exactly as the pieces beside have them
            places[[0, -1]] = low, high
        return places

    def _origin(self, low: float) -> float:
        """The last kink up to a position, -inf before the first."""
        return max((kink for kink in np.log(self.kinks) if kink <= low), default=-np.inf) if self.kinks else -np.inf
