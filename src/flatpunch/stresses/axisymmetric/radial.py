"""The radial functions from which all stresses and displacements under a round load follow, and their part in closed form.

A pressure p(r) = int k P J_0(kr) dk gives six functions of (r, z), a traction of the same shape in the direction x nine more,

    int k P(k) J_m(kr) F(k, z) dk,

with F the fields under unit load waves (`flatpunch.compliances.depth`) and the order m of the list. The angles come in at the
end (`cartesian`): friction goes with cos and sin of theta, 2 theta, 3 theta. In the half-space of the surface material F is a
polynomial of kz times exp(-kz) and the integrals are those of `ring_sources`.

Where that material is transversely isotropic the fields under a load wave are y = [H; 1] exp(-N kz) t (`compliance.transverse`).
With exp(-N x) = Re sum P_q exp(-p_q x) they are sums of the integrals of an isotropic half-space at the depths p_q z, which may
be complex: p_q are the two rates of decay and P_q their projections. Where the rates are nearly equal both projections grow
without limit, and the sum is taken over points of a circle about them instead, P_q the weighted resolvents of N (Cauchy's
integral, whose trapezoidal sum converges geometrically). Close to the surface of a power-law half-space the tractions and the
pressure that the material feels along the surface, nu/(1 - nu) s_zz, are those of a homogeneous half-space.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliances.depth import Waves, decaying_waves
from flatpunch.compliances.stack import plane_at
from flatpunch.compliances.transverse import Solid
from flatpunch.media import HalfSpace, Stack
from flatpunch.media.plane import Plane, over
from flatpunch.stresses.axisymmetric.panels import RoundLoad

NORMAL_ORDERS = (1, 0, 1, 0, 0, 2)
"""Bessel orders of u_r, u_z, s_rz, s_zz, (s_rr + s_tt)/2, -(s_rr - s_tt)/2 under a pressure."""

SHEAR_ORDERS = (0, 2, 1, 0, 2, 1, 1, 1, 3)
"""Bessel orders of u_l + u_t, u_l - u_t, u_z, s_lz + s_tz, s_lz - s_tz, s_zz, the in-plane mean, and the in-plane difference
plus and minus the in-plane shear, under a traction."""

NORMAL_POWERS, SHEAR_POWERS = (0, 0, 1, 1, 1, 1), (0, 0, 0, 1, 1, 1, 1, 1, 1)
"""Powers of k of these functions: displacements have one power less than stresses."""

COMPONENTS = 9
"""Stresses xx, yy, zz, yz, xz, xy and displacements x, y, z, in the order of all fields."""

_CLOSE, _CIRCLE, _POINTS = 1e-3, 0.1, 16
"""Difference of the rates over their mean below which the circle is taken, its radius over the mean, and its points, which leave
(1/10)^16."""


def orders(shear: bool) -> tuple[int, ...]:
    """Bessel orders of all functions: of a pressure, and of a traction of the same shape if there is one."""
    return NORMAL_ORDERS + SHEAR_ORDERS if shear else NORMAL_ORDERS


def functions_of(waves: Waves, k: Array, shear: bool) -> Array:
    """F of the six functions, shape (6, nk, nz), or with a traction of all, (15, nk, nz)."""
    normal, q = waves.normal.copy(), k[:, None]
    normal[:2] /= q
    if not shear:
        return normal
    u_l, u_z, s_lz, s_zz, mean, difference = waves.shear
    u_t, s_tz, s_lt = waves.transverse
    displacements = [(u_l + u_t) / q, (u_l - u_t) / q, u_z / q]
    stresses = [s_lz + s_tz, s_lz - s_tz, s_zz, mean, difference + s_lt, difference - s_lt]
    return np.concatenate([normal, displacements, stresses])


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
        # notation: s_rz, s_zz and the mean; under a traction s_lz + s_tz, s_lz - s_tz, s_zz and the mean
        result[2:4], result[4] = functions[2:4], self.along * functions[3]
        if len(functions) > len(NORMAL_ORDERS):
            result[9:12], result[12] = functions[9:12], self.along * functions[11]
        return result

    def kept_of_components(self, components: Array) -> Array:
        """What is taken of its stresses xx, yy, zz, yz, xz, xy and displacements, shape (9, ...)."""
        if self.along is None:
            return components
        result = np.zeros_like(components)
        result[2:5] = components[2:5]
        result[:2] = self.along * components[2]
        return result

    def of_load(self, load: RoundLoad, r: Array, z: Array, shear: bool) -> Array:
        """The part at points, shape (6, n), with a traction (15, n)."""
        return self.closed(load.integrals(r, z), z, shear)

    def closed(self, integrals: Array, z: Array, shear: bool) -> Array:
        """The part at points, from the integrals of the load."""
        mu, nu = self.constants
        normal = half_space_normal(integrals, z, mu, nu)
        return self.kept(np.concatenate([normal, half_space_shear(integrals, z, mu, nu)]) if shear else normal)


@dataclass(frozen=True)
class AnisotropicPart:
    """The part of the fields close to the surface that is taken in closed form.

    Attributes
    ----------
    material : Plane
        Coefficients of the material at the surface; the fields are those of a half-space of it.
    """

    material: Plane[float]

    @cached_property
    def _solid(self) -> Solid:
        return Solid(over(self._shear, self.material))

    @property
    def _shear(self) -> float:
        """Scale of the stresses [Pa]."""
        return 1 / self.material.shear

    def amplitudes(self, k: Array, z: Array, shear: bool) -> Array:
        """The part under unit load waves, shape (6 or 15, nk, nz)."""
        waves = decaying_waves(self.material, k, z, shear=shear)
        return functions_of(waves, k, shear)

    def of_load(self, load: RoundLoad, r: Array, z: Array, shear: bool) -> Array:
        """The part at points, shape (6, n), with a traction (15, n)."""
        result = np.zeros((len(orders(shear)), r.size))
        normal, sideways = result[: len(NORMAL_ORDERS)], result[len(NORMAL_ORDERS) :]
        # rows of the functions of a traction: u_l, u_l, u_z, s_lz, s_lz, s_zz, mean, difference, difference
        rows = np.array([0, 0, 1, 2, 2, 3, 4, 5, 5])
        for rate, projection in self._terms:
            functions, integrals = self._functions @ projection, load.integrals(r, np.asarray(rate * z))
            _add(normal, -functions[:, 1], NORMAL_ORDERS, NORMAL_POWERS, integrals)
            _add(sideways, functions[rows, 0], SHEAR_ORDERS, SHEAR_POWERS, integrals)
        if shear:
            rate, impedance = self._solid.sideways
            u, lt = -1 / (impedance * self._shear), -self._solid.plane.across / impedance
            factors = np.array([u, -u, 0.0, 1.0, -1.0, 0.0, 0.0, lt, -lt])
            _add(sideways, factors, SHEAR_ORDERS, SHEAR_POWERS, load.integrals(r, rate * z))
        return result

    @cached_property
    def _functions(self) -> Array:
        """The six functions of the tractions of one decaying field, shape (6, 2)."""
        plane, scale = self._solid.plane, self._shear
        fields = np.concatenate([self._solid.flexibility, np.eye(2)])
        along, szz = fields[0], fields[3]
        return np.stack(
            [
                along / scale,
                fields[1] / scale,
                fields[2],
                szz,
                plane.coupling * szz + (plane.stiffness - plane.across) * along,
                plane.across * along,
            ]
        )

    @cached_property
    def _terms(self) -> list[tuple[complex, Array]]:
        """Rates p_q and matrices P_q."""
        n, mean = self._solid.generator, self._solid.rates[0] / 2
        e2 = self._solid.square
        if abs(e2) <= (_CLOSE * mean) ** 2:
            # by symmetry about the real axis half the circle is enough
            turns = np.exp(2j * np.pi * (np.arange(_POINTS // 2) + 0.5) / _POINTS)
            points = mean * (1 + _CIRCLE * turns)
            return [
                (complex(p), 2 * mean * _CIRCLE * turn / _POINTS * np.linalg.inv(p * np.eye(2) - n))
                for p, turn in zip(points, turns, strict=True)
            ]
        if e2 < 0:
            e = 1j * (-e2) ** 0.5
            return [(mean - e, (n - (mean + e) * np.eye(2)) / -e)]
        e = e2**0.5
        slow, fast = self._solid.slowest, self._solid.fastest
        return [(slow, (fast * np.eye(2) - n) / (2 * e)), (fast, (n - slow * np.eye(2)) / (2 * e))]


def _add(result: Array, factors: Array, bessel: tuple[int, ...], powers: tuple[int, ...], integrals: Array) -> None:
    """Add factors times integrals I_mj to the functions; none where there are no rows for them."""
    for row, factor, m, j in zip(result, factors, bessel, powers, strict=False):
        row += (factor * integrals[m, j]).real


def surface_part(body: Stack) -> SurfacePart | AnisotropicPart:
    """The part close to the surface of a body that is taken in closed form."""
    top = body.parts[0]
    return AnisotropicPart(top.plane) if top.anisotropic else SurfacePart.of(body)


def under_pressure(functions: Array, theta: Array) -> Array:
    """Stress (xx, yy, zz, yz, xz, xy) and displacement (x, y, z) at polar angles theta [rad], shape (9, n).

    `functions`, shape (6, n), are those of a pressure.
    """
    u_r, u_z, s_rz, s_zz, mean, difference = functions
    c, s = np.cos(theta), np.sin(theta)
    c2, s2 = (c - s) * (c + s), 2 * s * c
    stress = [mean - difference * c2, mean + difference * c2, s_zz, s_rz * s, s_rz * c, -difference * s2]
    return np.stack([*stress, u_r * c, u_r * s, u_z])


def under_traction(functions: Array, theta: Array) -> Array:
    """The same components of the nine functions of a traction in the direction x, shape (9, n)."""
    u_sum, u_difference, u_z, t_sum, t_difference, s_zz, mean, first, third = functions
    c, s = np.cos(theta), np.sin(theta)
    c2, s2 = (c - s) * (c + s), 2 * s * c
    c3, s3 = c * c2 - s * s2, s * c2 + c * s2
    difference = (first * c - third * c3) / 2
    return np.stack(
        [
            mean * c + difference,
            mean * c - difference,
            s_zz * c,
            t_difference * s2 / 2,
            (t_difference * c2 - t_sum) / 2,
            (first * s - third * s3) / 2,
            (u_difference * c2 - u_sum) / 2,
            u_difference * s2 / 2,
            u_z * c,
        ]
    )


def turned(components: Array, direction: float) -> Array:
    """The nine components in axes of which the given ones are turned by `direction` about z."""
    if direction == 0:
        return components
    c, s = np.cos(direction), np.sin(direction)
    xx, yy, zz, yz, xz, xy, u_x, u_y, u_z = components
    return np.stack(
        [
            c * c * xx + s * s * yy - 2 * s * c * xy,
            s * s * xx + c * c * yy + 2 * s * c * xy,
            zz,
            s * xz + c * yz,
            c * xz - s * yz,
            s * c * (xx - yy) + (c * c - s * s) * xy,
            c * u_x - s * u_y,
            s * u_x + c * u_y,
            u_z,
        ]
    )
