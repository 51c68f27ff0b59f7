"""Stable branch of an adhesive contact at given parameters, with all derivatives, and where it lets go.

It is made of the functions of `flatpunch.fits.adhesion.tables`, and followed from the largest contact down to where d_x vanishes:
pull-off under prescribed depth. From two per cent in radius before it, or from where dF/dd falls below a given stiffness, the
force goes on as a straight line, so that a trial step that lets go too early still has a slope.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import ROUNDING, Array
from flatpunch.fits.adhesion.tables import BranchTables, flat_end
from flatpunch.fits.elastic.table import STEP, Piecewise
from flatpunch.numerics.chebyshev import NODES, derivative, polynomials

_TOUCHING = 1e-4
"""Contact radius over c below which the surfaces are taken not to touch; depth and force change by up to as much."""

_BORDER = 1e-5
"""s over b below which the contact is all of a flat end, and no more; depth and force change by up to as much."""

_GRID = 600
"""Points of the branch from which Newton's method begins."""


@dataclass(frozen=True, slots=True)
class BranchState:
    """The branch at n values of x.

    Attributes
    ----------
    depth, force : ndarray, shape (n,)
        d [m], F [N].
    depth_slope, force_slope : ndarray, shape (n,)
        Their derivatives over x.
    depth_by, force_by : ndarray, shape (parameters, n)
        Their derivatives over theta at constant x.
    """

    depth: Array
    force: Array
    depth_slope: Array
    force_slope: Array
    depth_by: Array
    force_by: Array


