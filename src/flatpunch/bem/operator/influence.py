"""Influence coefficients: displacement at a cell's centre per uniform pressure on another cell.

    u_i = sum_j g(x_i - x_j) p_j,      g(x) = int_cell G(|x - s|) d^2 s

The half-space part 1/(pi E* r), of which there is none under a membrane, has Love's closed form. The rest R of G is a smooth
function of distance on the scale of the layers: far from the origin its cell average is a function of r too, up to (h/r)^5 cos
4 phi, and is read from a table that contains the averaging; near it, and where cells are wider than the layer, it is integrated
cell by cell, the cell split towards the origin until every part is small against its distance. Power-law half-spaces have G ~
r^-(1 + exponent) throughout and take the same two roads.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gamma

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.bem.operator.radial import CellTable, remainder_table
from flatpunch.compliances import Kernel
from flatpunch.compliances.layered import SATURATION
from flatpunch.numerics.gauss import gauss

_NEAR = 24.0
"""Distance in cells from which the cell average is isotropic: the cos(4 phi) part is below 1e-9 of the diagonal there."""


Radial = Callable[[Array], Array]
Indices = NDArray[np.signedinteger]


def influence_coefficients(kernel: Kernel, spacing: float, shape: tuple[int, int]) -> Array:
    """Coefficients g at offsets of (i, j) cells.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    spacing : float
        Side of a cell [m].
    shape : (int, int)
        Number of offsets (rows, columns), beginning with zero.

    Returns
    -------
    ndarray, shape (rows, columns)
        g [m/Pa]; absolute error below 1e-8 g[0, 0] of a half-space of the same modulus.
    """
    if kernel.exponent != 0.0:
        return power_law_coefficients(kernel, kernel.exponent, spacing, shape)
    g = kernel.limit * love_coefficients(shape) * (spacing / (np.pi * kernel.modulus))
    if not kernel.homogeneous:
        add_remainder(g, kernel, spacing)
    return g


@byte_cached
def love_coefficients(shape: tuple[int, int]) -> Array:
    """int 1/r over the unit square around (j, i); shape (rows, columns)."""
    y = np.arange(-1, shape[0])[:, None] + 0.5
    x = np.arange(-1, shape[1])[None, :] + 0.5
    r = np.hypot(x, y)
    # y asinh(x/y) + x asinh(y/x) with asinh(x/y) = ln((x + r)/y); corners at negative x, y by antisymmetry
    corner = np.abs(y) * np.log((np.abs(x) + r) / np.abs(y)) + np.abs(x) * np.log((np.abs(y) + r) / np.abs(x))
    corner *= np.sign(x) * np.sign(y)
    return np.asarray(corner[1:, 1:] - corner[:-1, 1:] - corner[1:, :-1] + corner[:-1, :-1])


def add_remainder(g: Array, kernel: Kernel, spacing: float) -> None:
    """Add the part of the coefficients due to the medium's L - 1, in place."""
    factor = spacing**2 / (np.pi * kernel.modulus)
    near = near_cells(kernel, spacing)
    # distances below 1e-5 cells contribute 1e-10 of the diagonal, even of the logarithm of a graded surface
    closest, farthest = max(near, 1e-4) * spacing, spacing * max(float(np.hypot(*g.shape)), near)
    averaged = remainder_table(kernel, closest, max(farthest, 2 * closest), spacing)
    add_far(g, factor, CellTable.of(averaged, spacing / 4, farthest), spacing, near)
    if near > 0:
        add_block(g, factor * near_block(kernel, spacing))


@byte_cached
def near_block(kernel: Kernel, spacing: float) -> Array:
    """Cell averages of the medium's L - 1 near the origin, kept: windows and finer patches share the cells of a grid."""
    return near_averages(remainder_table(kernel, 1e-5 * spacing, 2 * _NEAR * spacing), spacing)


def near_cells(kernel: Kernel, spacing: float) -> float:
    """Distance in cells within which the remainder is integrated cell by cell; -1 when it is smooth everywhere."""
    smooth = 2 * kernel.length * SATURATION / max(kernel.cutoff, SATURATION)
    return -1.0 if kernel.tail == 0.0 and smooth > _NEAR * spacing else _NEAR


def add_far(g: Array, factor: float, radial: Radial, spacing: float, near: float) -> None:
    """Add cell averages that depend on distance alone, a few rows at a time, beyond `near` cells.

    The same distances stand on both sides of the diagonal and are looked up once.
    """
    rows, columns = g.shape
    for first in range(0, min(rows, columns), 32):
        stop = min(first + 32, rows, columns)
        y, x = np.arange(first, stop, dtype=float)[:, None], np.arange(first, max(rows, columns), dtype=float)
        r = np.hypot(x, y)
        values = radial(np.maximum(r, near) * spacing)
        values *= factor
        if first <= near:
            values[r <= near] = 0.0
        g[first:stop, first:] += values[:, : columns - first]
        g[stop:, first:stop] += values[:, stop - first : rows - first].T


