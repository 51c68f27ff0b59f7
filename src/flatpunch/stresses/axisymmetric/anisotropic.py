"""The half-space part of a round load where the surface material is transversely isotropic.

Its fields under a load wave are y = [H; 1] exp(-N kz) t (`compliance.transverse`). With exp(-N x) = Re sum P_q exp(-p_q x) they
are sums of the integrals of an isotropic half-space at the depths p_q z, which may be complex: p_q are the two rates of decay
and P_q their projections. Where the rates are nearly equal both projections grow without limit, and the sum is taken over
points of a circle about them instead, P_q the weighted resolvents of N (Cauchy's integral, whose trapezoidal sum converges
geometrically).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliances.depth import decaying_waves
from flatpunch.compliances.transverse import Solid
from flatpunch.media import Stack
from flatpunch.media.plane import Plane, over
from flatpunch.stresses.axisymmetric.radial import (
    NORMAL_ORDERS,
    SHEAR_ORDERS,
    Integrated,
    SurfacePart,
    normal_waves,
    shear_waves,
)

_CLOSE, _CIRCLE, _POINTS = 1e-3, 0.1, 16
"""Difference of the rates over their mean below which the circle is taken, its radius over the mean, and its points, which leave
(1/10)^16."""

_NORMAL = tuple(zip(NORMAL_ORDERS, (0, 0, 1, 1, 1, 1), strict=True))
_SHEAR = tuple(zip(SHEAR_ORDERS, (0, 0, 0, 1, 1, 1, 1, 1, 1), strict=True))
"""Bessel order and power of k of each function: displacements have one power less."""


def surface_part(body: Stack) -> SurfacePart | AnisotropicPart:
    """The part close to the surface of a body that is taken in closed form."""
    top = body.parts[0]
    return AnisotropicPart(top.plane) if top.anisotropic else SurfacePart.of(body)


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
        normal = normal_waves(waves, k)
        return np.concatenate([normal, shear_waves(waves, k)]) if shear else normal

    def of_load(self, load: Integrated, r: Array, z: Array, shear: bool) -> Array:
        """The part at points, shape (6, n), with a traction (15, n)."""
        result = np.zeros((15 if shear else 6, r.size))
        # rows of the functions of a traction: u_l, u_l, u_z, s_lz, s_lz, s_zz, mean, difference, difference
        rows = np.array([0, 0, 1, 2, 2, 3, 4, 5, 5])
        for rate, projection in self._terms:
            functions, integrals = self._functions @ projection, load.integrals(r, np.asarray(rate * z))
            _add(result[:6], -functions[:, 1], _NORMAL, integrals)
            _add(result[6:], functions[rows, 0], _SHEAR, integrals)
        if shear:
            rate, impedance = self._solid.sideways
            u, lt = -1 / (impedance * self._shear), -self._solid.plane.across / impedance
            sideways = np.array([u, -u, 0.0, 1.0, -1.0, 0.0, 0.0, lt, -lt])
            _add(result[6:], sideways, _SHEAR, load.integrals(r, rate * z))
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


def _add(result: Array, factors: Array, which: tuple[tuple[int, int], ...], integrals: Array) -> None:
    """Add factors times integrals I_mj to the functions; none where there are no rows for them."""
    for row, factor, (m, j) in zip(result, factors, which, strict=False):
        row += (factor * integrals[m, j]).real
