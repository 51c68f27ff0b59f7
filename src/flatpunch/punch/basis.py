"""Pressures on the unit disc with the edge singularity of a punch, and the functionals that act on them.

For the angular harmonic m (T3.1):

    p_n(r) = r^m P_n^(m,-1/2)(1 - 2 r^2) / (binom(n - 1/2, n) sqrt(1 - r^2)),     Hankel transform j_(m+2n)(k),

with edge coefficient (-1)^n. On a half-space of modulus 1 their matrix is diagonal, D_n = pi/(2(m + 2n) + 1), so what is
slow in n (the singular edge functionals of cones and the like) has closed forms there, collected here; a medium changes
the leading block alone.

Given how it changes with the radius, the flat punch c* determines what the edge does to any displacement (Krein's identity, see
`graded` for the derivation; primes are derivatives by ln beta, q = 2 l, s_l = (-1)^l):

    pi e^2 = c_0 + c_0',        pi e v_l = -q c_l - (2 q + 1) s_l (e - sum_(i<=l) s_i c_i) + c_l',

where e = S[c*] and S[A_0^-1 b] = S0[b] + b.v. The derivative of v gives the functional of d'(a). Sums over the edge signs are
never taken to the end of the series, which under graded surfaces would converge like N^-2 only.
"""

from __future__ import annotations

from math import exp, gamma, lgamma

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.numerics.gauss import gauss


def beta(a: float, b: float) -> float:
    """B(a, b) = Gamma(a) Gamma(b)/Gamma(a + b) for a, b > 0; to a few roundings where Gamma(a + b) does not overflow."""
    try:
        return gamma(a) / gamma(a + b) * gamma(b)
    except OverflowError:
        return exp(lgamma(a) - lgamma(a + b) + lgamma(b))


OUTWARDS = np.sin(np.linspace(0, np.pi / 2, 100))
"""Radii of the unit disc, centre and rim included, at which pressures of punches are judged."""

RELATIVE = 16 * np.finfo(float).eps
"""Rounding of sums over the terms of a punch."""


def half_space_diagonal(m: int, terms: int) -> Array:
    """D_n = pi/(2(m + 2n) + 1), shape (terms,)."""
    return np.asarray(np.pi / (2 * (m + 2 * np.arange(terms)) + 1))


def edge_signs(terms: int) -> Array:
    """Edge coefficients s_n = (-1)^n of the basis; S[c] = s.c is the strength of the edge singularity."""
    return np.where(np.arange(terms) % 2 == 0, 1.0, -1.0)


def normalisation(terms: int) -> Array:
    """binom(n - 1/2, n), shape (terms,)."""
    n = np.arange(1, terms)
    return np.cumprod(np.concatenate([[1.0], (n - 0.5) / n]))


def regular_part(m: int, terms: int, r: Array) -> Array:
    """p_n(r) sqrt(1 - r^2) at 0 <= r <= 1; shape (terms, *r.shape)."""
    r = np.asarray(r, dtype=float)
    x, total = 1 - 2 * r**2, m - 0.5
    p = np.empty((terms, *r.shape))
    p[0] = 1
    if terms > 1:
        p[1] = m + 1 + (total + 2) * (x - 1) / 2
    for n in range(2, terms):
        # three-term recurrence of the Jacobi polynomials (DLMF 18.9.2), stable on -1 <= x <= 1
        c = 2 * n + total
        above = (c - 1) * (c * (c - 2) * x + (m - 0.5) * (m + 0.5)) * p[n - 1] - (n + m - 1) * (2 * n - 3) * c * p[
            n - 2
        ]
        p[n] = above / (2 * n * (n + total) * (c - 2))
    p *= r**m
    p /= normalisation(terms).reshape(-1, *([1] * r.ndim))
    return p


def power_moments(exponent: float, m: int, terms: int) -> Array:
    """b_l[r^n] = int_0^1 r^n p_l r dr in closed form; shape (terms,)."""
    gamma = (exponent - m) / 2
    b = np.empty(terms)
    b[0] = 0.5 * beta((exponent + m) / 2 + 1, 0.5)
    n = np.arange(terms - 1)
    b[1:] = b[0] * np.cumprod((n - gamma) / (n + 1 + gamma + m + 0.5))
    return b


