"""Contact outline between the tongues of a star, whose core has few cells on a grid that holds the tongues as well.

The core is solved again on finer cells (zoom.py), the half, the quarter or the sector of it that stands for the rest.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_dilation

from flatpunch._support.checks import Array
from flatpunch.bem.grid import Grid, Mask
from flatpunch.bem.outline import rim_along
from flatpunch.compliance import Kernel
from flatpunch.contact.boundary_elements.outlines.zoom import ROOT, Patch, look_closer
from flatpunch.indenters.geometry.symmetry import mirrored_about, rotational_symmetry
from flatpunch.indenters.profile import Indenter

_FINE, _HALF_WIDTH, _WITHIN = 0.0133, 1.3, 1.15
"""Cells that it is looked at with, the least half-width of the look, and up to where it is to be known: over the mean radius."""
_SPARE = 0.1
"""What is looked at beyond the point of first touch, over its half-width, where one sector stands for all."""


def refine_core(
    kernel: Kernel,
    indenter: Indenter,
    depth: float,
    whole: Patch,
    contour: Array,
    gaps: Array,
    mean: float,
    islands: Mask,
) -> None:
    """Replace a(phi) [m] where it is within reach of a look at the core, and where rays do not meet the contact again.

    Parameters
    ----------
    kernel, indenter, depth
        Medium, indenter, and indentation depth [m].
    whole : Patch
        The solution on all of the grid.
    contour : ndarray, shape (angles,)
        a(phi) [m] at equal angles from 0; written to.
    gaps : ndarray, shape (angles, 2)
        What rays miss before a(phi), as `Outline.gaps` has it; written to.
    mean : float
        Mean radius of the contact [m].
    islands : ndarray, shape (ny, nx)
        Cells in contact that do not belong to the star.
    """
    spacing = whole.grid.spacing
    fine = spacing / np.ceil(spacing / (_FINE * mean))
    half = int(max(_HALF_WIDTH * mean, _WITHIN * mean + ROOT * spacing) / fine)
    grid = Grid(2 * half, 2 * half, fine)
    mirrored = mirrored_about(indenter, np.pi / 2), mirrored_about(indenter, 0.0)
    fold = rotational_symmetry(indenter)
    # of an odd number of arms, which have no quarters, one lies on the x axis: two others bound a sector on its other side
    sector = np.pi * (contour[0] > contour[contour.size // 2])
    one_of_many = mirrored[1] and fold % 2 == 1 and fold > 1
    if one_of_many:
        mirrored, spare = (False, True), int(_SPARE * half)
        across = min(half, int(half * np.sin(np.pi / fold) + ROOT * spacing / fine) + 1)
        grid = Grid(half + spare, 2 * across, fine, (np.cos(sector) * (half - spare) * fine / 2, 0.0))
    core = look_closer(kernel, indenter, depth, whole, grid, 0.0, mirrored=mirrored)
    if not core.converged:
        return
    pressure = np.where(_on(islands, whole.grid, grid), 0.0, core.pressure) if islands.any() else core.pressure
    if not pressure.any():
        # islands so near that nothing is sure to be the star's
        return
    closer, *_ = rim_along(grid, pressure, contour.size, (1 + kernel.exponent) / 2, kernel.surface_length)
    if one_of_many:
        rays, edge = np.arange(contour.size) * (2 * np.pi / contour.size), sector - np.pi / fold
        images = edge + np.mod(rays - edge, 2 * np.pi / fold)
        closer = np.interp(images, rays, closer, period=2 * np.pi)
    inside = (closer < half * fine - ROOT * spacing) & (gaps[:, 0] < ROOT * spacing)
    contour[inside], gaps[inside] = closer[inside], 0.0


def _on(islands: Mask, coarse: Grid, fine: Grid) -> Mask:
    """Which fine cells, their axes parallel, lie on islands or within two of the coarse cells around them."""
    around = binary_dilation(islands, np.ones((3, 3)), iterations=2)
    rows, columns = (
        np.clip(np.rint((values - first) / coarse.spacing).astype(int), 0, count - 1)
        for values, first, count in ((fine.y, coarse.y[0], coarse.ny), (fine.x, coarse.x[0], coarse.nx))
    )
    return np.asarray(around[np.ix_(rows, columns)])
