"""Responses of the punch matrices of all angular harmonics at once.

The matrices of one parity are trailing blocks of D + B (T3.2). Turned end to end they are leading blocks, and one
Cholesky factor holds the factors of all of them. Only the edge functionals are wanted: S[A_m^-1 b] = S0[b] + b.v_m with
v_m = A_m^-1 s - D_m^-1 s = -A_m^-1 r_m, r_m = B D_m^-1 s, and s.v_m, which the stiffening of edges is made of.

Sums over n of s_n/D_n j_(m+2n)(x) = S_m(x) are slow: cut off at the size of the matrix they cost k_m 1e-9 at beta = 20, and all
its digits at 200. Over all orders of a parity they are cos(x)/pi or sin(x)/pi (Rayleigh's expansion, DLMF 10.60.7, at the
edge), so S_m is that less its first terms, up to the sign, r_m = 2 int (L - 1) S_m j_p dx, and

    s.v_m = -2 int (L - 1) S_m^2 dx + r_m.A_m^-1 r_m,

of which the matrix has to know the second part only, which is small in what it leaves out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from flatpunch._support.checks import Array, Indices
from flatpunch.compliances import Kernel
from flatpunch.punch.basis import edge_signs, power_moments
from flatpunch.punch.family import punch_family
from flatpunch.punch.graded import graded_harmonics
from flatpunch.punch.matrix import edge_strength, effective_beta, remainder_rule, sufficient_terms
from flatpunch.punch.power_law import PowerLawPunch, power_law_punch

SPARE = 8
"""Terms besides those of a round contact: half or twice as many change outlines by 5e-9."""


@dataclass(frozen=True, slots=True)
class Edges:
    """Edge functionals of harmonics m > 0 at nb radii.

    Attributes
    ----------
    vectors : dict
        m -> v_m, shape (nb, terms of that harmonic); harmonics that are missing feel the half-space only.
    sums : dict
        m -> pi s.v_m less that of the translation m = 1, shape (nb,).
    beyond : ndarray, shape (nb,)
        The same of harmonics that are missing.
    """

    vectors: dict[int, Array]
    sums: dict[int, Array]
    beyond: Array

    @classmethod
    def half_space(cls, radii: int) -> Edges:
        """Solutions on a homogeneous half-space at so many radii."""
        return cls({}, {}, np.zeros(radii))

    def stiffening(self, orders: Indices) -> Array:
        """k_m: relative gain of edge strength per root of the normal distance under the harmonic m of an outline.

        Shape (nb, len(orders)); k_1 = 0 is a translation.
        """
        return np.stack([(m - 1) / 2 + self.sums.get(m, self.beyond) for m in orders.tolist()], axis=1)

    def power_edge(self, exponent: float, orders: Indices) -> Array:
        """S[A_m^-1 b[r^n]] for the displacement r^n cos(m phi), shape (nb, len(orders))."""
        result = np.repeat(half_space_power_edge(exponent, orders)[None, :], self.beyond.size, axis=0)
        for column, vector in self.felt(orders):
            result[:, column] += vector @ power_moments(exponent, int(orders[column]), vector.shape[1])
        return result

    def felt(self, orders: Indices) -> list[tuple[int, Array]]:
        """Columns of `orders` on which the layers act, with their vectors."""
        column = {int(m): i for i, m in enumerate(orders)}
        return [(column[m], vector) for m, vector in self.vectors.items() if m in column]


def half_space_power_edge(exponent: float, orders: Indices) -> Array:
    """S0_m = 1/B((m + n + 1)/2, 1/2) for many orders, shape (len(orders),)."""
    x = (np.asarray(orders, dtype=float) + exponent + 1) / 2
    return np.asarray(np.exp(scipy.special.gammaln(x + 0.5) - scipy.special.gammaln(x)) / np.sqrt(np.pi))


def harmonic_size(kernel: Kernel, beta: float) -> int:
    """Terms of the common matrix: on harmonics beyond twice this order only the half-space of the surface material acts."""
    terms = sufficient_terms(kernel, beta) + SPARE
    # the medium acts on harmonics up to m = 12 beta: v_m is 1e-8 of what it is added to there, and less in an outline, whose
    # harmonics fall like m^-2 or faster. No more than 300 beyond the terms of a round contact: under a four-sided pyramid on 100
    # layers, 600 change the outline by 2e-7 and the force by 1e-8, which is below what the series leave out, in twice the time
    return max(terms, min(int(np.ceil(6.0 * effective_beta(kernel, beta))), terms + 150))


def solve_edges(kernel: Kernel, beta: Array, orders: Indices) -> Edges:
    """Edge functionals of harmonics m > 0 at punch radii beta > 0, shape (nb,), in units of the medium's length."""
    if kernel.homogeneous:
        return Edges.half_space(beta.size)
    if kernel.graded:
        graded = graded_harmonics(kernel, beta, orders.tolist())
        return Edges(*graded, beyond=graded[1][max(graded[1])])
    largest = float(beta.max())
    most, terms = harmonic_size(kernel, largest), sufficient_terms(kernel, largest)
    wanted = {1, *orders[orders < 2 * most].tolist()}
    vectors: dict[int, Array] = {}
    own: dict[int, Array] = {}
    for parity in (0, 1):
        chosen = sorted(m for m in wanted if m % 2 == parity)
        if chosen:
            # no more than the highest order asks for: few where the outline is smooth
            parts = _solve_parity(kernel, beta, min(most, terms + chosen[-1] // 2 + SPARE), parity, chosen)
            vectors |= parts[0]
            own |= parts[1]
    return Edges(vectors, {m: np.pi * (value - own[1]) for m, value in own.items()}, -np.pi * own[1])


def _solve_parity(
    kernel: Kernel, beta: Array, size: int, parity: int, orders: list[int]
) -> tuple[dict[int, Array], dict[int, Array]]:
    """v_m, shape (nb, terms of it), and s.v_m, shape (nb,), of orders of one parity."""
    rule = remainder_rule(kernel, beta, size, parity)
    matrix = rule.matrix()
    factors = np.asarray(np.linalg.cholesky(matrix[:, ::-1, ::-1]), dtype=float)
    matrix[:, range(size), range(size)] -= rule.diagonal
    # sums over all n, and over the first of them
    every = rule.table.waves[parity] / np.pi
    # all orders side by side: sums over the first n of each, then right-hand sides, zero above the block of an order
    starts = (np.array(orders) - parity) // 2
    first = np.where(np.arange(size)[:, None] < starts, (edge_signs(size) / rule.diagonal)[:, None], 0.0)
    waves = every - first.T @ rule.table.j
    right = np.where(first == 0, rule.column(every)[:, :, None] - matrix @ first, 0.0)
    half, solved = _block_solutions(factors, right, starts)
    own = np.sum(half**2, axis=1) - rule.weights @ (waves**2).T
    vectors = {
        m: -((-1.0) ** start) * solved[:, start:, i] for i, (m, start) in enumerate(zip(orders, starts, strict=True))
    }
    return vectors, {m: own[:, i] for i, m in enumerate(orders)}


def _block_solutions(factors: Array, right: Array, starts: Indices) -> tuple[Array, Array]:
    """L^-1 r and (L L^T)^-1 r for columns r, each with the block of the matrix that begins at its `starts`."""
    size = right.shape[1]
    half, solved = np.empty_like(right), np.empty_like(right)
    outside = np.arange(size)[::-1, None] < starts
    for i, factor in enumerate(factors):
        # LAPACK reads rows as columns: the lower triangle is an upper one to it
        part = scipy.linalg.blas.dtrsm(1.0, factor.T, right[i, ::-1], trans_a=1)
        part[outside] = 0.0
        half[i], solved[i] = part, scipy.linalg.blas.dtrsm(1.0, factor.T, part)[::-1]
    return half, solved


@dataclass(frozen=True, slots=True)
class PowerLawEdges:
    """Edge functionals of a power-law half-space, in closed form, with the interface of `Edges`.

    Attributes
    ----------
    punch : PowerLawPunch
        The closed forms.
    strength : ndarray, shape (nb,)
        Edge strengths e of the flat punches.
    """

    punch: PowerLawPunch
    strength: Array

    def stiffening(self, orders: Indices) -> Array:
        """k_m = (m - 1)(1 - k)/2, shape (nb, len(orders))."""
        return np.repeat([[self.punch.stiffening(int(m)) for m in orders]], self.strength.size, axis=0)

    def power_edge(self, exponent: float, orders: Indices) -> Array:
        """S of the pressure for r^n cos(m phi): R_m e D1, shape (nb, len(orders))."""
        response = np.array([self.punch.outline_response(exponent, int(m)) for m in orders])
        return np.asarray(self.strength[:, None] * response * exponent * self.punch.power_depth(exponent))


@dataclass(frozen=True, slots=True)
class KnownEdges:
    """Edge functionals read from a table for certain orders and one exponent, with the interface of `Edges`.

    Attributes
    ----------
    stiff, power : ndarray, shape (nb, orders)
        k_m, and S[A_m^-1 b[r^n]].
    """

    stiff: Array
    power: Array

    def stiffening(self, orders: Indices) -> Array:
        """k_m of the orders it was made for."""
        return self.stiff

    def power_edge(self, exponent: float, orders: Indices) -> Array:
        """S of the pressure for r^n cos(m phi), for the exponent and the orders it was made for."""
        return self.power


def known_edges(kernel: Kernel, beta: Array, orders: Indices, exponent: float) -> KnownEdges | None:
    """Edge functionals that are read from the medium's table, if it has one that holds them."""
    table = kernel.solution
    if table is None or not table.responds_to(exponent) or not beta.all() or not table.covers(beta):
        return None
    return KnownEdges(*table.edges(beta, orders, exponent))


def edges_of(kernel: Kernel, beta: Array, orders: Indices) -> Edges | PowerLawEdges:
    """Edge functionals at radii beta, shape (nb,); beta = 0 is the half-space of the surface material."""
    if kernel.exponent:
        return PowerLawEdges(power_law_punch(kernel), edge_strength(punch_family(kernel).at(beta)))
    return solve_edges(kernel, beta, orders) if beta.all() else Edges.half_space(beta.size)
