"""Punch matrices under a graded surface, where L - 1 = c/kappa + ... decays slowly.

B_pq = 2 int_0^inf (L - 1) j_p j_q dx, L at kappa = x/beta, is split at an X above all orders p, q. Below X it is the
quadrature of `wavenumbers`. Above X, with the spherical Hankel functions h = j + i y,

    j_p j_q = (1/2) (j_p j_q + y_p y_q) + (1/2) Re h_p h_q.

The first part does not oscillate: panels that double in length, up to where nothing is left. The second turns into
x = X + i t, where it decays like exp(-2 t) and L is its own series slightly off the real axis. No expansion of L - 1 is
needed, all nodes are in x and serve every radius.

Edge strengths from the matrix alone, S[c] = sum (-1)^n c_n, converge like N^-2 only. But for displacements f, g of one
harmonic, with c_f = A^-1 b[f] and f(a rho) on the disc of radius a,

    pi S[c_f] S[c_g] = d/da (a b[g].c_f) = b[g].c_f + b[g].A^-1 b[r f'] + b[r g'].c_f - c_g.B' c_f,      B' = dB/dln beta

(Krein's identity for f = g = 1), and its right side converges like the stiffness does. On the half-space alone the same
identity says how b changes with the radius,

    b_l[r f'] = pi s_l S0[f] - (q + 1) b_l - sum_(i<l) (2 q_i + 1) s_l s_i b_i,      q = m + 2 l,  s_l = (-1)^l,

and with g = r^m, b[g] ~ (1, 0, 0, ...), c_g = A^-1 b[g] the edge functional S[A^-1 b] = S0[b] + b.v follows:

    pi S[c_g] v_l = (m - q) c_g,l - (2 q + 1) s_l (S[c_g] - sum_(i<=l) s_i c_g,i) - (A^-1 B' c_g)_l.

Its derivative by ln beta gives the functional of d'(a) for m = 0: -a dS[f]/da = t0[f] + b.u,

    u_l = (q + 1) v_l - (2 q + 1) s_l sum_(i<=l) s_i v_i - dv_l/dln beta.

The edge strengths S_m of the displacements r^m cos(m phi) also hold what k_m of the perturbation theory needs: on every medium

    d ln S_m/dln beta = pi (s.v_m - s.v_(m+1)),

and while each s.v_m grows without bound under a graded surface, the left side converges like the stiffness.

multiples of S do not change d'(a), and the one added here, pi z (v + s/D) with z the sum of all s_i v_i, makes u_l small at
the end of the series, so that profiles with slow moments (cones) converge.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import ROUNDING, Array
from flatpunch._support.threads import in_threads
from flatpunch.compliances import Kernel
from flatpunch.compliances.interpolant import SmoothResponse
from flatpunch.numerics.chebyshev import Numbers
from flatpunch.punch.basis import excess, half_space_diagonal, inverse_factors, round_functionals
from flatpunch.punch.wavenumbers import above_orders, bessel_table, composite_gauss, far_edges, panel_edges

ComplexArray = NDArray[np.complexfloating]


def graded_terms(kernel: Kernel, beta: float) -> int:
    """Terms for stiffness and edge strength at 1e-10 (1e-8 where the radius is 1000 times the surface's own length E/E')."""
    assert kernel.series is not None
    level = np.log10(max(beta * kernel.series.sharpness, ROUNDING))
    return int(np.interp(level, [-3, -2, -1, 0, 1, 2, 3, 4], [10, 14, 24, 40, 64, 112, 192, 256]))


@dataclass(frozen=True, slots=True)
class Table:
    """Nodes over all x for one parity; `terms` orders.

    Attributes
    ----------
    x, w : ndarray, shape (n,)
        Real nodes and weights; those above X twice, once for each kind of Bessel function.
    f : ndarray, shape (terms, n)
        Spherical Bessel functions: j below X, j and y above.
    z : ndarray, shape (k,)
        Nodes X + i t.
    h : ndarray, shape (terms, k)
        Hankel functions there, times the root of i dt.
    """

    x: Array
    w: Array
    f: Array
    z: ComplexArray
    h: ComplexArray


@byte_cached
def split_point(parity: int, terms: int) -> float:
    """X: a panel edge above the highest order, where the Hankel functions have left their turning point."""
    return float(panel_edges(0, above_orders(parity, terms))[-1])


@byte_cached
def wave_table(parity: int, terms: int, first: int) -> Table:
    """Nodes and functions; the lowest panel ends at 4^first, see `wavenumbers`."""
    start = split_point(parity, terms)
    near = bessel_table(parity, terms, first, start)
    # end of the panels above X in units of X: the integrand falls like 1/x^3, what is left out is 1e-14 of the tail
    x, w = composite_gauss(far_edges(start, parity + 2 * terms, 1e7 * start, 3.0))
    # at the lowest X the highest order still decays like exp(-1.5 t)
    t, v = composite_gauss(np.array([0.0, 2.0, 6.0, 14.0, 30.0]))
    z = start + 1j * t
    far = _hankel(parity + 2 * terms, x + 0j)[parity::2][:terms]
    turned = _hankel(parity + 2 * terms, z)[parity::2][:terms]
    return Table(
        x=np.concatenate([near.x, x, x]),
        # 2 (L - 1) dx below X, the half of it above
        w=np.concatenate([2 * near.w, w, w]),
        f=np.concatenate([near.j, far.real, far.imag], axis=1),
        z=z,
        h=np.asarray(turned * np.sqrt(1j * v)),
    )


def _hankel(orders: int, z: ComplexArray) -> ComplexArray:
    """Spherical Hankel functions of the first kind, orders below |z|: upward recurrence is stable."""
    h = np.empty((max(orders, 2), z.size), dtype=complex)
    wave = np.exp(1j * z) / z
    h[0] = -1j * wave
    h[1] = -wave * (1 + 1j / z)
    for n in range(2, orders):
        h[n] = (2 * n - 1) / z * h[n - 1] - h[n - 2]
    return h[:orders]


def graded_matrices(kernel: Kernel, beta: Array, terms: int, parity: int = 0, order: int = 0) -> Array:
    """B and its derivatives by ln beta up to `order`; shape (order + 1, nb, terms, terms)."""
    assert kernel.series is not None
    first = min(0, int(np.floor(np.log(kernel.series.floor * float(beta.min())) / np.log(4))))
    table = wave_table(parity, terms, first)
    split = split_point(parity, terms)
    far = table.x.searchsorted(split)
    count = (table.x.size - far) // 2
    real = _derivatives(kernel.series, table.x[: far + count] / beta[:, None], order)
    real = np.concatenate([real, real[..., far:]], axis=-1) * table.w
    turned = _derivatives(kernel.series, table.z / beta[:, None], order)
    # d/dln beta at fixed x is -d/dln kappa
    real[1::2], turned[1::2] = -real[1::2], -turned[1::2]
    weights, shapes = _independent(real)
    blocks = _combined(weights, shapes, table.f, lambda shape: table.f * shape)
    # on few nodes: Re h_p h_q g over the nodes z, of real and imaginary parts side by side
    n = table.z.size
    weights, shapes = _independent(np.concatenate([turned.real, turned.imag], axis=-1))
    a, b = table.h.real, table.h.imag

    def turned_by(shape: Array) -> Array:
        c, d = shape[:n], shape[n:]
        return np.concatenate([a * c - b * d, -a * d - b * c], axis=1)

    blocks += _combined(weights, shapes, np.concatenate([a, b], axis=1), turned_by)
    return np.asarray(blocks.reshape(order + 1, beta.size, terms, terms))


def _combined(weights: Array, shapes: Array, functions: Array, weighted: Callable[[Array], Array]) -> Array:
    """Sums of weights, (nb, k), over the products weighted(shape) @ functions.T of k shapes; shape (nb, terms, terms)."""
    terms, nodes = functions.shape
    products = np.empty((len(shapes), terms, terms))

    def fill(i: int) -> None:
        np.matmul(weighted(shapes[i]), functions.T, out=products[i])

    in_threads(fill, len(shapes), operations=2.0 * len(shapes) * terms**2 * nodes)
    return np.asarray(np.tensordot(weights, products, axes=1))


def _derivatives(series: SmoothResponse, kappa: Array | ComplexArray, order: int) -> Numbers:
    """L - 1 and derivatives by ln kappa at kappa, shape (nb, n) -> (order + 1, nb, n)."""
    return np.asarray(series.derivatives(kappa.ravel(), order).reshape(order + 1, *kappa.shape))


def _independent(values: Array) -> tuple[Array, Array]:
    """The few shapes, (k, n), of which values (orders, nb, n) consist to rounding, and weights, (orders * nb, k)."""
    count = np.maximum(np.abs(values).max(axis=(0, 1)), np.finfo(float).tiny)
    # series of 24 terms lose two digits with each derivative
    trust = np.array([1.0, 1e-2, 1e-4])[: values.shape[0], None, None]
    left, strength, shapes = np.linalg.svd((values * trust / count).reshape(-1, count.size), full_matrices=False)
    # smaller singular values are rounding: those of the functions themselves end at 25 of them
    kept = max(1, int(np.count_nonzero(strength > 100 * np.finfo(float).eps * strength[0])))
    return left[:, :kept] * strength[:kept] / np.repeat(trust.ravel(), values.shape[1])[:, None], shapes[:kept] * count


def graded_harmonics(kernel: Kernel, beta: Array, orders: list[int]) -> tuple[dict[int, Array], dict[int, Array]]:
    """Edge functionals of harmonics m > 0 at punch radii beta, shape (nb,), and the growth of their edges with the radius.

    The first maps m to v with S[A_m^-1 b] = S0[b] + b.v, shape (nb, terms); high orders, above 128 at most, are left to the
    half-space. The second maps all m up to the largest to pi (s.v_m - s.v_1), shape (nb,): minus the sum of d ln S_j/d ln beta
    over j = 1 ... m - 1, where S_j is the edge strength for the displacement r^j cos(j phi).
    """
    assert kernel.series is not None
    terms = graded_terms(kernel, float(beta.max()))
    felt = float(beta.max()) * kernel.series.sharpness
    # on higher harmonics the half-space of the surface material acts, but for tail beta/m of their (small) share. Small contacts
    # need fewer: the share of a kinked outline's harmonics beyond m is m^-3, so that m^4 may fall with beta
    largest = min(max(orders, default=1), int(128 * np.clip(felt, 1e-3, 1.0) ** (1 / 4)))
    size = terms + largest // 2 + 1
    systems = [_All(parity, graded_matrices(kernel, beta, size, parity, order=2)) for parity in (0, 1)]
    vectors, sums = {}, {1: np.zeros(beta.size)}
    for m in range(1, largest + 1):
        # sums[m + 1] is known one order ahead
        sums[m + 1] = sums[m] - systems[m % 2].growth[:, m // 2]
        if m in orders:
            vectors[m] = systems[m % 2].edge(m)
    return vectors, sums


def fade(terms: int) -> Array:
    """Weights of an edge functional's terms that end its sums smoothly over their second half, shape (terms,).

    b.v is a sum of smooth terms with alternating signs, which for cones (b_l ~ l^-2.5) and blunter kinks is cut off with half of
    its next term: up to 6e-5 of the depth under a cone at beta = 10 ... 100 on a surface 1e4 times stiffer than its base. Ended
    smoothly, 1e-8 is left there and 1e-10 where the surface is no stiffer.
    """
    x = np.clip(2 * (np.arange(terms) + 0.5) / terms - 1, 0, 1)
    return np.asarray(scipy.special.betainc(4, 4, 1 - x))


class _All:
    """All harmonics m of one parity at nb radii, row i for m = parity + 2 i.

    Kept of each: c = A^-1 (1, 0, ...), w = A^-1 B' c = -dc/dln beta, the edge strength S[c] and its growth with ln beta.

    The matrices are trailing blocks of one, and turned end to end leading blocks with one Cholesky factor. Its inverse J is
    lower triangular: row n of J, times the diagonal element, is c of the block that ends there, and J itself cut off at n
    solves that block. So vectors of all harmonics are rows of triangular matrices, and products of matrices serve all.
    """

    def __init__(self, parity: int, blocks: Array) -> None:
        terms = blocks.shape[-1]
        self.parity, self.terms = parity, terms
        inverse = _inverse_factor(parity, blocks[0])
        first, second = blocks[1, :, ::-1, ::-1], blocks[2, :, ::-1, ::-1]
        orders = (parity + 2 * np.arange(terms))[::-1]
        peak = np.diagonal(inverse, axis1=1, axis2=2)
        self._c = inverse * peak[:, :, None]
        first_c = np.tril(self._c @ first)
        self._w = np.tril(first_c @ inverse.transpose(0, 2, 1)) @ inverse
        square = (1 + 2 * orders) * peak**2 - np.sum(self._c * first_c, axis=-1)
        change = -(1 + 2 * orders) * np.diagonal(self._w, axis1=1, axis2=2)
        change = change + 2 * np.sum(self._w * first_c, axis=-1) - np.sum(self._c * (self._c @ second), axis=-1)
        self._strength = np.sqrt(square / np.pi)
        self.growth = (change / (2 * square))[:, ::-1]

    def edge(self, m: int) -> Array:
        """The vector v of harmonic m, shape (nb, terms of it)."""
        row = self.terms - 1 - (m - self.parity) // 2
        c, w = self._c[:, row, row::-1], self._w[:, row, row::-1]
        strength = self._strength[:, row, None]
        return np.asarray((excess(m, c, strength) - w) / (np.pi * strength)) * fade(c.shape[1])


def graded_round(kernel: Kernel, beta: Array, terms: int) -> tuple[Array, Array, Array]:
    """Flat punch c*, edge functional and slope functional of harmonic 0, as of `matrix.Responses`; (nb, terms) each."""
    blocks = graded_matrices(kernel, beta, terms, order=2)
    inverse = _inverse_factor(0, blocks[0])
    c = _solve(inverse, np.broadcast_to(np.eye(1, terms), (beta.size, terms)))
    # A c = (1, 0, 0, ...) at every radius: A c' = -B' c and A c'' = -B'' c - 2 B' c'
    change = -_solve(inverse, _times(blocks[1], c))
    second = -_solve(inverse, _times(blocks[2], c) + 2 * _times(blocks[1], change))
    edge, slope = round_functionals(c, change, second)
    faded = fade(terms)
    return c, edge * faded, slope * faded


def _solve(inverse: Array, right: Array) -> Array:
    """A^-1 times vectors (nb, terms), from the inverse Cholesky factor of A turned end to end."""
    half = _times(inverse, right[:, ::-1])
    return np.asarray(np.matmul(half[:, None, :], inverse)[:, 0, ::-1])


def _inverse_factor(parity: int, block: Array) -> Array:
    """Inverse Cholesky factor of D + B turned end to end: its leading blocks serve all harmonics of one parity."""
    matrix = block + np.diag(half_space_diagonal(parity, block.shape[-1]))
    return inverse_factors(matrix[:, ::-1, ::-1])


def _times(matrices: Array, vectors: Array) -> Array:
    return np.asarray(np.matmul(matrices, vectors[:, :, None])[:, :, 0])