def power_edge(exponent: float, m: int) -> float:
    """S of the half-space pressure for the displacement r^n cos(m phi): 1/B((m + n + 1)/2, 1/2)."""
    return 1 / beta((m + exponent + 1) / 2, 0.5)


@byte_cached
def quarter_nodes(nodes: int) -> tuple[Array, Array]:
    """Radii r = cos(theta) at Gauss-Legendre nodes of theta on (0, pi/2), and the weights in theta; shape (nodes,)."""
    t, v = gauss(nodes)
    return np.cos(np.pi / 4 * (t + 1)), v * np.pi / 4


def node_count(terms: int) -> int:
    """Nodes on a radius for products of smooth functions with so many terms: exact for polynomials, 1e-12 of other functions."""
    return 2 * terms + 48


@byte_cached
def projection(m: int, terms: int, nodes: int) -> tuple[Array, Array]:
    """Radii r, shape (nodes,), and matrix M, shape (terms, nodes), with b_l[f] = M f(r).

    Gauss-Legendre in theta, r = cos(theta): the integrand is smooth for any profile smooth in r, kinked at r = 0 or not.
    """
    r, weight = quarter_nodes(nodes)
    return r, regular_part(m, terms, r) * (r * weight)


def inverse_factors(matrices: Array) -> Array:
    """Inverse Cholesky factors L^-1 of positive definite matrices L L^T, shape (nb, n, n): triangular, in half the time."""
    return _inverse_of_lower(np.asarray(np.linalg.cholesky(matrices), dtype=float))


def _inverse_of_lower(factors: Array) -> Array:
    """Inverse of lower triangular matrices, by halves: [[A, 0], [B, C]]^-1 = [[A^-1, 0], [-C^-1 B A^-1, C^-1]]."""
    size, small = factors.shape[-1], 10
    if size <= small:
        return np.asarray(np.tril(np.linalg.inv(factors)))
    half = size // 2
    upper, lower = _inverse_of_lower(factors[:, :half, :half]), _inverse_of_lower(factors[:, half:, half:])
    inverse = np.zeros_like(factors)
    inverse[:, :half, :half], inverse[:, half:, half:] = upper, lower
    inverse[:, half:, :half] = -lower @ factors[:, half:, :half] @ upper
    return inverse


def round_functionals(c: Array, first: Array, second: Array) -> tuple[Array, Array]:
    """Edge functional v and slope functional u of harmonic 0, shape (nb, terms) each.

    From the flat punch c* on the unit disc at nb radii and its derivatives by ln beta. S[A_0^-1 b] = S0[b] + b.v, and
    -a dS[f]/da = t0[f] + b.u up to a multiple of S, which d'(a) does not feel.
    """
    s = edge_signs(c.shape[1])
    width = 4.0 * np.arange(c.shape[1]) + 1
    strength = np.sqrt((c[:, 0] + first[:, 0]) / np.pi)[:, None]
    growth = (first[:, 0] + second[:, 0])[:, None] / (2 * np.pi * strength**2)
    edge = (excess(0, c, strength) + first) / (np.pi * strength)
    change = (excess(0, first, growth * strength) + second) / (np.pi * strength) - edge * growth
    sums = np.cumsum(s * edge, axis=-1)
    total = sums[:, -1:]
    # the multiple of S added makes the functional small at the end of the series, so that slow moments (cones) converge
    slope = ((width + 1) / 2 + np.pi * total) * edge + width * s * (total - sums) - change
    return edge, slope


def excess(m: int, c: Array, strength: Array) -> Array:
    """(m - q) c_l - (2 q + 1) s_l (S - sum_(i<=l) s_i c_i) for q = m + 2 l; shapes (nb, terms) and (nb, 1)."""
    s = edge_signs(c.shape[-1])
    q = m + 2.0 * np.arange(c.shape[-1])
    return np.asarray((m - q) * c - (2 * q + 1) * s * (strength - np.cumsum(s * c, axis=-1)))
