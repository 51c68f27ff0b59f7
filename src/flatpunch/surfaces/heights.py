"""Tables of heights with coordinates of columns and rows: best plane, missing values, square cells."""

from __future__ import annotations

import numpy as np
import scipy

from flatpunch._support.checks import Array

MOST_OF_IT = 0.5
"""Share of the variance of the heights above which a plane is noted."""


def plane(columns: Array, rows: Array, heights: Array) -> Array:
    """Best plane through the whole map, or what is known of it."""
    x, y = np.meshgrid(columns - columns.mean(), rows - rows.mean())
    known = ~np.isnan(heights)
    scale = np.ptp(columns) + np.ptp(rows)
    table = np.column_stack([np.full(x.size, scale), x.ravel(), y.ravel()])
    solution = np.linalg.lstsq(table[known.ravel()], heights[known] - np.mean(heights[known]), rcond=None)[0]
    return np.asarray(np.mean(heights[known]) + (table @ solution).reshape(x.shape))


def nearest_filled(heights: Array) -> Array:
    """Heights with the missing ones replaced by the nearest known ones."""
    missing = np.isnan(heights)
    if not missing.any():
        return heights
    nearest = scipy.ndimage.distance_transform_edt(missing, return_distances=False, return_indices=True)
    return np.asarray(heights[tuple(nearest)])


def interpolated(columns: Array, rows: Array, heights: Array) -> Array:
    """Heights with the missing ones interpolated linearly between the points around them; outside these the nearest one."""
    missing = np.isnan(heights)
    around = scipy.ndimage.binary_dilation(missing, np.ones((3, 3))) & ~missing
    result = nearest_filled(heights)
    points, wanted = (np.column_stack([rows[j], columns[i]]) for j, i in (np.nonzero(around), np.nonzero(missing)))
    # points in a line span no triangle
    if len(points) > 2 and np.linalg.matrix_rank(points - points.mean(axis=0)) == 2:
        linear = scipy.interpolate.griddata(points, heights[around], wanted, method="linear", rescale=True)
        result[missing] = np.where(np.isnan(linear), result[missing], linear)
    return result


def on_square_cells(columns: Array, rows: Array, heights: Array) -> tuple[Array, float]:
    """Heights by bicubic splines on square cells of the smaller mean distance of points, and this distance [m]."""
    spacing = float(min(np.ptp(axis) / (axis.size - 1) for axis in (columns, rows)))
    along = [axis[0] + spacing * np.arange(int(np.ptp(axis) / spacing * (1 + 1e-9)) + 1) for axis in (rows, columns)]
    return np.asarray(scipy.interpolate.RectBivariateSpline(rows, columns, heights)(*along)), spacing


def tilt(heights: Array, periodic: tuple[bool, bool]) -> tuple[Array, float]:
    """Slopes of the best plane along x and y, per cell, and its share in the variance of the heights.

    Along an axis on which the surface repeats, the plane counts only where the heights jump at the border by half of its rise or
    more: a wave of the length of the period contains a plane too, without a jump.
    """
    sizes = np.array(heights.shape[::-1])
    columns, rows = (np.arange(n, dtype=float) for n in sizes)
    best = plane(columns, rows, heights)
    slopes = np.array([best[0, 1] - best[0, 0], best[1, 0] - best[0, 0]])
    jumps = np.array([np.mean(np.take(heights, -1, axis) - np.take(heights, 0, axis)) for axis in (1, 0)])
    slopes[np.array(periodic) & (np.abs(jumps) < np.abs(slopes) * sizes / 2)] = 0.0
    variance = float(np.var(heights))
    return slopes, float(slopes**2 @ (sizes**2 - 1)) / 12 / variance if variance > 0 else 0.0


def tilt_note(heights: Array, spacing: float, periodic: tuple[bool, bool]) -> tuple[str, ...]:
    """A sentence where a plane is most of the roughness, with its slopes; none otherwise."""
    slopes, share = tilt(heights, periodic)
    if not share > MOST_OF_IT:
        return ()
    x, y = slopes / spacing
    return (
        f"A plane of slopes {x:.3g} along x and {y:.3g} along y makes {share:.0%} of the variance of the heights. If it is the "
        "tilt of the mount, subtract it: level=True of read_topography, level = true in [surface].",
    )
