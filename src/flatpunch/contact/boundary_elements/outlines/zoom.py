"""A closer look at a part of a contact: finer cells along a ray, while the pressure elsewhere stays as it is.

What the pressure elsewhere does to the surface there is the known displacement less that of the pressure inside; it is smooth
and carries over to other cells. The contact on the finer cells is solved against it. What changes there is little against the
whole load, so that looking back is not worth its price: from 256 cells the load along the tongues under a pyramid's edges is
that of 2048 to a per cent (films 1 to 50 times stiffer than their substrate, half-spaces and power laws).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from flatpunch._support.checks import Array
from flatpunch.bem.grid import Grid, Mask, polar
from flatpunch.bem.height import IndenterHeight
from flatpunch.bem.operator.convolution import build_operator, coefficients_for, padded_shape
from flatpunch.bem.solver.active_set import solve_contact
from flatpunch.compliance import Kernel
from flatpunch.indenters.profile import Indenter

ROOT = 3.0
"""Cells of what is known within which the finer ones, at their border, still feel that the others stand still."""

_TOLERANCE = 1e-5
"""Within reach of single precision, which takes half the time; with 1e-4 needles end up to 3 % of the mean radius off."""
_DROP = 0.1
"""Reduction per step: the contact changes more often than where all cells are as fine."""
_LIMIT = 1000
_MARGIN, _FEWEST = 6, 8
"""Cells around the window from which displacements are interpolated (with 3 the border of the spline shows: 2e-3 of the largest
pressure in the window's outermost cells), and the fewest of them along an axis."""


@dataclass(frozen=True, slots=True)
class Patch:
    """Pressure and displacement on a grid whose x axis points along the polar angle `angle`.

    Attributes
    ----------
    grid : Grid
        The cells; x along the ray, y to its left.
    angle : float
        Polar angle of the ray [rad].
    pressure, displacement : ndarray, shape (ny, nx)
        Pressure [Pa] and inward displacement of the surface [m].
    converged : bool
        Whether the contact was found.
    coefficients : ndarray, optional
        Influence coefficients of its cells at the offsets of its own operator, those of a look closer [m/Pa].
    """

    grid: Grid
    angle: float
    pressure: Array
    displacement: Array
    converged: bool = True
    coefficients: Array | None = None


def look_closer(
    kernel: Kernel,
    indenter: Indenter,
    depth: float,
    patch: Patch,
    grid: Grid,
    angle: float,
    *,
    mirrored: tuple[bool, bool] = (False, False),
) -> Patch:
    """Contact on a finer grid inside a patch.

    Parameters
    ----------
    kernel, indenter, depth
        Medium, indenter, and indentation depth [m].
    patch : Patch
        What is known.
    grid : Grid
        The finer grid, its axes turned by `angle`.
    angle : float
        Polar angle of its x axis [rad].
    mirrored : (bool, bool)
        Whether indenter and contact are their own mirror images along the finer grid's x and y, where it is centred then.
    """
    turn, wide = angle - patch.angle, patch.grid
    inner = grid.folded(mirrored)
    along, across = turned(inner.x[None, :], inner.y[:, None], turn)
    # the part of the patch around the new cells, and of that the cells they take the place of
    corners = turned(
        *np.meshgrid(grid.center[0] + _ends(grid.nx, grid.length), grid.center[1] + _ends(grid.ny, grid.spacing)), turn
    )
    columns, rows = _within(wide.x, corners[0], wide.length), _within(wide.y, corners[1], wide.spacing)
    part = wide.part(rows, columns)
    back = turned(part.x[None, :], part.y[:, None], -turn)
    replaced = _between(back[0], grid.x, grid.length) & _between(back[1], grid.y, grid.spacing)
    own = np.where(replaced, patch.pressure[rows, columns], 0.0) / kernel.modulus
    own_operator = build_operator(kernel, part, coefficients=_some_of(patch, part), solving=False)
    imposed = patch.displacement[rows, columns] - own_operator.apply(own) * part.spacing
    places = [(across - part.y[0]) / part.spacing, (along - part.x[0]) / part.length]
    elsewhere = map_coordinates(imposed, places, order=3, mode="nearest")
    start = np.maximum(map_coordinates(own, places, order=1, mode="nearest"), 0.0)
    # half of the cells around the contact, over which interpolation spreads it
    start[map_coordinates((own > 0).astype(float), places, order=1, mode="nearest") <= 0.5] = 0.0
    x, y = turned(inner.x[None, :], inner.y[:, None], angle)
    height = IndenterHeight(indenter).at(*polar(x, y))
    coefficients = coefficients_for(kernel, inner)
    operator = build_operator(kernel, inner, coefficients=coefficients).single()
    state = solve_contact(
        operator,
        operator.asarray((height + elsewhere) / grid.spacing),
        depth / grid.spacing,
        start=operator.asarray(start),
        inner=operator,
        trusted=True,
        drop=_DROP,
        tolerance=_TOLERANCE,
        limit=_LIMIT,
    )
    pressure, displacement = state.pressure * kernel.modulus, state.displacement * grid.spacing + elsewhere
    pressure, displacement = (inner.unfold(field) for field in (pressure, displacement))
    return Patch(grid, angle, pressure, displacement, state.converged, coefficients)


def _some_of(patch: Patch, part: Grid) -> Array | None:
    """Influence coefficients of a part of a patch, where the patch has them."""
    rows, columns = (cells // 2 + 1 for cells in padded_shape(part))
    known = patch.coefficients
    return None if known is None or known.shape[0] < rows or known.shape[1] < columns else known[:rows, :columns]


def turned(x: Array, y: Array, angle: float) -> tuple[Array, Array]:
    """Points (x, y) turned about the origin: from axes at a polar angle to the usual ones, and with its negative back."""
    return x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)


def _ends(cells: int, side: float) -> Array:
    return np.array([-0.5, 0.5]) * cells * side


def _within(centres: Array, span: Array, spacing: float) -> slice:
    """Cells along one axis that a span covers, and some around them."""
    low, high = np.searchsorted(centres, [span.min() - spacing / 2, span.max() + spacing / 2])
    first = max(0, min(int(low) - _MARGIN, centres.size - _FEWEST))
    return slice(first, min(centres.size, max(int(high) + _MARGIN, first + _FEWEST)))


def _between(values: Array, centres: Array, spacing: float) -> Mask:
    return np.asarray((values > centres[0] - spacing / 2) & (values < centres[-1] + spacing / 2))
