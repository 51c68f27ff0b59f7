"""Measured or random topography: heights on a grid of square cells, peaks positive, which may repeat.

Random surfaces are self-affine: Gaussian heights with a power spectrum of given exponent between two wavelengths. Summits are
cells higher than their eight neighbours, with the paraboloid through them.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import ArrayLike
from scipy.ndimage import maximum_filter

from flatpunch._support.checks import CELLS, FEWEST, LARGEST, Array, numbers, positive, real, shown, switch, whole
from flatpunch._support.readable import Table, readable


@readable
@dataclass(frozen=True, eq=False)
class Summits:
    """Summits of a topography.

    Attributes
    ----------
    positions : ndarray, shape (n, 2)
        Places (x, y) [m], measured from the centre of the surface, between the cells.
    heights : ndarray, shape (n,)
        Heights over the mean of the surface [m].
    curvatures : ndarray, shape (n, 2)
        Principal curvatures [1/m], both > 0, the smaller one first.

    See Also
    --------
    flatpunch.Topography : Its method `summits` finds them.
    flatpunch.rough_theories : Greenwood and Williamson's theory takes them.

    Examples
    --------
    >>> rough = fp.self_affine(64, 10e-9, rms_slope=0.1, cut_off=80e-9)
    >>> summits = rough.summits()
    >>> print(summits.positions.shape[0], f"{1e9 / summits.curvatures.mean():.0f} nm")
    12 283 nm
    """

    positions: Array
    heights: Array
    curvatures: Array

    def _table_(self) -> Table:
        """Number and ranges."""
        rows = (
            ("number", str(self.heights.size)),
            ("heights", f"{self.heights.min():.4g} to {self.heights.max():.4g} m" if self.heights.size else ""),
            ("mean radius", f"{1 / self.curvatures.mean():.4g} m" if self.heights.size else ""),
        )
        return Table("Summits", (), rows)


@readable
@dataclass(frozen=True, eq=False)
class Topography:
    """Rough surface of a rigid body, given by heights on square cells.

    Parameters
    ----------
    heights : array, shape (ny, nx)
        Heights [m] of the cell centres, rows along y; peaks are positive and point towards the elastic body. They are copied into
        an array of the surface's own, which other programs (Tamaas, SurfaceTopography) take as it is.
    spacing : float
        Side of a cell [m], > 0.
    periodic : bool or (bool, bool)
        Whether the surface repeats, along both axes or along (x, y). Where it does not, it ends at its border, and nothing beyond
        touches the body.

    Raises
    ------
    ValueError, TypeError
        If heights are missing or infinite, or the shape is no grid of at least 8 x 8 cells.

    See Also
    --------
    self_affine : Random surfaces.
    rough_contact : Press it into a body.
    HeightMap : A tip with one apex.

    Examples
    --------
    >>> x = np.arange(64) * 1e-7
    >>> wavy = fp.Topography(20e-9 * np.cos(2 * np.pi * x / 6.4e-6) * np.ones((64, 1)), spacing=1e-7)
    >>> print(f"rms height {wavy.rms_height * 1e9:.1f} nm, rms slope {wavy.rms_slope:.4f}")
    rms height 14.1 nm, rms slope 0.0139
    """

    heights: Array
    spacing: float
    periodic: tuple[bool, bool] = (True, True)

    def __init__(self, heights: ArrayLike, spacing: float, periodic: bool | tuple[bool, bool] = True) -> None:
        table = numbers("Topography.heights", heights, "m")
        if table.ndim != 2 or min(table.shape) < FEWEST:
            raise ValueError(
                f"Topography.heights has shape {table.shape}; it must be a two-dimensional array (ny, nx) of at least "
                f"{FEWEST} x {FEWEST} heights, rows along y."
            )
        if table.size > CELLS**2:
            raise ValueError(
                f"Topography.heights has shape {table.shape}; {CELLS} x {CELLS} cells are the most that are solved. Cut it, or "
                "average blocks of cells."
            )
        bad = ~(np.abs(table) <= LARGEST)
        if bad.any():
            i, j = (int(n) for n in np.argwhere(bad)[0])
            raise ValueError(
                f"Topography.heights has {int(bad.sum())} missing or infinite values, the first in row {i}, column {j}. Fill "
                "them, or cut the surface to where it was measured; a HeightMap may have missing values at its rim."
            )
        object.__setattr__(self, "heights", table)
        hint = "It is the side of a cell in metres, not the length of the scan."
        object.__setattr__(self, "spacing", positive("Topography.spacing", spacing, hint, unit="m"))
        object.__setattr__(self, "periodic", _pair(periodic))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Topography):
            return NotImplemented
        return self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def recorded(self) -> dict[str, object]:
        """What a record of a calculation holds in place of all heights."""
        names = ("shape", "periodic")
        numbers = ("spacing", "rms_height", "rms_slope")
        return {
            "type": "Topography",
            **{name: list(getattr(self, name)) for name in names},
            **{name: getattr(self, name) for name in numbers},
            "digest": self._digest,
        }

    @property
    def shape(self) -> tuple[int, int]:
        """(ny, nx)."""
        ny, nx = self.heights.shape
        return ny, nx

    @property
    def size(self) -> tuple[float, float]:
        """Lengths along x and y [m]."""
        ny, nx = self.shape
        return nx * self.spacing, ny * self.spacing

    @property
    def area(self) -> float:
        """Nominal area [m^2]."""
        return self.heights.size * self.spacing**2

    @property
    def rms_height(self) -> float:
        """Standard deviation of the heights [m]."""
        return float(np.std(self.heights))

    @property
    def rms_slope(self) -> float:
        """Root of the mean squared gradient [-], from differences of neighbouring cells."""
        return float(np.sqrt(sum(np.mean(self._differences(axis) ** 2) for axis in (0, 1)))) / self.spacing

    def summits(self) -> Summits:
        """Cells higher than their eight neighbours: places, heights and curvatures of the paraboloids through them."""
        return _summits_of(self.heights, self.spacing, self.periodic)

    def _differences(self, axis: int) -> Array:
        """Differences of neighbours along an axis [m], across the border where the surface repeats."""
        first = np.take(self.heights, [0], axis)
        closed = np.concatenate([self.heights, first], axis) if self.periodic[1 - axis] else self.heights
        return np.asarray(np.diff(closed, axis=axis))

    @property
    def _digest(self) -> str:
        return hashlib.sha256(self.heights.tobytes()).hexdigest()[:16]

    @property
    def _key(self) -> tuple[object, ...]:
        return self._digest, self.shape, self.spacing, self.periodic


def _pair(periodic: object) -> tuple[bool, bool]:
    if isinstance(periodic, (tuple, list)) and len(periodic) == 2:
        along_x, along_y = (switch("Topography.periodic", each) for each in periodic)
        return along_x, along_y
    if not isinstance(periodic, (bool, np.bool_)):
        raise TypeError(
            f"Topography.periodic = {shown(periodic)} must be True or False, or a pair of them for the axes x and y."
        )
    return bool(periodic), bool(periodic)


def _summits_of(h: Array, spacing: float, periodic: tuple[bool, bool]) -> Summits:
    """Summits of heights [m], none at a border where the surface ends; paraboloids by central differences of the cells."""
    # of equal neighbours the first one counts
    found = h > maximum_filter(h, footprint=_BEFORE, mode="wrap")
    found &= h >= maximum_filter(h, footprint=_BEFORE[::-1, ::-1], mode="wrap")
    for axis, repeats in enumerate(periodic[::-1]):
        if not repeats:
            for end in (0, -1):
                found[(slice(None),) * axis + (end,)] = False
    j, i = np.nonzero(found)

    def at(dj: int, di: int) -> Array:
        return np.asarray(h[(j + dj) % h.shape[0], (i + di) % h.shape[1]])

    gx, gy = (at(0, 1) - at(0, -1)) / 2, (at(1, 0) - at(-1, 0)) / 2
    xx, yy = at(0, 1) - 2 * at(0, 0) + at(0, -1), at(1, 0) - 2 * at(0, 0) + at(-1, 0)
    xy = (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) / 4
    hessian = np.stack([np.stack([xx, xy], -1), np.stack([xy, yy], -1)], -2)
    curvatures = -np.linalg.eigvalsh(hessian)[:, ::-1]
    # ridges and saddles that are highest among cells by chance are no summits
    convex = curvatures[:, 0] > 0
    slope, place = np.stack([gx, gy], -1)[convex], np.stack([i, j], -1)[convex]
    shift = np.clip(-np.linalg.solve(hessian[convex], slope[..., None])[..., 0], -0.5, 0.5)
    rise = (slope * shift).sum(-1) / 2
    centre = (np.array(h.shape[::-1]) - 1) / 2
    return Summits(
        positions=(place + shift - centre) * spacing,
        heights=h[found][convex] - h.mean() + rise,
        curvatures=np.asarray(curvatures[convex] / spacing**2, dtype=float),
    )


_BEFORE = np.array([[1, 1, 1], [1, 0, 0], [0, 0, 0]], dtype=bool)
"""Four of the eight neighbours."""


def self_affine(
    shape: int | tuple[int, int],
    spacing: float,
    *,
    hurst: float = 0.8,
    rms_height: float | None = None,
    rms_slope: float | None = None,
    roll_off: float | None = None,
    cut_off: float | None = None,
    seed: int = 0,
) -> Topography:
    """Random periodic surface whose power spectrum falls like q^(-2 - 2 hurst).

    Parameters
    ----------
    shape : int or (int, int)
        Number of cells (ny, nx); one number for a square.
    spacing : float
        Side of a cell [m].
    hurst : float
        Hurst exponent [-], 0 < hurst <= 1.
    rms_height, rms_slope : float
        Exactly one of them, > 0: the heights [m] are scaled until `Topography.rms_height` or `Topography.rms_slope` [-] is it.
    roll_off : float, optional
        Wavelength [m] above which the spectrum is constant; by default it rises up to the length of the surface.
    cut_off : float, optional
        Shortest wavelength [m]; by default twice the spacing. Eight spacings or more resolve the shape of each asperity.
    seed : int
        Seed of the random numbers; equal seeds give equal surfaces.

    Returns
    -------
    Topography
        Periodic in both directions, mean height zero.

    Raises
    ------
    ValueError, TypeError
        If not exactly one of `rms_height` and `rms_slope` is given, or no wavelength lies between the limits.

    See Also
    --------
    Topography : Measured surfaces.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001 (2017).

    Examples
    --------
    >>> rough = fp.self_affine(128, 10e-9, hurst=0.8, rms_slope=0.1, roll_off=0.5e-6, cut_off=40e-9, seed=1)
    >>> print(rough.shape, f"{rough.rms_slope:.3f}")
    (128, 128) 0.100
    """
    ny, nx = (whole("shape", n, FEWEST, "It counts cells along a side.", most=CELLS) for n in _two(shape))
    spacing = positive("spacing", spacing, "It is the side of a cell.", unit="m")
    hurst = real("hurst", hurst, "1")
    if not 0 < hurst <= 1:
        raise ValueError(f"hurst = {hurst!r} must lie in 0 < hurst <= 1: it is the Hurst exponent of the surface.")
    if (rms_height is None) == (rms_slope is None):
        raise ValueError("Give exactly one of rms_height [m] and rms_slope [-]; the other follows from the spectrum.")
    wanted = (
        positive("rms_height", rms_height, unit="m")
        if rms_slope is None
        else positive("rms_slope", rms_slope, unit="1")
    )
    longest, shortest = max(ny, nx) * spacing, 2 * spacing
    roll_off = longest if roll_off is None else positive("roll_off", roll_off, "It is a wavelength.", unit="m")
    cut_off = shortest if cut_off is None else positive("cut_off", cut_off, "It is a wavelength.", unit="m")
    q = np.hypot(scipy.fft.fftfreq(ny, spacing)[:, None], scipy.fft.rfftfreq(nx, spacing))
    with np.errstate(divide="ignore"):
        amplitude = np.maximum(q, 1 / roll_off) ** (-1 - hurst)
    # wavelengths that equal a limit count, whatever the rounding of their inverse
    amplitude[(q == 0) | (q * cut_off > 1 + 1e-9)] = 0.0
    if not amplitude.any():
        raise ValueError(
            f"cut_off = {cut_off!r} m leaves no wavelength: the longest that fits on the surface is {longest:.4g} m, the "
            f"shortest that its cells resolve {shortest:.4g} m."
        )
    noise = np.random.default_rng(whole("seed", seed, 0)).standard_normal((ny, nx))
    heights = scipy.fft.irfft2(scipy.fft.rfft2(noise) * amplitude, (ny, nx))
    rough = Topography(heights / np.abs(heights).max(), spacing)
    factor = wanted / (rough.rms_height if rms_slope is None else rough.rms_slope)
    return Topography(rough.heights * factor, spacing)


def _two(shape: object) -> tuple[object, object]:
    if not isinstance(shape, (tuple, list)):
        return shape, shape
    if len(shape) != 2:
        raise ValueError(f"shape = {shown(shape)} must be one number of cells, or the pair (ny, nx).")
    return shape[0], shape[1]
