"""Contacts of few cells, solved directly: the gap on them is removed by a Cholesky factor of their influence matrix.

Narrow contacts (the tongues under the edges of a pyramid on a stiff film, rings, needles) are where dividing by the symbol
knows least, and where there are few cells. Their influence coefficients are the cosine transform of
the operator's spectrum; on a folded grid those of the mirror images are added. NumPy only. The matrix is in double precision:
stiff films have condition numbers that leave little of single.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.linalg.blas import dsymv
from scipy.ndimage import binary_dilation

from flatpunch._support.checks import Array
from flatpunch.bem.grid import Mask
from flatpunch.bem.operator.convolution import Operator
from flatpunch.bem.operator.transforms import even_transform_back

Places = NDArray[np.intp]

MOST = 2500
"""Most cells of a matrix: 50 MB, and a tenth of a second."""

_BYTES = 32
"""Bytes per element while the matrix is gathered or factored (30 measured)."""

_PRECISE, _REFINEMENTS = 1e-8, 6
"""Residual of a direct solution relative to the gap, and the solutions it may take: two or three with a factor in single."""

_ROWS = 64
"""Rows of a matrix gathered at a time."""

_AFFORDABLE = 25.0
"""Square of the cells in contact over those of the grid up to which a direct step costs no more than some ten iterations."""

_AFFORDABLE_WHERE_SLOW = 150.0
"""The same where a step turned out to take tens of iterations."""

_AFFORDABLE_ONCE = 15.0
"""The same where the matrix serves one step only."""


@dataclass(frozen=True, slots=True)
class Influence:
    """Influence matrix of some cells of a grid.

    Attributes
    ----------
    place : ndarray of int, shape (ny nx,)
        Row of the matrix that belongs to a cell; -1 for cells that are not in it.
    matrix : ndarray, shape (n, n)
        Displacement [cells] of one cell and of its mirror images under unit pressure [E*] on another and its images; the upper
        triangle, as it is symmetric.
    """

    place: Places
    matrix: Array

    def covers(self, contact: Mask) -> bool:
        """Whether all cells of a contact are in it."""
        return bool((self.place[np.flatnonzero(contact)] >= 0).all())

    def remove_gap(self, contact: Mask, gap: Array) -> Array | None:
        """Pressure [E*] on `contact` that removes the gap [cells] there, shape (ny, nx); None if rounding forbids it."""
        cells = np.flatnonzero(contact)
        rows = self.place[cells]
        part = self.matrix if rows.size == self.matrix.shape[0] else self.matrix.take(rows, 0).take(rows, 1)
        solved = _solved(part, -gap.ravel()[cells].astype(float))
        if solved is None:
            return None
        change = np.zeros(gap.size)
        change[cells] = solved
        return change.reshape(gap.shape)


def _solved(matrix: Array, right: Array) -> Array | None:
    """Solution of a symmetric system, of which the upper triangle is given; None if rounding forbids it.

    A factor in single precision takes half the time, and the residual in double precision shows what it leaves.
    """
    if right.size == 0:
        return right
    # by rows the upper triangle is the lower one by columns, as LAPACK reads it: nothing is copied to another order
    system, aim = matrix.T, _PRECISE * np.abs(right).max()
    solution = None
    for dtype in (np.float32, np.float64):
        try:
            factor = cho_factor(system.astype(dtype), lower=True, overwrite_a=True, check_finite=False)
        except np.linalg.LinAlgError:
            solution = None
            continue
        solution, residual = np.zeros(right.size), right
        for _ in range(_REFINEMENTS):
            solution += cho_solve(factor, residual.astype(dtype), check_finite=False)
            residual = dsymv(-1.0, system, solution, beta=1.0, y=right, lower=1)
            if np.abs(residual).max() <= aim:
                return solution
    # to the rounding that double precision leaves
    return solution


def affordable(operator: Operator, cells: int, *, slow: bool, once: bool) -> bool:
    """Whether a contact of so many cells is better solved directly.

    `slow` if iterations were seen to be many, `once` if this is the only step on this contact and those next to it.
    """
    share = _AFFORDABLE_WHERE_SLOW if slow else _AFFORDABLE_ONCE if once else _AFFORDABLE
    size = operator.grid.nx * operator.grid.ny
    return operator.xp is np and cells <= MOST and cells**2 <= share * size


def most_bytes(cells: int) -> int:
    """Upper bound of the memory that direct steps take on a grid of so many cells [bytes]."""
    return int(_BYTES * min(MOST**2, _AFFORDABLE_WHERE_SLOW * cells))


def influence(operator: Operator, contact: Mask, table: Array) -> Influence:
    """Influence matrix of a contact and, where that is affordable, of the cells next to it, which may join it.

    `table` is the operator's, from `offsets`.
    """
    wider = binary_dilation(contact)
    if np.count_nonzero(wider) <= 1.3 * np.count_nonzero(contact):
        contact = wider
    i, j = np.nonzero(contact)
    matrix = _between(operator, table, i, j)
    place = np.full(contact.size, -1, dtype=np.intp)
    place[np.flatnonzero(contact)] = np.arange(i.size)
    return Influence(place, matrix)


def offsets(operator: Operator) -> Array:
    """Influence coefficients at all offsets between two cells of the whole grid, negative ones too; in one row."""
    far_y, far_x = operator.grid.unfolded.shape
    quarter = even_transform_back(operator.spectrum.astype(float))[:far_y, :far_x]
    # even in both offsets: with negative ones in the table too, the place in it is a difference of two numbers
    upper = np.concatenate([quarter[:, :0:-1], quarter], axis=1)
    return np.asarray(np.concatenate([upper[:0:-1], upper]).ravel())


def _between(operator: Operator, table: Array, i: Places, j: Places) -> Array:
    """Influence of cells (i, j) on each other, mirror images included: upper triangle of a matrix (n, n)."""
    (far_y, far_x), (along_x, along_y) = operator.grid.unfolded.shape, operator.grid.mirrored
    width = 2 * far_x - 1
    here, matrix = (i + far_y - 1) * width + j + far_x - 1, np.zeros((i.size, i.size))
    for first in range(0, i.size, _ROWS):
        rows, rest = slice(first, first + _ROWS), slice(first, None)
        for image_y in (i, -1 - i)[: 1 + along_y]:
            for image_x in (j, -1 - j)[: 1 + along_x]:
                offset = here[rows, None] - (image_y * width + image_x)[rest]
                # all offsets lie inside the table, and clipping is faster than making sure
                matrix[rows, rest] += np.take(table, offset, mode="clip")
    return matrix
