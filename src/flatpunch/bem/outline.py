"""Outline of a contact to a fraction of a cell.

Towards the rim of a smooth contact the pressure falls like the root of the distance (like its power (1 + k)/2 on a
power-law half-space), so p^2 is linear there. From where the cells end along every ray from the point of first touch p^2 is read
across the rim, one to four cells inside, and the parabola through it followed to zero: 0.00-0.03 cells off on average, 0.03-0.1
cells scatter. Points move across the rim, and along rays that graze it in two steps, as there the cells are a staircase.

Under a layer the root holds over a part of its thickness only, and a parabola that bends upwards ends too far out, by half a
cell for each cell^-1 of its curvature over its slope: that is made up for, and 0.05 cells are left of 0.1 to 0.2. With fewer
than three cells in the thickness, or twelve where the parabola is much bent, the outline is that of the cells themselves,
blurred over two of them. These count when they are covered in part, 0.13 cells too many for every medium alike; that is taken
off, and 0.15-0.2 cells of scatter are left. So it is in notches of the outline, where parabolas bend upwards on every medium.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter, label, map_coordinates

from flatpunch._support.checks import Array
from flatpunch.bem.grid import Grid, Mask, check_square

_DEPTHS = np.array([1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0])
"""Distances from the rim, in cells, at which the pressure is read."""

_NORMAL_CELLS, _STEEPEST, _FLATTEST = 1.5, 30.0, 1e-3
"""Cells over which the direction of the rim is averaged, the largest slope of an outline that is told, and the least by how much
contact thins out along a ray."""

_GRAZING = 1.2
"""Slope d ln a/d phi of an outline from which on rays graze it."""

_JUMP = 0.25
"""Difference of ln a from ray to ray from on which the outline jumps onto a needle."""

_FARTHEST, _FARTHEST_GRAZING, _FARTHEST_AGAIN = 1.0, 1.5, 0.5
"""Cells from a rough outline up to which a parabola's zero is believed, at corners the fit fails: in general, along rays that
graze the outline, and from what these have told."""

_RESOLVED, _PERHAPS = 12.0, 3.0
"""Cells in the length over which the pressure is root-like, from which on the fit is trusted, and if it is hardly bent."""

_BENT = -0.12, 0.4
"""Curvatures of the parabola over its slope, per cell, between which it is: stiff films bend it more downwards,
thin incompressible layers more upwards."""

_TOO_FAR = 0.55
"""Cells by which a parabola ends too far out, over that curvature where it is positive (0.4 to 0.7 found)."""

_BLURS = 2.0, 1.4
"""Cells over which cells are blurred: what that takes off where their outline is convex follows from the two."""

_EXCESS = 0.13
"""Cells by which outlines of the cells themselves are too large, measured across the rim (0.05 to 0.2 found)."""

_FEWEST = 6.0
"""Cells from the centre to the rim below which no line is fitted."""

_SAMPLES, _AROUND = 4, 2
"""Samples a cell along rays, and cells around the first of them within which lies all that they and the next one depend on."""

_RAYS = 180
"""Rays that are looked along at least: radius and area are means over them, and each needs its neighbours' slope."""


@dataclass(frozen=True, slots=True)
class Outline:
    """Contact outline a(phi) about the point of first touch.

    Attributes
    ----------
    phi : ndarray, shape (n,)
        Polar angles [rad], equally spaced over the full turn.
    contour : ndarray, shape (n,)
        a(phi), the farthest points in contact [m]; NaN where there is none, for the reason in `note`.
    radius : float
        Mean radius a0 [m]: the mean over the polar angle of a, less what lies in `gaps`.
    area : float
        Area inside the outline less that in `gaps` [m^2], or of the cells in contact where there is no outline.
    half_axes : (float, float)
        Half-axes of the ellipse with the same second moments, the longer first [m].
    eccentricity : float
        sqrt(1 - (b/a)^2) of these half-axes.
    gaps : ndarray, shape (n, 2)
        Where rays leave the contact and meet it again: the sums of r_2 - r_1 [m] and of r_2^2 - r_1^2 [m^2] from leaving to
        meeting it.
    note : str
        Why there is no outline, or why it is only good to a cell; empty otherwise.
    """

    phi: Array
    contour: Array
    radius: float
    area: float
    half_axes: tuple[float, float]
    eccentricity: float
    gaps: Array
    note: str = ""


