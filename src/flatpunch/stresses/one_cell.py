"""Fields of one loaded square cell at offsets in units of cells: the kernel of convolutions on planes of constant depth."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, Indices
from flatpunch.stresses.axisymmetric.radial import (
    NORMAL_ORDERS,
    AnisotropicPart,
    surface_part,
    turned,
    under_pressure,
    under_traction,
)
from flatpunch.stresses.axisymmetric.round_load import layered_part, split_off
from flatpunch.stresses.axisymmetric.uniform_disc import UniformDisc
from flatpunch.stresses.bodies import Located
from flatpunch.stresses.rectangle import corner, summed

_ROUNDER = (1 / 12 - 1 / (4 * np.pi)) / 2
"""Share of a disc in the four cells around it with which it has the second moments of the square."""

_ODD_IN_X, _ODD_IN_Y = np.isin(np.arange(9), [4, 5, 6]), np.isin(np.arange(9), [3, 5, 7])
"""Which components a pressure has with opposite signs at opposite x, and at opposite y: xz, xy and u_x; yz, xy and u_y."""


def kernels(
    at: Located,
    depths: Array,
    layer: int,
    across: Indices,
    along: Indices,
    h: float,
    direction: float | None,
    layered: bool,
) -> Iterator[Array]:
    """Fields of one loaded cell at offsets (in cells), shape (9, ny, nx), depth by depth.

    They are found in one quadrant, under a traction along x and one along y, and reflected. What layers add is found for all
    depths at once: most of its time goes into the waves below them, which is the same for all.
    """
    columns, rows = (np.arange(np.abs(each).min(), np.abs(each).max() + 1) for each in (across, along))
    loads = [(None, 1.0)] if direction is None else [(axis, np.cos(direction - axis)) for axis in (0.0, np.pi / 2)]
    acting = [(axis, share) for axis, share in loads if abs(share) > ROUNDING]
    quadrants = [_in_quadrant(at, depths, layer, columns, rows, h, axis, layered) for axis, _ in acting]
    for each_load in zip(*quadrants, strict=True):
        found = np.zeros((9, along.size, across.size))
        for quadrant, (axis, share) in zip(each_load, acting, strict=True):
            odd_x, odd_y = _ODD_IN_X ^ (axis == 0.0), _ODD_IN_Y ^ (axis not in (None, 0.0))
            signs = np.where(np.multiply.outer(odd_y, along < 0), -share, share)
            signs = signs[:, :, None] * np.where(np.multiply.outer(odd_x, across < 0), -1, 1)[:, None, :]
            found += signs * quadrant[:, np.abs(along) - rows[0]][:, :, np.abs(across) - columns[0]]
        yield found


def _in_quadrant(
    at: Located,
    depths: Array,
    layer: int,
    across: Indices,
    along: Indices,
    h: float,
    direction: float | None,
    layered: bool,
) -> Iterator[Array]:
    disc, shear = UniformDisc(h / np.sqrt(np.pi)), direction is not None
    r, which, angles = _polar(_longer(across), _longer(along), h)
    places = np.tile(r, depths.size), np.repeat(depths, r.size), np.full(r.size * depths.size, layer)
    added = layered_part(at.body, disc, *places, shear)
    shape = along.size + 2, across.size + 2
    for i, z in enumerate(depths.tolist()):
        mine = i * r.size + which
        found = _squared(_components(added[:, mine], angles, direction).reshape(-1, *shape))
        if not layered and split_off(at.body, disc, np.full(1, z), np.full(1, layer))[0]:
            found += _split_off_part(at, z, across, along, h, direction)
        yield found


def _longer(offsets: Indices) -> Indices:
    return np.arange(offsets[0] - 1, offsets[-1] + 2)


def _squared(discs: Array) -> Array:
    """Smooth fields of a square from those of discs on one more offset all around."""
    middle = discs[:, 1:-1, 1:-1]
    around = discs[:, 2:, 1:-1] + discs[:, :-2, 1:-1] + discs[:, 1:-1, 2:] + discs[:, 1:-1, :-2]
    return middle + _ROUNDER * (around - 4 * middle)


def _polar(across: Indices, along: Indices, h: float) -> tuple[Array, Indices, Array]:
    """Different distances [m] of offsets (in cells) from the origin, which of them each offset has, and its polar angle."""
    gx, gy = np.meshgrid(across, along)
    squares, which = np.unique(gx * gx + gy * gy, return_inverse=True)
    return h * np.sqrt(squares), which.ravel(), np.arctan2(gy, gx).ravel()


def _components(functions: Array, angles: Array, direction: float | None) -> Array:
    """Nine components of the functions of a pressure, or of those of a traction in a direction, which follow them."""
    if direction is None:
        return under_pressure(functions, angles)
    return turned(under_traction(functions[len(NORMAL_ORDERS) :], angles - direction), direction)


def _split_off_part(at: Located, z: float, across: Indices, along: Indices, h: float, direction: float | None) -> Array:
    part = surface_part(at.body)
    if isinstance(part, AnisotropicPart):
        # a disc of the same area takes the place of the square
        r, which, angles = _polar(across, along, h)
        functions = part.of_load(UniformDisc(h / np.sqrt(np.pi)), r, np.full(r.size, z), direction is not None)
        return _components(functions[:, which], angles, direction).reshape(-1, along.size, across.size)
    x, y = ((np.append(each, each[-1] + 1) - 0.5) * h for each in (across, along))
    return part.kept_of_components(summed(corner(*np.meshgrid(x, y), z, *part.constants, direction)))
