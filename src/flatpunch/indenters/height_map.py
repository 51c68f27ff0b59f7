"""Measured tip on a grid of points: an AFM image of a tip, or one asperity of a scanned surface.

The map is interpolated by a bicubic spline, so that height and slope belong together and the level lines are smooth, and it is
read in polar coordinates about its apex, which is found between the points. Whatever noise the map has is in the spline;
`smoothing` takes it out.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from scipy.interpolate import RectBivariateSpline
from scipy.ndimage import gaussian_filter

from flatpunch._validation import Array, Indices, non_negative, positive, values
from flatpunch.indenters.star import first_fall

_MARGIN = 4
"""Points kept around the largest circle, so that the spline does not feel the cut."""
_SMALLEST = 7
"""Points across the map that leave a circle worth the name."""


@dataclass(frozen=True, slots=True, eq=False)
class HeightMap:
    """Tip given by heights on a rectangular grid.

    Parameters
    ----------
    x, y : sequence of float, shapes (nx,), (ny,)
        Coordinates of columns and rows [m], strictly monotonic.
    z : array, shape (ny, nx)
        Heights [m].
    apex : "lowest" or "highest"
        Which way the tip points in the map. "lowest": z grows away from the apex, as the gap f does. "highest": the apex is the
        top of the map, as in images of tips and in scans of surfaces whose asperities are meant.
    level : bool
        Subtract the plane that fits the whole map best, as scans need. It is wrong for a single tip that is not in the middle.
    smoothing : float
        Standard deviation of a Gaussian by which the map is smoothed [m]; 0 interpolates it as it is.
    near : pair of float, optional
        A point (x, y) [m]; the apex is then found from there by descending, not as the lowest point of the map.
    reach : float or "usable", optional
        Largest radius about the apex [m] to be used, by default the largest circle that fits into the map. With "usable" as
        much of it as rises in every direction.

    Raises
    ------
    ValueError
        If the map is no grid, has gaps, its apex lies at the border, or the height does not rise from the apex in every
        direction up to `reach`; the message says where, and which reach would do.

    Attributes
    ----------
    centre : tuple of float
        Where the apex is (x, y) [m], between the points.
    shape, spacing : tuple
        Rows and columns of the map, and their mean distances along x and y [m].
    """

    shape: tuple[int, int]
    spacing: tuple[float, float]
    centre: tuple[float, float]
    reach: float
    smoothing: float
    digest: str
    _spline: RectBivariateSpline = field(repr=False)
    _offset: float = field(repr=False)

    def __init__(
        self,
        x: Sequence[float] | Array,
        y: Sequence[float] | Array,
        z: Sequence[Sequence[float]] | Array,
        *,
        apex: Literal["lowest", "highest"] = "lowest",
        level: bool = False,
        smoothing: float = 0.0,
        near: tuple[float, float] | None = None,
        reach: float | Literal["usable"] | None = None,
    ) -> None:
        columns, rows, heights = _checked_grid(x, y, z)
        smoothing = non_negative("HeightMap.smoothing", smoothing, "0 interpolates the map as it is.")
        heights = _oriented(heights, apex)
        if level:
            heights = heights - _plane(columns, rows, heights)
        if smoothing > 0:
            heights = gaussian_filter(heights, smoothing / np.array(_even_spacing(columns, rows)), mode="nearest")
        lowest = _lowest_point(columns, rows, heights, near)
        circle = _largest_circle(columns, rows, lowest)
        wanted = circle if reach is None or reach == "usable" else positive("HeightMap.reach", reach)
        spline, centre, offset = _fitted(columns, rows, heights, lowest, max(wanted, 0.0))
        fits = min(centre[0] - columns[0], columns[-1] - centre[0], centre[1] - rows[0], rows[-1] - centre[1])
        if reach is not None and reach != "usable" and wanted > fits:
            raise ValueError(
                f"HeightMap.reach = {wanted!r} is more than the map holds about its apex at ({centre[0]:.6g}, "
                f"{centre[1]:.6g}) m, "
                f"{fits:.6g} m."
            )
        _set(
            self,
            shape=heights.shape,
            spacing=(float(np.diff(columns).mean()), float(np.diff(rows).mean())),
            centre=centre,
            reach=float(min(wanted, fits)),
            smoothing=smoothing,
            digest=hashlib.sha256(b"".join(a.tobytes() for a in (columns, rows, heights))).hexdigest()[:16],
            _spline=spline,
            _offset=offset,
        )
        self._check_star(usable=reach == "usable")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, HeightMap):
            return NotImplemented
        return (self.digest, self.centre, self.reach) == (other.digest, other.centre, other.reach)

    def __hash__(self) -> int:
        return hash((self.digest, self.centre, self.reach))

    @property
    def exponent(self) -> None:
        """None: no power law."""
        return None

    @property
    def corners(self) -> tuple[float, ...]:
        """No edges: the spline rounds them over the distance of two points."""
        return ()

    @property
    def rings(self) -> tuple[float, ...]:
        """No kinks."""
        return ()

    @property
    def round(self) -> bool:
        """False."""
        return False

    @property
    def tabulated(self) -> bool:
        """True: third derivatives jump from point to point of the map."""
        return True

    @property
    def angular_tolerance(self) -> float:
        """Third derivatives of the spline jump from point to point."""
        return 1e-8

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together; continued straight beyond the reach."""
        r, phi, inside = self._within(r, phi)
        x, y = self._points(inside, phi)
        gap = self._spline.ev(y, x) - self._offset
        beyond = r - inside
        if np.any(beyond > 0):
            gap = gap + beyond * self._radial(x, y, phi)
        # rounding beside the apex must not make the gap negative
        return np.where(r == 0, 0.0, np.maximum(gap, 0.0))

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        _, phi, inside = self._within(r, phi)
        return np.asarray(self._radial(*self._points(inside, phi), phi))

    def _within(self, r: Array, phi: Array) -> tuple[Array, Array, Array]:
        r, phi = np.broadcast_arrays(np.asarray(r, dtype=float), np.asarray(phi, dtype=float))
        return r, phi, np.minimum(r, self.reach)

    def _points(self, r: Array, phi: Array) -> tuple[Array, Array]:
        return self.centre[0] + r * np.cos(phi), self.centre[1] + r * np.sin(phi)

    def _radial(self, x: Array, y: Array, phi: Array) -> Array:
        along_x, along_y = self._spline.ev(y, x, dy=1), self._spline.ev(y, x, dx=1)
        return np.asarray(along_x * np.cos(phi) + along_y * np.sin(phi))

    def _check_star(self, *, usable: bool) -> None:
        fall = first_fall(self)
        if fall is None:
            return
        remaining = max(self.spacing)
        if usable and fall.usable > 2 * remaining:
            _set(self, reach=fall.usable)
            return
        place = self._points(np.array(fall.radius), np.array(fall.angle))
        remedy = (
            f"Set reach={fall.usable:.4g} (or reach='usable') to use what rises, or smooth the map by `smoothing`."
            if fall.usable > 2 * remaining
            else "That is within two points of the apex: smooth the map by `smoothing`, or look at its noise and at `apex`."
        )
        raise ValueError(
            f"HeightMap does not rise from its apex in every direction: at x = {float(place[0]):.6g} m, y = "
            f"{float(place[1]):.6g} m, "
            f"{fall.radius:.4g} m from the apex at ({self.centre[0]:.6g}, {self.centre[1]:.6g}) m, the radial slope is "
            f"{fall.slope:.3g}. {remedy}"
        )


