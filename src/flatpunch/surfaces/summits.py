"""Summits of a rough surface: cells higher than their eight neighbours, with the paraboloid through them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter

from flatpunch._support.checks import Array
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


def summits_of(h: Array, spacing: float, periodic: tuple[bool, bool]) -> Summits:
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
