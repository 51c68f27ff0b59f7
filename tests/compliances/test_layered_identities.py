"""What the compliance of a stack must obey whatever its numbers."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flatpunch.compliances import compliance
from flatpunch.compliances.response import layered_response
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase

KAPPA = np.geomspace(1e-3, 40, 40)
# 1e-12: two evaluations, each within 6e-13 of the truth (test_layered_closed_forms)
RTOL = 1e-12

poisson = st.one_of(st.just(0.5), st.floats(-0.4, 0.5))
layer = st.builds(
    Layer,
    young=st.floats(-4, 0).map(lambda x: 10**x),
    poisson=poisson,
    thickness=st.floats(-1, 1).map(lambda x: 10**x),
    bonded=st.booleans(),
)
base = st.one_of(
    st.just(RigidBase()),
    st.builds(HalfSpace, young=st.floats(-4, 0).map(lambda x: 10**x), poisson=poisson),
)
stack = st.builds(Medium, st.lists(layer, min_size=1, max_size=4), base)
seeded = settings(max_examples=40, derandomize=True, deadline=None)


def scaled(medium, length, modulus):
    layers = [Layer(p.young * modulus, p.poisson, p.thickness * length, p.bonded) for p in medium.layers]
    bottom = medium.base
    if isinstance(bottom, HalfSpace):
        bottom = HalfSpace(bottom.young * modulus, bottom.poisson)
    return Medium(layers, bottom)


@seeded
@given(stack)
def test_only_ratios_of_lengths_and_moduli_matter(medium):
    # powers of two: scaling is exact, so is the answer
    other = scaled(medium, 2.0**-20, 2.0**30)
    np.testing.assert_array_equal(
        layered_response(medium, KAPPA / medium.length), layered_response(other, KAPPA / other.length)
    )


@seeded
@given(stack, st.integers(0, 3), st.floats(0.05, 0.95))
def test_a_layer_cut_in_two_is_one_layer(medium, which, fraction):
    i = which % len(medium.layers)
    whole = medium.layers[i]
    parts = [
        Layer(whole.young, whole.poisson, fraction * whole.thickness, bonded=True),
        Layer(whole.young, whole.poisson, (1 - fraction) * whole.thickness, whole.bonded),
    ]
    cut = Medium([*medium.layers[:i], *parts, *medium.layers[i + 1 :]], medium.base)
    k = KAPPA / medium.length
    np.testing.assert_allclose(layered_response(cut, k), layered_response(medium, k), rtol=5 * RTOL)


@seeded
@given(stack)
def test_response_is_positive_and_stiffer_bodies_give_less(medium):
    k = KAPPA / medium.length
    soft = layered_response(medium, k)
    assert (soft > 0).all()
    first = medium.layers[0]
    for i, part in enumerate(medium.layers[1:], start=1):
        stiffer = list(medium.layers)
        stiffer[i] = Layer(2 * part.young, part.poisson, part.thickness, part.bonded)
        assert (layered_response(Medium(stiffer, medium.base), k) <= soft * (1 + 1e-12)).all()
    glued = Medium([Layer(first.young, first.poisson, first.thickness), *medium.layers[1:]], medium.base)
    assert (layered_response(glued, k) <= soft * (1 + 1e-12)).all()


def dundurs(layer, base):
    """alpha and beta of a layer (1) on a base (2), positive where the base is the stiffer one."""
    shear = [body.young / (2 * (1 + body.poisson)) for body in (layer, base)]
    k1, k2 = 3 - 4 * layer.poisson, 3 - 4 * base.poisson
    g = shear[1] / shear[0]
    whole = g * (k1 + 1) + k2 + 1
    return (g * (k1 + 1) - (k2 + 1)) / whole, (g * (k1 - 1) - (k2 - 1)) / whole


@seeded
@given(st.floats(-3, 3), st.floats(0.0, 0.5), st.floats(0.0, 0.5), st.floats(0.0, 0.5))
def test_dundurs_parameters_are_all_that_matters(log_young, nu1, nu2, other_nu1):
    pair = Layer(1.0, nu1, 1.0), HalfSpace(10**log_young, nu2)
    alpha, beta = dundurs(*pair)
    # solve the two definitions for the base under a layer of another Poisson ratio
    ratio, kolosov = (1 + alpha) / (1 - alpha), 3 - 4 * other_nu1
    q = 2 / (beta * (1 + ratio) - (ratio - 1) + 2 * ratio / (kolosov + 1))
    other_nu2 = 1 - q / 4
    assume(-0.9 < other_nu2 <= 0.5)
    shear = ratio * q / (kolosov + 1)
    other = Layer(2 * (1 + other_nu1), other_nu1, 1.0), HalfSpace(2 * (1 + other_nu2) * shear, other_nu2)
    # the pairs agree in alpha and beta up to rounding over 1 - |alpha| >= 1e-3, which passes into L in the
    # same ratio
    np.testing.assert_allclose(dundurs(*other), (alpha, beta), atol=1e-13)
    one, two = (Medium([layer], base) for layer, base in (pair, other))
    np.testing.assert_allclose(layered_response(one, KAPPA), layered_response(two, KAPPA), rtol=1e-10)


@seeded
@given(stack)
def test_short_waves_feel_the_top_layer_alone(medium):
    k = np.array([26.0, 40.0, 1e3]) / medium.length
    np.testing.assert_array_equal(layered_response(medium, k), 1.0)


@pytest.mark.parametrize("base_young", [1e-3, 0.3, 10.0, 1e3])
def test_long_waves_feel_the_base_alone(base_young):
    top, bottom = Layer(1.0, 0.4, 1.0), HalfSpace(base_young, 0.2)
    kappa = np.array([1e-4, 1e-5])
    ratio = layered_response(Medium([top], bottom), kappa) * bottom.surface_modulus / top.surface_modulus
    # first order in kappa times the larger modulus ratio, so a tenfold kappa gives a tenfold difference
    assert abs(ratio[1] - 1) < 2e-5 * max(base_young, 1 / base_young)
    assert (ratio[0] - 1) / (ratio[1] - 1) == pytest.approx(10, rel=0.2)


def test_a_stack_without_contrast_is_a_half_space():
    same = Medium([Layer(5.0, 0.3, 0.2), Layer(5.0, 0.3, 3.0)], HalfSpace(5.0, 0.3))
    np.testing.assert_allclose(layered_response(same, KAPPA), 1.0, rtol=RTOL)


def test_equal_media_share_a_kernel():
    one, other = (Medium([Layer(1.0, 0.3, 1.0)], RigidBase()) for _ in range(2))
    assert compliance(one) is compliance(other)
