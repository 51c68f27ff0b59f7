"""From coarse cells to fine ones: the start of the next solve, and that of a punch."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.bem.grid import Cells, Grid
from flatpunch.bem.operator.convolution import to_numpy


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
