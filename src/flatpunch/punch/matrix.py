"""The punch matrix A of each harmonic, and its answers, for a batch of punch radii (design 2.2).

A_ln = pi/(2(m + 2n) + 1) delta_ln + B_pq with p = m + 2l, q = m + 2n and B_pq = 2 int_0^inf (L - 1) j_p j_q dx, L taken at
k l = x/beta. The matrices of all harmonics of one parity are trailing blocks of one B.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import sici

from flatpunch._validation import Array
from flatpunch.compliance import Kernel
from flatpunch.punch.basis import edge_signs, edge_slopes, half_space_diagonal
from flatpunch.punch.wavenumbers import BesselTable, bessel_table, composite_gauss, panel_edges, spherical_bessel

LARGEST = 300.0
"""Largest effective beta, cutoff beta/25: beyond it tables take hundreds of megabytes and seconds."""

_TAIL_FROM = 4.0


def effective_beta(kernel: Kernel, beta: float) -> float:
    """Radius over the shortest length of the medium: what sets the number of terms and wavenumbers."""
    return beta * kernel.cutoff / 25.0


def sufficient_terms(kernel: Kernel, beta: float) -> int:
    """Number of terms for edge and pressure at 1e-10 (design 2.2, measured over stacks of modulus ratio 1e-4 .. 1e4)."""
    if kernel.tail != 0.0:
        return int(np.interp(np.log10(max(beta, 1e-12)), [-2, 0, 1, 2], [24, 40, 64, 140]))
    level = np.log10(max(effective_beta(kernel, beta), 1e-12))
    return int(np.ceil(np.interp(level, [-4, -2, -1, 0, 1, 1.5, 2, 2.5], [4, 5, 7, 13, 44, 76, 134, 300])))


def kernel_matrix(kernel: Kernel, beta: Array, terms: int, parity: int = 0) -> Array:
    """B_pq for p, q = parity, parity + 2, ...

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium, with a finite length of its own.
    beta : ndarray, shape (nb,)
        Punch radii in units of that length, > 0.
    terms : int
        Size of the matrix.
    parity : int
        0 or 1.

    Returns
    -------
    ndarray, shape (nb, terms, terms)
    """
    table, weights = _weighted(kernel, beta, terms, parity)
    blocks = np.empty((beta.size, terms, terms))
    for i, weight in enumerate(weights):
        used = int(np.searchsorted(table.x, kernel.cutoff * beta[i]))
        j = table.j[:, :used]
        np.matmul(j * weight[:used], j.T, out=blocks[i])
    if kernel.tail != 0.0:
        blocks += 2 * kernel.tail * beta[:, None, None] * tail_matrix(parity, terms)
    return blocks


def _weighted(kernel: Kernel, beta: Array, terms: int, parity: int) -> tuple[BesselTable, Array]:
    """Nodes x with the Bessel functions, and 2 (L - 1) dx on them without its tail, shape (nb, nodes)."""
    low, high = float(beta.min()), float(beta.max())
    first = min(0, int(np.floor(np.log(kernel.floor * low) / np.log(4))))
    table = bessel_table(parity, terms, first, _x_high(kernel, high))
    kappa = table.x / beta[:, None]
    remainder = np.zeros_like(kappa)
    tailed = table.x > _TAIL_FROM
    live = kappa < kernel.cutoff
    remainder[live] = kernel.remainder(kappa[live])
    if kernel.tail != 0.0:
        remainder = np.where(tailed & live, remainder - kernel.tail / kappa, remainder)
    return table, 2 * remainder * table.w


def edge_columns(kernel: Kernel, beta: Array, terms: int) -> tuple[Array, Array]:
    """B D^-1 s and B D^-1 t of harmonic 0 without truncating the sums over n; shape (nb, terms) each.

    sum_n (4n + 1) (-1)^n j_2n(x) P_2n(t) = cos(xt), so sum_n s_n/D_n j_2n = cos(x)/pi and, with P'_2n(1) = n (2n + 1),
    sum_n t_n/D_n j_2n = x sin(x)/pi. Summed up to the size of the matrix instead, what is slow in n (cones on films that
    are thin against the punch) is lost: 1e-3 of the depth at beta = 100 under a film 1e4 times stiffer than its base.
    """
    table, weights = _weighted(kernel, beta, terms, 0)
    value = (weights * np.cos(table.x)) @ table.j.T / np.pi
    if kernel.tail != 0.0:
        value += 2 * kernel.tail * beta[:, None] * tail_column(terms)
        # the functional t of a surface whose modulus varies has no limit in n; it is taken on the matrix as it is
        return value, kernel_matrix(kernel, beta, terms) @ (edge_slopes(terms) / half_space_diagonal(0, terms))
    return value, (weights * table.x * np.sin(table.x)) @ table.j.T / np.pi


@lru_cache(maxsize=32)
def tail_column(terms: int) -> Array:
    """(1/pi) int_4^inf j_2n(x) cos(x) dx/x: over the whole axis (-1)^n/(2n (2n + 1)) for n >= 1 (DLMF 10.22.57)."""
    p = 2.0 * np.arange(terms)
    x, w = composite_gauss(panel_edges(-20, _TAIL_FROM))
    j = spherical_bessel(int(p[-1]) + 1, x)[::2]
    whole = np.zeros(terms)
    whole[1:] = edge_signs(terms)[1:] / (p[1:] * (p[1:] + 1))
    result = whole - j @ (w * np.cos(x) / x)
    x0 = _TAIL_FROM
    # int_x0^inf sin(x) cos(x)/x^2 dx by parts
    result[0] = np.sin(2 * x0) / (2 * x0) - sici(2 * x0)[1]
    return np.asarray(result / np.pi)


def _x_high(kernel: Kernel, beta: float) -> float:
    """Upper end of the integral over x, on few levels so that tables are shared between radii."""
    needed = kernel.cutoff * beta
    levels = 4.0 * 2.0 ** np.arange(0, 60)
    return float(levels[np.searchsorted(levels, needed)]) if needed > 4 else 4.0


@lru_cache(maxsize=32)
def tail_matrix(parity: int, terms: int) -> Array:
    """int_4^inf j_p j_q dx/x for p, q = parity, parity + 2, ...: what a graded surface adds per tail constant.

    The whole integral is the critical case of Weber and Schafheitlin (DLMF 10.22.57); the part below x = 4 is taken off
    by quadrature. For p = q = 0 the integral from 4 itself is elementary.
    """
    p = parity + 2.0 * np.arange(terms)
    mu, nu = p[:, None] + 0.5, p[None, :] + 0.5
    mu_safe = np.where(mu + nu > 1, mu, 1.0)
    with np.errstate(divide="ignore"):
        ratio = np.exp(_log_gamma((mu_safe + nu - 1) / 2) - _log_gamma((mu_safe + nu + 3) / 2))
    # 1/(gamma(3/2 - h) gamma(3/2 + h)) at the integer h = (mu - nu)/2, by reflection
    half = np.round((mu - nu) / 2)
    signs = np.where(half % 2 == 0, 1.0, -1.0) / (np.pi * (0.25 - half**2))
    whole = np.pi / 2 * ratio / 4 * signs
    x, w = composite_gauss(panel_edges(-20, _TAIL_FROM))
    j = spherical_bessel(int(p[-1]) + 1, x)[parity::2]
    result = whole - (j * (w / x)) @ j.T
    if parity == 0:
        x0 = _TAIL_FROM
        # int_x0^inf sin(x)^2/x^3 dx by parts
        result[0, 0] = np.sin(x0) ** 2 / (2 * x0**2) + np.sin(2 * x0) / (2 * x0) - sici(2 * x0)[1]
    return np.asarray(result)


def _log_gamma(x: Array) -> Array:
    from scipy.special import gammaln

    return np.asarray(gammaln(x))


@dataclass(frozen=True, slots=True)
class Answers:
    """What the matrices of a batch of radii say; unit disc, modulus 1; shapes (nb, terms).

    Attributes
    ----------
    flat : ndarray
        c* = A_0^-1 b[1], the flat punch.
    edge : ndarray
        A_m^-1 s - D_m^-1 s: S[A_m^-1 b] = S0[b] + b.edge. (For m = 0 edge strength e of the punch: 1/pi + edge_0.)
    slope : ndarray
        A_0^-1 t - D_0^-1 t, the same for the functional t of d'(a); only for m = 0.
    """

    flat: Array
    edge: Array
    slope: Array


def solve_round(kernel: Kernel, beta: Array, terms: int) -> Answers:
    """Flat punch and edge functionals of harmonic 0 at radii beta, shape (nb,)."""
    block = kernel_matrix(kernel, beta, terms)
    diagonal = half_space_diagonal(0, terms)
    matrix = block.copy()
    matrix[:, range(terms), range(terms)] += diagonal
    value, slope = edge_columns(kernel, beta, terms)
    first = np.zeros(terms)
    first[0] = 1.0
    right = np.stack([np.broadcast_to(first, (beta.size, terms)), -value, -slope], axis=-1)
    solution: Array = np.asarray(np.linalg.solve(matrix, right), dtype=float)
    return Answers(solution[..., 0], solution[..., 1], solution[..., 2])
