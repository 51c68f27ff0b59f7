"""Contacts in several parts: a star with the tongues that its grid has cut off, and islands on the faces of the tip."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import label

from flatpunch import bem
from flatpunch.bem.grid import Grid, Mask
from flatpunch.bem.outline import Outline, trace_outline
from flatpunch.compliance import Kernel
from flatpunch.contact.boundary_elements.outlines.zoom import turned
from flatpunch.indenters.geometry.edges import wedges_of
from flatpunch.indenters.profile import Indenter

FILLED = 0.7
"""Share of the wedge between neighbouring edges within which cells belong to the tongue along one of them."""
EXCESS = 0.07
"""By how much cells in contact are too many along their rim, in cells: those covered in part count (0.04 to 0.11 found)."""
_AT = 1.5
"""Cells from the point of first touch within which it counts as in contact."""


def star_of(kernel: Kernel, indenter: Indenter, solution: bem.Solution, angles: int) -> tuple[Outline, Mask]:
    """Outline of the part about the point of first touch, and the cells of islands, which lie apart from it between the edges.

    Of tongues that the grid has cut off, where necks are thinner than a cell, the outline holds what is left. Where the point of
    first touch is not in contact there is none.
    """
    grid = solution.grid
    contact = solution.pressure > 0
    parts, count = label(contact, np.ones((3, 3)))
    # tongues and islands may be larger than the part about the point of first touch
    distance = np.where(contact, np.hypot(grid.x[None, :], grid.y[:, None]), np.inf)
    main = int(parts.flat[distance.argmin()])
    if count < 2 or distance.min() > _AT * grid.spacing:
        return solution.outline, np.zeros_like(contact)
    rows, columns = np.nonzero(contact & (parts != main))
    x, y, part = grid.x[columns], grid.y[rows], parts[rows, columns]
    between, beside = np.ones(x.size, dtype=bool), np.zeros(x.size, dtype=bool)
    for angle, wedge, _ in wedges_of(indenter):
        along, across = turned(x, y, -angle)
        between &= (along <= 0) | (np.abs(across) > FILLED * wedge * along + grid.spacing)
        beside |= (along > 0) & (np.abs(across) < 1.5 * grid.spacing)
    tongues = np.setdiff1d(part[beside], part[between])
    islands = contact & (parts != main) & ~np.isin(parts, tongues)
    pressure = np.where(parts == main, solution.pressure, 0.0)
    rim = (1 + kernel.exponent) / 2
    return trace_outline(grid, pressure, angles=angles, rim=rim, length=kernel.surface_length), islands


def ray_and_area(grid: Grid, cells: Mask) -> tuple[float, float]:
    """Mean length of the rays from the point of first touch in some cells [m], the integral of 1/r by 2 pi, and their area [m^2].

    Both less what cells are too many along their rim.
    """
    x, y = (np.append(v - grid.spacing / 2, v[-1] + grid.spacing / 2) for v in (grid.x, grid.y))
    x, y = x[None, :], y[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        # zero on the axes, where arcsinh(1/0) times zero is none
        corner = np.nan_to_num(x * np.arcsinh(y / np.abs(x))) + np.nan_to_num(y * np.arcsinh(x / np.abs(y)))
    ray = float(np.diff(np.diff(corner, axis=0), axis=1)[cells].sum()) / (2 * np.pi)
    padded, count = np.pad(cells, 1), int(np.count_nonzero(cells))
    faces = sum(int(np.count_nonzero(np.diff(padded, axis=axis))) for axis in (0, 1))
    # a staircase is longer than what it follows
    share = max(1.0 - EXCESS * float(np.pi / 4) * faces / max(count, 1), 0.0)
    return share * ray, share * count * grid.cell_area
