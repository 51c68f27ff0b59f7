"""Stable branch of an adhesive contact (JKR) at given parameters: depth and force over the contact radius, and where it lets go.

Along the branch of contact radii a of (T11.1), as `flatpunch.contact.adhesion.branch` has it,

    d = d_n - D,    F = F_n - T;    d_n = d0 exp f_0,  F_n = F0 exp f_1,  D = (w l/E)^(1/2) exp f_2,  T = (w E l^3)^(1/2) exp f_3

with f smooth functions of x = ln(a/l) and of the numbers q of `flatpunch.fit.parameters.scaling`, tabulated like the force
without adhesion (`flatpunch.fit.adhesion.tables`).

The branch is followed from the largest contact down to where d_x vanishes: pull-off under prescribed depth. From two per cent
in radius before it, or from where dF/dd falls below a given stiffness, the force goes on as a straight line, so that a trial
step that lets go too early still has a slope.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.adhesion.tables import FUNCTIONS, BranchTables
from flatpunch.fit.elastic.table import STEP, Piecewise

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
    forms : ndarray, shape (4 + coordinates,)
        ln d0, ln F0, ln (w l/E)^(1/2), ln (w E l^3)^(1/2), q.
    weights : ndarray, shape (4 + coordinates, parameters)
        Their derivatives over theta.
    tables : BranchTables
        f_0 to f_3.

    Attributes
    ----------
    top, fold : float
        x at the largest contact and at pull-off, once `up_to` has been called.
    """

    forms: Array
    weights: Array
    tables: BranchTables
    top: float = 0.0
    fold: float = 0.0
    _pieces: tuple[Piecewise, ...] = ()
    _grid: tuple[Array, Array] | None = None

    def up_to(self, deepest: float, softest: float = -np.inf) -> StableBranch:
        """Choose the largest radius, and find pull-off below it; the branch begins where dF/dd is `softest` [N/m], or there."""
        q = tuple(self.forms[FUNCTIONS:])
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
        # decades of radius over which pull-off is looked for
        x = np.linspace(top - 6.0 * np.log(10), top, 40 * int(6.0))
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
        self._grid = (grid, self._depths(grid)[0])
        return self

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
        return plain - back, plain * up - back * fall

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
        parts, slopes, by = [], [], []
        for i, piece in enumerate(self._pieces):
            value, rising, others = piece.at(x)
            part = np.exp(value + self.forms[i])
            log_by = np.repeat(self.weights[i][:, None], x.size, axis=1)
            for j, other in enumerate(others):
                log_by += self.weights[FUNCTIONS + j][:, None] * other
            parts.append(part)
            slopes.append(part * rising)
            by.append(part * log_by)
        return BranchState(
            parts[0] - parts[2],
            parts[1] - parts[3],
            slopes[0] - slopes[2],
            slopes[1] - slopes[3],
            by[0] - by[2],
            by[1] - by[3],
        )
