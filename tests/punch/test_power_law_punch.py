"""Closed forms of power-law half-spaces against the table, against quadrature, and against exact elliptic contacts."""

import csv
from pathlib import Path

import numpy as np
import pytest

from flatpunch.compliances import compliance
from flatpunch.compliances.power_law import power_law_constant, stiffness_factor
from flatpunch.contact.round.profile import SampledProfile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.media import GradedLayer, HalfSpace, Medium, PowerLawHalfSpace, PowerModulus
from flatpunch.punch import basis, flat_punch
from flatpunch.punch.power_law import power_law_punch

DATA = Path(__file__).parents[1] / "data"
EXPONENTS = [-0.3, 0.0, 0.5, 0.9, 1.0]


def body(k):
    return PowerLawHalfSpace(2.0, 3.0, k, 0.5 if k == 1 else 0.2)


def test_constants_of_the_reference_table():
    with open(DATA / "power_law_half_space.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert len(rows) > 15
    for row in rows:
        k, nu = float(row["k"]), float(row["nu"])
        # twelve digits are printed of the formula, nine good ones of the numerical constant
        assert stiffness_factor(k, nu) == pytest.approx(float(row["hN_formula"]), rel=1e-11)
        assert 2 * (1 - nu**2) * power_law_constant(k, nu) == pytest.approx(float(row["c_numeric"]), rel=3e-9)


def test_gibson_soil_is_a_bed_of_springs():
    # E = 3 G, G = m z, nu = 1/2: the surface sinks by p/(2 m) under the load and nowhere else
    soil = PowerLawHalfSpace(modulus=3.0, depth=1.0, exponent=1.0, poisson=0.5)
    np.testing.assert_allclose(compliance(soil)(np.array([0.1, 1.0, 50.0])), 0.5, rtol=1e-14)
    np.testing.assert_allclose(
        flat_punch(soil, 2.0).pressure(np.array([0.0, 1.0, 1.999, 2.1])), [2, 2, 2, 0], rtol=1e-14
    )
    assert stiffness_factor(1.0, 0.5) == pytest.approx(np.pi / 2, rel=1e-14)
    # continuous: 1 - k = 1e-7 changes it by as much
    assert stiffness_factor(1 - 1e-7, 0.5) == pytest.approx(np.pi / 2, rel=1e-6)


@pytest.mark.parametrize("k", EXPONENTS)
def test_flat_punch_pressure_sums_to_the_stiffness_and_moments(k):
    p, a = power_law_punch(body(k)), 0.7
    rho, weight = p.rule(60)
    scaled = flat_punch(body(k), a).pressure(a * rho) * (1 - rho**2) ** (-p.alpha)
    # Gauss-Jacobi is exact to rounding here
    assert 2 * np.pi * a**2 * scaled @ weight == pytest.approx(p.stiffness(a), rel=1e-12)
    pbar = scaled * np.pi * a / p.modulus
    for n in (1, 2, 4):
        assert (n + 1) * (pbar * rho**n) @ weight == pytest.approx(p.moment(n, a), rel=1e-12)


def test_exponent_zero_is_the_homogeneous_half_space():
    p = power_law_punch(PowerLawHalfSpace(2.0, 3.0, 0.0, 0.3))
    plain = flat_punch(HalfSpace(2.0, 0.3), 0.7)
    assert p.stiffness(0.7) == pytest.approx(plain.stiffness, rel=1e-14)
    assert p.moment(2, 0.7) == pytest.approx(plain.moment(2), rel=1e-13)
    # S of r^n cos(m phi), times n R_m over that of m = 0
    for m in (0, 2):
        share = basis.power_edge(1.5, m) / basis.power_edge(1.5, 0)
        assert 1.5 * p.outline_response(1.5, m) == pytest.approx(share, rel=1e-14)
    assert p.outline_response(2, 2) == pytest.approx(2 / 3, rel=1e-14)


@pytest.mark.parametrize("k", EXPONENTS)
def test_round_contact_of_a_mixed_profile(k):
    p, a = power_law_punch(body(k)), np.array([0.3, 0.8])
    profile = SampledProfile(lambda r: 0.2 * r + 0.05 * r**2, lambda r: 0.2 + 0.1 * r)
    contact = round_contact(compliance(body(k)), profile, a)
    parts = [0.2 * a * p.power_depth(1), 0.05 * a**2 * p.power_depth(2)]
    np.testing.assert_allclose(contact.depth, parts[0] + parts[1], rtol=1e-12)
    expected = p.stiffness(a) * (parts[0] * p.power_force(1) + parts[1] * p.power_force(2))
    np.testing.assert_allclose(contact.force, expected, rtol=1e-12)
    # the paraboloid of the literature, d = a^2/(R (1 + k)), f = r^2/(2 R)
    assert 0.5 * p.power_depth(2) == pytest.approx(1 / (1 + k), rel=1e-14)


@pytest.mark.parametrize("k", EXPONENTS)
def test_outline_under_an_elliptic_paraboloid(k):
    # exact: p ~ (1 - x^2/a^2 - y^2/b^2)^((1+k)/2); curvatures ~ int cos^2 (a^2 cos^2 + b^2 sin^2)^(-(3+k)/2) dphi
    phi = np.arange(400) * np.pi / 200
    logs = []
    for e in (0.02, 0.04):
        s = (np.exp(2 * e) * np.cos(phi) ** 2 + np.exp(-2 * e) * np.sin(phi) ** 2) ** (-(3 + k) / 2)
        one, two = np.mean(np.cos(phi) ** 2 * s), np.mean(np.sin(phi) ** 2 * s)
        psi = one * np.cos(phi) ** 2 + two * np.sin(phi) ** 2
        outline = -0.5 * np.log(np.exp(-2 * e) * np.cos(phi) ** 2 + np.exp(2 * e) * np.sin(phi) ** 2)
        logs.append(-np.mean(outline * np.cos(2 * phi)) / np.mean(np.log(psi) * np.cos(2 * phi)))
    # odd in e, so the quotient is even: one elimination leaves e^4
    exact = (4 * logs[0] - logs[1]) / 3
    assert power_law_punch(body(k)).outline_response(2, 2) == pytest.approx(exact, rel=1e-5)


def test_kernel_and_medium_give_the_same_closed_forms():
    medium = PowerLawHalfSpace(2.0, 3.0, 0.4, 0.3)
    one, two = power_law_punch(medium), power_law_punch(compliance(medium))
    assert one.stiffness(0.7) == pytest.approx(two.stiffness(0.7), rel=1e-14)
    k = np.array([0.2, 5.0])
    # scaling: C ~ k^(exponent - 1)
    ratio = compliance(medium)(k)
    assert ratio[0] / ratio[1] == pytest.approx((0.2 / 5.0) ** (0.4 - 1), rel=1e-13)


@pytest.mark.long
def test_a_thick_graded_layer_approaches_it():
    # E = E_l (z + s)^k with a small shift s, and a base far below
    k, nu = 0.5, 0.3
    exact = power_law_punch(PowerLawHalfSpace(1.0, 1.0, k, nu)).stiffness(1.0)
    errors = []
    for shift in (1e-3, 1e-4):
        layer = GradedLayer(lambda z, s=shift: (z + s) ** k, nu, 1000.0)
        errors.append(flat_punch(Medium([layer], HalfSpace(1000.0**k, nu)), 1.0).stiffness / exact - 1)
    # the compliance lost, z^-k - (z + s)^-k, integrates to s^(1-k)
    assert errors[0] / errors[1] == pytest.approx(10 ** (1 - k), rel=0.05)
    assert 0 < errors[1] < 0.03


def test_its_own_law_needs_a_positive_modulus():
    with pytest.raises(ValueError, match="top"):
        PowerModulus(0.0, 1.0, 1.0, 0.5)


def test_exponent_zero_has_the_kernel_of_the_homogeneous_half_space():
    one, plain = PowerLawHalfSpace(2.0, 3.0, 0.0, 0.3), HalfSpace(2.0, 0.3)
    assert flat_punch(one, 0.7).stiffness == flat_punch(plain, 0.7).stiffness
    np.testing.assert_array_equal(compliance(one)(np.array([0.1, 5.0])), compliance(plain)(np.array([0.1, 5.0])))
