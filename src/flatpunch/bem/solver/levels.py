"""Nested grids: a fine one, its coarser companions, the part of each around a contact, and their operators.

Where the indenter is its own mirror image the contact is too, as it is unique, and half of the grid or a quarter is enough. Here
too are the memory and the threads that a solve on a grid takes.
"""

from __future__ import annotations

import logging
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, switch
from flatpunch._support.threads import given_blas_threads, one_blas_thread
from flatpunch.bem.grid import Cells, Grid, Height, Namespace, check_grid
from flatpunch.bem.operator.convolution import (
    BYTES_PER_CELL,
    THREADED,
    Operator,
    build_operator,
    coefficients_for,
    padded_shape,
    to_numpy,
)
from flatpunch.bem.solver.active_set import State
from flatpunch.compliances import Kernel

logger = logging.getLogger("flatpunch.bem")

COARSEST = 32
"""Square root of the cells of the coarsest grid; half as many add a solve that does not help, 20 % of the time."""


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
    xp: Namespace = np
    single: bool = False
    shared: Array | None = field(default=None, repr=False, compare=False)

    @cached_property
    def coarser(self) -> Levels | None:
        """The next coarser level; None on the coarsest."""
        whole = self.grid.unfolded
        if whole.nx * whole.ny < (2 * COARSEST) ** 2:
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

    def window(self, pressure: Cells) -> Window | None:
        """The part of the grid around the contact of a pressure, which is kept; None where that would save little."""
        contact = to_numpy(pressure) > 0
        rows, columns = np.flatnonzero(contact.any(axis=1)), np.flatnonzero(contact.any(axis=0))
        if rows.size == 0:
            return None
        cut, mirrored = [], self.grid.mirrored
        for used, cells, half in ((columns, self.grid.nx, mirrored[0]), (rows, self.grid.ny, mirrored[1])):
            # cells left around the contact of a coarser grid, whose rim is known to two cells
            rim = max(4, int(0.03 * used.size * (1 + half)))
            cut.append((0 if half else max(0, int(used[0]) - rim), min(cells, int(used[-1]) + 1 + rim)))
        (x0, x1), (y0, y1) = cut
        size = (x1 - x0) * (1 + mirrored[0]), (y1 - y0) * (1 + mirrored[1])
        if (y1 - y0) * (x1 - x0) == contact.size or min(size) < COARSEST:
            return None
        part = replace(self, grid=self.grid.part(slice(y0, y1), slice(x0, x1)), shared=self.coefficients)
        self._windows[:] = [Window(part, slice(y0, y1), slice(x0, x1), self.grid)]
        return self._windows[0]

    @cached_property
    def _windows(self) -> list[Window]:
        return []

    def around(self, contact: Cells) -> tuple[Levels, Cells]:
        """The levels of the latest window and its part of a contact, if it holds all of it; else these and the contact."""
        for window in self._windows:
            inside = window.cut(contact)
            if self.xp.count_nonzero(inside) == self.xp.count_nonzero(contact):
                return window.levels, inside
        return self, contact

    def folded_to(self, height: Height) -> tuple[Levels, Cells]:
        """The levels folded along the axes about which the indenter is its own mirror image, with its `cells` there."""
        heights = height(self.grid) / self.grid.spacing
        folded = self.folded(mirror_axes(self, heights))
        return folded, folded.asarray(np.ascontiguousarray(folded.kept(heights)))

    def folded(self, mirrored: tuple[bool, bool]) -> Levels:
        """Levels on the half or quarter of the grid that symmetry leaves; kept, as operators are expensive."""
        if mirrored == (False, False):
            return self
        if mirrored not in self._folded:
            self._folded[mirrored] = replace(self, grid=self.grid.folded(mirrored))
        return self._folded[mirrored]

    @cached_property
    def _folded(self) -> dict[tuple[bool, bool], Levels]:
        return {}

    def kept(self, values: Cells) -> Cells:
        """The part of an array on the whole grid that this folded one holds."""
        along_x, along_y = self.grid.mirrored
        return values[along_y * self.grid.ny :, along_x * self.grid.nx :]

    def unfolded_state(self, state: State) -> State:
        """A solution on the whole grid."""
        fields = ("pressure", "displacement", "contact", "elastic")
        return replace(state, **{name: self.grid.unfold(getattr(state, name)) for name in fields})

    @property
    def unit(self) -> float:
        """Force of a cell under E* [N]."""
        return self.kernel.modulus * self.grid.cell_area

    def cells(self, height: Height) -> Cells:
        """Gap at first touch in units of a cell, shape (ny, nx)."""
        return self.asarray(height(self.grid) / self.grid.spacing)

    def asarray(self, values: Cells) -> Cells:
        """NumPy values as an array of the levels' namespace and precision."""
        return self.xp.asarray(np.asarray(values), dtype=self.xp.float32 if self.single else self.xp.float64)


@dataclass(frozen=True, slots=True)
class Window:
    """Part of a grid, on which a contact can be solved at less cost; the whole grid then only checks it."""

    levels: Levels
    rows: slice
    columns: slice
    whole: Grid

    def cut(self, values: Cells) -> Cells:
        """The window's part of an array on the whole grid."""
        return values[self.rows, self.columns]

    def embed(self, values: Cells) -> Cells:
        """An array on the whole grid that is zero outside the window."""
        whole = self.levels.xp.zeros(self.whole.shape, dtype=values.dtype)
        whole[self.rows, self.columns] = values
        return whole


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
    return bool(np.allclose(values, image, rtol=ROUNDING, atol=ROUNDING))


def required_bytes(grid: Grid, *, single: bool = False) -> int:
    """Upper bound of the memory that a solve on `grid` takes [bytes].

    See Also
    --------
    flatpunch.bem.Grid : The cells.

    Examples
    --------
    >>> from flatpunch import bem
    >>> print(f"{bem.required_bytes(bem.Grid(nx=1024, ny=1024, spacing=1e-9)) / 1e6:.0f} MB")
    210 MB
    """
    check_grid(grid)
    cells = grid.nx * grid.ny
    return cells * (BYTES_PER_CELL // 2 if switch("single", single) else BYTES_PER_CELL)


def announced(levels: Levels, steps: int) -> Levels:
    """Say what is about to be solved and how much memory that takes."""
    grid = levels.grid
    logger.info(
        "%d x %d cells of %.4g m, %d step(s): at most %.0f MB",
        grid.nx,
        grid.ny,
        grid.spacing,
        steps,
        required_bytes(grid, single=levels.single) / 1e6,
    )
    return levels


def fitting_threads(cells: int) -> AbstractContextManager[None]:
    """One thread of linear algebra while solving on grids of so few cells that more would wait for each other.

    On 256 x 256 cells two threads took 1.4 to 1.8 times as long as one: they stay awake between the many small products.
    """
    return given_blas_threads() if cells >= THREADED else one_blas_thread()
