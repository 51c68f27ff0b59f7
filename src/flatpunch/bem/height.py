"""The indenter as the boundary element solver sees it: heights on a grid, and the first guess of where contact will be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.bem.grid import Grid, Mask
from flatpunch.indenters.profile import Indenter, reach_along

Height = Callable[[Grid], Array]

_ANGLES = 64
_DOUBLINGS = 400


@dataclass(frozen=True, slots=True)
class IndenterHeight:
    """Gap at first touch on a grid [m], infinite beyond the indenter's reach."""

    indenter: Indenter

    def __call__(self, grid: Grid) -> Array:
        """Heights at the cell centres, shape (ny, nx)."""
        return self.at(*grid.polar)

    def at(self, r: Array, phi: Array) -> Array:
        """Heights at polar coordinates (r, phi) of equal shape."""
        reach = reach_along(self.indenter, phi)
        height = np.array(self.indenter.height(np.minimum(r, reach), phi), dtype=float)
        height[r > reach] = np.inf
        return height


@dataclass(frozen=True, slots=True)
class PunchHeight:
    """Flat end of any planform: zero on it, infinite elsewhere.

    Parameters
    ----------
    planform : callable
        (x, y) [m], broadcast together -> bool.
    """

    planform: Callable[[Array, Array], Mask]

    def __call__(self, grid: Grid) -> Array:
        """Heights at the cell centres, shape (ny, nx)."""
        inside = np.broadcast_to(self.planform(grid.x[None, :], grid.y[:, None]), grid.shape)
        return np.where(inside, 0.0, np.inf)


def overlap_half_widths(indenter: Indenter, depth: float) -> tuple[float, float]:
    """Half-widths of the bounding box of f < depth about the origin [m]: where a rigid surface would be cut."""
    phi = 2 * np.pi * np.arange(_ANGLES) / _ANGLES
    reach = reach_along(indenter, phi)
    radii = np.array([_crossing(partial(_excess, indenter, depth, p), end) for p, end in zip(phi, reach, strict=True)])
    return _box(radii, phi)


def loaded_half_widths(indenter: Indenter, force: float, modulus: float) -> tuple[float, float]:
    """Half-widths of the box where force ~ modulus x radius x height [m]: the order of a half-space's contact."""
    phi = 2 * np.pi * np.arange(_ANGLES) / _ANGLES
    typical = _crossing(
        lambda r: modulus * r * float(np.mean([_height(indenter, r, p) for p in phi])) - force, indenter.reach
    )
    depth = float(np.mean([_height(indenter, typical, p) for p in phi]))
    return overlap_half_widths(indenter, depth) if depth > 0 else (typical, typical)


def _excess(indenter: Indenter, depth: float, phi: float, r: float) -> float:
    return _height(indenter, r, phi) - depth


def _height(indenter: Indenter, r: float, phi: float) -> float:
    return float(indenter.height(np.array([r]), np.array([phi]))[0])


def _crossing(excess: Callable[[float], float], reach: float) -> float:
    """Radius at which an increasing function changes sign, to a factor of two; at most the reach."""
    r = min(1.0, reach)
    for _ in range(_DOUBLINGS):
        if excess(r) <= 0:
            break
        r /= 2
    for _ in range(_DOUBLINGS):
        if r >= reach or excess(min(2 * r, reach)) > 0:
            break
        r *= 2
    low, high = r, min(2 * r, reach)
    for _ in range(12):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) <= 0 else (low, middle)
    return high


def _box(radii: Array, phi: Array) -> tuple[float, float]:
    return float(np.max(np.abs(radii * np.cos(phi)))), float(np.max(np.abs(radii * np.sin(phi))))