def _set(tip: HeightMap, **fields: object) -> None:
    for name, value in fields.items():
        object.__setattr__(tip, name, value)


def _checked_grid(x: object, y: object, z: object) -> tuple[Array, Array, Array]:
    columns = values("HeightMap.x", x, minimum=-np.inf)
    rows = values("HeightMap.y", y, minimum=-np.inf)
    try:
        heights = np.array(z, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(
            "HeightMap.z must be a table of numbers, one row for each y and one column for each x."
        ) from None
    if heights.shape != (rows.size, columns.size) or min(heights.shape) < _SMALLEST:
        raise ValueError(
            f"HeightMap.z has shape {heights.shape} for {rows.size} values of y and {columns.size} of x; it must "
            "be (ny, nx), "
            f"{_SMALLEST} or more each."
        )
    missing = ~np.isfinite(heights)
    if missing.any():
        j, i = (int(n) for n in np.argwhere(missing)[0])
        raise ValueError(
            f"HeightMap.z has {int(missing.sum())} gaps or infinite values, the first in row {j}, column {i}. "
            "Fill them or cut the "
            "map to where it was measured."
        )
    for name, axis, direction in (("x", 1, np.diff(columns)), ("y", 0, np.diff(rows))):
        if (direction < 0).all():
            heights = np.flip(heights, axis)
        elif not (direction > 0).all():
            raise ValueError(f"HeightMap.{name} must increase or decrease strictly: it is the coordinate of a grid.")
    return np.sort(columns), np.sort(rows), np.ascontiguousarray(heights)


def _oriented(heights: Array, apex: str) -> Array:
    if apex not in ("lowest", "highest"):
        raise ValueError(
            f"HeightMap.apex = {apex!r} must be 'lowest' (heights grow away from the apex) or 'highest' (image of "
            "a tip that points "
            "up)."
        )
    return heights if apex == "lowest" else -heights


def _even_spacing(columns: Array, rows: Array) -> tuple[float, float]:
    """Distances of rows and columns, for filters in units of points."""
    for name, axis in (("x", columns), ("y", rows)):
        steps = np.diff(axis)
        if np.ptp(steps) > 1e-3 * steps.mean():
            raise ValueError(f"HeightMap.{name} is not evenly spaced, which smoothing needs. Resample the map first.")
    return float(np.diff(rows).mean()), float(np.diff(columns).mean())


def _plane(columns: Array, rows: Array, heights: Array) -> Array:
    """Best plane through the whole map."""
    x, y = columns - columns.mean(), (rows - rows.mean())[:, None]
    rest = heights - heights.mean()
    along_x, along_y = (rest * x).sum() / (x * x).sum() / rows.size, (rest * y).sum() / (y * y).sum() / columns.size
    return np.asarray(heights.mean() + along_x * x + along_y * y)


def _lowest_point(columns: Array, rows: Array, heights: Array, near: tuple[float, float] | None) -> tuple[int, int]:
    """Row and column of the apex: the lowest point, or the one reached from `near` by descending."""
    if near is None:
        j, i = (int(n) for n in np.unravel_index(np.argmin(heights), heights.shape))
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
            f"HeightMap has its apex at the border, at x = {columns[i]:.6g} m, y = {rows[j]:.6g} m: nothing is "
            "left of it to press in. "
            "Check `apex` (which way the tip points), remove a tilt with level=True, or name a point with `near`."
        )
    return j, i


