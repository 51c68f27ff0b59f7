"""Measured or synthetic topography: heights on a grid of square cells, peaks positive, which may repeat.

Its summits are cells higher than their eight neighbours, with the paraboloid through them.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import maximum_filter

from flatpunch._support.checks import CELLS, LARGEST, Array, numbers, positive, shown, switch
from flatpunch._support.readable import Table, readable

FEWEST = 8
"""Fewest cells along a side, those of a grid of boundary elements."""


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
