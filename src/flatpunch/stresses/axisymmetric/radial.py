"""The radial functions from which all stresses and displacements under a round load follow.

A pressure p(r) = int k P J_0(kr) dk gives six functions of (r, z), a traction of the same shape in the direction x nine more,

    int k P(k) J_m(kr) F(k, z) dk,

with F the fields under unit load waves (`flatpunch.compliances.depth`) and the order m of the list. The angles come in at the
end (`cartesian`): friction goes with cos and sin of theta, 2 theta, 3 theta. In the half-space of the surface material F is a
polynomial of kz times exp(-kz) and the integrals are those of `ring_sources`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliances.depth import Waves
from flatpunch.compliances.stack import plane_at
from flatpunch.media import HalfSpace, Stack

NORMAL_ORDERS = (1, 0, 1, 0, 0, 2)
"""Bessel orders of u_r, u_z, s_rz, s_zz, (s_rr + s_tt)/2, -(s_rr - s_tt)/2 under a pressure."""

SHEAR_ORDERS = (0, 2, 1, 0, 2, 1, 1, 1, 3)
"""Bessel orders of u_l + u_t, u_l - u_t, u_z, s_lz + s_tz, s_lz - s_tz, s_zz, the in-plane mean, and the in-plane difference
plus and minus the in-plane shear, under a traction."""


def normal_waves(waves: Waves, k: Array) -> Array:
    """F of the six functions, shape (6, nk, nz)."""
    found = waves.normal.copy()
    found[:2] /= k[:, None]
    return found


def shear_waves(waves: Waves, k: Array) -> Array:
    """F of the nine functions, shape (9, nk, nz)."""
    u_l, u_z, s_lz, s_zz, mean, difference = waves.shear
    u_t, s_tz, s_lt = waves.transverse
    q = k[:, None]
    return np.stack(
        [
            (u_l + u_t) / q,
            (u_l - u_t) / q,
            u_z / q,
            s_lz + s_tz,
            s_lz - s_tz,
            s_zz,
            mean,
            difference + s_lt,
            difference - s_lt,
        ]
    )


def half_space_normal(i: Array, z: Array, mu: float, nu: float) -> Array:
    """The six functions in a half-space, from the integrals I_mj, shape (4, 3, n); shape (6, n)."""
    return np.stack(
        [
            (z * i[1, 1] - (1 - 2 * nu) * i[1, 0]) / (2 * mu),
            (z * i[0, 1] + 2 * (1 - nu) * i[0, 0]) / (2 * mu),
            -z * i[1, 2],
            -(i[0, 1] + z * i[0, 2]),
            (z * i[0, 2] - (1 + 2 * nu) * i[0, 1]) / 2,
            (z * i[2, 2] - (1 - 2 * nu) * i[2, 1]) / 2,
        ]
    )


def half_space_shear(i: Array, z: Array, mu: float, nu: float) -> Array:
    """The nine functions in a half-space, shape (9, n)."""
    return np.stack(
        [
            (z * i[0, 1] - 2 * (2 - nu) * i[0, 0]) / (2 * mu),
            (z * i[2, 1] + 2 * nu * i[2, 0]) / (2 * mu),
            (z * i[1, 1] + (1 - 2 * nu) * i[1, 0]) / (2 * mu),
            2 * i[0, 1] - z * i[0, 2],
            -z * i[2, 2],
            -z * i[1, 2],
            z * i[1, 2] / 2 - (1 + nu) * i[1, 1],
            z * i[1, 2] / 2 - (2 - nu) * i[1, 1],
            z * i[3, 2] / 2 + nu * i[3, 1],
        ]
    )


class Integrated(Protocol):
    """A round load by its half-space integrals."""

    def integrals(self, r: Array, z: Array) -> Array: ...  # noqa: D102


@dataclass(frozen=True, slots=True)
class SurfacePart:
    """The part of the fields close to the surface that is taken in closed form.

    Attributes
    ----------
    half_space : HalfSpace
        Homogeneous body whose fields these are: of the material at the surface.
    along : float or None
        Under a power-law half-space, whose modulus at the surface is zero or infinite, only the tractions are those of the
        half-space; the stresses along the surface are this multiple of s_zz, and displacements are left out.
    """

    half_space: HalfSpace
    along: float | None = None

    @classmethod
    def of(cls, body: Stack) -> SurfacePart:
        """Part that belongs to a body."""
        if law := body.power_law:
            return cls(HalfSpace(law.modulus, law.poisson), law.poisson / (1 - law.poisson))
        plane = plane_at(body, np.zeros(1), np.zeros(1, dtype=int))
        mu, ratio = float(plane.across[0]), float(plane.coupling[0])
        nu = ratio / (1 + ratio)
        return cls(HalfSpace(2 * mu * (1 + nu), nu))

    @property
    def constants(self) -> tuple[float, float]:
        """Shear modulus [Pa] and Poisson ratio."""
        return self.half_space.young / (2 * (1 + self.half_space.poisson)), self.half_space.poisson

    def amplitudes(self, k: Array, z: Array, shear: bool) -> Array:
        """The part under unit load waves, shape (6 or 15, nk, nz): the integrals without the load's transform."""
        decay = np.exp(-np.multiply.outer(k, z))
        powers = np.broadcast_to(np.stack([decay / k[:, None], decay, decay * k[:, None]]), (4, 3, *decay.shape))
        return self.closed(powers, z, shear)

    def kept(self, functions: Array) -> Array:
        """What is taken of the half-space's functions, shape (6 or 15, ...)."""
        if self.along is None:
            return functions
        result = np.zeros_like(functions)
        # notation: s_rz, s_zz, and under a traction s_lz + s_tz, s_lz - s_tz, s_zz
        for rows, szz, mean in (((2, 3), 3, 4), ((9, 10, 11), 11, 12)):
            if szz < len(functions):
                result[list(rows)] = functions[list(rows)]
                result[mean] = self.along * functions[szz]
        return result

    def kept_of_components(self, components: Array) -> Array:
        """What is taken of its stresses xx, yy, zz, yz, xz, xy and displacements, shape (9, ...)."""
        if self.along is None:
            return components
        result = np.zeros_like(components)
        result[2:5] = components[2:5]
        result[:2] = self.along * components[2]
        return result

    def of_load(self, load: Integrated, r: Array, z: Array, shear: bool) -> Array:
        """The part at points, shape (6, n), with a traction (15, n)."""
        return self.closed(load.integrals(r, z), z, shear)

    def closed(self, integrals: Array, z: Array, shear: bool) -> Array:
        """The part at points, from the integrals of the load."""
        mu, nu = self.constants
        normal = half_space_normal(integrals, z, mu, nu)
        return self.kept(np.concatenate([normal, half_space_shear(integrals, z, mu, nu)]) if shear else normal)


