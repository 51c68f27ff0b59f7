"""Outline of a contact to a fraction of a cell.

The outermost cell in contact along a ray gives the rim to about half a cell. Towards the rim of a smooth contact the pressure
falls like a power q of the distance s (q = 1/2; (1 + k)/2 on a power-law half-space), so p^(1/q) is smooth in s and vanishes at
the rim. It is read one to four cells inside, across the rim, and the parabola through these values is followed to zero: within
0.1 cells of the true rim. Where this zero is more than a cell from the rim of the cells (corners, lobes a few cells wide), the
cells count, less the share of a cell by which they reach too far. So they do where the surface layer, or the depth over which a
graded surface changes, is only some cells thick and the power law holds nowhere; there the staircase of the cells is smoothed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, label, map_coordinates

from flatpunch._support.checks import ANGLES, AT_ONCE, Array, follows, positive, switch, whole
from flatpunch._support.readable import readable
from flatpunch.bem.grid import Grid, Mask, check_grid, on_grid

EXCESS = 0.13
"""Distance in cells by which cells in contact reach beyond the rim; twice as much makes areas 0.3 % too small at 256 cells."""

_DEPTHS = np.arange(1.0, 4.5, 0.5)
"""Distances from the rim, in cells, at which the pressure is read; half as deep, the staircase of the rim doubles the error."""

_FEWEST = 6.0
"""Cells from the point of first touch to the rim below which the outline is that of the cells; half leaves the fit no room."""

_SMOOTH = 1.5
"""Width in cells of the filter that takes the staircase out of the rim of the cells; half as much leaves some of it."""


@readable
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
        Mean radius a0 [m]: the mean over the polar angle of the length of the ray in contact.
    area : float
        Contact area [m^2]; of the cells in contact where there is no outline.
    half_axes : (float, float)
        Half-axes of the ellipse with the same second moments, the longer first [m].
    eccentricity : float
        sqrt(1 - (b/a)^2) of these half-axes.
    error : float
        Estimated error of the contour [m]: its largest distance from the rim of the cells, along the normal.
    note : str
        Why there is no outline, or why it is only good to a cell; empty otherwise.

    See Also
    --------
    flatpunch.bem.trace_outline : Makes it.

    Examples
    --------
    >>> from flatpunch import bem
    >>> kernel = fp.compliance(fp.HalfSpace(young=1e6, poisson=0.3))
    >>> (contact,) = bem.solve(kernel, fp.Paraboloid(radius=1e-3), depths=1e-5, grid=64)
    >>> print(f"{contact.outline.radius * 1e6:.0f} um, Hertz {np.sqrt(1e-3 * 1e-5) * 1e6:.0f} um")
    100 um, Hertz 100 um
    """

    phi: Array
    contour: Array
    radius: float
    area: float
    half_axes: tuple[float, float]
    eccentricity: float
    error: float
    note: str = ""

    def _line_(self) -> str:
        """Sizes; the points are in `contour`."""
        return f"Outline(radius={self.radius:.6g}, area={self.area:.6g}, {self.phi.size} angles)"


