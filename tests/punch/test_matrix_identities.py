"""Identities, limits and convergence of the punch matrix, and a second road to the same numbers."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flatpunch.compliances import Kernel, compliance
from flatpunch.compliances.interpolant import interpolate
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase
from flatpunch.punch.basis import (
    edge_signs,
    half_space_diagonal,
    normalisation,
    power_edge,
    power_moments,
    projection,
    regular_part,
)
from flatpunch.punch.matrix import solve_round, sufficient_terms
from flatpunch.reference import layers as closed
from support.punch_matrices import kernel_matrix

DATA = Path(__file__).parents[1] / "data"
MEDIA = {
    "bonded incompressible": Medium([Layer(1.0, 0.5, 1.0)], RigidBase()),
    "bonded": Medium([Layer(1.0, 0.3, 1.0)], RigidBase()),
    "sliding": Medium([Layer(1.0, 0.3, 1.0, bonded=False)], RigidBase()),
    "stiff film": Medium([Layer(1.0, 0.3, 1.0)], HalfSpace(0.01, 0.3)),
    "very stiff film": Medium([Layer(1.0, 0.3, 1.0)], HalfSpace(1e-4, 0.3)),
    "soft film": Medium([Layer(1.0, 0.45, 1.0)], HalfSpace(1e4, 0.2)),
    "three layers": Medium(
        [Layer(1.0, 0.3, 1.0), Layer(0.1, 0.5, 0.5, bonded=False), Layer(20.0, 0.2, 3.0)], HalfSpace(0.5, 0.4)
    ),
}
by_medium = pytest.mark.parametrize("medium", MEDIA.values(), ids=MEDIA.keys())


def stiffness(medium, beta, terms=None):
    """Kbar and the edge coefficient times pi of each beta."""
    kernel = compliance(medium)
    beta = np.atleast_1d(beta)
    responses = solve_round(kernel, beta, terms or sufficient_terms(kernel, float(beta.max())))
    return np.pi * responses.flat[:, 0], 1 + np.pi * responses.edge[:, 0]


@by_medium
@pytest.mark.parametrize("beta", [1e-3, 0.1, 1.0, 10.0, 60.0])
def test_krein(medium, beta):
    # d(beta Kbar)/d beta = (pi e)^2; differences of order 4 with step 1 % leave 0.01^4/30 of the fifth
    # derivative
    step = 0.01 * beta
    kbar, edge = stiffness(medium, beta + step * np.array([-2, -1, 0, 1, 2]))
    product = kbar * (beta + step * np.array([-2, -1, 0, 1, 2]))
    derivative = (product[0] - 8 * product[1] + 8 * product[3] - product[4]) / (12 * step)
    assert derivative == pytest.approx(edge[2] ** 2, rel=1e-7)


@by_medium
@pytest.mark.parametrize(("beta", "rtol"), [(1e-4, 1e-11), (0.03, 1e-11), (1.0, 1e-11), (30.0, 1e-10), (100.0, 1e-8)])
def test_sufficient_terms_are_sufficient(medium, beta, rtol):
    # the accuracies promised for beta <= 30 and <= 100; half as many terms again is taken for exact
    kernel = compliance(medium)
    terms = sufficient_terms(kernel, beta)
    kbar, edge = stiffness(medium, beta)
    better, better_edge = stiffness(medium, beta, terms + terms // 2 + 4)
    np.testing.assert_allclose(kbar, better, rtol=rtol)
    # the edge coefficient converges later: 1e-9 where Kbar has 1e-11 (and enters dK/da, not K)
    np.testing.assert_allclose(edge, better_edge, rtol=100 * rtol)


def test_convergence_is_exponential_in_the_number_of_terms():
    medium = MEDIA["bonded"]
    exact, _ = stiffness(medium, 3.0, 40)
    error = np.array([abs(stiffness(medium, 3.0, n)[0][0] / exact[0] - 1) for n in (2, 4, 6, 8)])
    # L is analytic around the real axis, so each further pair of terms gains at least the same factor: here
    # more than 30
    assert (error[:-1] / error[1:] > 30).all()


@by_medium
@pytest.mark.parametrize("beta", [1.0, 10.0, 30.0, 100.0])
def test_cones_need_no_more_terms_than_punches(medium, beta):
    # d and F of f = r with the terms that suffice for the punch, and with two thirds more
    few = cone(medium, beta, sufficient_terms(compliance(medium), beta))
    many = cone(medium, beta, 5 * sufficient_terms(compliance(medium), beta) // 3 + 8)
    # 1e-12: 1.3e-13 measured, rounding under a film 1e4 times stiffer than its base
    np.testing.assert_allclose(few, many, rtol=1e-12)


def cone(medium, beta, terms):
    responses = solve_round(compliance(medium), np.array([beta]), terms)
    b = power_moments(1.0, 0, terms)
    depth = (power_edge(1.0, 0) + b @ responses.edge[0]) / (1 / np.pi + responses.edge[0, 0])
    return depth, np.pi * (depth * responses.flat[0, 0] - b @ responses.flat[0])


def test_edge_of_a_graded_surface_converges_with_the_sixth_power_of_the_terms():
    # L - 1 = c tanh^2(kappa)/kappa has the tail c/kappa of a modulus that varies at the surface
    series = interpolate(lambda x: 1 - 0.7 * np.tanh(x) ** 2 / x, 0.1, 0, vanishing=False)
    kernel = Kernel(1.0, 1.0, series, tail=series.tail, floor=series.floor, series=series)
    assert series.tail == pytest.approx(-0.7, rel=1e-10)
    edge = [1 + np.pi * solve_round(kernel, np.array([1.0]), n).edge[0, 0] for n in (8, 16, 32, 128)]
    error = np.abs(np.array(edge[:3]) - edge[3])
    # c_n falls like n^-3, a quadratic form in it like n^-6; the plain sum of the coefficients converges like n^-2 only
    assert np.log2(error[:-1] / error[1:]) == pytest.approx([6, 6], abs=0.3)
    # Krein: the square is d(beta Kbar)/d beta; differences of order 4 and step 2e-3 leave 1e-11
    beta = 1 + 2e-3 * np.array([-2, -1, 1, 2])
    product = beta * np.pi * solve_round(kernel, beta, 64).flat[:, 0]
    derivative = (product[0] - 8 * product[1] + 8 * product[2] - product[3]) / (12 * 2e-3)
    assert edge[3] ** 2 == pytest.approx(derivative, rel=1e-9)


@given(st.sampled_from(list(MEDIA)), st.floats(-2, 1), st.integers(-40, 40), st.integers(-40, 40))
@settings(max_examples=30, derandomize=True, deadline=None)
def test_only_beta_matters(name, log_beta, length, modulus):
    # powers of two scale without rounding
    medium = MEDIA[name]
    layers = [Layer(p.young * 2.0**modulus, p.poisson, p.thickness * 2.0**length, p.bonded) for p in medium.layers]
    base = medium.base
    if isinstance(base, HalfSpace):
        base = HalfSpace(base.young * 2.0**modulus, base.poisson)
    beta = 10**log_beta
    np.testing.assert_array_equal(stiffness(Medium(layers, base), beta), stiffness(medium, beta))


@by_medium
def test_reciprocity_of_punch_and_profiles(medium):
    # b[f].A^-1 b[g] = b[g].A^-1 b[f], and the matrix itself is symmetric
    block = kernel_matrix(compliance(medium), np.array([2.0]), 24)[0]
    np.testing.assert_allclose(block, block.T, rtol=0, atol=1e-15 * np.abs(block).max())


@by_medium
def test_matrix_is_positive(medium):
    for parity in (0, 1):
        block = kernel_matrix(compliance(medium), np.array([3.0]), 20, parity)[0]
        assert np.linalg.eigvalsh(block + np.diag(half_space_diagonal(parity, 20)))[0] > 0


def test_thick_layer_series():
    with open(DATA / "layer_asymptotics.json", encoding="utf-8") as file:
        moments = json.load(file)["moments_N0_N2_N4"]
    beta = np.array([1e-4, 1e-3, 1e-2])
    for name, (n0, n2, _) in moments.items():
        layer = Layer(1.0, float(name.removeprefix("bonded_nu")) if "nu" in name else 0.2, 1.0, "nu" in name)
        kbar, _ = stiffness(Medium([layer], RigidBase()), beta)
        series = closed.thick_layer_stiffness(beta, float(n0), float(n2))
        # the next term is of order beta^4, with a coefficient below 3
        assert (np.abs(kbar - series) < 3 * beta**4 + 1e-13).all(), name


def test_thin_layers():
    # the edge adds a strip of width h: relative corrections of order 1/beta with factors of order one
    for poisson, bonded in ((0.3, True), (0.0, True), (0.3, False)):
        beta = np.array([50.0, 100.0])
        kbar, _ = stiffness(Medium([Layer(1.0, poisson, 1.0, bonded)], RigidBase()), beta)
        leading = [closed.thin_flat_punch(b, 1.0, 1.0, poisson, bonded=bonded) for b in beta]
        ratio = kbar * 2 * beta / (1 - poisson**2) / leading
        assert (np.abs(ratio - 1) < 2 / beta).all()
        assert (ratio[0] - 1) / (ratio[1] - 1) == pytest.approx(2, rel=0.1)


@by_medium
@pytest.mark.parametrize("beta", [0.3, 3.0])
def test_second_road_by_nystroem(medium, beta):
    # q(t) + (2/pi) int_0^1 q(s) ds int_0^inf (L - 1) cos(xt) cos(xs) dx = 1 at k h = x/beta, Kbar = int q, pi
    # e = q(1)
    kernel = compliance(medium)
    x, w = log_panels(kernel.floor * 1e-3, kernel.cutoff * beta)
    remainder = w * kernel.remainder(x / beta)
    t, v = np.polynomial.legendre.leggauss(60)
    t, v = (t + 1) / 2, v / 2
    t = np.append(t, 1.0)
    cosine = np.cos(np.outer(t, x))
    weights = np.append(v, 0.0)
    q = np.linalg.solve(np.eye(t.size) + 2 / np.pi * (cosine * remainder) @ cosine.T * weights, np.ones(t.size))
    kbar, edge = stiffness(medium, beta)
    # 1e-10: both roads are exponentially convergent; rounding grows with Kbar and with the contrast of the
    # layers
    assert kbar[0] == pytest.approx(weights @ q, rel=1e-10)
    assert edge[0] == pytest.approx(q[-1], rel=1e-9)


def log_panels(low, high):
    edges = np.concatenate([[0.0], np.geomspace(low, 1.0, 30), np.arange(1.5, high + 1, 0.5)])
    t, v = np.polynomial.legendre.leggauss(20)
    half = np.diff(edges)[:, None] / 2
    return ((edges[1:] + edges[:-1])[:, None] / 2 + half * t).ravel(), (half * v).ravel()


@pytest.mark.parametrize("m", [0, 1, 2, 5])
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0, 4.0])
def test_moments_in_closed_form_equal_quadrature(m, exponent):
    # 400 nodes resolve 30 terms of r^n; the weights alternate, 1e-13 of their size is rounding
    r, matrix = projection(m, 30, 400)
    np.testing.assert_allclose(power_moments(exponent, m, 30), matrix @ r**exponent, rtol=0, atol=2e-13)


def test_half_space_edge_functional_sums_its_slow_series():
    # S0[r^2] = sum (-1)^n b_n/D_n ends after two terms for r^2, which is even and of degree 2
    b = power_moments(2.0, 0, 12)
    assert np.abs(b[2:]).max() < 1e-16
    assert power_edge(2.0, 0) == pytest.approx(np.sum(edge_signs(12) * b / half_space_diagonal(0, 12)), rel=1e-14)


def test_basis_at_the_edge():
    for m in (0, 3):
        np.testing.assert_allclose(regular_part(m, 8, np.array(1.0)), edge_signs(8), rtol=1e-12)
    assert normalisation(3) == pytest.approx([1.0, 0.5, 0.375])
