"""From a table of heights to a spline about an apex, and where it stops rising: the steps that `HeightMap` takes.

The contact theory needs star-shaped level lines. Every contact outline a(phi) is single-valued only if f and df/dr are positive
along every ray; then ln f has its angular mean and harmonics at every radius. Measured tips fail this behind side peaks and in
noise close to the apex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from flatpunch._support.checks import ROUNDING, Array, BadValue, Flags, Indices, numbers, one_of, values
from flatpunch._support.prefixes import text
from flatpunch.indenters._common import FULL_TURN, RAYS
from flatpunch.indenters.profile import Indenter

FEWEST = 7
"""Fewest rows and columns of a map: bicubic splines with two points on either side of the apex."""


def checked_grid(x: object, y: object, z: object) -> tuple[Array, Array, Array]:
    """Coordinates in ascending order and heights to match, shapes (nx,), (ny,), (ny, nx), after all checks.

    Heights that are missing at the rim are NaN.
    """
    columns = values("HeightMap.x", x, minimum=-np.inf, unit="m")
    rows = values("HeightMap.y", y, minimum=-np.inf, unit="m")
    heights = numbers("HeightMap.z", z, "m")
    if heights.shape != (rows.size, columns.size) or min(heights.shape) < FEWEST:
        raise BadValue(
            "HeightMap.z",
            "",
            f"has shape {heights.shape} for {rows.size} values of y and {columns.size} of x; it must be (ny, nx), "
            f"{FEWEST} or more each.",
        )
    heights[~np.isfinite(heights)] = np.nan
    holes = _holes(np.isnan(heights))
    if holes.any():
        j, i = (int(n) for n in np.argwhere(holes)[0])
        raise BadValue(
            "HeightMap.z",
            "",
            f"has {int(holes.sum())} gaps or infinite values inside, the first in row {j}, column {i}; only at "
            "the rim of the map values may be missing. Fill them or cut the map to where it was measured.",
        )
    for name, axis, direction in (("x", 1, np.diff(columns)), ("y", 0, np.diff(rows))):
        if (direction < 0).all():
            heights = np.flip(heights, axis)
        elif not (direction > 0).all():
            raise BadValue(
                f"HeightMap.{name}", "", "must increase or decrease strictly: it is the coordinate of a grid."
            )
    return np.sort(columns), np.sort(rows), np.ascontiguousarray(heights)


def _holes(missing: Flags) -> Flags:
    """Missing values that are not connected with the border, all of them if nothing is known."""
    if not missing.any() or missing.all():
        return missing
    outside = scipy.ndimage.binary_propagation(np.zeros_like(missing), mask=missing, border_value=1)
    return np.asarray(missing & ~outside)


def oriented(heights: Array, apex: str) -> Array:
    """Heights that grow away from the apex."""
    hint = "In an image of a tip that points up the apex is the highest point."
    return heights if one_of("HeightMap.apex", apex, ("lowest", "highest"), hint) == "lowest" else -heights


def even_spacing(columns: Array, rows: Array) -> tuple[float, float]:
    """Distances of rows and columns, for filters in units of points."""
    for name, axis in (("x", columns), ("y", rows)):
        steps = np.diff(axis)
        if np.ptp(steps) > 1e-3 * steps.mean():
            raise BadValue(
                f"HeightMap.{name}", "", "is not evenly spaced, which smoothing needs. Resample the map first."
            )
    return float(np.diff(rows).mean()), float(np.diff(columns).mean())


def lowest_point(columns: Array, rows: Array, heights: Array, near: tuple[float, float] | None) -> tuple[int, int]:
    """Row and column of the apex: the lowest point, or the one reached from `near` by descending.

    Of several lowest ones, as on flat ends and ridges, the one farthest from the border. Missing heights are infinite.
    """
    if near is None:
        lowest = np.argwhere(heights == heights.min())
        inside = np.minimum(lowest, np.array(heights.shape) - 1 - lowest)
        j, i = (int(n) for n in lowest[np.argmax(inside.min(axis=1) + inside.sum(axis=1) / heights.size)])
    else:
        i, j = int(np.argmin(np.abs(columns - near[0]))), int(np.argmin(np.abs(rows - near[1])))
        while True:
            top, left = max(j - 1, 0), max(i - 1, 0)
            window = heights[top : j + 2, left : i + 2]
            dj, di = (int(n) for n in np.unravel_index(np.argmin(window), window.shape))
            if heights[top + dj, left + di] >= heights[j, i]:
                break
            j, i = top + dj, left + di
    if not (1 < j < rows.size - 2 and 1 < i < columns.size - 2):
        raise ValueError(
            f"HeightMap has its apex at the border, at x = {text(float(columns[i]), 'm')}, y = "
            f"{text(float(rows[j]), 'm')}: nothing is "
            "left of it to press in. "
            "Check `apex` (which way the tip points), remove a tilt with level=True, or name a point with `near`."
        )
    return j, i


def largest_circle(columns: Array, rows: Array, at: tuple[int, int]) -> float:
    """Radius of the largest circle about a point of the map that fits into it [m]."""
    x, y = columns[at[1]], rows[at[0]]
    return float(min(x - columns[0], columns[-1] - x, y - rows[0], rows[-1] - y))


def fitted(
    columns: Array, rows: Array, heights: Array, at: tuple[int, int], radius: float
) -> tuple[scipy.interpolate.RectBivariateSpline, tuple[float, float], float]:
    """Spline of the square about the apex, the apex between the points, and the height there."""
    x, y = columns[at[1]], rows[at[0]]
    i, j = _window(columns, x, radius), _window(rows, y, radius)
    # heights above the lowest point: nothing is lost to rounding at the apex
    spline = scipy.interpolate.RectBivariateSpline(rows[j], columns[i], heights[np.ix_(j, i)] - heights[at])
    point = np.array([x, y])
    step = max(float(np.diff(columns).max()), float(np.diff(rows).max()))
    for _ in range(30):
        gradient = np.array([spline.ev(point[1], point[0], dy=1), spline.ev(point[1], point[0], dx=1)])
        mixed = spline.ev(point[1], point[0], dx=1, dy=1)
        curvature = np.array(
            [[spline.ev(point[1], point[0], dy=2), mixed], [mixed, spline.ev(point[1], point[0], dx=2)]]
        )
        smallest = float(np.linalg.eigvalsh(curvature)[0])
        if smallest <= 0:
            # a saddle or plateau of the spline: go downhill
            move = -gradient / max(float(np.hypot(*gradient)), np.finfo(float).tiny) * step / 10
        else:
            move = -np.linalg.solve(curvature, gradient)
            move *= min(1.0, step / 2 / max(float(np.hypot(*move)), np.finfo(float).tiny))
        point = point + move
        if np.abs(move).max() < ROUNDING * step:
            break
    if np.abs(point - [x, y]).max() > 2 * step:
        point = np.array([x, y])
    return spline, (float(point[0]), float(point[1])), float(spline.ev(point[1], point[0]))


def _window(axis: Array, centre: float, radius: float) -> Indices:
    inside = np.flatnonzero(np.abs(axis - centre) <= radius)
    # four points more on each side, so that the cut does not affect the spline
    return np.arange(max(inside[0] - 4, 0), min(inside[-1] + 4 + 1, axis.size))


@dataclass(frozen=True, slots=True)
class Fall:
    """First place, by its distance from the apex, where a tip stops rising.

    Attributes
    ----------
    radius, angle : float
        Polar coordinates about the apex [m], [rad].
    slope : float
        Radial slope there [-], not positive.
    usable : float
        Largest sampled radius below which the tip rises in every direction [m].
    """

    radius: float
    angle: float
    slope: float
    usable: float


def first_fall(indenter: Indenter, reach: float | None = None) -> Fall | None:
    """First place within `reach` [m] where the height does not rise along one of 360 rays, at 400 radii; flat ends count."""
    end = indenter.reach if reach is None else reach
    if not np.isfinite(end):
        end = 1.0
    phi = FULL_TURN * np.arange(RAYS) / RAYS
    # half as many radii may miss a dip that is 2 % wide
    r = np.linspace(0, end, 401)[1:]
    slope = np.empty((r.size, RAYS))
    for rows in np.array_split(np.arange(r.size), 10):
        slope[rows] = indenter.slope(r[rows, None], phi)
    height = np.asarray(indenter.height(r[:1, None], phi))
    falling = np.less_equal(slope, 0)
    falling[0] |= height[0] <= 0
    if not falling.any():
        return None
    i = int(np.argmax(falling.any(axis=1)))
    j = int(np.argmin(slope[i]))
    return Fall(float(r[i]), float(phi[j]), float(slope[i, j]), float(r[i - 1]) if i else 0.0)
