"""Half-space integrals of a uniform pressure on a disc, in elliptic integrals (Eason, Noble and Sneddon 1955).

With L(n, j) = int k^j J_1(ka) J_n(kr) exp(-kz) dk, P = p a J_1(ka)/k gives I_mj = p a L(m, j - 1). L(1, 0), L(0, 0) (a solid
angle) and their derivatives over z are complete elliptic integrals, here in Carlson's symmetric form, whose differences do not
cancel on the axis; one power of k less follows from homogeneity, orders two and three from the recurrence of J_n(kr). Close to
the axis that recurrence divides by r, and the power series in r takes its place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import elliprc, elliprd, elliprf, elliprj, factorial, j1

from flatpunch._support.checks import TINY, Array
from flatpunch.stresses.axisymmetric.panels import Edge, Edges

_TERMS = 9
"""Terms of that series: 0.1^18."""

_DUPLICATIONS = 4
"""Duplications of the third elliptic integral at complex depths: each halves the angles of its arguments to the real axis."""


@dataclass(frozen=True, slots=True)
class UniformDisc:
    """Uniform pressure 1 Pa on a disc.

    Parameters
    ----------
    radius : float
        [m].
    """

    radius: float

    @property
    def shallow(self) -> float:
        """Depth to which the closed form is used under a power-law half-space [m]: far below it a cell acts like a disc."""
        return self.radius * 16 / 3

    @property
    def edges(self) -> Edges:
        """The rim, at which the pressure jumps."""
        return (Edge(self.radius, 0.0),)

    @property
    def scale(self) -> float:
        """Size of the pressure [Pa]."""
        return 1.0

    @property
    def force(self) -> float:
        """Total load [N]."""
        return float(np.pi * self.radius**2)

    def transform(self, k: Array) -> Array:
        """P(k) = a J_1(ka)/k [m^2 Pa]."""
        return np.asarray(self.radius * j1(self.radius * k) / k)

    def integrals(self, r: Array, z: Array) -> Array:
        """I_mj at points (r, z) with Re z >= 0, shape (4, 3, n); complex at complex depths."""
        a = self.radius
        # in units of the radius: L(m, j) has the dimension of k^(j + 1)
        scaled = _integrals(r / a, z / a)
        return scaled * (a ** np.array([1.0, 0.0, -1.0]))[None, :, None]


def _integrals(r: Array, z: Array) -> Array:
    """L(m, j - 1) for a disc of radius 1, shape (4, 3, n); L(3, -1), which nobody needs, is zero."""
    # distance from the axis over that from the rim below which the power series in r is used
    near = r < 0.1 * np.abs(np.sqrt(1 + z * z))
    result = np.zeros((4, 3, r.size), dtype=z.dtype)
    if near.any():
        result[:, :, near] = _series(r[near], z[near])
    if not near.all():
        result[:, :, ~near] = _elliptic(r[~near], z[~near])
    return result


def _elliptic(r: Array, z: Array) -> Array:
    far2 = (1 + r) ** 2 + z * z
    near2 = (1 - r) ** 2 + z * z + TINY
    far, total = np.sqrt(far2), 1 + r * r + z * z
    ratio = near2 / far2
    zero, one = np.zeros_like(r), np.ones_like(r)
    rf, rd = elliprf(zero, ratio, one), elliprd(zero, ratio, one)
    # notation: modulus^2 = 4 r/far2, K = rf, E = rf - modulus^2 rd/3
    e = rf - 4 * r / (3 * far2) * rd
    side = (1 - r) / (1 + r)
    side = np.where(np.abs(side) < 1e-100, 1e-100, side)  # at the rim itself its product with the integral vanishes
    third = rf + 4 * r / (3 * (1 + r) ** 2) * _third_kind(ratio, side * side)
    here = np.where(r < 1, 1.0, np.where(r > 1, 0.0, 0.5))
    through = rf + np.where(r == 1, 0.0, side * third)
    l00 = here - z / (np.pi * far) * through
    l10 = (4 * total * rd / (3 * far2) - 2 * e) / (np.pi * far)
    l01 = (rf + (1 - r * r - z * z) / near2 * e) / (np.pi * far)
    l11 = z / (np.pi * far) * (2 * e / near2 - 4 * rd / (3 * far2))
    ring = 2 * rf / (np.pi * far)  # int J_0(k) J_0(kr) exp(-kz) dk
    other = (1 - z * ring - l00) / r  # int J_0(k) J_1(kr) exp(-kz) dk
    # homogeneity in (a, r, z)
    l0m = ring - r * l10 - z * l00
    l1m = (other + r * l00 - z * l10) / 2
    other_m = r * ring - l10 - z * other
    l1mm = (other_m + r * l0m - z * l1m) / 3
    l2m, l20, l21 = 2 / r * l1mm - l0m, 2 / r * l1m - l00, 2 / r * l10 - l01
    l30, l31 = 4 / r * l2m - l10, 4 / r * l20 - l11
    return np.stack(
        [np.stack(each) for each in ((l0m, l00, l01), (l1m, l10, l11), (l2m, l20, l21), (np.zeros_like(r), l30, l31))]
    )


def _third_kind(ratio: Array, p: Array) -> Array:
    """R_J(0, ratio, 1, p). SciPy has it for Re ratio >= 0; duplications bring complex ones there (DLMF 19.26.18)."""
    x, y, z = np.zeros_like(ratio), ratio, np.ones_like(ratio)
    if not np.iscomplexobj(ratio):
        return np.asarray(elliprj(x, y, z, p))
    p, total, factor = p.astype(complex), np.zeros_like(ratio), 1.0
    for _ in range(_DUPLICATIONS):
        a, b, c = np.sqrt(x), np.sqrt(y), np.sqrt(z)
        grown = a * b + b * c + c * a
        alpha, beta = p * (a + b + c) + a * b * c, np.sqrt(p) * (p + grown)
        total += 3 * factor * elliprc(alpha**2, beta**2)
        x, y, z, p, factor = x + grown, y + grown, z + grown, p + grown, 2 * factor
    return np.asarray(total + factor * elliprj(x, y, z, p))


def _series(r: Array, z: Array) -> Array:
    """Power series in r: J_m(kr) = sum (-1)^s (kr/2)^(m + 2s)/(s! (m + s)!), term by term on the axis."""
    rho = np.sqrt(1 + z * z)
    x = z / rho
    highest = 2 * _TERMS + 4
    # moments int k^n J_1(k) exp(-kz) dk = (n - 1)! P_n'(x)/rho^(n + 2) times rho^(n + 2), which overflows far away, from n = -1
    moments = [rho / (rho + z), rho / (rho + z)]
    legendre, slope = [np.ones_like(x), x], [np.zeros_like(x), np.ones_like(x)]
    for n in range(1, highest + 1):
        moments.append(factorial(n - 1) * slope[n])
        legendre.append(((2 * n + 1) * x * legendre[n] - n * legendre[n - 1]) / (n + 1))
        slope.append((n + 1) * legendre[n] + x * slope[n])
    result = np.zeros((4, 3, r.size), dtype=z.dtype)
    for m in range(4):
        for j in range(3):
            for s in range(_TERMS):
                weight = (-1) ** s / (factorial(s) * factorial(m + s))
                result[m, j] += weight * (r / (2 * rho)) ** (m + 2 * s) * moments[j + m + 2 * s] / rho ** (j + 1)
    return result
