"""Contacts on nested grids: solve on coarse cells first, interpolate the pressure to finer ones, and finish on the given grid.

The fine grid then only corrects the rim of the contact, and at given force starts with a depth and a stiffness that are
nearly right: F(d) = F_wanted is solved by Newton's method with the stiffness dF/dd of a flat punch under the present
contact, which the next coarser grid knows well enough.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.bem.grid import Cells, Grid, Height
from flatpunch.bem.operator.convolution import SINGLE_FLOOR, to_numpy
from flatpunch.bem.solver.active_set import Aim, State, punch_stiffness, solve_contact
from flatpunch.bem.solver.levels import Levels, mirror_axes

COARSE_TOLERANCE = 1e-4
"""Largest tolerance of coarser grids, whose forces enter error estimates; at twice or half, forces change by 1e-10."""


@dataclass(frozen=True, slots=True)
class Effort:
    """Inner iterations of a nested solve per level (finest last), whether the force was met, and forces on coarser cells.

    The latter are the forces [N] on cells twice and four times as wide at the same depth; NaN where these were not solved.
    """

    iterations: tuple[int, ...]
    force_error: float = 0.0
    coarser_force: float = float("nan")
    coarsest_force: float = float("nan")


@dataclass(frozen=True, slots=True)
class Punch:
    """Flat punch under a contact: its pressure on a grid up to a factor, and its stiffness dF/dd [N/m] to a few per cent.

    `foresees` turns false when the force it foretold on some grid was not the one that came.
    """

    grid: Grid
    pressure: Array
    stiffness: float
    foresees: bool = True

    def share(self, grid: Grid) -> Array:
        """Share of its force that each cell of a grid carries."""
        pressure = sampled(self.pressure, self.grid, grid)
        return np.asarray(pressure / (grid.copies * pressure.sum()))


def solve_depth(
    levels: Levels,
    height: Height,
    depth: float,
    tolerance: float,
    limit: int,
    start: Cells = None,
    *,
    rough: Rough | None = None,
) -> tuple[State, Effort]:
    """Contact at a depth [m], from the coarsest level up; `start` replaces the coarser levels, `rough` the coarsest of them."""
    folded, cells = levels.folded_to(height)
    if start is not None:
        start = folded.kept(start)
    state, effort = _nested_depth(folded, height, cells, depth, tolerance, limit, start, rough)
    return folded.unfolded_state(state), effort


@dataclass(frozen=True, slots=True)
class Rough:
    """Pressure [E*] of an approximate contact, on a coarse grid."""

    grid: Grid
    pressure: Array


def _nested_depth(
    levels: Levels,
    height: Height,
    cells: Cells,
    depth: float,
    tolerance: float,
    limit: int,
    start: Cells,
    rough: Rough | None,
    *,
    finest: bool = True,
) -> tuple[State, Effort]:
    before: tuple[int, ...] = ()
    coarser, coarser_force, coarsest_force = levels.coarser, float("nan"), float("nan")
    if start is None and coarser is not None:
        # the level below the finest is always solved: the difference of their forces estimates the error
        if rough is not None and not finest and _cells(coarser.grid) <= _cells(rough.grid):
            start = levels.asarray(prolong(rough.pressure, rough.grid, levels.grid))
        else:
            looser = max(tolerance, min(COARSE_TOLERANCE, 10 * tolerance))
            state, effort = _nested_depth(
                coarser, height, coarser.cells(height), depth, looser, limit, None, rough, finest=False
            )
            before, start = effort.iterations, levels.asarray(prolong(state.pressure, coarser.grid, levels.grid))
            coarser_force, coarsest_force = state.force * coarser.unit, effort.coarser_force
    taken = 0
    window = None if start is None else levels.window(start)
    if window is not None:
        part = _solve(window.levels, window.cut(cells), depth, window.cut(start), tolerance, limit)
        taken, start = part.iterations, window.embed(part.pressure)
    state = _solve(levels, cells, depth, start, tolerance, limit - taken)
    iterations = (*before, taken + state.iterations)
    return state, Effort(iterations, coarser_force=coarser_force, coarsest_force=coarsest_force)


def solve_force(
    levels: Levels, height: Height, force: float, guess: float, tolerance: float, limit: int
) -> tuple[State, Effort]:
    """Contact at a force [N], from the coarsest level up; `guess` is any depth [m] of the right order."""
    folded, cells = levels.folded_to(height)
    state, effort, _ = _nested_force(folded, height, cells, force, guess, tolerance, limit)
    return folded.unfolded_state(state), effort


def solve_stiffness(levels: Levels, contact: Cells, tolerance: float) -> float:
    """Stiffness dF/dd [N/m] of a flat punch under a contact on the finest grid."""
    folded = levels.folded(mirror_axes(levels, to_numpy(contact)))
    part, contact = folded.around(folded.kept(contact))
    operator = part.inner if tolerance >= SINGLE_FLOOR else part.operator
    stiffness = punch_stiffness(operator, contact, tolerance)[1]
    return stiffness * levels.kernel.modulus * levels.grid.spacing


def _nested_force(
    levels: Levels,
    height: Height,
    cells: Cells,
    force: float,
    guess: float,
    tolerance: float,
    limit: int,
) -> tuple[State, Effort, Punch | None]:
    coarser = levels.coarser
    if coarser is None:
        state, taken, missing, _ = _newton(levels, cells, force, guess, None, None, tolerance, limit)
        return state, Effort((taken,), missing), None
    coarse_tolerance = max(tolerance, COARSE_TOLERANCE / 10)
    state, effort, punch = _nested_force(coarser, height, coarser.cells(height), force, guess, coarse_tolerance, limit)
    start, depth = (
        levels.asarray(prolong(state.pressure, coarser.grid, levels.grid)),
        state.depth * coarser.grid.spacing,
    )
    coarser_depth = depth
    punch = replace(_punch(coarser, state), foresees=punch is None or punch.foresees)
    taken = 0
    window = levels.window(start)
    if window is not None:
        part, taken, missing, punch = _newton(
            window.levels, window.cut(cells), force, depth, window.cut(start), punch, tolerance, limit
        )
        start, depth = window.embed(part.pressure), part.depth * levels.grid.spacing
    state, more, missing, punch = _newton(
        levels, cells, force, depth, start, punch, tolerance, limit - taken, follow=window is None
    )
    # another depth for the same force corresponds to another force at the same depth
    changed = state.depth * levels.grid.spacing - coarser_depth
    coarser_force = force + punch.stiffness * changed if punch is not None else float("nan")
    coarsest_force = coarser_force + effort.coarser_force - force
    return state, Effort((*effort.iterations, taken + more), missing, coarser_force, coarsest_force), punch


def _newton(
    levels: Levels,
    cells: Cells,
    force: float,
    depth: float,
    start: Cells,
    punch: Punch | None,
    tolerance: float,
    limit: int,
    *,
    follow: bool = True,
) -> tuple[State, int, float, Punch | None]:
    """Contact at a force on one grid, with iterations, the relative error of force and the punch as far as it is still of use.

    Without a punch, which gives the change of the force, the depth may be far off and is not worth a precise solve before it is
    near; with one the depth may `follow` within the solve, which pays unless the depth is right already.
    """
    spacing, modulus, unit = levels.grid.spacing, levels.kernel.modulus, levels.unit
    iterations, missing, aim = 0, 1.0, None
    stiffness = 0.0 if punch is None else punch.stiffness
    if punch is not None and punch.foresees and follow:
        share = levels.asarray(punch.share(levels.grid))
        aim = Aim(force / unit, stiffness / (modulus * spacing), share * (stiffness / (modulus * spacing)))
    # most Newton steps towards a force on one grid; three or four are usual, and half as many would do
    for _ in range(40):
        wanted = max(tolerance, min(1e-2, abs(missing) * 1e-2)) if punch is None else tolerance
        if stiffness > 0:
            # a gap adds stiffness times the gap to the force
            wanted *= min(1.0, force / (stiffness * depth))
        state = _solve(levels, cells, depth, start, wanted, limit - iterations, aim)
        iterations, start = iterations + state.iterations, state.pressure
        if punch is not None and aim is not None and state.depth == depth / spacing:
            punch = replace(punch, foresees=False)
        depth, before = state.depth * spacing, missing
        missing = 1 - state.force * unit / force
        if (abs(missing) <= tolerance and wanted <= tolerance) or iterations >= limit:
            break
        if not state.contact.any():
            # no cell is that low: the force grows from the depth of the lowest on
            state = replace(state, contact=cells == cells.min())
            depth = float(cells.min()) * spacing
            stiffness = _punch(levels, state).stiffness
        elif punch is None or abs(missing) > abs(before) / 2:
            stiffness = _punch(levels, state).stiffness
        aim, depth = None, max(depth + missing * force / stiffness, depth / 4)
    return state, iterations, abs(missing), punch


def _solve(
    levels: Levels,
    cells: Cells,
    depth: float,
    start: Cells,
    tolerance: float,
    limit: int,
    aim: Aim | None = None,
) -> State:
    return solve_contact(
        levels.operator,
        cells,
        depth / levels.grid.spacing,
        start=start,
        inner=levels.inner,
        aim=aim,
        tolerance=tolerance,
        limit=limit,
    )


def _punch(levels: Levels, state: State) -> Punch:
    pressure, stiffness, _, _ = punch_stiffness(levels.inner, state.contact)
    return Punch(levels.grid, to_numpy(pressure).astype(float), stiffness * levels.kernel.modulus * levels.grid.spacing)


def _cells(grid: Grid) -> int:
    """Number of cells, copies included."""
    return grid.nx * grid.ny * grid.copies


def prolong(pressure: Cells, coarse: Grid, fine: Grid) -> Array:
    """Pressure of a coarse grid on a finer one: p^2, linear at the rim of a smooth contact, is interpolated linearly."""
    squared = beyond_the_rim(to_numpy(pressure).astype(float) ** 2)
    return np.asarray(np.sqrt(np.maximum(sampled(squared, coarse, fine), 0.0)))


def sampled(values: Array, coarse: Grid, fine: Grid) -> Array:
    """Values of one grid at the cells of another, linear between them and zero beyond."""
    along_x, along_y = coarse.mirrored
    # a ring of zeros around, or on the other side of a mirror the first cells again
    padded = np.pad(values, 1)
    if along_y:
        padded[0] = padded[1]
    if along_x:
        padded[:, 0] = padded[:, 1]
    y, x = ((f - c[0]) / coarse.spacing + 1 for f, c in ((fine.y, coarse.y), (fine.x, coarse.x)))
    between_rows = _between(padded, y)
    return np.asarray(_between(between_rows.T, x).T)


def _between(values: Array, position: Array) -> Array:
    """Rows at fractional positions, those at the ends beyond them."""
    position = np.clip(position, 0.0, values.shape[0] - 1.0)
    low = np.minimum(position.astype(np.intp), values.shape[0] - 2)
    share = (position - low)[:, None]
    return np.asarray((1 - share) * values[low] + share * values[low + 1])


def beyond_the_rim(squared: Array) -> Array:
    """p^2 continued to the cells next to the contact, where it is negative: else the contact grows by half a cell.

    Only half of the linear continuation is taken: a start too wide is corrected more easily than one too narrow, and
    the rim of the coarse grid is itself known to a fraction of a cell only. Beside a single cell, of which no slope is known,
    the rim is put on the cell's own: lobes two cells wide would else become half as wide again.
    """
    ny, nx = squared.shape
    padded, empty = np.pad(squared, 2), squared == 0
    total, sides = np.zeros_like(squared), np.zeros_like(squared)
    for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        first, second = (padded[2 + n * dy : 2 + n * dy + ny, 2 + n * dx : 2 + n * dx + nx] for n in (1, 2))
        known = empty & (first > 0)
        total += np.where(known, np.where(second > 0, np.minimum(2 * first - second, 0.0), -first), 0.0)
        sides += known
    return np.asarray(squared + 0.5 * total / np.maximum(sides, 1.0))
