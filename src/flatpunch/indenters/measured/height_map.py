"""Measured tip on a grid of points: an AFM image of a tip, or one asperity of a scanned surface.

The map is interpolated by a bicubic spline, so that height and slope belong together and the level lines are smooth, and it is
read in polar coordinates about its apex, which is found between the points. Whatever noise the map has is in the spline;
`smoothing` takes it out.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Literal

import numpy as np
import scipy

from flatpunch._support.checks import Array, non_negative, point, positive, switch
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch.indenters.measured.height_grid import (
    checked_grid,
    even_spacing,
    fitted,
    largest_circle,
    lowest_point,
    oriented,
    plane,
)
from flatpunch.indenters.measured.rising import first_fall
from flatpunch.indenters.shape import Shape


@readable
@dataclass(frozen=True, slots=True, eq=False)
class HeightMap(Shape):
    """Tip given by heights on a rectangular grid; the spline rounds its edges over the distance of two points.

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

    See Also
    --------
    read_height_map : From the file of a microscope.
    RadialProfile : Round tips.

    Examples
    --------
    >>> x = np.linspace(-1e-6, 1e-6, 41)
    >>> fp.HeightMap(x, x, (x[:, None] ** 2 + x**2) / 2e-6).round
    False
    """

    shape: tuple[int, int]
    spacing: tuple[float, float]
    centre: tuple[float, float]
    reach: float = field()
    smoothing: float
    digest: str
    _spline: scipy.interpolate.RectBivariateSpline = field(repr=False)
    _offset: float = field(repr=False)
    _hessian: tuple[float, float, float] = field(repr=False)

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
        columns, rows, heights = checked_grid(x, y, z)
        smoothing = non_negative("HeightMap.smoothing", smoothing, "0 interpolates the map as it is.", unit="m")
        heights = oriented(heights, apex)
        if near is not None:
            near = point("HeightMap.near", near, "m")
        if switch("HeightMap.level", level):
            heights = heights - plane(columns, rows, heights)
        if smoothing > max(np.ptp(columns), np.ptp(rows)):
            raise ValueError(
                f"HeightMap.smoothing = {smoothing!r} is wider than the map, which would become flat. Take some of its spacings."
            )
        if smoothing > 0:
            from scipy.ndimage import gaussian_filter

            heights = gaussian_filter(heights, smoothing / np.array(even_spacing(columns, rows)), mode="nearest")
        lowest = lowest_point(columns, rows, heights, near)
        circle = largest_circle(columns, rows, lowest)
        by_itself = reach is None or (isinstance(reach, str) and reach == "usable")
        wanted = circle if by_itself else positive("HeightMap.reach", reach, unit="m")
        spline, centre, offset = fitted(columns, rows, heights, lowest, max(wanted, 0.0))
        fits = min(centre[0] - columns[0], columns[-1] - centre[0], centre[1] - rows[0], rows[-1] - centre[1])
        if not by_itself and wanted > fits:
            raise ValueError(
                f"HeightMap.reach = {wanted!r} is more than the map holds about its apex at ({centre[0]:.6g}, "
                f"{centre[1]:.6g}) m, "
                f"{text(float(fits), 'm')}."
            )
        at = partial(spline.ev, centre[1], centre[0])
        _set(
            self,
            shape=heights.shape,
            spacing=(float(np.diff(columns).mean()), float(np.diff(rows).mean())),
            centre=centre,
            reach=float(fits if by_itself else wanted),
            smoothing=smoothing,
            digest=hashlib.sha256(b"".join(a.tobytes() for a in (columns, rows, heights))).hexdigest()[:16],
            _spline=spline,
            _offset=offset,
            _hessian=(float(at(dy=2)), float(at(dx=1, dy=1)), float(at(dx=2))),
        )
        self._check_star(usable=by_itself and reach is not None)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, HeightMap):
            return NotImplemented
        return (self.digest, self.centre, self.reach) == (other.digest, other.centre, other.reach)

    def __hash__(self) -> int:
        return hash((self.digest, self.centre, self.reach))

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
        # beside the apex the differences of heights would be rounding; there the spline is its own curvature
        close = r <= self._beside
        return np.where(close, 0.5 * r**2 * self._curvature(phi), gap) if np.any(close) else np.asarray(gap)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        r, phi, inside = self._within(r, phi)
        slope, close = self._radial(*self._points(inside, phi), phi), r <= self._beside
        return np.where(close, r * self._curvature(phi), slope) if np.any(close) else slope

    def _within(self, r: Array, phi: Array) -> tuple[Array, Array, Array]:
        r, phi = np.broadcast_arrays(np.asarray(r, dtype=float), np.asarray(phi, dtype=float))
        return r, phi, np.minimum(r, self.reach)

    def _points(self, r: Array, phi: Array) -> tuple[Array, Array]:
        return self.centre[0] + r * np.cos(phi), self.centre[1] + r * np.sin(phi)

    def _radial(self, x: Array, y: Array, phi: Array) -> Array:
        along_x, along_y = self._spline.ev(y, x, dy=1), self._spline.ev(y, x, dx=1)
        return np.asarray(along_x * np.cos(phi) + along_y * np.sin(phi))

    @property
    def _beside(self) -> float:
        """Radius below which f is taken from the curvature at the apex: rounding and third derivatives both count 1e-5 there."""
        return 1e-5 * min(self.spacing)

    def _curvature(self, phi: Array) -> Array:
        xx, xy, yy = self._hessian
        c, s = np.cos(phi), np.sin(phi)
        return np.asarray(xx * c * c + 2 * xy * c * s + yy * s * s)

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
            f"HeightMap does not rise from its apex in every direction: at x = {text(float(place[0]), 'm')}, y = "
            f"{text(float(place[1]), 'm')}, "
            f"{text(fall.radius, 'm')} from the apex at ({self.centre[0]:.6g}, {self.centre[1]:.6g}) m, the radial slope is "
            f"{fall.slope:.3g}. {remedy}"
        )


def _set(tip: HeightMap, **fields: object) -> None:
    for name, value in fields.items():
        object.__setattr__(tip, name, value)
