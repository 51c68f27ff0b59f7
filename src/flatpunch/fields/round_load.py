"""Stress and displacement in one body under a round load: pressure, and a traction of the same shape in one direction."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.compliance.depth import constants_at
from flatpunch.fields.bodies import Located
from flatpunch.fields.layered import REACH, layered_part
from flatpunch.fields.radial import cartesian, half_space_normal, half_space_shear


class RoundLoad(Protocol):
    """A round pressure: its half-space integrals and its transform."""

    @property
    def radius(self) -> float: ...  # noqa: D102

    def integrals(self, r: Array, z: Array) -> Array: ...  # noqa: D102

    def transform(self, k: Array) -> Array: ...  # noqa: D102


def round_fields(
    load: RoundLoad,
    at: Located,
    x: Array,
    y: Array,
    *,
    pressure: float = 1.0,
    traction: float = 0.0,
    direction: float = 0.0,
    reach: float = REACH,
) -> tuple[Array, Array]:
    """Fields at points of one body, in the coordinates in which its depth is positive.

    Parameters
    ----------
    load : RoundLoad
        The load, about the origin.
    at : Located
        Points of the body.
    x, y : ndarray, shape (n,)
        Their coordinates along the surface [m].
    pressure, traction : float
        Factors of the load as pressure and as traction [-].
    direction : float
        Polar angle of the traction [rad].
    reach : float
        Where integrals over the layers' response end, see `layered_part`.

    Returns
    -------
    stress : ndarray, shape (6, n)
        xx, yy, zz, yz, xz, xy [Pa].
    displacement : ndarray, shape (3, n)
        [m].
    """
    shear = traction != 0
    r, z, layer, which = _distinct(np.hypot(x, y), at)
    top = layer == 0
    normal, sideways = layered_part(at.body, load, r, z, layer, shear, reach)
    if top.any():
        zero = np.zeros(1)
        mu, nu = (float(each[0]) for each in constants_at(at.body, zero, np.zeros(1, dtype=int)))
        integrals = load.integrals(r[top], z[top])
        normal[:, top] += half_space_normal(integrals, z[top], mu, nu)
        if shear:
            extra = half_space_shear(integrals, z[top], mu, nu)
            sideways = extra_added(sideways, extra, top)
    theta = np.arctan2(y, x) - direction
    stress, displacement = cartesian(
        pressure * normal[:, which], traction * sideways[:, which] if shear and sideways is not None else None, theta
    )
    return turned(stress, displacement, direction)


def extra_added(sideways: Array | None, extra: Array, top: Array) -> Array:
    """The half-space part of the traction's fields added at the points of the top layer."""
    total = np.zeros((extra.shape[0], top.size)) if sideways is None else sideways
    total[:, top] += extra
    return total


def _distinct(r: Array, at: Located) -> tuple[Array, Array, Indices, Indices]:
    """Different (r, depth, layer), and which of them each point is: planes about the axis repeat them."""
    keys = np.empty(r.size, dtype=complex)
    keys.real, keys.imag = r, at.depth
    _, first, which = np.unique(keys, return_index=True, return_inverse=True)
    return r[first], at.depth[first], at.layer[first], which.ravel()


def turned(stress: Array, displacement: Array, direction: float) -> tuple[Array, Array]:
    """Components in axes of which the given ones are turned by `direction` about z."""
    if direction == 0:
        return stress, displacement
    c, s = np.cos(direction), np.sin(direction)
    xx, yy, zz, yz, xz, xy = stress
    u_x, u_y, u_z = displacement
    return (
        np.stack(
            [
                c * c * xx + s * s * yy - 2 * s * c * xy,
                s * s * xx + c * c * yy + 2 * s * c * xy,
                zz,
                s * xz + c * yz,
                c * xz - s * yz,
                s * c * (xx - yy) + (c * c - s * s) * xy,
            ]
        ),
        np.stack([c * u_x - s * u_y, s * u_x + c * u_y, u_z]),
    )
