"""Measured tip on a grid of points: an AFM image of a tip, or one asperity of a scanned surface.

The map is interpolated by a bicubic spline, so that height and slope belong together and the level lines are smooth, and it is
read in polar coordinates about its apex, which is found between the points. Whatever noise the map has is in the spline;
`smoothing` takes it out. A map with several summits, a flat top or noise has no outline about one apex, and boundary elements
alone solve it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, Literal

import numpy as np
import scipy

from flatpunch._support.checks import Array, BadValue, Indices, point, positive
from flatpunch._support.declared import a_length, checked
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch.indenters.measured.height_grid import (
    checked_grid,
    even_spacing,
    first_fall,
    fitted,
    largest_circle,
    lowest_point,
    oriented,
)
from flatpunch.indenters.measured.radial_profile import what_smoothing_changed
from flatpunch.indenters.profile import Indenter
from flatpunch.surfaces.heights import nearest_filled, plane

Smoothing = Annotated[
    float, a_length("smoothing", above=-np.inf, least=0.0, varies=False, remedy="0 interpolates the map as it is.")
]


@readable
@dataclass(frozen=True, slots=True, eq=False)
class HeightMap(Indenter):
    """Tip given by heights on a rectangular grid; the spline rounds its edges over the distance of two points.

    Parameters
    ----------
    x, y : sequence of float, shapes (nx,), (ny,)
        Coordinates of columns and rows [m], strictly monotonic.
    z : array, shape (ny, nx)
        Heights [m]. They may be missing (NaN) at the rim of the map; nothing of the tip is there then.
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
        Largest radius about the apex [m] to be used. By default boundary elements use the whole map, and the other methods the
        largest circle that fits into it, if the map rises from its apex in every direction. With "usable" as much of it as
        does rise.

    Raises
    ------
    ValueError
        If the map is no grid, has gaps inside, its apex lies at the border, or the height does not rise from the apex in every
        direction up to a given `reach`; the message says where, and which reach would do.

    Attributes
    ----------
    centre : tuple of float
        Where the apex is (x, y) [m], between the points.
    shape, spacing : tuple
        Rows and columns of the map, and their mean distances along x and y [m].
    rising, elsewhere : bool, float
        Whether the map rises from its apex in every direction: if not, boundary elements alone solve it. Height of the lowest
        summit beyond the circle in which it does [m]; infinite without one.

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
    rising: bool = field()
    elsewhere: float = field()
    why_not_rising: str = field(repr=False)
    notes: tuple[str, ...] = field(repr=False)
    _spline: scipy.interpolate.RectBivariateSpline = field(repr=False)
    _offset: float = field(repr=False)
    _hessian: tuple[float, float, float] = field(repr=False)
    _map: tuple[Array, Array, Array] | None = field(repr=False)
    # the tip goes on beyond the map, where it was not measured
    cut = True
    # third derivatives jump from point to point of the map
    tabulated = True
    angular_tolerance = 1e-8

    @checked
    def __init__(
        self,
        x: Sequence[float] | Array,
        y: Sequence[float] | Array,
        z: Sequence[Sequence[float]] | Array,
        *,
        apex: Literal["lowest", "highest"] = "lowest",
        level: bool = False,
        smoothing: Smoothing = 0.0,
        near: tuple[float, float] | None = None,
        reach: float | Literal["usable"] | None = None,
    ) -> None:
        columns, rows, heights = checked_grid(x, y, z)
        heights = oriented(heights, apex)
        if near is not None:
            near = point("HeightMap.near", near, "m")
        if level:
            heights = heights - plane(columns, rows, heights)
        if smoothing > max(np.ptp(columns), np.ptp(rows)):
            raise BadValue(
                "HeightMap.smoothing",
                repr(smoothing),
                "is wider than the map, which would become flat. Take some of its spacings.",
            )
        notes: tuple[str, ...] = ()
        if smoothing > 0:
            from scipy.ndimage import gaussian_filter

            before, missing = heights, np.isnan(heights)
            width = smoothing / np.array(even_spacing(columns, rows))
            heights = np.where(missing, np.nan, gaussian_filter(nearest_filled(before), width, mode="nearest"))
            notes = (what_smoothing_changed(smoothing, (heights - before)[~missing]),)
        known = np.where(np.isnan(heights), np.inf, heights)
        lowest = lowest_point(columns, rows, known, near)
        by_itself = reach is None or (isinstance(reach, str) and reach == "usable")
        wanted = largest_circle(columns, rows, lowest) if by_itself else positive("HeightMap.reach", reach, unit="m")
        whole = reach is None
        spline, centre, offset = fitted(
            columns, rows, nearest_filled(heights), lowest, np.inf if whole else max(wanted, 0.0)
        )
        gap = known - known[lowest] - offset
        fits = min(centre[0] - columns[0], columns[-1] - centre[0], centre[1] - rows[0], rows[-1] - centre[1])
        if np.isinf(known).any():
            j, i = np.nonzero(np.isinf(known))
            nearest = np.hypot(columns[i] - centre[0], rows[j] - centre[1]).min()
            fits = min(fits, nearest - max(np.diff(columns).max(), np.diff(rows).max()))
        if not by_itself and wanted > fits:
            raise BadValue(
                "HeightMap.reach",
                repr(wanted),
                f"is more than the map holds about its apex at ({centre[0]:.6g}, {centre[1]:.6g}) m, "
                f"{text(float(fits), 'm')}.",
            )
        at = partial(spline.ev, centre[1], centre[0])
        _set(
            self,
            shape=heights.shape,
            spacing=(float(np.diff(columns).mean()), float(np.diff(rows).mean())),
            centre=centre,
            reach=float(fits if by_itself else wanted),
            smoothing=smoothing,
            notes=notes,
            digest=hashlib.sha256(b"".join(a.tobytes() for a in (columns, rows, heights))).hexdigest()[:16],
            rising=True,
            elsewhere=np.inf,
            why_not_rising="",
            _map=(columns - centre[0], rows - centre[1], gap) if whole else None,
            _spline=spline,
            _offset=offset,
            _hessian=(float(at(dy=2)), float(at(dx=1, dy=1)), float(at(dx=2))),
        )
        self._check_star(usable=by_itself and not whole, whole=whole)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, HeightMap):
            return NotImplemented
        return self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[object, ...]:
        return self.digest, self.centre, self.reach, self._map is None

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together; continued straight beyond the reach.

        Infinite where heights are missing.
        """
        r, phi, inside = self._within(r, phi)
        x, y = self._points(inside, phi)
        gap = self._spline.ev(y, x) - self._offset
        beyond = r - inside
        if np.any(beyond > 0):
            gap = gap + beyond * self._radial(x, y, phi)
        # beside the apex the differences of heights would be rounding; there the spline is its own curvature
        close = r <= self._beside
        gap = np.where(close, 0.5 * r**2 * self._curvature(phi), gap) if np.any(close) else np.asarray(gap)
        return self._known(gap, x, y)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        r, phi, inside = self._within(r, phi)
        slope, close = self._radial(*self._points(inside, phi), phi), r <= self._beside
        return np.where(close, r * self._curvature(phi), slope) if np.any(close) else slope

    def _within(self, r: Array, phi: Array) -> tuple[Array, Array, Array]:
        r, phi = np.broadcast_arrays(np.asarray(r, dtype=float), np.asarray(phi, dtype=float))
        return r, phi, np.minimum(r, self.reach_along(phi))

    def reach_along(self, phi: Array) -> Array:
        """Distance to the border of the map in directions phi [m], or `reach` where that was given."""
        if self._map is None:
            return np.broadcast_to(self.reach, np.shape(phi))
        x, y, _ = self._map
        c, s = np.cos(phi), np.sin(phi)
        with np.errstate(divide="ignore", over="ignore"):
            return np.asarray(
                np.minimum(np.where(c > 0, x[-1], -x[0]) / np.abs(c), np.where(s > 0, y[-1], -y[0]) / np.abs(s))
            )

    def box(self, depth: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Half-widths and centre [m] of the rectangle around all points of the map lower than a depth [m]."""
        if self._map is None:
            return (self.reach, self.reach), (0.0, 0.0)
        x, y, gap = self._map
        low = gap < depth
        sides = []
        for axis, points in ((0, x), (1, y)):
            inside = np.flatnonzero(low.any(axis=axis))
            # to the next points, between which the spline may be as low
            sides.append(points[[max(inside[0] - 1, 0), min(inside[-1] + 1, points.size - 1)]])
        (left, right), (below, above) = sides
        return ((right - left) / 2, (above - below) / 2), ((left + right) / 2, (below + above) / 2)

    def _known(self, gap: Array, x: Array, y: Array) -> Array:
        """A gap at points of the map, infinite where the nearest height is missing."""
        if self._map is None or np.isfinite(self._map[2]).all():
            return gap
        columns, rows, heights = self._map
        i, j = (_nearest(axis, place - c) for axis, place, c in zip((columns, rows), (x, y), self.centre, strict=True))
        return np.where(np.isinf(heights[j, i]), np.inf, gap)

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

    def _check_star(self, *, usable: bool, whole: bool) -> None:
        fall = first_fall(self)
        if fall is None:
            if self._map is not None:
                x, y, gap = self._map
                lowest = gap == scipy.ndimage.minimum_filter(gap, 3, mode="nearest")
                beyond = lowest & (np.hypot(x, y[:, None]) > self.reach)
                _set(self, elsewhere=float(gap[beyond].min(initial=np.inf)))
            return
        remaining = max(self.spacing)
        if usable and fall.usable > 2 * remaining:
            _set(self, reach=fall.usable)
            return
        place = self._points(np.array(fall.radius), np.array(fall.angle))
        remedy = (
            f"set reach={fall.usable:.4g} (or reach='usable') to use what rises, or smooth the map by `smoothing`."
            if fall.usable > 2 * remaining
            else "that is within two points of the apex: smooth the map by `smoothing`, or look at its noise and at `apex`."
        )
        found = (
            f"HeightMap does not rise from its apex in every direction: at x = {_place(place[0], remaining)}, "
            f"y = {_place(place[1], remaining)}, {text(fall.radius, 'm')} from the apex at x = "
            f"{_place(self.centre[0], remaining)}, y = {_place(self.centre[1], remaining)}, the radial slope is "
            f"{round(fall.slope, 9) + 0.0:.3g}."
        )
        if not whole:
            raise ValueError(f"{found} {remedy[0].upper()}{remedy[1:]}")
        _set(
            self,
            rising=False,
            why_not_rising=f"{found} Such a map is solved by boundary elements, method='bem'. For other methods: {remedy}",
            notes=(*self.notes, f"{found} It is solved by boundary elements as it is. For other methods: {remedy}"),
        )


def _place(coordinate: float | Array, spacing: float) -> str:
    """A coordinate of the map [m], to a thousandth of its spacing."""
    step = spacing / 1000
    return text(round(float(coordinate) / step) * step + 0.0, "m")


def _nearest(axis: Array, points: Array) -> Indices:
    """Index of the value of an ascending axis that is nearest to each point."""
    return np.searchsorted((axis[1:] + axis[:-1]) / 2, points)


def _set(tip: HeightMap, **fields: object) -> None:
    for name, value in fields.items():
        object.__setattr__(tip, name, value)
