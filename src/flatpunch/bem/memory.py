"""How much memory a solve takes, said before it begins."""

from __future__ import annotations

import logging

from flatpunch.bem.direct import most_bytes
from flatpunch.bem.grid import Grid
from flatpunch.bem.levels import Levels
from flatpunch.bem.operator import BYTES_PER_CELL

logger = logging.getLogger("flatpunch.bem")


def required_bytes(grid: Grid, *, single: bool = False) -> int:
    """Upper bound of the memory that a solve on `grid` takes [bytes]."""
    cells = grid.nx * grid.ny
    return cells * (BYTES_PER_CELL // 2 if single else BYTES_PER_CELL) + most_bytes(cells)


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
