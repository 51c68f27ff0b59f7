"""Answers of the punch matrices of all angular harmonics at once.

The matrices of one parity are trailing blocks of D + B (T3.2). Turned end to end they are leading blocks, and one
Cholesky factor holds the factors of all of them. Only the edge functionals are wanted: S[A_m^-1 b] = S0[b] + b.edge_m.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln

from flatpunch._validation import Array, Indices
from flatpunch.compliance import Kernel
from flatpunch.punch.basis import edge_signs, half_space_diagonal, inverse_factors, power_moments
from flatpunch.punch.graded import graded_harmonics
from flatpunch.punch.matrix import effective_beta, kernel_matrix, sufficient_terms

_MOST_HARMONICS = 600
"""Beyond the terms of a round contact: what kinked outlines have above twice that is m^-3 = 1e-9 of their asymmetry, and
matrices of contacts a few hundred layers wide stay below a few hundred megabytes."""


@dataclass(frozen=True, slots=True)
class Edges:
    """Edge functionals of harmonics m > 0 at nb radii.

    Attributes
    ----------
    vectors : dict
        m -> A_m^-1 s - D_m^-1 s, shape (nb, terms of that harmonic); harmonics that are missing feel the half-space only.
    first : ndarray, shape (nb,)
        s.(A_1^-1 - D_1^-1)s of the translation, m = 1.
    sums : dict or None
        Under a graded surface, where sums over a vector have no limit: m -> pi s.(A_m^-1 - D_m^-1)s less that of m = 1.
    """

    vectors: dict[int, Array]
    first: Array
    sums: dict[int, Array] | None = None

    def stiffening(self, orders: Indices) -> Array:
        """k_m: relative gain of edge strength per root of the normal distance under the harmonic m of an outline.

        Shape (nb, len(orders)); k_1 = 0 is a translation.
        """
        if self.sums is not None:
            last = self.sums[max(self.sums)]
            return np.stack([(m - 1) / 2 + self.sums.get(m, last) for m in orders.tolist()], axis=1)
        k = np.broadcast_to((orders - 1) / 2, (self.first.size, orders.size)) - np.pi * self.first[:, None]
        for column, vector in self._among(orders):
            k[:, column] += np.pi * (vector @ edge_signs(vector.shape[1]))
        return k

    def power_edge(self, exponent: float, orders: Indices) -> Array:
        """S[A_m^-1 b[r^n]] for the displacement r^n cos(m phi), shape (nb, len(orders))."""
        result = np.repeat(half_space_power_edge(exponent, orders)[None, :], self.first.size, axis=0)
        for column, vector in self._among(orders):
            result[:, column] += vector @ power_moments(exponent, int(orders[column]), vector.shape[1])
        return result

    def _among(self, orders: Indices) -> list[tuple[int, Array]]:
        """Columns of `orders` in which the medium is felt, with their vectors."""
        column = {int(m): i for i, m in enumerate(orders)}
        return [(column[m], vector) for m, vector in self.vectors.items() if m in column]


def half_space_power_edge(exponent: float, orders: Indices) -> Array:
    """S0_m = 1/B((m + n + 1)/2, 1/2) for many orders, shape (len(orders),)."""
    x = (np.asarray(orders, dtype=float) + exponent + 1) / 2
    return np.asarray(np.exp(gammaln(x + 0.5) - gammaln(x)) / np.sqrt(np.pi))


def harmonic_size(kernel: Kernel, beta: float) -> int:
    """Terms of the common matrix: beyond order twice this, harmonics feel the half-space of the surface material only."""
    return sufficient_terms(kernel, beta) + 8 + int(np.ceil(min(4 * effective_beta(kernel, beta), _MOST_HARMONICS / 2)))


def solve_edges(kernel: Kernel, beta: Array, orders: Indices) -> Edges:
    """Edge functionals of the wanted harmonics.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    beta : ndarray, shape (nb,)
        Punch radii in units of the medium's length, > 0.
    orders : ndarray of int
        Harmonics m > 0.

    Returns
    -------
    Edges
    """
    if kernel.homogeneous:
        return Edges({}, np.zeros(beta.size))
    if kernel.graded:
        vectors, sums = graded_harmonics(kernel, beta, orders.tolist())
        return Edges(vectors, np.zeros(beta.size), sums)
    largest = float(beta.max())
    # no more than the highest order asks for: few where the outline is smooth
    size = min(harmonic_size(kernel, largest), sufficient_terms(kernel, largest) + int(max(orders, default=1)) // 2 + 8)
    wanted = {1, *orders[orders < 2 * size].tolist()}
    vectors = {}
    for parity in (0, 1):
        chosen = sorted(m for m in wanted if m % 2 == parity)
        if chosen:
            vectors |= _solve_parity(kernel, beta, size, parity, chosen)
    return Edges(vectors, vectors[1] @ edge_signs(size))


def _solve_parity(kernel: Kernel, beta: Array, size: int, parity: int, orders: list[int]) -> dict[int, Array]:
    block = kernel_matrix(kernel, beta, size, parity)
    matrix = block.copy()
    matrix[:, range(size), range(size)] += half_space_diagonal(parity, size)
    inverse = inverse_factors(matrix[:, ::-1, ::-1])
    vectors = {}
    for m in orders:
        start = (m - parity) // 2
        n = size - start
        s = edge_signs(n) / half_space_diagonal(m, n)
        right = -(block[:, start:, start:] @ s)[:, ::-1]
        half = np.einsum("bij,bj->bi", inverse[:, :n, :n], right)
        vectors[m] = np.einsum("bji,bj->bi", inverse[:, :n, :n], half)[:, ::-1]
    return vectors
