"""Fields in a half-space under a uniformly loaded rectangle, corner by corner (Love 1929, Ahmadi, Keer and Mura 1987).

Each component is f(x2, y2) - f(x1, y2) - f(x2, y1) + f(x1, y1) of a corner function f, the second integral over x and y of that
of a point force. With Phi = int p/R /(2 pi) and its integrals over depth the pressure gives, for example,
s_xx = -A_xx - 2 nu A_yy - z d^2 Phi/dx^2, where A_xx belongs to exp(-kz) (k_x/k)^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import TINY, Array

Depth = Array | float

_SWAP = np.array([1, 0, 2, 4, 3, 5, 7, 6, 8])
"""Components after exchanging x and y."""


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
