"""Graded layers in C(k): against constant layers, fine stacks, tables, closed limits; and what the interpolant loses."""

import csv
from pathlib import Path

import numpy as np
import pytest

from flatpunch.compliances import compliance
from flatpunch.compliances.response import layered_response
from flatpunch.media import (
    ExponentialModulus,
    GradedLayer,
    HalfSpace,
    Layer,
    LinearModulus,
    Medium,
    PowerModulus,
    RigidBase,
)

DATA = Path(__file__).parents[1] / "data"
KAPPA = np.geomspace(1e-3, 60, 31)
BASES = {"rigid": RigidBase(), "soft": HalfSpace(1e-3, 0.1), "stiff": HalfSpace(1e3, 0.4)}
LAWS = {
    "linear 5": LinearModulus(1.0, 5.0, 1.0),
    "exponential 0.1": ExponentialModulus(1.0, 0.1, 1.0),
    "linear 1e4": LinearModulus(1.0, 1e4, 1.0),
    "linear 1e-4": LinearModulus(1.0, 1e-4, 1.0),
    "exponential 1e4": ExponentialModulus(1.0, 1e4, 1.0),
    "exponential 1e-4": ExponentialModulus(1.0, 1e-4, 1.0),
}


def test_coatings_of_the_reference_table():
    with open(DATA / "graded_coating_compliance.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    for row in rows:
        law = {"linear": LinearModulus, "exponential": ExponentialModulus}[row["profile"]]
        ratio, nu = float(row["E_ratio"]), float(row["nu"])
        medium = Medium([GradedLayer(law(1.0, ratio, 1.0), nu, 1.0)], HalfSpace(ratio, nu))
        for name, value in row.items():
            if name.startswith("M_kh="):
                # nine digits are printed
                response = compliance(medium).response(np.array([float(name[5:])]))[0]
                assert response == pytest.approx(float(value), abs=6e-10)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("bonded", [True, False])
@pytest.mark.parametrize("base", list(BASES))
def test_a_constant_grading_is_a_layer(nu, bonded, base):
    graded = Medium([Layer(3.0, 0.2, 0.4), GradedLayer(1.0, nu, 1.0, bonded)], BASES[base])
    plain = Medium([Layer(3.0, 0.2, 0.4), Layer(1.0, nu, 1.0, bonded)], BASES[base])
    # TOLERANCE 1e-12 a step; a base 1e3 times softer amplifies what is lost at the lower face tenfold
    np.testing.assert_allclose(layered_response(graded, KAPPA), layered_response(plain, KAPPA), rtol=1e-11)


@pytest.mark.parametrize("law", list(LAWS))
@pytest.mark.parametrize("nu", [0.3, 0.5])
@pytest.mark.parametrize("bonded", [True, False])
def test_a_cut_through_the_grading_changes_nothing(law, nu, bonded):
    young = LAWS[law]
    whole = Medium([GradedLayer(young, nu, 1.0, bonded)], RigidBase())
    upper = GradedLayer(young, nu, 0.37)
    lower = GradedLayer(lambda z: young(z + 0.37), nu, 0.63, bonded)
    np.testing.assert_allclose(
        layered_response(whole, KAPPA), layered_response(Medium([upper, lower], RigidBase()), KAPPA), rtol=2e-11
    )


@pytest.mark.parametrize("law", ["linear 5", "exponential 0.1", "exponential 1e4"])
@pytest.mark.parametrize("base", list(BASES))
def test_stacks_of_constant_layers_converge_to_it_like_n_to_the_minus_two(law, base):
    def poisson(z):
        return 0.2 + 0.3 * z

    medium = Medium([GradedLayer(LAWS[law], poisson, 1.0)], BASES[base])
    kappa = np.array([0.05, 0.5, 2.0, 6.0])
    exact = layered_response(medium, kappa)
    values = []
    for n in (32, 64, 128, 256):
        z = (np.arange(n) + 0.5) / n
        stack = [Layer(e, nu, 1 / n) for e, nu in zip(LAWS[law](z), poisson(z), strict=True)]
        # of n C(k): the stack's own surface modulus is that of its first sublayer
        thin = Medium(stack, BASES[base])
        values.append(layered_response(thin, kappa) * medium.surface_modulus / thin.surface_modulus)
    error = np.abs(np.array(values) / exact - 1)
    # midpoint constants: the error is a series in n^-2
    np.testing.assert_allclose(np.log2(error[2] / error[3]), 2, atol=0.05)
    first = (4 * np.array(values[1:]) - np.array(values[:-1])) / 3
    second = (16 * first[1:] - first[:-1]) / 15
    third = (64 * second[1] - second[0]) / 63
    # what two more eliminations leave at n = 256: (slope/256)^8, slope <= 9.2
    np.testing.assert_allclose(third, exact, rtol=3e-9)


@pytest.mark.long
@pytest.mark.parametrize("law", list(LAWS))
@pytest.mark.parametrize("nu", [0.3, 0.5])
@pytest.mark.parametrize("base", list(BASES))
def test_the_interpolant_is_as_good_as_it_says(law, nu, base):
    medium = Medium([GradedLayer(LAWS[law], nu, 1.0)], BASES[base])
    kernel = compliance(medium)
    kappa = np.geomspace(kernel.floor / 300, kernel.cutoff, 211) * 1.013
    exact = layered_response(medium, kappa)
    # TOLERANCE of the interpolant plus that of the response, relative everywhere
    np.testing.assert_allclose(kernel.response(kappa), exact, rtol=1e-11)
    np.testing.assert_allclose(kernel.remainder(kappa), exact - 1, rtol=0, atol=1e-11 * exact.max())


@pytest.mark.parametrize(
    ("young", "poisson", "slope", "poisson_slope"),
    [
        (LinearModulus(2.0, 5.0, 1.0), 0.3, 1.5, 0.0),
        (ExponentialModulus(1.0, 0.1, 1.0), 0.45, -np.log(10), 0.0),
        (1.0, ([0, 1], [0.2, 0.4]), 0.0, 0.2),
        (lambda z: np.exp(z), lambda z: 0.1 + 0.3 * z, 1.0, 0.3),
    ],
)
def test_tail_from_the_slopes_at_the_surface(young, poisson, slope, poisson_slope):
    layer = GradedLayer(young, poisson, 1.0)
    nu = layer.poisson_at(np.zeros(1))[0]
    expected = -(2 - nu) / (2 * (1 - nu)) * slope + (1 - 2 * nu) / (2 * (1 - nu**2)) * poisson_slope
    # kappa (L - 1) is fitted where L is good to 1e-13, kappa <= 3000
    assert compliance(Medium([layer], HalfSpace(2.0, 0.3))).tail == pytest.approx(expected, rel=1e-8)


def test_long_waves_on_a_rigid_base():
    young = ExponentialModulus(1.0, 7.0, 1.0)
    kappa = np.array([1e-4, 1e-3])
    z, w = np.polynomial.legendre.leggauss(30)
    z, w = (z + 1) / 2, w / 2
    # compressible, bonded: oedometric compliances in series; next order kappa^2
    nu = 0.3
    one = w @ ((1 + nu) * (1 - 2 * nu) / ((1 - nu) * young(z)))
    medium = Medium([GradedLayer(young, nu, 1.0)], RigidBase())
    np.testing.assert_allclose(layered_response(medium, kappa), medium.surface_modulus * kappa / 2 * one, rtol=3e-6)
    # incompressible, bonded: flow driven by the pressure gradient, C = k^2 int z^2/mu dz
    three = w @ (z**2 * 3 / young(z))
    medium = Medium([GradedLayer(young, 0.5, 1.0)], RigidBase())
    np.testing.assert_allclose(
        layered_response(medium, kappa), medium.surface_modulus * kappa**3 / 2 * three, rtol=3e-6
    )


def test_tables_are_integrated_across_their_knots():
    z = np.linspace(0, 1, 9)
    table = (z, [1.0, 3.0, 2.0, 2.0, 8.0, 1.0, 1.0, 4.0, 0.5])
    layer = GradedLayer(table, 0.3, 1.0)
    pieces = [GradedLayer(lambda s, a=a: layer.young_at(a + s), 0.3, 0.125) for a in z[:-1]]
    base = HalfSpace(2.0, 0.2)
    np.testing.assert_allclose(
        layered_response(Medium([layer], base), KAPPA), layered_response(Medium(pieces, base), KAPPA), rtol=1e-11
    )


def test_a_jump_inside_one_layer_is_found_by_the_step_control():
    jump = GradedLayer(lambda z: np.where(z < 0.51, 1.0, 2.0), 0.3, 1.0)
    halves = Medium([Layer(1.0, 0.3, 0.51), Layer(2.0, 0.3, 0.49)], RigidBase())
    # the step across the jump shrinks until its estimate is below TOLERANCE; estimates of smooth laws are worth less there
    np.testing.assert_allclose(
        layered_response(Medium([jump], RigidBase()), KAPPA), layered_response(halves, KAPPA), rtol=1e-10
    )


def test_a_law_that_is_noise_is_refused():
    rng = np.random.default_rng(3)
    layer = GradedLayer(lambda z: 1 + 0.1 * rng.random(np.shape(z)), 0.3, 1.0)
    with pytest.raises(ValueError, match="grading of a layer"):
        compliance(Medium([layer], RigidBase()))


def test_a_law_that_fails_between_the_depths_checked_is_caught_on_the_way():
    # a dip to negative values narrower than the spacing of the check at 2049 depths
    layer = GradedLayer(lambda z: 1 - 2 * np.exp(-(((z - 0.50012) / 5e-5) ** 2)), 0.3, 1.0)
    with pytest.raises(ValueError, match=r"young = -.* at depth z = 500\.1 mm"):
        layered_response(Medium([layer], RigidBase()), np.geomspace(0.1, 20, 200))


@pytest.mark.long
def test_a_root_of_the_depth_has_no_tail_but_a_response():
    # E' is infinite at z = 0: L - 1 falls like kappa^-1/2, no series in 1/kappa exists
    medium = Medium([GradedLayer(PowerModulus(1.0, 2.0, 1.0, 0.5), 0.3, 1.0)], HalfSpace(2.0, 0.3))
    kernel = compliance(medium)
    kappa = np.geomspace(0.01, 1e6, 40)
    np.testing.assert_allclose(kernel.response(kappa), layered_response(medium, kappa), rtol=1e-11)


def test_under_a_homogeneous_layer_short_waves_see_that_layer_only():
    medium = Medium([Layer(2.0, 0.3, 0.5), GradedLayer(LAWS["linear 5"], 0.4, 1.0)], RigidBase())
    kernel = compliance(medium)
    assert kernel.tail == 0.0
    assert not kernel.graded
    np.testing.assert_allclose(kernel.response(KAPPA), layered_response(medium, KAPPA / 0.5), rtol=1e-11)
    np.testing.assert_array_equal(kernel.response(np.array([30.0, 1e3])), 1.0)


def test_only_dimensionless_groups_matter():
    young = LAWS["linear 5"]
    here = compliance(Medium([GradedLayer(young, 0.3, 1.0)], HalfSpace(2.0, 0.3)))
    there = compliance(Medium([GradedLayer(lambda z: 1e9 * young(z / 1e-6), 0.3, 1e-6)], HalfSpace(2e9, 0.3)))
    # C = 2 L/(E* k); 1e-6 is no power of two, so steps differ in rounding
    np.testing.assert_allclose(here(KAPPA) / there(KAPPA / 1e-6), 1e15, rtol=1e-11)
