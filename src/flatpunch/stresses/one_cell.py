"""Fields of one uniformly loaded square or rectangle: in a half-space corner by corner, and through layers.

In a half-space each component is f(x2, y2) - f(x1, y2) - f(x2, y1) + f(x1, y1) of a corner function f, the second integral over
x and y of that of a point force (Love 1929, Ahmadi, Keer and Mura 1987). With Phi = int p/R /(2 pi) and its integrals over depth
the pressure gives, for example, s_xx = -A_xx - 2 nu A_yy - z d^2 Phi/dx^2, where A_xx belongs to exp(-kz) (k_x/k)^2. What layers
add comes from a disc of the same area. `kernels` gives both at offsets in units of cells, for convolutions on planes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import ROUNDING, TINY, Array, Indices
from flatpunch.stresses.axisymmetric.radial import (
    COMPONENTS,
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

Depth = Array | float

_SWAP = np.array([1, 0, 2, 4, 3, 5, 7, 6, 8])
"""Components after exchanging x and y."""

_ROUNDER = (1 / 12 - 1 / (4 * np.pi)) / 2
"""Share of a disc in the four cells around it with which it has the second moments of the square."""

_ODD_IN_X = np.array([0, 0, 0, 0, 1, 1, 1, 0, 0], dtype=bool)
_ODD_IN_Y = np.array([0, 0, 0, 1, 0, 1, 0, 1, 0], dtype=bool)
"""Which components a pressure has with opposite signs at opposite x, and at opposite y: xz, xy and u_x; yz, xy and u_y."""


@dataclass(frozen=True, slots=True)
class _Corner:
    """What the corner functions are made of, at corners x, y and depth z; times 2 pi."""

    x: Array
    y: Array
    z: Depth
    r: Array
    log_x: Array
    log_y: Array
    log_z: Array
    over_x: Array
    over_y: Array
    solid: Array
    a_xx: Array
    a_yy: Array


def _corner(x: Array, y: Array, z: Depth) -> _Corner:
    r = np.sqrt(x * x + y * y + z * z + TINY)
    log_x, over_x = _log_and_inverse(x, y, z, r)
    log_y, over_y = _log_and_inverse(y, x, z, r)
    return _Corner(
        x=x,
        y=y,
        z=z,
        r=r,
        log_x=log_x,
        log_y=log_y,
        log_z=np.log(r + z),
        over_x=over_x,
        over_y=over_y,
        solid=np.arctan2(x * y, z * r),
        a_xx=np.arctan2(x * y * (r - z), x * x * r + z * y * y),
        a_yy=np.arctan2(x * y * (r - z), y * y * r + z * x * x),
    )


def _log_and_inverse(x: Array, y: Array, z: Depth, r: Array) -> tuple[Array, Array]:
    """ln(x + r) and 1/(r (x + r)) without cancellation at negative x."""
    rest = y * y + z * z + TINY
    total = np.where(x > 0, x + r, rest / (r + abs(x)))
    return np.log(total), 1 / (r * total)


def _normal_corner(x: Array, y: Array, z: Depth, mu: float, nu: float) -> Array:
    """Stress (xx, yy, zz, yz, xz, xy) and displacement (x, y, z) under the pressure 1; shape (9, ...)."""
    c = _corner(x, y, z)
    second_x, second_y = x * c.over_y, y * c.over_x
    return np.stack(
        [
            -c.a_xx - 2 * nu * c.a_yy - z * second_x,
            -c.a_yy - 2 * nu * c.a_xx - z * second_y,
            -c.solid + z * (second_x + second_y),
            -z * z * c.over_x,
            -z * z * c.over_y,
            -(1 - 2 * nu) * c.log_z - z / c.r,
            ((1 - 2 * nu) * _integrated(c, c.a_xx, y, c.log_y, x) - z * c.log_y) / (2 * mu),
            ((1 - 2 * nu) * _integrated(c, c.a_yy, x, c.log_x, y) - z * c.log_x) / (2 * mu),
            (2 * (1 - nu) * _potential(c) + z * c.solid) / (2 * mu),
        ]
    ) / (2 * np.pi)


def _shear_corner(x: Array, y: Array, z: Depth, mu: float, nu: float) -> Array:
    """Corner function under a traction 1 along x."""
    c = _corner(x, y, z)
    deep = 1 / (c.r + z)
    return np.stack(
        [
            2 * c.log_y + 2 * nu * y * deep + z * (y * deep / c.r + z * c.over_y),
            2 * nu * (c.log_y - y * deep) - z * y * deep / c.r,
            -z * z * c.over_y,
            -z / c.r,
            -c.solid - z * x * c.over_y,
            c.log_x - 2 * nu * x * deep - z * x * deep / c.r,
            (2 * _potential(c) - 2 * nu * (x * c.log_y - z * c.a_xx) - z * c.a_xx) / (2 * mu),
            -(2 * nu * (c.r - z * c.log_z) + z * c.log_z) / (2 * mu),
            -((1 - 2 * nu) * _integrated(c, c.a_xx, y, c.log_y, x) + z * c.log_y) / (2 * mu),
        ]
    ) / (2 * np.pi)


def corner(x: Array, y: Array, z: Depth, mu: float, nu: float, direction: float | None) -> Array:
    """Corner function under the pressure 1, or under a traction 1 in a direction."""
    if direction is None:
        return _normal_corner(x, y, z, mu, nu)
    found = np.cos(direction) * _shear_corner(x, y, z, mu, nu)
    if np.sin(direction):
        found += np.sin(direction) * _shear_corner(y, x, z, mu, nu)[_SWAP]
    return np.asarray(found)


def _potential(c: _Corner) -> Array:
    """Of 1/R."""
    return c.x * c.log_y + c.y * c.log_x - c.z * c.solid


def _integrated(c: _Corner, a: Array, across: Array, log_across: Array, along: Array) -> Array:
    """Of the derivative of -ln(R + z) along one axis."""
    return -(across * c.log_z + c.z * log_across + along * a)


def summed(corners: Array) -> Array:
    """Differences over neighbouring corners, shape (..., ny + 1, nx + 1) -> (..., ny, nx)."""
    return np.asarray(np.diff(np.diff(corners, axis=-1), axis=-2))


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
        found = np.zeros((COMPONENTS, along.size, across.size))
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
