"""A tension that is uniform over a disc of radius c, on any medium, as the theory of Maugis needs it.

A uniform pressure on the disc is the sum of the pressures of flat punches of all radii b < c, pressed in by q_c(b) db (T11.4). A
contact of radius a inside then needs only smooth functions of the angle theta of b = c cos(theta):

    1 - U_b(c)                  drop of the surface at the radius c beside a flat punch of radius b that is pressed in by 1
    D_c(b) = int_b^c q_c db     depth of the contact of radius b under the tip U_c(0) - U_c(r), counted from U_c(0)
    K(b)                        stiffness of the punch

Both displacements are integrals over cos(kt) along the radius. With t = c sin(psi), the flat punch's c_n and v_l of the edge
functional (page 3) and phi = sum (-1)^n c_n P_2n, omega = sum (-1)^l v_l P_2l,

    U_b(c) = 2 int_0^(pi/2 - theta) phi(sin psi/cos theta) (1 + c cos psi N) dpsi,    N = int (L - 1) cos(kt) J_0(kc) dk
    E* D_c e/2 = h(b)/pi + int phi -> omega,    h = c cos psi + M,    M = c int (L - 1) cos(kt) J_1(kc)/k dk.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.polynomial import chebyshev
from numpy.polynomial.legendre import legvander

from flatpunch._support.checks import Array, Indices
from flatpunch.compliances import Kernel
from flatpunch.contact.round.carried import wave_range
from flatpunch.numerics.chebyshev import nodal_transform, polynomials, tail, unit_nodes
from flatpunch.numerics.gauss import gauss
from flatpunch.punch.basis import edge_signs
from flatpunch.punch.family import TOLERANCE, punch_family
from flatpunch.punch.matrix import edge_strength
from flatpunch.punch.wavenumbers import bessel_table

_FEWEST, _MOST = 16, 256
"""Terms of the series in theta and psi: from those of half-spaces to those of discs of a few hundred thicknesses."""


@dataclass(frozen=True, slots=True)
class CohesiveZone:
    """Discs under uniform tension.

    Attributes
    ----------
    outer : ndarray, shape (n,)
        c [m].
    series : ndarray, shape (n, 3, terms)
        Chebyshev series in theta^2, up to an angle, of (1 - U_b(c))/sin(theta) [-], D_c(b)/sin(theta) [m/Pa] and K(b) [N/m].
    most : float
        The angle.
    """

    outer: Array
    series: Array
    most: float

    def at(self, row: Indices, angle: Array) -> tuple[Array, Array, Array, Array, Array]:
        """1 - U, D, their derivatives by theta, and K at angles of discs, shape (m, points) each, for rows of shape (m,)."""
        basis = np.moveaxis(polynomials(_unit(angle, self.most), self.series.shape[2] - 1), 0, 1)
        series = self.series[row]
        scaled = np.moveaxis(series @ basis, 1, 0)
        rate = np.moveaxis(chebyshev.chebder(series[:, :2], axis=2) @ basis[:, :-1], 1, 0) * 4 * angle / self.most**2
        sine, cosine = np.sin(angle), np.cos(angle)
        drop, depth = sine * scaled[:2]
        return drop, depth, *(cosine * scaled[:2] + sine * rate), scaled[2]


def cohesive_zone(kernel: Kernel, outer: Array, most: float = np.pi / 2, refinement: int = 1) -> CohesiveZone:
    """Discs of the radii c [m], shape (n,), up to an angle, with `refinement` times as many terms as are enough."""
    limit, series = tolerance(kernel), _series(kernel, outer, terms := _FEWEST, most)
    while max(tail(series[i, j]) for i in range(outer.size) for j in range(2)) > limit and terms < _MOST:
        series = _series(kernel, outer, terms := 2 * terms, most)
    return CohesiveZone(outer, series if refinement == 1 else _series(kernel, outer, refinement * terms, most), most)


def rim_lift(kernel: Kernel, outer: Array) -> Array:
    """Height to which a unit tension on discs of radii c [m] lifts the surface at their rims [m/Pa], shape (n,)."""
    zone, row = cohesive_zone(kernel, outer), np.arange(outer.size)
    t, weights = gauss(2 * zone.series.shape[2])
    drop, _, _, growth, _ = zone.at(row, np.broadcast_to(np.pi / 4 * (1 + t), (outer.size, t.size)))
    _, whole, *_ = zone.at(row, np.full((outer.size, 1), np.pi / 2))
    return np.asarray(whole[:, 0] - np.pi / 4 * (drop * growth) @ weights)


def tolerance(kernel: Kernel) -> float:
    """Tail of a series that needs no more terms; integrals over the response of a graded surface leave 1e-6."""
    return 1e-6 if kernel.graded else TOLERANCE


def _unit(angle: Array, most: float = np.pi / 2) -> Array:
    return np.asarray(2 * (angle / most) ** 2 - 1)


def _angles(count: int, most: float = np.pi / 2) -> Array:
    """Angles at the nodes of series in their square."""
    return np.asarray(most * np.sqrt((1 + unit_nodes(count)) / 2))


def _series(kernel: Kernel, outer: Array, count: int, most: float) -> Array:
    theta = _angles(count, most)
    share, rest = np.cos(theta), np.pi / 2 - theta
    punches = punch_family(kernel).at((outer[:, None] * share).ravel() / kernel.length)
    terms = punches.flat.shape[1]
    flat, edge = (
        np.moveaxis((each * edge_signs(terms)).reshape(outer.size, count, terms), 1, 0)
        for each in (punches.flat, punches.edge)
    )
    waves = _waves(kernel, outer)
    t, v = gauss(waves.shape[2] + terms)
    psi, weight = rest[:, None] * (1 + t) / 2, rest[:, None] / 2 * v
    basis = np.moveaxis(legvander(np.sin(psi) / share[:, None], 2 * terms - 2)[..., ::2], 2, 1)
    places = polynomials(_unit(np.c_[psi, rest]), waves.shape[2] - 1).reshape(waves.shape[2], -1)
    bent = np.moveaxis((waves @ places).reshape(2, outer.size, count, -1), 2, 1)
    cosine = np.cos(psi)[:, None]
    beside = 2 * ((flat @ basis) * (1 + cosine * bent[0, ..., :-1]) @ weight[..., None])[..., 0].T
    rising = (weight * np.cos(psi) / share[:, None])[..., None]
    within = ((edge @ basis) * (cosine + bent[1, ..., :-1]) @ rising)[..., 0].T
    depth = ((np.sin(theta) + bent[1, ..., -1].T) / np.pi + within) / edge_strength(punches).reshape(within.shape)
    stiffness = np.pi * share * punches.flat[:, 0].reshape(within.shape) * kernel.modulus
    scaled = [(1 - beside) / np.sin(theta), 2 * outer[:, None] / kernel.modulus * depth / np.sin(theta)]
    return np.stack([*scaled, 2 * outer[:, None] * stiffness], axis=1) @ nodal_transform(count).T


def _waves(kernel: Kernel, outer: Array) -> Array:
    """Series of c N and M/c in psi^2, shape (2, n, terms)."""
    if kernel.homogeneous:
        return np.zeros((2, outer.size, 1))
    beta = outer / kernel.length
    table = bessel_table(0, 1, *wave_range(kernel, float(beta.min()), float(beta.max())))
    kappa = table.x / beta[:, None]
    # the slow part of graded surfaces, k/(k^2 + 1/l^2), in closed form
    rest = (kernel.remainder(kappa.ravel()).reshape(kappa.shape) - kernel.tail * kappa / (kappa**2 + 1)) * table.w
    waves, terms = np.stack([rest * scipy.special.j0(table.x), rest * scipy.special.j1(table.x) / table.x]), _FEWEST
    while True:
        series = waves @ (np.cos(np.outer(table.x, np.sin(_angles(terms)))) @ nodal_transform(terms).T)
        if tail(np.moveaxis(series, 2, 0)) < tolerance(kernel) or terms >= _MOST:
            return np.asarray(series + kernel.tail * _slow_waves(beta[:, None], terms))
        terms *= 2


def _slow_waves(beta: Array, terms: int) -> Array:
    """The same for L - 1 = kappa/(kappa^2 + 1)."""
    t = beta * np.sin(_angles(terms))
    even = (np.exp(t - beta) + np.exp(-t - beta)) / 2
    slow = [beta * scipy.special.k0e(beta) * even, 1 / beta - scipy.special.k1e(beta) * even]
    return np.asarray(np.stack(slow) @ nodal_transform(terms).T)