def cartesian(normal: Array | None, shear: Array | None, theta: Array) -> tuple[Array, Array]:
    """Stress (xx, yy, zz, yz, xz, xy), shape (6, n), and displacement (x, y, z), shape (3, n).

    Parameters
    ----------
    normal, shear : ndarray, shape (6, n) and (9, n), or None
        The radial functions under a pressure, and under a traction in the direction x.
    theta : ndarray, shape (n,)
        Polar angle of the points [rad].
    """
    stress, displacement = np.zeros((6, theta.size)), np.zeros((3, theta.size))
    c, s = np.cos(theta), np.sin(theta)
    c2, s2 = (c - s) * (c + s), 2 * s * c
    if normal is not None:
        u_r, u_z, s_rz, s_zz, mean, difference = normal
        displacement += np.stack([u_r * c, u_r * s, u_z])
        stress += np.stack(
            [
                mean - difference * c2,
                mean + difference * c2,
                s_zz,
                s_rz * s,
                s_rz * c,
                -difference * s2,
            ]
        )
    if shear is not None:
        c3, s3 = c * c2 - s * s2, s * c2 + c * s2
        u_sum, u_difference, u_z, t_sum, t_difference, s_zz, mean, first, third = shear
        displacement += np.stack([(u_difference * c2 - u_sum) / 2, u_difference * s2 / 2, u_z * c])
        stress += np.stack(
            [
                mean * c + (first * c - third * c3) / 2,
                mean * c - (first * c - third * c3) / 2,
                s_zz * c,
                t_difference * s2 / 2,
                (t_difference * c2 - t_sum) / 2,
                (first * s - third * s3) / 2,
            ]
        )
    return stress, displacement
