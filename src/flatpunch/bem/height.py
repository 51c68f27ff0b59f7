"""The indenter as the boundary element solver sees it: heights on a grid, and the first estimate of the box of the contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.bem.grid import Grid, Mask
from flatpunch.indenters.profile import Indenter

Height = Callable[[Grid], Array]


@dataclass(frozen=True, slots=True)
class IndenterHeight:
    """Gap at first touch on a grid [m], infinite beyond the indenter's reach."""

    indenter: Indenter

    def __call__(self, grid: Grid) -> Array:
        """Heights at the cell centres, shape (ny, nx)."""
        return self.at(*grid.polar)

    def at(self, r: Array, phi: Array) -> Array:
        """Heights at polar coordinates (r, phi) of equal shape."""
        reach = self.indenter.reach_along(phi)
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
    """Half-widths of the bounding box of f < depth about the origin [m]: where the tip would cut a rigid surface."""
    phi = _directions()
    radii = _crossing(lambda r, phi: _finite(indenter, r, phi) - depth, indenter.reach_along(phi), phi)
    return _box(radii, phi)


def loaded_half_widths(indenter: Indenter, force: float, modulus: float) -> tuple[float, float]:
    """Half-widths of the box where force ~ modulus x radius x height [m]: the order of a half-space's contact."""
    phi = _directions()

    def mean_height(r: Array) -> Array:
        return np.asarray(np.broadcast_to(_finite(indenter, r[..., None], phi), (*r.shape, phi.size)).mean(axis=-1))

    typical = _crossing(lambda r: modulus * r * mean_height(r) - force, np.array(indenter.reach))
    depth = float(mean_height(typical))
    return overlap_half_widths(indenter, depth) if depth > 0 else (float(typical), float(typical))


def _finite(indenter: Indenter, r: Array, phi: Array) -> Array:
    """Heights, a face of 45 degrees where the indenter has no surface."""
    height = np.asarray(indenter.height(r, phi))
    return np.where(np.isinf(height), r, height)


def _directions() -> Array:
    # with half as many directions the box of a narrow tip is 1 % too small
    return np.asarray(2 * np.pi * np.arange(64) / 64)


def _crossing(excess: Callable[..., Array], reach: Array, *arguments: Array) -> Array:
    """Radii at which increasing functions change sign, to a thousandth, at most the reach; of the shape of `reach`."""
    from scipy.optimize import elementwise

    start = np.minimum(1.0, reach)
    found = elementwise.bracket_root(excess, start / 2, start, xmin=0.0, xmax=reach, args=arguments)
    root = elementwise.find_root(excess, found.bracket, args=arguments, tolerances={"xrtol": 1e-3})
    return np.where(root.success, root.x, reach)


def _box(radii: Array, phi: Array) -> tuple[float, float]:
    return float(np.max(np.abs(radii * np.cos(phi)))), float(np.max(np.abs(radii * np.sin(phi))))
