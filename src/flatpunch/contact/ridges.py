"""Contact outline beside the edges of a tip, to a fraction of a cell.

An edge draws the contact out into a tongue that ends in a point, narrower than a cell long before its end; the cells lose
the last two or three of it, or break it up. The load per length q(x) along the edge knows it better: beside its end the
tongue is a wedge pressed in, and a wedge's half-width b is proportional to q. So b = q (c_0 + c_1 q + c_2 q^2) is fitted where
the tongue is wide enough to be measured, each side of the edge by itself, and q gives the rest. Towards the end b falls like
(x_end - x)^1.25 (read off solutions on 1024 squared, half-space and layers alike), which tells x_end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label, map_coordinates

from flatpunch import bem
from flatpunch._validation import Array
from flatpunch.bem.outline import Outline, first_images, mirrors, trace_outline
from flatpunch.compliance import Kernel
from flatpunch.indenters.profile import Indenter
from flatpunch.indenters.symmetry import rotational_symmetry

_STEP, _LATERAL = 0.5, 0.25
"""Spacing of the samples along and across a ridge, in cells."""
_WIDTH, _CELLS = 0.22, 8.0
"""Half-width up to which a tongue is looked at: over the mean radius, and at least this many cells."""
_MEASURED = 2.0
"""Half-width in cells from which on it is measured by the cells themselves."""
_EXCESS = 0.07
"""By how much these are too many on each side, in cells: those covered in part count (0.04 to 0.11 found)."""
_TAIL = (0.7, 4.0)
"""Half-widths in cells from which the end is extrapolated."""
_TAIL_LENGTH = 8.0
_LOST = 4.0
"""Cells over which the end is extrapolated, and how far it may lie beyond the last of them."""
_POWER = 1.25
_FEWEST = 5
_SAME_RAY = 1e-6


@dataclass(frozen=True, slots=True)
class Trace:
    """Outline of one solution.

    Attributes
    ----------
    contour : ndarray, shape (angles,)
        a(phi) [m] at equal angles from 0; NaN where the contact has no outline.
    radius, area : float
        Mean of a(phi) [m] and area [m^2]; of contacts without outline the area of the cells and the radius of that disc.
    """

    contour: Array
    radius: float
    area: float


def traced(kernel: Kernel, indenter: Indenter, solution: bem.Solution, angles: int) -> Trace:
    """Outline of a boundary element solution, its points along the edges of the tip restored."""
    outline = solution.outline
    pressure = solution.pressure
    if indenter.corners and not np.isfinite(outline.contour[0]):
        outline, pressure = _without_crumbs(kernel, indenter, solution, angles)
    contour = np.array(outline.contour)
    if not np.isfinite(contour[0]):
        return Trace(contour, float(np.sqrt(solution.area / np.pi)), solution.area)
    if not indenter.corners:
        return Trace(contour, outline.radius, outline.area)
    mirrored = mirrors(solution.grid, pressure)
    for corner in indenter.corners:
        ray = np.mod(corner / (2 * np.pi), 1) * angles
        if ray <= float(first_images(ray, angles, mirrored)) + _SAME_RAY:
            _restore(solution.grid, pressure, contour, corner, outline.radius)
    contour = contour[first_images(np.arange(angles), angles, mirrored)]
    fold = rotational_symmetry(indenter)
    if angles % fold == 0:
        # cells lie differently in each sector
        contour = np.tile(contour.reshape(fold, -1).mean(axis=0), fold)
    return Trace(contour, float(contour.mean()), float(np.pi * np.mean(contour**2)))


def _without_crumbs(kernel: Kernel, indenter: Indenter, solution: bem.Solution, angles: int) -> tuple[Outline, Array]:
    """Outline and pressure without cells along the edges that the grid has cut off a tongue."""
    grid = solution.grid
    contact = solution.pressure > 0
    parts, count = label(contact, np.ones((3, 3)))
    if count < 2:
        return solution.outline, solution.pressure
    main = parts == 1 + np.argmax(np.bincount(parts.ravel())[1:])
    rows, columns = np.nonzero(contact & ~main)
    x, y = grid.x[columns], grid.y[rows]
    beside = np.zeros(x.size, dtype=bool)
    for corner in indenter.corners:
        along, across = np.cos(corner) * x + np.sin(corner) * y, np.cos(corner) * y - np.sin(corner) * x
        beside |= (along > 0) & (np.abs(across) < 1.5 * grid.spacing)
    if not beside.all():
        return solution.outline, solution.pressure
    pressure = np.where(main, solution.pressure, 0.0)
    rim = (1 + kernel.exponent) / 2
    return trace_outline(grid, pressure, angles=angles, rim=rim, length=kernel.length), solution.pressure


def _restore(grid: bem.Grid, pressure: Array, contour: Array, corner: float, mean: float) -> None:
    """Replace a(phi) on the rays that meet the tongue along one edge."""
    h = grid.spacing
    widest = max(_WIDTH * mean, _CELLS * h)
    x = np.arange(0.3 * mean, 1.05 * contour.max() + 3 * h, _STEP * h)
    y = np.arange(_LATERAL / 2 * h, 1.5 * widest + 2 * h, _LATERAL * h)
    turn = np.mod(2 * np.pi * np.arange(contour.size) / contour.size - corner + np.pi, 2 * np.pi) - np.pi
    tongues = []
    for side in (1.0, -1.0):
        east = x[:, None] * np.cos(corner) - side * y * np.sin(corner)
        north = x[:, None] * np.sin(corner) + side * y * np.cos(corner)
        places = [(north - grid.y[0]) / h, (east - grid.x[0]) / h]
        width, load = (
            map_coordinates(field, places, order=1, mode="constant").sum(axis=1) * (_LATERAL * h)
            for field in ((pressure > 0).astype(float), pressure)
        )
        tongue = _tongue(x, width, load, widest, h)
        if tongue is None:
            return
        tongues.append(tongue)
    # both sides end at one point
    end = (tongues[0][0][-1] + tongues[1][0][-1]) / 2
    for side, (along, half) in zip((1.0, -1.0), tongues, strict=True):
        along[-1] = max(end, along[-2] + 1e-6 * h)
        angle = np.arctan2(half, along)
        order = np.argsort(angle)
        on_side = (side * turn >= 0) & (np.abs(turn) < angle.max())
        contour[on_side] = np.interp(np.abs(turn[on_side]), angle[order], np.hypot(along, half)[order])


def _tongue(x: Array, width: Array, load: Array, widest: float, h: float) -> tuple[Array, Array] | None:
    """Points (x, b) of one side of a tongue from where it is `widest` to its end; None where there is no tongue."""
    wide = np.flatnonzero(width > widest)
    first = int(wide[-1]) + 1 if wide.size else 0
    x, width, load = x[first:], width[first:], load[first:]
    measured = width > _MEASURED * h
    if measured.sum() < _FEWEST or load.max() <= 0:
        return None
    q = load / load.max()
    design = np.column_stack([q, q**2, q**3])[measured]
    c = np.linalg.lstsq(design, width[measured] - _EXCESS * h, rcond=None)[0]
    half = np.maximum(q * (c[0] + q * (c[1] + q * c[2])), 0.0)
    low, high = (limit * h for limit in _TAIL)
    last = x[half > low][-1] if (half > low).any() else 0.0
    tail = (half > low) & (half < high) & (x > last - _TAIL_LENGTH * h)
    if tail.sum() < 3:
        return None
    slope, start = np.polyfit(x[tail], half[tail] ** (1 / _POWER), 1)
    if slope >= 0:
        return None
    end = min(-start / slope, last + _LOST * h)
    keep = (half > low) & (x < end)
    # a ray meets the tongue once: b/x falls
    along, half = x[keep], half[keep]
    return np.append(along, end), np.append(half, 0.0)