def trace_outline(
    grid: Grid,
    pressure: Array,
    *,
    angles: int = 360,
    rim: float = 0.5,
    length: float = np.inf,
    sharp: bool = False,
) -> Outline:
    """Outline from the pressure on a grid.

    Parameters
    ----------
    grid : Grid
        The grid.
    pressure : ndarray, shape (ny, nx)
        Pressure; positive in contact, zero elsewhere.
    angles : int
        Number of polar angles; radius and area do not depend on it.
    rim : float
        Power of the distance with which the pressure falls to zero at the rim.
    length : float
        Thickness of the layer at the surface [m], where there is one.
    sharp : bool
        Whether the rim is an edge of the indenter, where pressure is singular; the outline then is that of the cells.
    """
    check_square(grid)
    rays = enough_rays(angles)
    told = slice(None, None, rays // angles)
    phi = 2 * np.pi * np.arange(rays) / rays
    contact = pressure > 0
    cells = float(contact.sum()) * grid.cell_area
    note = _why_none(grid, contact)
    if note:
        none, nothing = float("nan"), np.full((angles, 2), np.nan)
        return Outline(phi[told], nothing[:, 0], none, cells, (none, none), none, nothing, note)
    contour, narrowest, gaps = rim_along(grid, pressure, rays, rim, length, sharp)
    if narrowest < _FEWEST:
        note = (
            f"the contact is only {2 * narrowest:.0f} cells across at its narrowest: its outline is good "
            "to about a cell. Use more cells."
        )
    axes = _half_axes(phi, contour)
    eccentricity = float(np.sqrt(max(0.0, 1 - (axes[1] / axes[0]) ** 2)))
    area = cells if sharp else float(np.pi * np.mean(contour**2 - gaps[:, 1]))
    radius = float(np.mean(contour - gaps[:, 0]))
    return Outline(phi[told], contour[told], radius, area, axes, eccentricity, gaps[told], note)


def enough_rays(angles: int) -> int:
    """Number of rays to look along for an outline at `angles` polar angles, a multiple of it."""
    return angles * -(-_RAYS // angles)


def rim_along(
    grid: Grid, pressure: Array, angles: int, rim: float, length: float, sharp: bool = False
) -> tuple[Array, float, Array]:
    """Radii where the contact ends along rays from the point of first touch, the least of them in cells, and the gaps before.

    The parameters are those of `trace_outline`, the gaps those of `Outline`.
    """
    phi = 2 * np.pi * np.arange(angles) / angles
    # rays that are mirror images of others follow from those
    different, of_ray = np.unique(first_images(np.arange(angles), angles, mirrors(grid, pressure)), return_inverse=True)
    rays, contact = phi[different], (pressure > 0).astype(float)
    contour, gaps = _cell_outline(grid, contact, rays)
    narrowest = float(contour.min() / grid.spacing)
    if narrowest < _FEWEST or sharp:
        return contour[of_ray], narrowest, gaps[of_ray]
    slope = _slope_across(grid, contact, phi, contour[of_ray])
    inwards, by_cells = np.full_like(contour, _EXCESS * grid.spacing), np.ones(rays.size, dtype=bool)
    if length >= _PERHAPS * grid.spacing:
        down, bends = _down_to_zero(grid, pressure, rays, contour, slope[different], rim)
        if length >= _RESOLVED * grid.spacing or _BENT[0] < _median(bends) < _BENT[1]:
            # in notches of the outline the root is true of less than a cell
            by_cells = bends > _BENT[1]
            inwards[~by_cells] = down[~by_cells]
    if by_cells.any():
        # contact as thin as a cell is blurred away
        blurred = _blurred_outline(grid, contact, rays[by_cells])
        contour[by_cells] = np.where(np.isfinite(blurred), blurred, contour[by_cells])
    return _moved(phi, contour[of_ray], slope, inwards[of_ray]), narrowest, gaps[of_ray]


def _blurred_outline(grid: Grid, contact: Array, phi: Array) -> Array:
    """Outline of the cells, blurred over two of them."""
    wide, narrow = (_cell_outline(grid, gaussian_filter(contact, width), phi)[0] for width in _BLURS)
    # what that takes off where it is convex grows like the square of the width
    return np.asarray(narrow + (narrow - wide) / ((_BLURS[0] / _BLURS[1]) ** 2 - 1))


def mirrors(grid: Grid, values: Array) -> tuple[bool, bool]:
    """Whether an array on a grid around the origin is its own mirror image along x and along y."""
    along_x = grid.center[0] == 0 and bool(np.array_equal(values, values[:, ::-1]))
    return along_x, grid.center[1] == 0 and bool(np.array_equal(values, values[::-1]))


def first_images(position: Any, turn: int, mirrored: tuple[bool, bool]) -> Any:
    """Smallest of the mirror images of positions on a full turn, of length `turn`, from the x axis on."""
    images = [position]
    if mirrored[1]:
        images.append(np.mod(-position, turn))
    if mirrored[0] and turn % 2 == 0:
        images += [np.mod(turn // 2 - image, turn) for image in images]
    return np.minimum.reduce(images)


def _why_none(grid: Grid, contact: Mask) -> str:
    """Reason why the contact has no outline a(phi); empty if it has one."""
    if not contact.any():
        return "there is no contact"
    if _read(grid, contact.astype(float), np.zeros((1, 1)), np.zeros((1, 1)))[0, 0] <= 0.5:
        return "the point of first touch is not in contact, so the contact has no outline a(phi) about it; area counts cells"
    if label(contact, np.ones((3, 3)))[1] > 1 or label(~contact)[1] > 1:
        return "the contact has several parts or holes, so it has no outline a(phi); area counts cells"
    return ""


def _cell_outline(grid: Grid, indicator: Array, phi: Array) -> tuple[Array, Array]:
    """Largest radius along each ray where the indicator of contact, interpolated, falls through one half; and gaps before it.

    NaN along rays that meet nothing.
    """
    h, step = grid.spacing, 1 / _SAMPLES
    rows, columns = np.nonzero(indicator)
    cells = np.arange(np.ceil(np.hypot(grid.x[columns], grid.y[rows]).max() / h) + 3)
    radii = (cells[:, None] + step * np.arange(_SAMPLES)).ravel()
    values = _read_beside_rim(grid, indicator, cells, phi)
    met = values[:, -2::-1] >= 0.5
    last, nothing = values.shape[1] - 2 - np.argmax(met, axis=1), ~met.any(axis=1)
    ray = np.arange(phi.size)
    inner, outer = values[ray, last], np.where(nothing, np.nan, values[ray, last + 1])
    out = (values < 0.5) & (radii < radii[last, None])
    gaps = np.column_stack([h * step * out.sum(axis=1), h**2 * step * (out @ (2 * radii))])
    return np.asarray(h * (radii[last] + step * (inner - 0.5) / (inner - outer))), gaps


def _down_to_zero(
    grid: Grid, pressure: Array, phi: Array, rough: Array, slope: Array, rim: float
) -> tuple[Array, Array]:
    """Ways [m] from a rough outline across the rim to the zeros of parabolas through p^(1/rim) just inside, > 0 inwards.

    Of the outline d ln a/d phi is `slope`. With them the parabolas' curvatures over their slopes [1/cell], less than zero where
    they bend downwards.
    """
    values, rough_rim = pressure ** (1 / rim), rough * np.exp(1j * phi)
    inwards = _inwards(phi, slope)
    way, bends = _zero(grid, values, rough_rim, inwards)
    way += _TOO_FAR * min(max(_median(bends), 0.0), _BENT[1])
    # along rays that graze the rim the rough outline is a staircase, of which one step is not far enough from the rim
    grazed = np.abs(slope) > _GRAZING
    way[~(np.abs(way) < np.where(grazed, _FARTHEST_GRAZING, _FARTHEST))] = np.nan
    closer = (rough_rim + np.nan_to_num(way) * grid.spacing * inwards)[grazed]
    rest, own = _zero(grid, values, closer, inwards[grazed])
    rest += _TOO_FAR * np.clip(own, 0.0, _BENT[1])
    way[grazed] += np.where(np.abs(rest) < _FARTHEST_AGAIN, rest, np.nan)
    # where nothing is believed the cells themselves know the rim to about one cell
    return grid.spacing * np.nan_to_num(way), bends


def _median(bends: Array) -> float:
    """Curvature that most parabolas have; those that tell nothing count as straight."""
    return float(np.median(np.nan_to_num(bends, posinf=0.0)))


def _inwards(phi: Array, slope: Array) -> Array:
    """Direction across the rim as complex numbers of length one."""
    return np.asarray(np.exp(1j * phi) * (1j * slope - 1) / np.hypot(1.0, slope))


def _zero(grid: Grid, values: Array, start: Array, inwards: Array) -> tuple[Array, Array]:
    """Cells from points inwards to where parabolas through values on a grid vanish, and their curvatures over their slopes.

    Points and directions are complex numbers. Where a parabola does not vanish the first is far or not finite; the second is
    infinite where it has no slope to begin with, and NaN where values do not grow inwards.
    """
    points = start[:, None] + grid.spacing * _DEPTHS * inwards[:, None]
    # c0 + c1 s + c2 s^2, s in cells from the points inwards
    basis = np.vander(_DEPTHS, 3, increasing=True)
    read = _read(grid, values, points.real, points.imag)
    c0, c1, c2 = np.linalg.lstsq(basis, read.T, rcond=None)[0]
    c0[read[:, -1] <= read[:, 0]] = np.nan
    with np.errstate(invalid="ignore", divide="ignore"):
        zero = -2 * c0 / (c1 + np.sqrt(np.maximum(c1**2 - 4 * c0 * c2, 0.0)))
        return zero, np.where(np.isnan(c0), np.nan, np.where(c1 > 0, c2 / c1, np.inf))


def _moved(phi: Array, contour: Array, slope: Array, inwards: Array) -> Array:
    """An outline at equal angles after its points have moved across the rim: along rays that graze it they would scatter."""
    moved = contour * np.exp(1j * phi) + inwards * _inwards(phi, slope)
    angle = np.mod(np.angle(moved), 2 * np.pi)
    order = np.argsort(angle)
    # round the full turn
    angle, radius = np.pad(angle[order], 1, mode="wrap"), np.pad(np.abs(moved)[order], 1, mode="wrap")
    angle[[0, -1]] += [-2 * np.pi, 2 * np.pi]
    after = np.searchsorted(angle[1:-1], phi) + 1
    gap = angle[after] - angle[after - 1]
    share = np.divide(phi - angle[after - 1], gap, out=np.zeros_like(gap), where=gap > 0)
    # between rays that meet a needle and those that miss it there is no rim to follow
    jumps = np.abs(np.log(radius[after] / radius[after - 1])) > _JUMP
    share = np.where(jumps, np.round(share), share)
    return np.asarray(radius[after - 1] + share * (radius[after] - radius[after - 1]))


def _slope_across(grid: Grid, contact: Array, phi: Array, contour: Array) -> Array:
    """d ln a/d phi of an outline of the cells, by how these thin out across it: rays that graze it tell nothing of that."""
    h, blurred = grid.spacing, gaussian_filter(contact, _NORMAL_CELLS)
    x, y = contour * np.cos(phi), contour * np.sin(phi)
    along_x = _read(grid, blurred, x + h, y) - _read(grid, blurred, x - h, y)
    along_y = _read(grid, blurred, x, y + h) - _read(grid, blurred, x, y - h)
    thinning = -(along_x + 1j * along_y) * np.exp(-1j * phi)
    return np.asarray(np.clip(-thinning.imag / np.maximum(thinning.real, _FLATTEST), -_STEEPEST, _STEEPEST))


def _read(grid: Grid, values: Array, x: Array, y: Array) -> Array:
    """Values on a grid at points [m], zero beyond it."""
    places = [(y - grid.y[0]) / grid.spacing, (x - grid.x[0]) / grid.spacing]
    return np.asarray(map_coordinates(values, places, order=1, mode="constant"))


def _read_beside_rim(grid: Grid, indicator: Array, cells: Array, phi: Array) -> Array:
    """The indicator along rays, so many samples a cell: read near its rim, elsewhere one inside and zero outside.

    Parameters
    ----------
    grid, indicator
        Cells and how much they are in contact; the rim is where that is one half.
    cells : array, shape (n,)
        Radii of the first samples in each cell [cells].
    phi : array, shape (m,)
        Polar angles of the rays.

    Returns
    -------
    ndarray, shape (m, n _SAMPLES)
        Exact on both sides of every crossing of the rim.
    """
    # beyond the grid nothing is in contact
    inside = np.pad(indicator >= 0.5, _AROUND)
    beside = np.zeros_like(inside)
    beside[1:] |= inside[1:] != inside[:-1]
    beside[:, 1:] |= inside[:, 1:] != inside[:, :-1]
    for axis in (0, 1):
        around = beside.copy()
        for shift in range(-_AROUND, _AROUND + 1):
            around |= np.roll(beside, shift, axis)
        beside = around
    direction, h = np.exp(1j * phi)[:, None], grid.spacing
    nearest = [
        np.clip(np.rint(cells * way + (_AROUND - first / h)).astype(np.intp), 0, size - 1)
        for way, first, size in zip((direction.imag, direction.real), (grid.y[0], grid.x[0]), inside.shape, strict=True)
    ]
    values = np.repeat(inside[*nearest].astype(float), _SAMPLES, axis=1).reshape(phi.size, cells.size, _SAMPLES)
    ray, cell = np.nonzero(beside[*nearest])
    points = h * (cells[cell, None] + np.arange(_SAMPLES) / _SAMPLES) * direction[ray]
    values[ray, cell] = _read(grid, indicator, points.real, points.imag)
    return values.reshape(phi.size, -1)


def _half_axes(phi: Array, contour: Array) -> tuple[float, float]:
    """Half-axes of the ellipse with the outline's second moments, the longer first."""
    weight = contour**2 / 2
    area = weight.mean()
    centre = np.array([(contour**3 * np.cos(phi)).mean(), (contour**3 * np.sin(phi)).mean()]) / (3 * area)
    fourth = contour**4 / (4 * area)
    xx = (fourth * np.cos(phi) ** 2).mean() - centre[0] ** 2
    yy = (fourth * np.sin(phi) ** 2).mean() - centre[1] ** 2
    xy = (fourth * np.cos(phi) * np.sin(phi)).mean() - centre[0] * centre[1]
    small, large = np.linalg.eigvalsh([[xx, xy], [xy, yy]])
    return 2 * float(np.sqrt(large)), 2 * float(np.sqrt(small))