@dataclass(eq=False)
class StableBranch:
    """The branch at given parameters, from pull-off up.

    Parameters
    ----------
    forms : ndarray, shape (forms + coordinates,)
        ln d0, ln F0, ln (w l/E)^(1/2), ln (w E l^3)^(1/2), with a range of action ln z0, ln (s0 l/E), ln (s0 l^2), and q.
    weights : ndarray, shape (forms + coordinates, parameters)
        Their derivatives over theta.
    tables : BranchTables
        f_0 to f_5.

    Attributes
    ----------
    top, fold : float
        x at the largest contact and at pull-off, once `up_to` has been called.
    edge, touch : float
        x below which the surfaces do not touch, and ln(c/l) there; beside a flat end x below which the contact is not all of it.
    """

    forms: Array
    weights: Array
    tables: BranchTables
    top: float = 0.0
    fold: float = 0.0
    edge: float = -np.inf
    touch: float = 0.0
    _pieces: tuple[Piecewise, ...] = ()
    _apart: tuple[Piecewise, ...] = ()
    _flat: Array | None = None
    _grid: tuple[Array, Array] | None = None

    @property
    def _q(self) -> tuple[float, ...]:
        return tuple(self.forms[self.forms.size - len(self.tables.family.coordinates) :])

    def up_to(self, deepest: float, softest: float = -np.inf) -> StableBranch:
        """Choose the largest radius, and find pull-off below it; the branch begins where dF/dd is `softest` [N/m], or there."""
        q = self._q
        top = self.tables.begin(q, self.forms, deepest)
        most = self.tables.functions[0].highest(q) - 3 * STEP
        for _ in range(400):
            top = min(top, most)
            self._pieces = tuple(table.at(q, top) for table in self.tables.functions)
            depth, rising = self._depths(np.array([top]))
            if (depth[0] >= deepest and depth[0] > 0 and rising[0] > 0) or top >= most:
                break
            top += 4 * STEP
        self.top = top
        self._find_edge(q)
        # six decades, over which pull-off is looked for: to a millionth of the depth at the border of a flat end; and three of c
        lowest = min(top - 6 * np.log(10), self.edge - 3 * np.log(10) if self._apart else np.inf)
        x = np.append(np.arange(lowest, top - STEP / 2, STEP), top)
        if self._flat is not None:
            # the depth rises like s from the border of the flat, which rounding hides beside it; and the first panel is empty
            # where the surfaces touch as soon as adhesion acts beyond the border
            value, *others = np.abs(self._flat[0, 0, 0])
            empty = max(others) <= ROUNDING * value
            over = np.arange(self.edge - (1 if empty else 2), self.edge, STEP)
            x = np.append(over, x[x > self.edge - np.log(_BORDER) / 2])
        _, rising = self._depths(x)
        below = np.flatnonzero(rising <= 0)
        self.fold = float(x[0])
        if below.size and below[-1] + 1 < x.size:
            low, high = x[below[-1]], x[below[-1] + 1]
            for _ in range(40):
                middle = (low + high) / 2
                if self._depths(np.array([middle]))[1][0] > 0:
                    high = middle
                else:
                    low = middle
            self.fold = float(high)
        # denser towards pull-off, where the depth goes like the square of the distance in x
        # distance in ln a before pull-off from which the branch is continued by its tangent
        start = min(self.fold + 0.02, self.top - STEP)
        if np.isfinite(softest):
            start = self._stiffer(start, softest)
        grid = start + (self.top - start) * np.linspace(0, 1, _GRID) ** 2
        if start < self.edge < self.top:
            # no cell on both sides of it; next to it the depth of tables may fall by their error
            grid[np.argmin(np.abs(grid - self.edge))] = self.edge
        self._grid = (grid, np.maximum.accumulate(self._depths(grid)[0]))
        return self

    def _find_edge(self, q: tuple[float, ...]) -> None:
        """Find where the surfaces no longer touch, if that is not far below the table, where pull-off is long past."""
        family = self.tables.family
        if not family.by_range:
            return
        if not self.tables.apart:
            _, indenter = family.branch(q)
            self.edge, self._flat = float(np.log(_BORDER * flat_end(indenter))), self.tables.over_flat(q)
            return
        lowest = self._pieces[3].start
        tension = self._pieces[3].at(np.array([lowest]))[0][0] + self.forms[3]
        touch = float(tension - np.log(np.pi) - self.forms[6]) / 2
        edge = max(touch + np.log(_TOUCHING), lowest)
        if edge < touch - np.log(10):
            self.edge, self.touch = edge, touch
            self._apart = tuple(table.at(q[: len(table.coordinates)], touch) for table in self.tables.apart)

    def _stiffer(self, start: float, softest: float) -> float:
        """Smallest x from `start` on with a stiffness of `softest` or more; dF/dd grows along the branch."""
        for _ in range(2):
            x = np.linspace(start, self.top - STEP, _GRID // 4)
            state = self.at(x)
            below = np.flatnonzero(state.force_slope < softest * state.depth_slope)
            if not below.size:
                return start
            start = float(x[below[-1]])
            end = float(x[min(below[-1] + 1, x.size - 1)])
        return end

    def _depths(self, x: Array) -> tuple[Array, Array]:
        """Depth and its slope."""
        (plain, up, _), (back, fall, _) = self._pieces[0].at(x), self._pieces[2].at(x)
        plain, back = np.exp(plain + self.forms[0]), np.exp(back + self.forms[2])
        depth, rising = plain - back, plain * up - back * fall
        if (apart := x < self.edge).any():
            beyond = self._apart_at(x[apart])
            depth[apart], rising[apart] = beyond.depth, beyond.depth_slope
        return depth, rising

    def opening(self, deepest: float) -> float:
        """Depth of the adhesive contact whose radius is that without adhesion at `deepest`."""
        assert self._grid is not None
        grid, depths = self._grid
        plain = np.exp(self._pieces[0].at(grid)[0] + self.forms[0])
        return float(np.interp(deepest, plain, depths))

    def radius_at(self, depth: Array) -> tuple[Array, Array]:
        """x at depths, and the distance of depths beyond the ends of the branch [m]."""
        assert self._grid is not None
        grid, depths = self._grid
        inside = np.clip(depth, depths[0], depths[-1])
        cell = np.clip(np.searchsorted(depths, inside), 1, grid.size - 1)
        low, high = grid[cell - 1], grid[cell]
        x = np.interp(inside, depths, grid)
        # turns of Newton's method at most; four are usual
        for _ in range(6):
            value, rising = self._depths(x)
            trial = np.clip(x - (value - inside) / rising, low, high)
            moved = float(np.abs(trial - x).max(initial=0.0))
            x = trial
            # quadratic convergence
            if moved < 1e-7:
                break
        return x, depth - inside

    def at(self, x: Array) -> BranchState:
        """Everything at given x."""
        parts = [self._scaled(i, piece, x) for i, piece in enumerate(self._pieces)]
        (d, d_x, d_by), (f, f_x, f_by) = (
            tuple(a - b for a, b in zip(plain, less, strict=True))
            for plain, less in zip(parts[:2], parts[2:], strict=True)
        )
        state = BranchState(d, f, d_x, f_x, d_by, f_by)
        if (apart := x < self.edge).any():
            beyond = self._apart_at(x[apart])
            for name in BranchState.__slots__:
                getattr(state, name)[..., apart] = getattr(beyond, name)
        return state

    def _scaled(self, form: int, piece: Piecewise, x: Array) -> tuple[Array, Array, Array]:
        """A function times its unit, its slope and its derivatives over theta."""
        value, rising, others = piece.at(x)
        part = np.exp(value + self.forms[form])
        first = self.forms.size - len(self.tables.family.coordinates)
        log_by = self.weights[form][:, None] + self.weights[first : first + len(others)].T @ others
        return part, part * rising, part * log_by

    def _over_flat_at(self, x: Array, series: Array) -> BranchState:
        """Contacts that are not all of a flat end, on panels of width 1 in x."""
        v = np.clip(x - self.edge + 2, 0.0, 2.0)
        panel = (v >= 1).astype(int)
        basis, first = polynomials(2 * (v - panel) - 1), self.forms.size - len(self.tables.family.coordinates)
        columns = []
        for form in range(2):
            # by the coordinates too, shape (1 + coordinates, n, terms)
            parts = np.exp(self.forms[form]) * series[:, panel, form]
            value, *others = np.sum(parts * basis.T, axis=2)
            rising = 2 * np.sum(parts[0] @ derivative(NODES).T * basis[:-1].T, axis=1)
            by = self.weights[form][:, None] * value
            columns.append((value, rising, by + self.weights[first:].T @ np.reshape(others, (-1, x.size))))
        (d, d_x, d_by), (f, f_x, f_by) = columns
        return BranchState(d, f, d_x, f_x, d_by, f_by)

    def _apart_at(self, x: Array) -> BranchState:
        """Surfaces that attract one another and do not touch."""
        if self._flat is not None:
            return self._over_flat_at(x, self._flat)
        y = x - self.edge + self.touch
        height, lift = (self._scaled(i, piece, y) for i, piece in zip((0, 5), self._apart, strict=True))
        pull = -np.pi * np.exp(2 * y + self.forms[6])
        reach = np.exp(self.forms[4])
        d, d_x, d_by = (a - b for a, b in zip(height, lift, strict=True))
        d_by = d_by - reach * self.weights[4][:, None]
        return BranchState(d - reach, pull, d_x, 2 * pull, d_by, pull * self.weights[6][:, None])
