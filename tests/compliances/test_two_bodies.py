"""Two bodies pressed together: compliances add, whatever the bodies are."""

import numpy as np
import pytest

from flatpunch.compliances import compliance
from flatpunch.media import (
    ExponentialModulus,
    GradedLayer,
    HalfSpace,
    Layer,
    Medium,
    PowerLawHalfSpace,
    RigidBase,
    TwoBodies,
)

BODIES = {
    "half-space": HalfSpace(3.0, 0.2),
    "film": Medium([Layer(10.0, 0.3, 1.0)], HalfSpace(1.0, 0.4)),
    "thin soft layer": Medium([Layer(0.1, 0.5, 0.01)], RigidBase()),
    "graded": Medium([GradedLayer(ExponentialModulus(1.0, 4.0, 0.3), 0.4, 0.3)], RigidBase()),
    "graded below": Medium(
        [Layer(1.0, 0.3, 0.2), GradedLayer(ExponentialModulus(1.0, 4.0, 2.0), 0.4, 2.0)], RigidBase()
    ),
}
K = np.geomspace(1e-3, 1e5, 41)


@pytest.mark.parametrize("upper", list(BODIES))
@pytest.mark.parametrize("lower", list(BODIES))
def test_compliances_add_and_order_does_not_matter(upper, lower):
    one, two = BODIES[upper], BODIES[lower]
    pair = compliance(TwoBodies(one, two))
    expected = compliance(one)(K) + compliance(two)(K)
    # sums of rounded numbers
    np.testing.assert_allclose(pair(K), expected, rtol=1e-13)
    np.testing.assert_allclose(compliance(TwoBodies(two, one))(K), expected, rtol=1e-13)
    # the remainder is that of the same L, also where it comes from series (good to 2e-12, absolute)
    kappa = K * (pair.length if np.isfinite(pair.length) else 1.0)
    response = expected * pair.modulus * K / 2
    np.testing.assert_allclose(pair.remainder(kappa), response - 1, rtol=0, atol=1e-11 * response.max())


@pytest.mark.parametrize("name", list(BODIES))
def test_a_rigid_body_leaves_the_other(name):
    body = BODIES[name]
    assert compliance(TwoBodies(body, RigidBase())) is compliance(body)
    assert compliance(TwoBodies(RigidBase(), body)) is compliance(body)


def test_two_equal_half_spaces_are_one_of_half_the_modulus():
    pair = compliance(TwoBodies(BODIES["half-space"], BODIES["half-space"]))
    assert pair.homogeneous
    np.testing.assert_allclose(pair(K), compliance(HalfSpace(1.5, 0.2))(K), rtol=1e-15)


def test_two_equal_layers_are_one_of_half_the_modulus():
    half = Medium([Layer(5.0, 0.3, 1.0)], HalfSpace(0.5, 0.4))
    np.testing.assert_allclose(
        compliance(TwoBodies(BODIES["film"], BODIES["film"]))(K), compliance(half)(K), rtol=1e-13
    )


def test_the_pair_keeps_the_upper_length_and_the_widest_range_of_wavenumbers():
    pair = compliance(TwoBodies(BODIES["film"], BODIES["thin soft layer"]))
    assert pair.length == 1.0
    assert pair.cutoff == pytest.approx(25.0 / 0.01, rel=1e-12)
    assert pair.tail == 0.0
    assert compliance(TwoBodies(BODIES["half-space"], BODIES["film"])).length == 1.0
    graded = compliance(BODIES["graded"])
    pair = compliance(TwoBodies(BODIES["film"], BODIES["graded"]))
    share = pair.modulus / graded.modulus
    # c/(k l) counts in the pair's length
    assert pair.tail == pytest.approx(share * graded.tail / 0.3, rel=1e-12)


def test_power_law_media_pair_with_their_own_exponent_or_a_rigid_body():
    one, other = PowerLawHalfSpace(1.0, 1.0, 0.3, 0.3), PowerLawHalfSpace(5.0, 0.2, 0.3, 0.45)
    expected = compliance(one)(K) + compliance(other)(K)
    for pair in (TwoBodies(one, other), TwoBodies(other, one)):
        np.testing.assert_allclose(compliance(pair)(K), expected, rtol=1e-14)  # a few roundings
    np.testing.assert_allclose(compliance(TwoBodies(one, RigidBase()))(K), compliance(one)(K), rtol=0)
    for stranger in (BODIES["film"], PowerLawHalfSpace(1.0, 1.0, 0.4, 0.3)):
        with pytest.raises(ValueError, match=r"pairs with one of its own exponent or with RigidBase"):
            TwoBodies(one, stranger)
    with pytest.raises(TypeError, match="must be a Medium, a half-space or TwoBodies"):
        compliance(RigidBase())