def trace_outline(
    grid: Grid, pressure: Array, *, angles: int = 360, rim: float = 0.5, length: float = np.inf, sharp: bool = False
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

    See Also
    --------
    flatpunch.bem.Outline : What it returns.
    flatpunch.plot_outline : Outlines of a result.

    Examples
    --------
    >>> from flatpunch import bem
    >>> grid = bem.Grid(nx=64, ny=64, spacing=0.05)
    >>> x, y = np.meshgrid(grid.x, grid.y)
    >>> outline = bem.trace_outline(grid, np.sqrt(np.maximum(1 - x**2 - y**2, 0.0)))
    >>> print(f"{outline.radius:.2f} {outline.area / np.pi:.2f}")
    1.00 1.00
    """
    check_grid(grid)
    pressure = on_grid("pressure", pressure, grid)
    contact = pressure > 0
    angles, rim, sharp = checked_angles(angles), positive("rim", rim, unit="1"), switch("sharp", sharp)
    length = length if follows(length, float) and length == np.inf else positive("length", length, unit="m")
    rays = enough_rays(angles, _slenderness(grid, contact))
    every = slice(None, None, rays // angles)
    phi = 2 * np.pi * np.arange(rays) / rays
    cells = float(contact.sum()) * grid.cell_area
    note = why_none(grid, contact)
    if note:
        none = float("nan")
        return Outline(phi[every], np.full(angles, none), none, cells, (none, none), none, float("inf"), note)
    contour, moved = rim_along(grid, pressure, phi, rim, length=length, sharp=sharp)
    narrowest = float(contour.min() / grid.spacing)
    if narrowest < _FEWEST:
        note = (
            f"the contact is only {2 * narrowest:.0f} cells across at its narrowest: its outline is good "
            "to about a cell. Use more cells."
        )
    axes = _half_axes(phi, contour)
    eccentricity = float(np.sqrt(max(0.0, 1 - (axes[1] / axes[0]) ** 2)))
    r, angle = grid.polar
    missed = ~contact & (r < np.interp(angle, phi, contour, period=2 * np.pi) - grid.spacing)
    radius = float(np.mean(contour)) - float(np.sum(1 / r[missed])) * grid.cell_area / (2 * np.pi)
    area = float(np.pi * np.mean(contour**2)) - np.count_nonzero(missed) * grid.cell_area
    return Outline(
        phi[every], contour[every], radius, cells if sharp else area, axes, eccentricity, float(moved.max()), note
    )


def checked_angles(angles: int) -> int:
    """Return a number of polar angles, refused where it is none."""
    return whole("angles", angles, 1, "It is the number of polar angles of the outline.", most=ANGLES)


def enough_rays(angles: int, slenderness: float = 1.0) -> int:
    """Number of rays for an outline at `angles` polar angles, a multiple of it; `slenderness` is its length over its width."""
    # least number of rays; radius and area are means over them, and half would leave 0.1 % at the corners of pyramids; the ends
    # of slender contacts take up a share of the turn like their width over their length
    return angles * -(-max(180, int(60 * slenderness)) // angles)


def _slenderness(grid: Grid, contact: Mask) -> float:
    """Length over width of what is in contact, from second moments of the cells."""
    rows, columns = np.nonzero(contact)
    if rows.size < 2:
        return 1.0
    # a single row of cells has the width of one
    spread = np.cov(grid.x[columns], grid.y[rows], bias=True) + np.eye(2) * grid.cell_area / 12
    small, large = np.linalg.eigvalsh(spread)
    return float(np.sqrt(large / small))


def rim_along(
    grid: Grid,
    pressure: Array,
    phi: Array,
    rim: float,
    *,
    length: float = np.inf,
    sharp: bool = False,
    farthest: float = 1.0,
) -> tuple[Array, Array]:
    """Farthest points in contact along rays from the point of first touch, and their errors [m]; NaN without contact.

    The error is the distance between the rim of the pressure and that of the cells, which counts above `farthest` cells; one
    cell where only the latter is known. Other arguments as for `trace_outline`.
    """
    contact, h = (pressure > 0).astype(float), grid.spacing
    contour = _cell_rim(grid, contact, phi)
    if sharp or not np.nanmin(contour, initial=np.inf) >= _FEWEST * h:
        return contour, np.full_like(contour, h)
    # the power law holds over about half of the thickness
    short = length <= 2 * _DEPTHS[-1] * h
    if short:
        shift = _cell_rim(grid, gaussian_filter(contact, _SMOOTH), phi) - contour
        # corners and the ends of lobes, which smoothing moves inwards, stay; so does the mean, as curved rims move a little
        staircase = np.abs(shift) < h
        contour = contour + np.where(staircase, shift - shift[staircase].sum() / max(staircase.sum(), 1), 0.0)
    points = contour * np.exp(1j * phi)
    inwards = _inwards(grid, contact, points)
    way = _zero(grid, pressure ** (1 / rim), points, inwards)
    believed = (np.abs(way - EXCESS) < farthest) & (not short)
    moved = h * np.where(believed, way, EXCESS)
    # least cosine of the angle between a ray and the normal of the rim; half lets rays along a flank scatter twice as much
    slant = np.maximum(-(inwards * np.exp(-1j * phi)).real, 0.3)
    return contour - moved / slant, h * np.where(believed, np.abs(way - EXCESS), 1.0)


def covered(contact: Mask) -> Array:
    """Share of each cell that is in contact, shape (ny, nx): cells along the rim reach `EXCESS` of a cell beyond it."""
    padded = np.pad(contact, 1)
    beside = padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]
    # a staircase is 4/pi times as long as the rim that it follows
    open_sides = sum((~neighbours).astype(float) for neighbours in beside)
    return np.asarray(contact * (1 - EXCESS * np.pi / 4 * open_sides))


def ray_lengths(grid: Grid) -> Array:
    """Integral of dA/(2 pi r) over each cell [m], shape (ny, nx): its part in the mean radius of what is in contact."""
    x, y = (np.append(v - grid.spacing / 2, v[-1] + grid.spacing / 2) for v in (grid.x, grid.y))
    x, y = x[None, :], y[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        # zero on the axes, where arcsinh(1/0) times zero is none
        corner = np.nan_to_num(x * np.arcsinh(y / np.abs(x))) + np.nan_to_num(y * np.arcsinh(x / np.abs(y)))
    return np.asarray(np.diff(np.diff(corner, axis=0), axis=1) / (2 * np.pi))


def read(grid: Grid, values: Array, points: Array | NDArray[np.complex128]) -> Array:
    """Values on a grid at points x + iy [m], linear between cell centres, zero beyond the grid."""
    places = [(points.imag - grid.y[0]) / grid.spacing, (points.real - grid.x[0]) / grid.spacing]
    return np.asarray(map_coordinates(values, places, order=1, mode="constant"))


def why_none(grid: Grid, contact: Mask) -> str:
    """Reason why the contact has no outline a(phi); empty if it has one."""
    if not contact.any():
        return "there is no contact"
    if read(grid, contact.astype(float), np.zeros(1, dtype=complex))[0] <= 0.5:
        return "the point of first touch is not in contact, so the contact has no outline a(phi) about it; area counts cells"
    if label(contact, np.ones((3, 3)))[1] > 1 or label(~contact)[1] > 1:
        return "the contact has several parts or holes, so it has no outline a(phi); area counts cells"
    return ""


def _cell_rim(grid: Grid, contact: Array, phi: Array) -> Array:
    """Largest radius along each ray where contact, interpolated between cell centres, falls below one half; else NaN [m]."""
    rows, columns = np.nonzero(contact)
    if not rows.size:
        return np.full(phi.size, np.nan)
    # half as many points along a ray may step over a notch half a cell wide
    h = grid.spacing / 4
    # rays leave slender contacts soon, most of them
    wide, high = np.abs(grid.x[columns]).max() + grid.spacing, np.abs(grid.y[rows]).max() + grid.spacing
    leaving = 1 / np.maximum(np.abs(np.cos(phi)) / wide, np.abs(np.sin(phi)) / high)
    steps = np.arange(min(np.hypot(grid.x[columns], grid.y[rows]).max(), leaving.max()) // h + 12)
    if phi.size * steps.size > AT_ONCE > steps.size:
        parts = np.array_split(phi, -(-phi.size * steps.size // AT_ONCE))
        return np.concatenate([_cell_rim(grid, contact, part) for part in parts])
    values = read(grid, contact, h * steps * np.exp(1j * phi)[:, None])
    met = values >= 0.5
    last = steps.size - 1 - np.argmax(met[:, ::-1], axis=1)
    last[~met.any(axis=1)] = 0
    inner, outer = (values[np.arange(phi.size), place] for place in (last, last + 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(met.any(axis=1), h * (last + (inner - 0.5) / (inner - outer)), np.nan)


def _inwards(grid: Grid, contact: Array, points: Array) -> Array:
    """Direction across the rim at points x + iy [m], of length one: that in which cells in contact become more."""
    along_y, along_x = np.gradient(gaussian_filter(contact, _SMOOTH))
    growth = read(grid, along_x, points) + 1j * read(grid, along_y, points)
    return np.asarray(growth / np.maximum(np.abs(growth), np.finfo(float).tiny))


def _zero(grid: Grid, values: Array, points: Array, inwards: Array) -> Array:
    """Cells from points x + iy [m] inwards to where parabolas through values on a grid vanish; NaN where they do not."""
    known = read(grid, values, points[:, None] + grid.spacing * _DEPTHS * inwards[:, None])
    # c0 + c1 s + c2 s^2, s in cells from the points inwards
    c0, c1, c2 = np.linalg.pinv(np.vander(_DEPTHS, 3, increasing=True)) @ known.T
    with np.errstate(invalid="ignore", divide="ignore"):
        zero = -2 * c0 / (c1 + np.sqrt(np.maximum(c1**2 - 4 * c0 * c2, 0.0)))
        return np.where(known[:, -1] > known[:, 0], zero, np.nan)


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
