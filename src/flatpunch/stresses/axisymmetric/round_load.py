"""Stress and displacement in one body under a round load: pressure, and a traction of the same shape in one direction."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.stresses.axisymmetric.anisotropic import surface_part
from flatpunch.stresses.axisymmetric.layered import layered_part, split_off
from flatpunch.stresses.axisymmetric.panels import REACH, Edges
from flatpunch.stresses.axisymmetric.radial import cartesian
from flatpunch.stresses.bodies import Located


class RoundLoad(Protocol):
    """A round pressure: its half-space integrals and its transform."""

    @property
    def radius(self) -> float: ...  # noqa: D102

    @property
    def shallow(self) -> float: ...  # noqa: D102

    @property
    def edges(self) -> Edges: ...  # noqa: D102

    @property
    def scale(self) -> float: ...  # noqa: D102

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
    normal, sideways = layered_part(at.body, load, r, z, layer, shear, reach)
    functions = normal if sideways is None else np.concatenate([normal, sideways])
    top = split_off(at.body, load, z, layer)
    if top.any():
        functions[:, top] += surface_part(at.body).of_load(load, r[top], z[top], shear)
    functions = functions[:, which]
    theta = np.arctan2(y, x) - direction
    stress, displacement = cartesian(pressure * functions[:6], traction * functions[6:] if shear else None, theta)
    return turned(stress, displacement, direction)


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
