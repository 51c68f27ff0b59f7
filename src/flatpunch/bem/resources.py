"""Memory and threads that a solve on a grid takes."""

from __future__ import annotations

import logging
from contextlib import AbstractContextManager

from flatpunch._support.threads import given_blas_threads, one_blas_thread
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator.convolution import BYTES_PER_CELL, THREADED
from flatpunch.bem.solver.levels import Levels

logger = logging.getLogger("flatpunch.bem")


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
    cells = grid.nx * grid.ny
    return cells * (BYTES_PER_CELL // 2 if single else BYTES_PER_CELL)


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