def near_averages(radial: Radial, spacing: float) -> Array:
    """Cell averages of a function of r [m] by quadrature up to _NEAR cells, zero beyond; shape (n, n)."""
    rule = near_rule()
    averages = np.bincount(rule.owner, rule.weight * radial(spacing * rule.radius))
    block = np.zeros((int(_NEAR) + 1, int(_NEAR) + 1))
    block[rule.row, rule.column] = block[rule.column, rule.row] = averages
    return block


@dataclass(frozen=True, slots=True)
class NearRule:
    """Quadrature over cells near the origin, for functions of the distance that are singular there at most.

    Attributes
    ----------
    row, column : ndarray of int, shape (n,)
        The cells, row <= column.
    radius, weight, owner : ndarray, shape (k,)
        Distances from the origin [cells], weights of the averages, and which cell they belong to.
    """

    row: Indices
    column: Indices
    radius: Array
    weight: Array
    owner: Indices


@byte_cached
def near_rule() -> NearRule:
    """The rule up to _NEAR cells: each cell is split towards the origin until its parts are small against their distance."""
    row, column = np.triu_indices(int(_NEAR) + 1)
    close = np.hypot(row, column) <= _NEAR
    row, column = row[close], column[close]
    # by symmetry the central cell is known from one of its quarters
    central = (row == 0) & (column == 0)
    x, y = np.where(central, 0.0, column - 0.5), np.where(central, 0.0, row - 0.5)
    share, owner = np.ones(row.size), np.arange(row.size)
    side = np.where(central, 0.5, 1.0)
    parts: list[tuple[Array, Array, Indices]] = []
    while x.size:
        distance = np.hypot(np.maximum(x, 0.0), np.maximum(np.maximum(y, -y - side), 0.0))
        # smallest piece of a cell: even the singularity of a power law (exponent up to 0.8) inside it weighs below rounding for
        # neighbours, and the central cell of power laws is done in closed form
        split = (side > distance) & (side > 1e-5)
        # Gauss points along a part that is farther from the origin than six of its sides, and along others
        far = distance > 6.0 * side
        for few, nodes in ((far, 4), (~far, 8)):
            done = few & ~split
            t, v = gauss(nodes)
            px, py = (start[done, None] + side[done, None] * (t + 1) / 2 for start in (x, y))
            weight = share[done, None, None] * (v[:, None] * v / 4)
            radius = np.hypot(px[:, None, :], py[:, :, None])
            parts.append((radius.ravel(), weight.ravel(), np.repeat(owner[done], nodes**2)))
        half = side[split] / 2
        x = np.concatenate([x[split] + a * half for a in (0, 1) for _ in (0, 1)])
        y = np.concatenate([y[split] + b * half for _ in (0, 1) for b in (0, 1)])
        side, owner, share = np.tile(half, 4), np.tile(owner[split], 4), np.tile(share[split] / 4, 4)
    radius, weight, owner = (np.concatenate(part) for part in zip(*parts, strict=True))
    return NearRule(row, column, radius, weight, owner)


def power_law_coefficients(kernel: Kernel, exponent: float, spacing: float, shape: tuple[int, int]) -> Array:
    """Coefficients of C ~ wavenumber^(k - 1), whose Green's function is a power: G = A r^-(1 + k)."""
    e = exponent
    wavenumber = 1.0 / spacing
    scale = float(np.atleast_1d(kernel(np.array([wavenumber])))[0]) * wavenumber ** (1 - e)
    amplitude = scale / (2 * np.pi) * 2**e * gamma((1 + e) / 2) / gamma((1 - e) / 2)
    g = np.zeros(shape)

    def averaged(r: Array) -> Array:
        # r^-(1+e) and the isotropic part of h^2/24 lap + 7 h^4/11520 lap lap, r in cells
        second, fourth = (1 + e) ** 2, (1 + e) ** 2 * (3 + e) ** 2
        return np.asarray(r ** -(1 + e) * (1 + second / (24 * r**2) + 7 * fourth / (11520 * r**4)))

    add_far(g, 1.0, averaged, 1.0, _NEAR)
    add_block(g, power_block(e))
    g *= amplitude * spacing ** (1 - e)
    return g


@byte_cached
def power_block(exponent: float) -> Array:
    """Integrals of r^-(1 + exponent) over unit cells near the origin, the same for all cells and media."""
    block = near_averages(lambda r: np.asarray(r ** -(1 + exponent)), 1.0)
    # the central cell in polar coordinates: eight triangles
    t, v = gauss()
    angle = np.pi / 8 * (t + 1)
    block[0, 0] = np.pi / (1 - exponent) * float(v @ (0.5 / np.cos(angle)) ** (1 - exponent))
    return block


def add_block(g: Array, block: Array) -> None:
    """Add coefficients of the cells nearest to the origin, in place."""
    rows, columns = (min(block.shape[0], cells) for cells in g.shape)
    g[:rows, :columns] += block[:rows, :columns]
