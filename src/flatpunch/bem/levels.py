"""Nested grids: solve on coarse cells first, carry the pressure to finer ones, and finish where it was asked for.

The fine grid then only corrects the rim of the contact, and at given force starts with a depth and a stiffness that are
nearly right: F(d) = F_wanted is solved by Newton's method with the stiffness dF/dd of a flat punch under the present
contact, which the next coarser grid knows well enough.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates

from flatpunch._validation import Array
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator import Operator, build_operator
from flatpunch.bem.solver import State, punch_stiffness, solve_contact
from flatpunch.compliance import Kernel

_COARSEST = 32
_COARSE_TOLERANCE = 1e-4
_NEWTON_STEPS = 40


@dataclass(frozen=True)
class Levels:
    """Operators of one medium on a grid and on its coarser companions.

    Attributes
    ----------
    kernel : Kernel
        Compliance of the medium.
    grid : Grid
        The finest grid.
    xp : module
        Array namespace.
    single : bool
        Whether everything is done in single precision.
    """

    kernel: Kernel
    grid: Grid
    xp: Any = np
    single: bool = False

    @cached_property
    def coarser(self) -> Levels | None:
        """The next coarser level; None on the coarsest."""
        if min(self.grid.shape) < 2 * _COARSEST:
            return None
        coarse = self.grid.coarser()
        return None if coarse is None else replace(self, grid=coarse)

    @cached_property
    def operator(self) -> Operator:
        """Operator of the outer loop."""
        built = build_operator(self.kernel, self.grid, xp=self.xp)
        return built.single() if self.single else built

    @cached_property
    def inner(self) -> Operator:
        """Operator of the inner loop."""
        return self.operator if self.single else self.operator.single()

    def cells(self, height: Callable[[Grid], Array]) -> Any:
        """Gap at first touch in units of a cell, shape (ny, nx)."""
        return self.operator.asarray(height(self.grid) / self.grid.spacing)


@dataclass(frozen=True, slots=True)
class Effort:
    """What a nested solve took: inner iterations per level (finest last) and whether the force was met."""

    iterations: tuple[int, ...]
    force_error: float = 0.0


def solve_depth(
    levels: Levels, height: Callable[[Grid], Array], depth: float, tolerance: float, limit: int, start: Any = None
) -> tuple[State, Effort]:
    """Contact at a depth [m], from the coarsest level up; `start` replaces the coarser levels."""
    before: tuple[int, ...] = ()
    coarser = levels.coarser
    if start is None and coarser is not None:
        state, effort = solve_depth(coarser, height, depth, max(tolerance, _COARSE_TOLERANCE), limit)
        before, start = effort.iterations, prolong(state.pressure, coarser, levels)
    state = _solve(levels, levels.cells(height), depth, start, tolerance, limit)
    return state, Effort((*before, state.iterations))


def solve_force(
    levels: Levels, height: Callable[[Grid], Array], force: float, guess: float, tolerance: float, limit: int
) -> tuple[State, Effort]:
    """Contact at a force [N], from the coarsest level up; `guess` is any depth [m] of the right order."""
    before: tuple[int, ...] = ()
    start, stiffness, coarser = None, 0.0, levels.coarser
    depth = guess
    if coarser is not None:
        state, effort = solve_force(coarser, height, force, guess, max(tolerance, _COARSE_TOLERANCE / 10), limit)
        before, start = effort.iterations, prolong(state.pressure, coarser, levels)
        depth = state.depth * coarser.grid.spacing
        stiffness = _stiffness(coarser, state)
    unit = levels.kernel.modulus * levels.grid.spacing**2
    cells, iterations, missing = levels.cells(height), 0, 1.0
    for _ in range(_NEWTON_STEPS):
        # no need to know the force of a wrong depth better than the depth itself
        wanted = tolerance if coarser is not None else max(tolerance, min(1e-2, abs(missing) * 1e-2))
        state = _solve(levels, cells, depth, start, wanted, limit - iterations)
        iterations, start = iterations + state.iterations, state.pressure
        missing = 1 - state.force * unit / force
        if (abs(missing) <= tolerance and wanted <= tolerance) or iterations >= limit:
            break
        if coarser is None:
            stiffness = _stiffness(levels, state)
        depth = max(depth + missing * force / stiffness, depth / 4)
    return state, Effort((*before, iterations), abs(missing))


def _solve(levels: Levels, cells: Any, depth: float, start: Any, tolerance: float, limit: int) -> State:
    return solve_contact(
        levels.operator,
        cells,
        depth / levels.grid.spacing,
        start=start,
        inner=levels.inner,
        tolerance=tolerance,
        limit=limit,
    )


def _stiffness(levels: Levels, state: State) -> float:
    """dF/dd [N/m] to a few per cent, from the punch under the present contact."""
    return punch_stiffness(levels.inner, state.contact)[1] * levels.kernel.modulus * levels.grid.spacing


def prolong(pressure: Any, coarse: Levels, fine: Levels) -> Any:
    """Pressure of a coarse grid on a finer one: p^2, linear at the rim of a smooth contact, is interpolated linearly."""
    gc, gf = coarse.grid, fine.grid
    y = (gf.y - gc.y[0]) / gc.spacing
    x = (gf.x - gc.x[0]) / gc.spacing
    values = to_numpy(pressure).astype(float)
    sampled = map_coordinates(values**2, np.meshgrid(y, x, indexing="ij"), order=1, mode="constant")
    return fine.operator.asarray(np.sqrt(sampled))


def to_numpy(values: Any) -> Array:
    """Array of any library as a NumPy array in main memory."""
    if hasattr(values, "get"):
        values = values.get()
    elif hasattr(values, "cpu"):
        values = values.cpu()
    return np.asarray(values)
