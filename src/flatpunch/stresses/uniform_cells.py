"""Half-space part of the fields within a few cells of uniformly loaded squares.

Squares around that of a point are summed in closed form, corner by corner (`one_cell`). What all others add is smooth over the
square of the point, and in depth over their distance: it is interpolated between Chebyshev nodes, each of them a convolution.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np
import scipy
from numpy.polynomial import chebyshev

from flatpunch._support.checks import AT_ONCE, ROUNDING, Array, Flags, Indices
from flatpunch.numerics.chebyshev import nodal_transform, unit_nodes
from flatpunch.stresses.axisymmetric.panels import nodes_or_points
from flatpunch.stresses.axisymmetric.radial import COMPONENTS, SurfacePart
from flatpunch.stresses.one_cell import corner, summed


@dataclass(frozen=True, slots=True)
class Rule:
    """How finely fields are evaluated.

    Attributes
    ----------
    cells : int
        Cells to the distance of a point from the load.
    cut : int
        Parts of a cell in each direction for what layers add, at least.
    window : int
        Cells on each side of that of a point that are summed in closed form.
    across, down : int
        Chebyshev nodes in each direction of a cell, and in a range of depths.
    """

    cells: int
    cut: int
    window: int
    across: int
    down: int


@dataclass(frozen=True, slots=True)
class _Squares:
    """One load on squares, and points by the square that they are in: of the grid, or of its continuation.

    Lengths are in squares; `column`, `row` are the numbers of the squares and `x`, `y` the places in them, -1/2 to 1/2.
    """

    load: Array
    part: SurfacePart
    spacing: float
    direction: float | None
    column: Indices
    row: Indices
    x: Array
    y: Array
    z: Array

    def corner(self, x: Array, y: Array, z: Array) -> Array:
        h = self.spacing
        return self.part.kept_of_components(corner(x * h, y * h, z * h, *self.part.constants, self.direction))

    def some(self, chosen: Indices) -> _Squares:
        return replace(
            self,
            column=self.column[chosen],
            row=self.row[chosen],
            x=self.x[chosen],
            y=self.y[chosen],
            z=self.z[chosen],
        )


def fields_of_squares(
    load: Array,
    part: SurfacePart,
    spacing: float,
    direction: float | None,
    place: tuple[Array, Array, Array],
    rule: Rule,
) -> Array:
    """Fields of uniformly loaded squares in the half-space of a surface.

    Parameters
    ----------
    load : ndarray, shape (ny, nx)
        Pressure, or traction in a direction [Pa].
    part : SurfacePart
        The half-space.
    spacing : float
        Side of a square [m].
    direction : float or None
        Polar angle of a traction [rad], None for a pressure.
    place : ndarray, ndarray, ndarray, shape (n,)
        Points from the centre of the first square, along x, y and z [m].
    rule : Rule
        How finely they are evaluated.

    Returns
    -------
    ndarray, shape (9, n)
        Stress xx, yy, zz, yz, xz, xy [Pa], NaN where it is infinite, and displacement x, y, z [m].
    """
    x, y, z = (each / spacing for each in place)
    column, row = (np.rint(each).astype(int) for each in (x, y))
    squares = _Squares(load, part, spacing, direction, column, row, x - column, y - row, z)
    result = np.empty((COMPONENTS, z.size))
    last_row, last_column = (n - 1 for n in load.shape)
    window = min(rule.window, int(np.abs([row, last_row - row, column, last_column - column]).max()))
    count = max(AT_ONCE // (128 * (2 * window + 2) ** 2), 1)
    for start in range(0, z.size, count):
        some = slice(start, start + count)
        result[:, some] = _closest(squares.some(np.arange(z.size)[some]), window)
    result += _others(squares, rule)
    return result


def _closest(squares: _Squares, window: int) -> Array:
    """What the squares around a point add."""
    span = np.arange(-window - 1, window + 2)
    rows, columns = (each[:, None] + span for each in (squares.row, squares.column))
    ny, nx = squares.load.shape
    loaded = ((rows >= 0) & (rows < ny) & (abs(span) <= window))[:, :, None]
    loaded = loaded & ((columns >= 0) & (columns < nx) & (abs(span) <= window))[:, None, :]
    load = np.where(loaded, squares.load[rows.clip(0, ny - 1)[:, :, None], columns.clip(0, nx - 1)[:, None, :]], 0.0)
    corners = span[:-1] + 0.5
    x, y = squares.x[:, None] - corners, squares.y[:, None] - corners
    parts = squares.corner(x[:, None, :], y[:, :, None], squares.z[:, None, None])
    found = np.einsum("cnij,nij->cn", parts, np.diff(np.diff(load, axis=1), axis=2))
    if squares.direction is not None:
        found[:6, _infinite(load[:, window + 1], x, squares.z) | _infinite(load[:, :, window + 1], y, squares.z)] = (
            np.nan
        )
    return np.asarray(found)


def _infinite(load: Array, corners: Array, z: Array) -> Flags:
    """Points of the surface on an edge at which a traction jumps; loads and edges along a line, shape (n, squares)."""
    at_jump = (abs(corners) < ROUNDING) & (np.diff(load, axis=1) != 0)
    return np.asarray(at_jump.any(axis=1) & (z < ROUNDING))


def _others(squares: _Squares, rule: Rule) -> Array:
    """What all squares outside the window of a point add."""
    result = np.zeros((COMPONENTS, squares.z.size))
    limits = np.array([0, 1 / 3, 1]) * rule.cells
    for low, high in pairwise(limits):
        chosen = np.flatnonzero((squares.z >= low) & (squares.z < high))
        if chosen.size:
            some = squares.some(chosen)
            depths, weights = nodes_or_points(some.z, low, high, rule.down)
            for z, weight in zip(depths, weights.T, strict=True):
                result[:, chosen] += weight * sum(_at_nodes(some, z, rule))
    return result


def _at_nodes(squares: _Squares, z: Array, rule: Rule) -> Iterator[Array]:
    """Shares of the Chebyshev nodes of a square in what others add at a depth."""
    ny, nx = squares.load.shape
    first, left = squares.row.min(), squares.column.min()
    shape = int(squares.row.max() - first) + 1, int(squares.column.max() - left) + 1
    along = first - ny + 1 + np.arange(ny + shape[0] - 1)
    across = left - nx + 1 + np.arange(nx + shape[1] - 1)
    inside = (abs(along) <= rule.window)[:, None] & (abs(across) <= rule.window)
    if inside.all():
        return
    in_x, in_y = (
        chebyshev.chebvander(2 * each, rule.across - 1) @ nodal_transform(rule.across)
        for each in (squares.x, squares.y)
    )
    nodes = unit_nodes(rule.across) / 2
    for i, j in product(range(rule.across), repeat=2):
        x, y = (np.append(each, each[-1] + 1) - 0.5 + node for each, node in ((across, nodes[i]), (along, nodes[j])))
        gx, gy = np.meshgrid(x, y)
        kernel = np.where(inside, 0.0, summed(squares.corner(gx, gy, z)))
        plane = convolved(squares.load, kernel, shape)
        yield in_x[:, i] * in_y[:, j] * plane[:, squares.row - first, squares.column - left]


def convolved(load: Array, kernel: Array, shape: tuple[int, int]) -> Array:
    """Sums of a kernel, shape (9, ...), over cells, at the lattice of `shape` that its offsets reach."""
    size = tuple(scipy.fft.next_fast_len(n, real=True) for n in kernel.shape[1:])
    spectrum = scipy.fft.rfft2(load, size)
    full = scipy.fft.irfft2(scipy.fft.rfft2(kernel, size) * spectrum, size)
    ny, nx = load.shape
    return np.asarray(full[:, ny - 1 : ny - 1 + shape[0], nx - 1 : nx - 1 + shape[1]])
