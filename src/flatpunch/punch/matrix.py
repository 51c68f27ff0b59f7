"""The punch matrix A of each harmonic, and its responses, for a batch of punch radii (T3.2).

A_ln = pi/(2(m + 2n) + 1) delta_ln + B_pq with p = m + 2l, q = m + 2n and B_pq = 2 int_0^inf (L - 1) j_p j_q dx, L taken at
k l = x/beta. The matrices of all harmonics of one parity are trailing blocks of one B. Where the modulus varies at the
surface itself L - 1 decays slowly and edge functionals need more care: see `graded`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, Indices
from flatpunch._support.threads import in_threads
from flatpunch.compliances import Kernel
from flatpunch.compliances.layered import SATURATION
from flatpunch.punch.basis import RELATIVE, half_space_diagonal
from flatpunch.punch.graded import graded_round, graded_terms
from flatpunch.punch.wavenumbers import WINDOW, BesselTable, bessel_table, split_table, window_start

RESOLVED = 300.0
"""Largest effective beta, cutoff beta/SATURATION, for which the terms suffice for edge and pressure at 1e-10."""


LARGEST = 2e5
"""Largest effective beta that is solved. Beyond it the shortest length of the medium is below 5e-6 of the contact radius."""


def effective_beta(kernel: Kernel, beta: float) -> float:
    """Radius over the shortest length of the medium: what sets the number of terms and wavenumbers."""
    if kernel.exponent != 0.0:
        # a power-law half-space is closed at every radius, there is nothing to resolve
        return 0.0
    if kernel.graded:
        # no table grows with beta here; up to 1.2e4 lengths are let through, their error is reported
        return 0.025 * beta
    return beta * kernel.cutoff / SATURATION


def largest_beta(kernel: Kernel) -> float:
    """Largest effective beta that is solved; under graded surfaces with their slow edge functionals the resolved one."""
    return RESOLVED if kernel.graded else LARGEST


def sufficient_terms(kernel: Kernel, beta: float) -> int:
    """Number of terms for edge and pressure at 1e-10 (theory page 3, measured over stacks of modulus ratio 1e-4 .. 1e4)."""
    if kernel.graded:
        return graded_terms(kernel, beta)
    level = np.log10(max(effective_beta(kernel, beta), ROUNDING))
    # terms at `RESOLVED` and beyond, where stiffness and moments keep 1e-6 while the pressure at the rim is not resolved
    return int(np.ceil(np.interp(level, [-4, -2, -1, 0, 1, 1.5, 2, 2.5], [4, 5, 7, 13, 44, 76, 134, 300])))


def fewer_terms(kernel: Kernel, beta: float, terms: int) -> int:
    """Number of terms of the second solution, whose difference from the one with all terms is the error estimate.

    A quarter is left out. Where the rim is not resolved the error oscillates as terms are added, and may be the same without a
    quarter; there three eighths are left out (250 random films of 1e-5 to 1e-2 of the radius: 0.82 of the estimate at most).
    """
    unresolved = not kernel.graded and effective_beta(kernel, beta) > RESOLVED
    return max(terms - max(3 * terms // 8 if unresolved else terms // 4, 2), 2)


@dataclass(frozen=True, slots=True)
class RemainderRule:
    """Quadrature of 2 int (L - 1) f dx at nb punch radii.

    Attributes
    ----------
    table : BesselTable
        Nodes x and the functions j_p on them.
    weights : ndarray, shape (nb, nodes)
        2 (L - 1) dx.
    used : ndarray of int, shape (nb,)
        Number of leading nodes at which L - 1 is not negligible.
    diagonal : ndarray, shape (terms,)
        D, the half-space's matrix.
    whole : ndarray, shape (nb, nodes), or None
        2 L dx, on tables that end at infinity.
    """

    table: BesselTable
    weights: Array
    used: Indices
    diagonal: Array
    whole: Array | None = None

    def matrix(self) -> Array:
        """A_pq, shape (nb, terms, terms).

        On a table that ends at infinity it is 2 int L j_p j_q dx itself, a sum of positive terms: where L is small, under thin
        incompressible layers, D + B would lose as many digits as Kbar has.
        """
        terms = self.table.j.shape[0]
        blocks = np.empty((self.used.size, terms, terms))

        weights = self.weights if self.whole is None else self.whole

        def fill(i: int) -> None:
            _fill(blocks[i], self.table.j, weights[i, : self.used[i]])

        in_threads(fill, self.used.size, operations=2.0 * terms**2 * float(self.used.sum()))
        if self.whole is None:
            blocks[:, range(terms), range(terms)] += self.diagonal
        return blocks

    def column(self, values: Array) -> Array:
        """2 int (L - 1) f j_p dx for a function's values on the nodes, shape (nb, terms)."""
        return np.asarray((self.weights * values) @ self.table.j.T)