def _largest_circle(columns: Array, rows: Array, at: tuple[int, int]) -> float:
    x, y = columns[at[1]], rows[at[0]]
    return float(min(x - columns[0], columns[-1] - x, y - rows[0], rows[-1] - y))


def _fitted(
    columns: Array, rows: Array, heights: Array, at: tuple[int, int], radius: float
) -> tuple[RectBivariateSpline, tuple[float, float], float]:
    """Spline of the square about the apex, the apex between the points, and the height there."""
    x, y = columns[at[1]], rows[at[0]]
    i, j = _window(columns, x, radius), _window(rows, y, radius)
    # heights from the lowest point on: nothing is lost to rounding at the apex
    spline = RectBivariateSpline(rows[j], columns[i], heights[np.ix_(j, i)] - heights[at])
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
            move = -gradient / max(float(np.hypot(*gradient)), 1e-300) * step / 10
        else:
            move = -np.linalg.solve(curvature, gradient)
            move *= min(1.0, step / 2 / max(float(np.hypot(*move)), 1e-300))
        point = point + move
        if np.abs(move).max() < 1e-14 * step:
            break
    if np.abs(point - [x, y]).max() > 2 * step:
        point = np.array([x, y])
    return spline, (float(point[0]), float(point[1])), float(spline.ev(point[1], point[0]))


def _window(axis: Array, centre: float, radius: float) -> Indices:
    inside = np.flatnonzero(np.abs(axis - centre) <= radius)
    return np.arange(max(inside[0] - _MARGIN, 0), min(inside[-1] + _MARGIN + 1, axis.size))
