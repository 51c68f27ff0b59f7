"""Nested grids: solve on coarse cells first, carry the pressure to finer ones, and finish where it was asked for.

The fine grid then only corrects the rim of the contact, and at given force starts with a depth and a stiffness that are
nearly right: F(d) = F_wanted is solved by Newton's method with the stiffness dF/dd of a flat punch under the present
contact, which the next coarser grid knows well enough.

Where the indenter is its own mirror image the contact is too, as it is unique, and half of the grid or a quarter is enough.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from flatpunch._validation import Array
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator import SINGLE_FLOOR, Operator, build_operator, coefficients_for, padded_shape, to_numpy
from flatpunch.bem.prolongation import prolong, sampled
from flatpunch.bem.solver import Aim, State, punch_stiffness, solve_contact
from flatpunch.compliance import Kernel

_COARSEST, _NARROWEST = 32, 16
"""Square root of the cells of the coarsest grid, and the fewest along an axis."""
_COARSE_TOLERANCE, _LOOSER = 1e-4, 10
"""Tolerance of coarser grids at most, and over that of the next finer one: their forces are told as well."""
_NEWTON_STEPS = 40

_PUNCH_CELLS = 144**2
"""Cells from which on the punch that tells how the force answers to the depth is the one of coarser cells."""

_RIM = 4
"""Cells left around the contact of a coarser grid, whose rim is known to two cells."""

_EVEN = 1e-12
"""Differences up to which heights are taken for mirror images, relative and in cells: polar angles are rounded."""

_WORTHWHILE = 0.8
"""Share of the grid above which a window is not worth its own coefficients."""


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
    shared : ndarray, optional
        Influence coefficients of a grid that this one is a part of [m/Pa].
    """

    kernel: Kernel
    grid: Grid
    xp: Any = np
    single: bool = False
    shared: Array | None = field(default=None, repr=False, compare=False)

    @cached_property
    def coarser(self) -> Levels | None:
        """The next coarser level; None on the coarsest."""
        whole = self.grid.unfolded
        if min(whole.shape) < 2 * _NARROWEST or whole.nx * whole.ny < (2 * _COARSEST) ** 2:
            return None
        coarse = self.grid.coarser()
        return None if coarse is None else replace(self, grid=coarse, shared=None)

    @cached_property
    def operator(self) -> Operator:
        """Operator of the outer loop."""
        built = build_operator(self.kernel, self.grid, xp=self.xp, coefficients=self.coefficients)
        return built.single() if self.single else built

    @cached_property
    def coefficients(self) -> Array:
        """Influence coefficients [m/Pa]; those of a window are some of the whole grid's."""
        if self.shared is None:
            return coefficients_for(self.kernel, self.grid)
        my, mx = padded_shape(self.grid)
        return self.shared[: my // 2 + 1, : mx // 2 + 1]

    @cached_property
    def inner(self) -> Operator:
        """Operator of the inner loop."""
        return self.operator if self.single else self.operator.single()

    def window(self, pressure: Any) -> Window | None:
        """The part of the grid around the contact of a pressure, which is kept; None where that would save little."""
        contact = to_numpy(pressure) > 0
        rows, columns = np.flatnonzero(contact.any(axis=1)), np.flatnonzero(contact.any(axis=0))
        if rows.size == 0:
            return None
        cut, mirrored = [], self.grid.mirrored
        for used, cells, half in ((columns, self.grid.nx, mirrored[0]), (rows, self.grid.ny, mirrored[1])):
            rim = max(_RIM, int(0.03 * used.size * (1 + half)))
            cut.append((0 if half else max(0, int(used[0]) - rim), min(cells, int(used[-1]) + 1 + rim)))
        (x0, x1), (y0, y1) = cut
        size = (x1 - x0) * (1 + mirrored[0]), (y1 - y0) * (1 + mirrored[1])
        if (y1 - y0) * (x1 - x0) > _WORTHWHILE * contact.size or min(size) < _COARSEST:
            return None
        part = replace(self, grid=self.grid.part(slice(y0, y1), slice(x0, x1)), shared=self.coefficients)
        self._windows[:] = [Window(part, slice(y0, y1), slice(x0, x1), self.grid)]
        return self._windows[0]

    @cached_property
    def _windows(self) -> list[Window]:
        return []

    def around(self, contact: Any) -> tuple[Levels, Any]:
        """The levels of the latest window and its part of a contact, if it holds all of it; else these and the contact."""
        for window in self._windows:
            inside = window.cut(contact)
            if self.xp.count_nonzero(inside) == self.xp.count_nonzero(contact):
                return window.levels, inside
        return self, contact

    def folded_to(self, height: Callable[[Grid], Array]) -> tuple[Levels, Any]:
        """The levels folded along the axes about which the indenter is its own mirror image, with its `cells` there."""
        heights = height(self.grid) / self.grid.spacing
        folded = self.folded(mirror_axes(self, heights))
        return folded, folded.asarray(np.ascontiguousarray(folded.kept(heights)))

    def folded(self, mirrored: tuple[bool, bool]) -> Levels:
        """The same levels on the half or quarter of the grid that stands for all of it; kept, as operators are dear."""
        if mirrored == (False, False):
            return self
        if mirrored not in self._folded:
            self._folded[mirrored] = replace(self, grid=self.grid.folded(mirrored))
        return self._folded[mirrored]

    @cached_property
    def _folded(self) -> dict[tuple[bool, bool], Levels]:
        return {}

    def kept(self, values: Any) -> Any:
        """The part of an array on the whole grid that this folded one holds."""
        along_x, along_y = self.grid.mirrored
        return values[along_y * self.grid.ny :, along_x * self.grid.nx :]

    def unfolded_state(self, state: State) -> State:
        """A solution on the whole grid."""
        fields = ("pressure", "displacement", "contact")
        return replace(state, **{name: self.grid.unfold(getattr(state, name)) for name in fields})

    @property
    def unit(self) -> float:
        """Force of a cell under E* [N]."""
        return self.kernel.modulus * self.grid.cell_area

    def cells(self, height: Callable[[Grid], Array]) -> Any:
        """Gap at first touch in units of a cell, shape (ny, nx)."""
        return self.asarray(height(self.grid) / self.grid.spacing)

    def asarray(self, values: Any) -> Any:
        """NumPy values as an array of the levels' namespace and precision."""
        return self.xp.asarray(np.asarray(values), dtype=self.xp.float32 if self.single else self.xp.float64)


@dataclass(frozen=True, slots=True)
class Window:
    """Part of a grid, on which a contact can be solved at less cost; the whole grid then only checks it."""

    levels: Levels
    rows: slice
    columns: slice
    whole: Grid

    def cut(self, values: Any) -> Any:
        """The window's part of an array on the whole grid."""
        return values[self.rows, self.columns]

    def embed(self, values: Any) -> Any:
        """An array on the whole grid that is zero outside the window."""
        whole = self.levels.xp.zeros(self.whole.shape, dtype=values.dtype)
        whole[self.rows, self.columns] = values
        return whole


@dataclass(frozen=True, slots=True)
class Effort:
    """What a nested solve took: inner iterations per level (finest last), whether the force was met, and what coarser cells say.

    The latter is the force [N] on cells twice as wide at the same depth; NaN where these were not solved.
    """

    iterations: tuple[int, ...]
    force_error: float = 0.0
    coarser_force: float = float("nan")


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
    height: Callable[[Grid], Array],
    depth: float,
    tolerance: float,
    limit: int,
    start: Any = None,
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
    """Pressure [E*] of about the contact that is looked for, on a coarse grid."""

    grid: Grid
    pressure: Array


def _nested_depth(
    levels: Levels,
    height: Callable[[Grid], Array],
    cells: Any,
    depth: float,
    tolerance: float,
    limit: int,
    start: Any,
    rough: Rough | None,
    *,
    finest: bool = True,
) -> tuple[State, Effort]:
    before: tuple[int, ...] = ()
    coarser, coarser_force = levels.coarser, float("nan")
    if start is None and coarser is not None:
        # of the finest level the next coarser one tells how large the error of its force is
        if rough is not None and not finest and _cells(coarser.grid) <= _cells(rough.grid):
            start = levels.asarray(prolong(rough.pressure, rough.grid, levels.grid))
        else:
            looser = max(tolerance, min(_COARSE_TOLERANCE, _LOOSER * tolerance))
            state, effort = _nested_depth(
                coarser, height, coarser.cells(height), depth, looser, limit, None, rough, finest=False
            )
            before, start = effort.iterations, levels.asarray(prolong(state.pressure, coarser.grid, levels.grid))
            coarser_force = state.force * coarser.unit
    taken, direct = 0, True
    window = None if start is None else levels.window(start)
    if window is not None:
        part = _solve(window.levels, window.cut(cells), depth, window.cut(start), tolerance, limit)
        taken, start, direct = part.iterations, window.embed(part.pressure), part.direct
    state = _solve(levels, cells, depth, start, tolerance, limit - taken, direct=direct)
    return state, Effort((*before, taken + state.iterations), coarser_force=coarser_force)


def solve_force(
    levels: Levels, height: Callable[[Grid], Array], force: float, guess: float, tolerance: float, limit: int
) -> tuple[State, Effort]:
    """Contact at a force [N], from the coarsest level up; `guess` is any depth [m] of the right order."""
    folded, cells = levels.folded_to(height)
    state, effort, _ = _nested_force(folded, height, cells, force, guess, tolerance, limit)
    return folded.unfolded_state(state), effort


def solve_stiffness(levels: Levels, contact: Any, tolerance: float) -> float:
    """Stiffness dF/dd [N/m] of a flat punch under a contact on the finest grid."""
    folded = levels.folded(mirror_axes(levels, to_numpy(contact)))
    part, contact = folded.around(folded.kept(contact))
    operator = part.inner if tolerance >= SINGLE_FLOOR else part.operator
    stiffness = punch_stiffness(operator, contact, tolerance)[1]
    return stiffness * levels.kernel.modulus * levels.grid.spacing


def _nested_force(
    levels: Levels,
    height: Callable[[Grid], Array],
    cells: Any,
    force: float,
    guess: float,
    tolerance: float,
    limit: int,
) -> tuple[State, Effort, Punch | None]:
    coarser = levels.coarser
    if coarser is None:
        state, taken, missing, _ = _newton(levels, cells, force, guess, None, None, tolerance, limit)
        return state, Effort((taken,), missing), None
    coarse_tolerance = max(tolerance, _COARSE_TOLERANCE / 10)
    state, effort, punch = _nested_force(coarser, height, coarser.cells(height), force, guess, coarse_tolerance, limit)
    start, depth = (
        levels.asarray(prolong(state.pressure, coarser.grid, levels.grid)),
        state.depth * coarser.grid.spacing,
    )
    coarser_depth = depth
    if punch is None or _cells(coarser.grid) <= _PUNCH_CELLS:
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
    # the other depth for the same force stands for another force at the same depth
    changed = state.depth * levels.grid.spacing - coarser_depth
    coarser_force = force + punch.stiffness * changed if punch is not None else float("nan")
    return state, Effort((*effort.iterations, taken + more), missing, coarser_force), punch


def _newton(
    levels: Levels,
    cells: Any,
    force: float,
    depth: float,
    start: Any,
    punch: Punch | None,
    tolerance: float,
    limit: int,
    *,
    follow: bool = True,
) -> tuple[State, int, float, Punch | None]:
    """Contact at a force on one grid, with iterations, the relative error of force and what is left to say of the punch.

    Without a punch that shows how the force answers, the depth may be far off and is not worth a precise solve before it is
    near; with one the depth may `follow` within the solve, which pays unless the depth is right already.
    """
    spacing, modulus, unit = levels.grid.spacing, levels.kernel.modulus, levels.unit
    iterations, missing, stiffness, aim = 0, 1.0, 0.0, None
    if punch is not None:
        stiffness = punch.stiffness
    if punch is not None and punch.foresees and follow:
        share = levels.asarray(punch.share(levels.grid))
        aim = Aim(force / unit, stiffness / (modulus * spacing), share * (stiffness / (modulus * spacing)))
    for _ in range(_NEWTON_STEPS):
        wanted = max(tolerance, min(1e-2, abs(missing) * 1e-2)) if punch is None else tolerance
        state = _solve(levels, cells, depth, start, wanted, limit - iterations, aim)
        iterations, start = iterations + state.iterations, state.pressure
        if punch is not None and aim is not None and state.depth == depth / spacing:
            punch = replace(punch, foresees=False)
        depth = state.depth * spacing
        missing = 1 - state.force * unit / force
        if (abs(missing) <= tolerance and wanted <= tolerance) or iterations >= limit:
            break
        if punch is None:
            stiffness = _punch(levels, state).stiffness
        aim, depth = None, max(depth + missing * force / stiffness, depth / 4)
    return state, iterations, abs(missing), punch


def _solve(
    levels: Levels,
    cells: Any,
    depth: float,
    start: Any,
    tolerance: float,
    limit: int,
    aim: Aim | None = None,
    *,
    direct: bool = True,
) -> State:
    return solve_contact(
        levels.operator,
        cells,
        depth / levels.grid.spacing,
        start=start,
        inner=levels.inner,
        direct=direct,
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


def mirror_axes(levels: Levels, values: Array) -> tuple[bool, bool]:
    """Along which axes an array on the whole grid is its own mirror image; only with NumPy, which has cosine transforms."""
    if levels.xp is not np or levels.grid.copies > 1:
        return False, False
    along_x, along_y = levels.grid.can_fold()
    return along_x and _even(values, 1), along_y and _even(values, 0)


def _even(values: Array, axis: int) -> bool:
    """Whether an array is its own mirror image along an axis."""
    image = np.flip(values, axis)
    if values.dtype == bool:
        return np.array_equal(values, image)
    return bool(np.allclose(values, image, rtol=_EVEN, atol=_EVEN))