def _fill(matrix: Array, j: Array, weights: Array) -> None:
    """Sum of weights times j_p j_q over the first nodes, by products of matrices with their own transpose."""
    if len(j) <= 64:
        np.matmul(j[:, : weights.size] * weights, j[:, : weights.size].T, out=matrix)
        return
    matrix[:] = 0.0
    roots, start = np.sqrt(np.abs(weights)), 0
    while start < weights.size:
        end = min(start + 256, weights.size)
        # size of j_p below its turning point from which it is left out
        orders = int(np.flatnonzero(np.abs(j[:, end - 1]) > 1e-18)[-1]) + 1
        if orders == len(j):
            end = weights.size
        scaled, negative = j[:orders, start:end] * roots[start:end], weights[start:end] < 0
        if negative.all() or not negative.any():
            part = scaled @ scaled.T
            matrix[:orders, :orders] += -part if negative[0] else part
        else:
            plus, minus = scaled[:, ~negative], scaled[:, negative]
            matrix[:orders, :orders] += plus @ plus.T - minus @ minus.T
        start = end


def remainder_rule(kernel: Kernel, beta: Array, terms: int, parity: int) -> RemainderRule:
    """The quadrature for `terms` orders of a parity at radii beta, shape (nb,)."""
    low, high = float(beta.min()), float(beta.max())
    first = min(0, int(np.floor(np.log(kernel.floor * low) / np.log(4))))
    table = _table(parity, terms, first, kernel.cutoff * high)
    kappa = table.x / beta[:, None]
    remainder, live = np.zeros_like(kappa), kappa < kernel.cutoff
    diagonal = half_space_diagonal(parity, terms)
    if table.split:
        whole = np.ones_like(kappa)
        whole[live] = kernel.response(kappa[live])
        remainder[live] = whole[live] - 1.0
        weights, used = 2 * remainder * table.w, np.full(beta.size, table.x.size)
        return RemainderRule(table, weights, used, diagonal, 2 * whole * table.w)
    remainder[live] = kernel.remainder(kappa[live])
    return RemainderRule(table, 2 * remainder * table.w, np.searchsorted(table.x, kernel.cutoff * beta), diagonal)


def _table(parity: int, terms: int, first: int, needed: float) -> BesselTable:
    """Quadrature over x up to `needed`; its end is on few levels so that tables are shared between radii."""
    window_end = window_start(parity, terms) + WINDOW
    if needed > 2 * window_end:
        return split_table(parity, terms, first, int(np.ceil(np.log2(needed / window_end))))
    return bessel_table(parity, terms, first, 4.0 * 2.0 ** max(0, int(np.ceil(np.log2(max(needed, 4.0) / 4.0)))))


@dataclass(frozen=True, slots=True)
class Responses:
    """What the matrices of a batch of radii say; unit disc, modulus 1; shapes (nb, terms).

    Attributes
    ----------
    flat : ndarray
        c* = A_0^-1 b[1], the flat punch.
    edge : ndarray
        A_m^-1 s - D_m^-1 s: S[A_m^-1 b] = S0[b] + b.edge. (For m = 0 edge strength e of the punch: 1/pi + edge_0.)
    slope : ndarray
        A_0^-1 t - D_0^-1 t, the same for the functional t of d'(a); only for m = 0.
    rounding : ndarray, shape (nb,)
        Relative error of `flat` from rounding: eps times the largest entry that the matrix is a sum of and the largest of its
        inverse.
    """

    flat: Array
    edge: Array
    slope: Array
    rounding: Array


def solve_round(kernel: Kernel, beta: Array, terms: int) -> Responses:
    """Flat punch and edge functionals of harmonic 0 at radii beta, shape (nb,)."""
    return solve_with_fewer(kernel, beta, terms)[0]


def solve_with_fewer(kernel: Kernel, beta: Array, terms: int, *fewer: int) -> list[Responses]:
    """Responses of harmonic 0 with all terms, and with smaller numbers of them: leading blocks of the same matrix."""
    if kernel.graded:
        found = [graded_round(kernel, beta, n) for n in (terms, *fewer)]
        return [Responses(flat, edge, slope, _rounding(flat, np.pi)) for flat, edge, slope in found]
    rule = remainder_rule(kernel, beta, terms, 0)
    matrix = rule.matrix()
    # B D^-1 s and B D^-1 t without truncating the sums over n: sum_n (4n + 1) (-1)^n j_2n(x) P_2n(t) = cos(xt), so
    # sum_n s_n/D_n j_2n = cos(x)/pi and, with P'_2n(1) = n (2n + 1), sum_n t_n/D_n j_2n = x sin(x)/pi. Summed up to the size
    # of the matrix instead, what is slow in n (cones on films that are thin against the punch) is lost: 1e-3 of the depth at
    # beta = 100 under a film 1e4 times stiffer than its base.
    cos, sin = rule.table.waves
    value, slope = rule.column(cos / np.pi), rule.column(rule.table.x * sin / np.pi)
    first = np.zeros(terms)
    first[0] = 1.0
    right = np.stack([np.broadcast_to(first, (beta.size, terms)), -value, -slope], axis=-1)
    size = np.pi if rule.whole is None else matrix[:, 0, 0]
    solutions = [np.asarray(np.linalg.solve(matrix[:, :n, :n], right[:, :n]), dtype=float) for n in (terms, *fewer)]
    return [Responses(s[..., 0], s[..., 1], s[..., 2], _rounding(s[..., 0], size)) for s in solutions]


def _rounding(flat: Array, size: float | Array) -> Array:
    return np.asarray(RELATIVE * np.maximum(1.0, flat[:, 0] * size))


def edge_strength(responses: Responses) -> Array:
    """Edge coefficient e of the flat punches, unit disc; 1/pi on a half-space; shape (n,)."""
    return np.asarray(1 / np.pi + responses.edge[:, 0])
