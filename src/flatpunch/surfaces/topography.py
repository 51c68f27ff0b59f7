"""Measured or synthetic topography: heights on a grid of square cells, peaks positive, which may repeat."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from flatpunch._support.checks import CELLS, LARGEST, Array, numbers, positive, shown, switch
from flatpunch._support.readable import readable
from flatpunch.surfaces.summits import Summits, summits_of

FEWEST = 8
"""Fewest cells along a side, those of a grid of boundary elements."""


@readable
@dataclass(frozen=True, eq=False)
class Topography:
    """Rough surface of a rigid body, given by heights on square cells.

    Parameters
    ----------
    heights : array, shape (ny, nx)
        Heights [m] of the cell centres, rows along y; peaks are positive and point towards the elastic body.
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
        table.setflags(write=False)
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

    @cached_property
    def rms_height(self) -> float:
        """Standard deviation of the heights [m]."""
        return float(np.std(self.heights))

    @cached_property
    def rms_slope(self) -> float:
        """Root of the mean squared gradient [-], from differences of neighbouring cells."""
        return float(np.sqrt(sum(np.mean(self._differences(axis) ** 2) for axis in (0, 1)))) / self.spacing

    def summits(self) -> Summits:
        """Cells higher than their eight neighbours: places, heights and curvatures of the paraboloids through them."""
        return summits_of(self.heights, self.spacing, self.periodic)

    def _differences(self, axis: int) -> Array:
        """Differences of neighbours along an axis [m], across the border where the surface repeats."""
        first = np.take(self.heights, [0], axis)
        closed = np.concatenate([self.heights, first], axis) if self.periodic[1 - axis] else self.heights
        return np.asarray(np.diff(closed, axis=axis))

    @cached_property
    def _digest(self) -> str:
        return hashlib.sha256(self.heights.tobytes()).hexdigest()[:16]

    @property
    def _key(self) -> tuple[object, ...]:
        return self._digest, self.shape, self.spacing, self.periodic


def _pair(periodic: object) -> tuple[bool, bool]:
    """Whether a surface repeats along x and y."""
    if isinstance(periodic, (tuple, list)) and len(periodic) == 2:
        along_x, along_y = (switch("Topography.periodic", each) for each in periodic)
        return along_x, along_y
    if not isinstance(periodic, (bool, np.bool_)):
        raise TypeError(
            f"Topography.periodic = {shown(periodic)} must be True or False, or a pair of them for the axes x and y."
        )
    return bool(periodic), bool(periodic)
