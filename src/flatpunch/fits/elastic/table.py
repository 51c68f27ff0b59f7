"""ln phi over ln delta of a scaled problem, tabulated once and interpolated.

Over ln delta: quintic splines through 24 nodes per decade (measured: 3e-9 for round tips, 5e-7 for pyramids). Over each
coordinate q: Lagrange interpolation through the six nearest knots. Below the table the curve continues as a power law; the
table begins five decades below the largest depth, where forces are below 1e-5 of the largest even for flat ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np
from scipy.interpolate import make_interp_spline

from flatpunch._support.byte_cache import PROCESS
from flatpunch._support.checks import Array, Indices
from flatpunch._support.progress import reporting
from flatpunch.fits.parameters.scaling import Coordinate

PER_DECADE = 24
"""Depths per decade that are solved exactly; half as many leave 5e-7 of the largest force under tips of kinked profile."""

STEP = np.log(10) / PER_DECADE

DEGREE = 5
"""Degree of the splines in ln delta; cubic ones leave 4e-7 of the largest force, where these leave 1e-9."""

_DECADES = 5
"""Decades of depth in a table, below which the power law of its end goes on; with three, 1e-8 of the largest force is left."""

_MARGIN = 4
"""Depths beyond either end that are solved for the splines; with none their ends would be off."""

_TABULATED = 2
"""Coordinates of a table at most; with more, six knots along each cost more solutions than a fit has steps."""

_SHIFT = 1e-4
"""Change of a coordinate for its derivative where nothing is tabulated over it; it errs by as much."""

KNOTS = DEGREE + 1
"""Points across each coordinate, interpolated with the degree of the splines; with four the force is off by 1e-5."""

Window = tuple[int, int]
"""First and last node, in steps of ln delta."""
Solve = Callable[[tuple[float, ...], Array], Array]


def shift(coordinate: Coordinate, value: float) -> float:
    """Change of a coordinate for a derivative, away from its limit."""
    c = coordinate
    return -_SHIFT if c.highest is not None and value + c.step > c.offset + c.step * c.highest else _SHIFT


@dataclass(frozen=True)
class Piecewise:
    """Polynomials of degree 5 on intervals of ln delta of equal width, power law below and above.

    Parameters
    ----------
    start : float
        ln delta at which the first interval begins.
    coefficients : ndarray, shape (functions, 6, intervals)
        Descending powers of the position within the interval, 0 to 1. The first function is ln phi, then its derivatives by
        the coordinates.
    """

    start: float
    coefficients: Array

    def at(self, log_depth: Array) -> tuple[Array, Array, Array]:
        """Value and slope of ln phi, shape (n,), and its derivatives by the coordinates, shape (coordinates, n)."""
        index, inside, beyond = _places(self.start, self.coefficients.shape[2], log_depth)
        value, slope = _horner(self.coefficients[0], index, inside, derivative=True)
        value += slope * beyond
        others = np.empty((self.coefficients.shape[0] - 1, log_depth.size))
        for i, coefficients in enumerate(self.coefficients[1:]):
            others[i] = _horner(coefficients, index, inside, derivative=False)[0]
        return value, slope / STEP, others


def _places(start: float, count: int, log_depth: Array) -> tuple[Indices, Array, Array]:
    """Interval of each place, the position within it, and how far beyond the ends of all it is."""
    position = (log_depth - start) / STEP
    index = np.clip(position.astype(np.intp), 0, count - 1)
    t = position - index
    inside = np.clip(t, 0.0, 1.0)
    return index, inside, t - inside


def _horner(coefficients: Array, index: Indices, t: Array, *, derivative: bool) -> tuple[Array, Array]:
    value = coefficients[0].take(index)
    slope = np.zeros_like(t)
    for row in coefficients[1:]:
        if derivative:
            slope *= t
            slope += value
        value *= t
        value += row.take(index)
    return value, slope


def at_pieces(start: float, coefficients: Array, log_depth: Array) -> tuple[Array, Array]:
    """Value and slope of piecewise polynomials, one for each row: shape (6, rows, intervals) at places (rows, n)."""
    rows, count = coefficients.shape[1:]
    index, inside, beyond = _places(start, count, log_depth)
    value, slope = _horner(coefficients, index + count * np.arange(rows)[:, None], inside, derivative=True)
    return value + slope * beyond, slope / STEP


@dataclass(eq=False)
class Table:
    """ln phi(ln delta; q) of one family of problems.

    Parameters
    ----------
    solve : callable
        (q, delta of shape (n,)) -> phi of shape (n,): the exact solution.
    coordinates : sequence of Coordinate
        What q is made of.
    limit : callable
        q -> largest ln delta that can be solved, infinite for idealised tips.
    decades : int
        How far below its upper end the table begins.
    """

    solve: Solve
    coordinates: Sequence[Coordinate]
    limit: Callable[[tuple[float, ...]], float]
    decades: int = _DECADES
    _window: Window = (0, -1)
    _nodes: dict[tuple[int, ...], dict[int, float]] = field(default_factory=dict)
    _pieces: dict[tuple[Window, tuple[int, ...]], Array] = field(default_factory=dict)
    _limits: dict[tuple[float, ...], float] = field(default_factory=dict)
    _stacks: dict[tuple[Window, tuple[int, ...]], Array] = field(default_factory=dict)
    _last: tuple[tuple[float, ...], Piecewise] | None = None
    _count: int = 0
    _slopes: tuple[Window, Array, Array] | None = None

    def at(self, q: Sequence[float], highest: float) -> Piecewise:
        """Interpolant at coordinates q, good for ln delta up to `highest`."""
        window = self._widened(highest if highest < self._safe else min(highest, self.highest(q)))
        key = (*q, *window)
        if self._last is None or self._last[0] != key:
            self._last = (key, Piecewise(window[0] * STEP, self._combined(q, window)))
        self._keep(window)
        return self._last[1]

    def at_many(self, q: Array, highest: Array) -> tuple[float, Array]:
        """Interpolants of ln phi at several coordinates at once.

        Parameters
        ----------
        q : ndarray, shape (n, coordinates)
            Coordinates.
        highest : ndarray, shape (n,)
            Largest ln delta of each.

        Returns
        -------
        start : float
            ln delta at which the first interval begins.
        coefficients : ndarray, shape (6, n, intervals)
            As in `Piecewise`.
        """
        first, beyond = self._around(q)
        nearest = {tuple(row) for row in np.rint(first + beyond).astype(int).tolist()}
        window = self._widened(min(float(highest.max()), max(map(self._end, nearest))))
        total = np.empty((len(q), DEGREE + 1, window[1] - window[0]))
        for place, mine in _alike(first):
            weights = np.ones((mine.size, 1))
            for t in beyond[mine].T:
                weights = (weights[:, :, None] * (_powers(t) @ _LAGRANGE)[:, None, :]).reshape(mine.size, -1)
            total[mine] = (weights @ self._knots(place, window)).reshape(mine.size, *total.shape[1:])
        self._keep(window)
        return window[0] * STEP, np.ascontiguousarray(total.transpose(1, 0, 2))

    def _knots(self, first: tuple[int, ...], window: Window) -> Array:
        """Coefficients at all knots around coordinates, a row each."""
        key = (window, first)
        if key not in self._stacks:
            # groups of neighbouring knots kept together for many vectors at once: some 20 MB
            if len(self._stacks) >= 100:
                self._stacks.clear()
            choices = product(range(KNOTS), repeat=len(first))
            self._stacks[key] = np.array(
                [self._knot(tuple(f + i for f, i in zip(first, c, strict=True)), window).ravel() for c in choices]
            )
        return self._stacks[key]

    def _keep(self, window: Window) -> None:
        """Make a window the table's own: what cannot be solved must not be asked of those who share it."""
        if window != self._window:
            self._window = window
            self._pieces = {place: piece for place, piece in self._pieces.items() if place[0] == window}
            self._stacks.clear()

    @cached_property
    def _safe(self) -> float:
        """ln delta that can be solved at any coordinates of interest, a decade below what can be at the first."""
        return float(self.limit(tuple(c.offset for c in self.coordinates)) - PER_DECADE * STEP)

    def highest(self, q: Sequence[float]) -> float:
        """Where the table must end, at the knot next to q, with a little to spare."""
        if not self.tabulated:
            return self._end(tuple(q))
        return self._end(tuple(round((v - c.offset) / c.step) for c, v in zip(self.coordinates, q, strict=True)))

    def _end(self, place: tuple[float, ...]) -> float:
        """Where the table must end at a knot, or at coordinates without knots."""
        if place not in self._limits:
            self._limits[place] = self.limit(self._values(place) if self.tabulated else place) + 2 * STEP
        return self._limits[place]

    @cached_property
    def _grid(self) -> Array:
        """Offsets and steps of the coordinates, their first and last knots; shape (4, coordinates)."""
        rows = [
            (c.offset, c.step, -np.inf if c.lowest is None else c.lowest, np.inf if c.highest is None else c.highest)
            for c in self.coordinates
        ]
        return np.array(rows, dtype=float).reshape(-1, 4).T

    def _around(self, q: Array) -> tuple[Indices, Array]:
        """The first of the six knots around coordinates, shape (..., coordinates), and how far beyond it they are, in steps."""
        offset, step, least, last = self._grid
        position = (q - offset) / step
        first = np.clip(np.floor(position) - KNOTS // 2 + 1, least, last - KNOTS + 1).astype(int)
        return first, position - first

    def _values(self, index: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(c.offset + c.step * i for c, i in zip(self.coordinates, index, strict=True))

    def _combined(self, q: Sequence[float], window: Window) -> Array:
        """Coefficients of ln phi and of its derivatives by the coordinates, shape (1 + coordinates, 6, intervals)."""
        if not self.tabulated:
            return self._solved(q, window)
        first, beyond = self._around(np.array(q))
        powers = _powers(beyond)
        weights = powers @ _LAGRANGE
        slopes = np.append(powers[:, 1:], np.zeros((len(q), 1)), axis=1) * np.arange(KNOTS - 1, -1, -1) @ _LAGRANGE
        slopes /= self._grid[1][:, None]
        rows = [_tensor(weights)]
        for j in range(len(q)):
            rows.append(_tensor([slopes[i] if i == j else each for i, each in enumerate(weights)]))
        knots = self._knots(tuple(first.tolist()), window)
        return np.asarray(np.array(rows) @ knots).reshape(len(rows), DEGREE + 1, window[1] - window[0])

    @property
    def tabulated(self) -> bool:
        """Whether there is a table over the coordinates; otherwise each is solved where it is asked for."""
        return len(self.coordinates) <= _TABULATED and all(c.tabulated for c in self.coordinates)

    def _solved(self, q: Sequence[float], window: Window) -> Array:
        """Splines without knots; derivatives by the coordinates from differences, taken anew beyond the distance of knots."""
        here, steps = self._spline(tuple(q), window), [c.step for c in self.coordinates]
        if self._slopes is None or self._slopes[0] != window or np.any(np.abs(self._slopes[1] - q) > steps):
            rows = []
            for j, c in enumerate(self.coordinates):
                rows.append(self._slope(q, j, shift(c, q[j]), here, window))
            self._slopes = (window, np.array(q), np.array(rows))
        return np.concatenate([here[None], self._slopes[2]])

    def _slope(self, q: Sequence[float], j: int, shift: float, here: Array, window: Window) -> Array:
        """Derivative of splines by a coordinate, from the side on which there is such a problem."""

        def towards(step: float) -> Array:
            moved = tuple(value + step * (i == j) for i, value in enumerate(q))
            return np.asarray((self._spline(moved, window) - here) / step)

        try:
            return towards(shift)
        except ValueError:
            return towards(-shift)

    def _widened(self, highest: float) -> Window:
        """The window grown in thirds of a decade, so that neighbouring curves share it."""
        chunk = PER_DECADE // 3
        top = chunk * int(np.ceil(highest / STEP / chunk))
        low, high = self._window
        if high < low:
            return top - self.decades * PER_DECADE, top
        if top > high or top < high - self.decades * PER_DECADE // 2:
            return min(low, top - self.decades * PER_DECADE), max(top, high)
        return self._window

    def _knot(self, index: tuple[int, ...], window: Window) -> Array:
        if (window, index) not in self._pieces:
            self._pieces[window, index] = self._spline(self._values(index), window, self._nodes.setdefault(index, {}))
            PROCESS.grown(2 * self._pieces[window, index].nbytes)
        return self._pieces[window, index]

    def _spline(self, q: tuple[float, ...], window: Window, nodes: dict[int, float] | None = None) -> Array:
        """Coefficients of ln phi at coordinates q, from solved nodes and those that are missing."""
        low, high = window
        nodes = {} if nodes is None else nodes
        self._count += 1
        with reporting("Solving", None) as report:
            report(self._count, 0)
        wanted = [i for i in range(low - _MARGIN, high + _MARGIN + 1) if i not in nodes]
        if wanted:
            phi = self.solve(q, np.exp(STEP * np.array(wanted)))
            # without sign where the theory has no answer, zero where rounding hides it: such nodes are left out below
            with np.errstate(invalid="ignore", divide="ignore"):
                nodes.update(zip(wanted, np.log(phi).tolist(), strict=True))
        grid = [i for i in range(low - _MARGIN, high + _MARGIN + 1) if np.isfinite(nodes[i])]
        spline = make_interp_spline(np.array(grid, dtype=float), [nodes[i] for i in grid], k=DEGREE)
        factorial = np.array([1, 1, 2, 6, 24, 120], dtype=float)
        starts = np.arange(low, high)
        pieces = np.array([spline(starts, nu=k) / factorial[k] for k in range(DEGREE, -1, -1)])
        # beyond what the tip or the theory allows the curve goes on as a power law, so that a trial step does not fail
        beyond = starts >= grid[-1]
        slope = float(spline(grid[-1], nu=1))
        pieces[:, beyond] = 0.0
        pieces[-1, beyond] = float(spline(grid[-1])) + slope * (starts[beyond] - grid[-1])
        pieces[-2, beyond] = slope
        return pieces


def _alike(first: Indices) -> Iterator[tuple[tuple[int, ...], Indices]]:
    """Different rows of an array of integers, and which rows are equal to each."""
    if first.shape[1] == 0 or (first == first[0]).all():
        yield tuple(first[0].tolist()), np.arange(len(first))
        return
    least = first.min(axis=0)
    key = np.ravel_multi_index((first - least).T, first.max(axis=0) - least + 1)
    for each in np.unique(key):
        mine = np.flatnonzero(key == each)
        yield tuple(first[mine[0]].tolist()), mine


_LAGRANGE = np.linalg.inv(np.vander(np.arange(KNOTS) - (KNOTS - 1) / 2, KNOTS))
"""Lagrange polynomials of the knots, in powers of the distance from their middle."""


def _powers(t: Array) -> Array:
    """Powers of the distance from the middle of knots at 0 .. 5, shape (n, 6), at positions t, shape (n,)."""
    return np.vander(t - (KNOTS - 1) / 2, KNOTS)


def _tensor(factors: Iterable[Array]) -> Array:
    """All products of one entry of each, in the order of `itertools.product`."""
    result = np.ones(1)
    for each in factors:
        result = np.outer(result, each).ravel()
    return result
