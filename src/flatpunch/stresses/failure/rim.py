"""The rim of a contact on cells, and the stress there.

The largest tension at the surface is at the rim. Inside it falls like the root of the distance, and the staircase of the cells
has an error there that falls only like the root of their width. A few cells outside the fields of the cells are accurate. There
the stress is fitted by a cubic polynomial of t = ln(1 + s/l), with s the distance from the rim and l the shortest length of
contact and body; under friction by one of the root of t, as the traction falls like the root. Its value at s = 0 is the stress at
the rim.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from flatpunch import bem
from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.numerics.gauss import gauss

_CLEAR = 3.0
"""Distance from the rim in cells beyond which the staircase changes the stress by less than 0.3 %; at two thirds, by 1 %."""

_REACH = 0.6
"""Range of the fit over the length l; with twice as much it is off by 3 % under friction."""

_NODES = 40
"""Nodes of the integral over directions at the rim of an ellipse, times the root of its aspect ratio: they leave 1e-9."""

_ASIDE = 3
"""Points of an outline on either side between which its normal is taken; with one, the noise of the points turns it."""


@dataclass(frozen=True, slots=True)
class Rim:
    """Points of an outline and the points outside at which the stress is fitted.

    Attributes
    ----------
    place : ndarray, shape (2, n)
        Points of the outline [m].
    outside : ndarray, shape (2, n, points)
        Points along the outward normals [m].
    weights : ndarray, shape (points,)
        Of the stress at these points in that at the rim.
    clear : float
        Distance from the rim below which cells do not resolve the stress [m].
    """

    place: Array
    outside: Array
    weights: Array
    clear: float

    def beside(self, place: Array) -> Flags:
        """Which places, shape (3, ...), are too close to the rim for the cells."""
        points = np.vstack([self.place, np.zeros(self.place.shape[1])]).T
        far, _ = cKDTree(points).query(np.moveaxis(place, 0, -1))
        return np.asarray(far < self.clear)

    def away(self, stress: Array, place: Array) -> Array:
        """Stresses without those that cells do not resolve beside it."""
        return np.where(self.beside(place), 0.0, stress)

    @classmethod
    def of(cls, solution: bem.Solution, length: float, sliding: bool, chosen: Indices | slice) -> Rim | None:
        """The rim of a solution at the chosen angles of its outline; None if it has none.

        `length` is the shortest over which the body changes with depth [m].
        """
        outline, spacing = solution.outline, solution.grid.spacing
        if not np.isfinite(outline.contour).all():
            return None
        place = outline.contour * np.array([np.cos(outline.phi), np.sin(outline.phi)])
        along = np.roll(place, -_ASIDE, axis=1) - np.roll(place, _ASIDE, axis=1)
        normal = np.array([along[1], -along[0]]) / np.hypot(*along)
        longer, shorter = outline.half_axes
        scale = min(shorter**2 / longer, length)
        # at least four cells, so that the fit averages over the staircase
        distance = np.linspace(_CLEAR * spacing, _CLEAR * spacing + max(_REACH * scale, 4 * spacing), 24)
        t = np.log1p(distance / scale)
        weights = np.linalg.pinv((t[:, None] / t[-1]) ** (np.arange(4) / (2 if sliding else 1)))[0]
        outside = place[..., None] + normal[..., None] * distance
        return cls(place[:, chosen], outside[:, chosen], weights, _CLEAR * spacing)


def at_ellipse(half_axes: Array, friction: float, poisson: float, phi: Array) -> tuple[Array, Array]:
    """Stress at the rim of a Hertzian ellipse on a half-space over its largest pressure.

    Along each direction theta from a point of the rim into the ellipse the pressure is sqrt(A r - B r^2), and the stress of a
    point force is f(theta)/(2 pi r^2) (K. L. Johnson, Contact Mechanics, 1985, ch. 3): over r the integral is pi A/(2 sqrt(B)).
    The directions are those of an angle chi between theta and the angle in the plane where the ellipse is a circle.

    Parameters
    ----------
    half_axes : ndarray, shape (2,)
        Half-axes along x and y [m].
    friction, poisson : float
        Traction along x over the pressure, and Poisson ratio [-].
    phi : ndarray, shape (n,)
        Parametric angles of the points of the rim [rad].

    Returns
    -------
    stress : ndarray, shape (6, n)
        xx, yy, zz, yz, xz, xy over the largest pressure [-].
    place : ndarray, shape (3, n)
        The points [m].
    """
    t, weight = gauss(int(np.ceil(_NODES * np.sqrt(half_axes.max() / half_axes.min()))))
    a, b = np.sqrt(half_axes)
    cos, sin = np.cos(phi)[:, None], np.sin(phi)[:, None]
    chi = np.arctan2(b * cos, -a * sin) + np.pi * (1 + t) / 2
    length, inverse = np.hypot(a * np.cos(chi), b * np.sin(chi)), np.hypot(b * np.cos(chi), a * np.sin(chi))
    c, s = a * np.cos(chi) / length, b * np.sin(chi) / length
    ray = -np.pi * (b * np.cos(chi) * cos + a * np.sin(chi) * sin) / inverse
    share = np.pi / 2 * weight * a * b / length**2 * ray / (2 * np.pi)
    # notation: j = 6 nu
    k, j = 1 - 2 * poisson, 3 * (2 * poisson)
    xx = k * (c * c - s * s) + friction * (j * c**3 + 2 * k * c)
    yy = k * (s * s - c * c) + friction * j * c * s * s
    xy = 2 * k * c * s + friction * (j * c * c * s + k * s)
    place = np.zeros((3, phi.size))
    zero = np.zeros_like(xx)
    stress = np.stack([(share * each).sum(axis=1) for each in (xx, yy, zero, zero, zero, xy)])
    place[:2] = half_axes[:, None] * np.array([np.cos(phi), np.sin(phi)])
    return stress, place
