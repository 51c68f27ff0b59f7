"""Graded layers as data: what they accept, what they refuse and where, when two of them are the same medium."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flatpunch import indent
from flatpunch.media import (
    DepthTable,
    ExponentialModulus,
    Formula,
    GradedLayer,
    HalfSpace,
    Layer,
    LinearModulus,
    Medium,
    PowerLawHalfSpace,
    PowerModulus,
    RigidBase,
    TwoBodies,
)

H = 2e-6
LAWS = {
    "linear": LinearModulus(1e9, 5e9, H),
    "exponential": ExponentialModulus(1e9, 5e9, H),
    "power": PowerModulus(1e9, 5e9, H, 1.0),
    "formula": Formula("1e9 + 4e9*z/2e-6"),
    "function": lambda z: 1e9 + 4e9 * z / H,
    "one depth at a time": lambda z: 1e9 if z < H / 2 else 5e9,
    "table": ([0, H / 2, H], [1e9, 3e9, 5e9]),
    "number": 1e9,
}


@pytest.mark.parametrize("name", list(LAWS))
def test_every_kind_of_law_gives_moduli_of_the_shape_asked_for(name):
    layer = GradedLayer(LAWS[name], 0.3, H)
    z = np.linspace(0, H, 12).reshape(3, 4)
    assert layer.young_at(z).shape == (3, 4)
    assert layer.young_at(np.zeros(1))[0] == 1e9
    assert layer.surface_modulus == pytest.approx(1e9 / 0.91, rel=1e-15)
    assert np.all(layer.poisson_at(z) == 0.3)


@given(st.lists(st.floats(1e8, 1e10), min_size=2, max_size=6))
@settings(max_examples=40, derandomize=True, deadline=None)
def test_tables_do_not_overshoot(entries):
    z = np.linspace(0, H, len(entries))
    layer = GradedLayer((z, entries), 0.3, H)
    for a, b, low, high in zip(z[:-1], z[1:], entries[:-1], entries[1:], strict=True):
        inside = layer.young_at(np.linspace(a, b, 50))
        # the cubic is evaluated in rounded arithmetic
        assert inside.min() >= min(low, high) * (1 - 1e-12)
        assert inside.max() <= max(low, high) * (1 + 1e-12)


def test_equal_parameters_make_equal_media_and_functions_count_by_identity():
    def medium(law):
        return Medium([GradedLayer(law, ([0, H], [0.3, 0.4]), H)], base=RigidBase())

    for name in ("linear", "formula"):
        assert medium(LAWS[name]) == medium(LAWS[name])
    assert medium(([0, H], [1.0, 2.0])) == medium((np.array([0, H]), np.array([1.0, 2.0])))
    assert hash(medium(([0, H], [1.0, 2.0]))) == hash(medium(([0, H], [1.0, 2.0])))
    assert medium(lambda z: 1 + z) != medium(lambda z: 1 + z)
    same = LAWS["function"]
    assert hash(medium(same)) == hash(medium(same))


@pytest.mark.parametrize(
    ("young", "poisson", "message"),
    [
        (lambda z: 1.5e-6 - z, 0.3, r"young = .* \(out of range from z = 1\.5 µm.*PowerLawHalfSpace"),
        (lambda z: z, 0.3, r"young = 0 at depth z = 0 m"),
        (1e9, lambda z: 0.3 + 2e5 * z, r"poisson = .* \(out of range from z = 1 µm.*-1 < poisson <= 0\.5"),
        (Formula("1e9*log(z/1e-6)"), 0.3, r"young = -inf at depth z = 0 m"),
        (([0, H / 2], [1e9, 2e9]), 0.3, r"a table from 0 to 1e-06 m in a layer of thickness 2e-06 m"),
        (([0, H, H], [1e9, 2e9, 3e9]), 0.3, r"depths\[2\].*ascend"),
        (([0, H], [1e9]), 0.3, r"2 depths and 1 entries"),
    ],
)
def test_profiles_out_of_range_are_refused_with_the_depth(young, poisson, message):
    with pytest.raises(ValueError, match=message):
        GradedLayer(young, poisson, H)


def test_wrong_types_are_refused():
    with pytest.raises(TypeError, match="must be a number, a function of depth, a named law or a table"):
        GradedLayer("1e9*z", 0.3, H)
    with pytest.raises(TypeError, match="bonded"):
        GradedLayer(1e9, 0.3, H, bonded=1)
    with pytest.raises(ValueError, match="thickness"):
        GradedLayer(1e9, 0.3, -H)
    with pytest.raises(TypeError, match="must be a Layer, a GradedLayer"):
        Medium([HalfSpace(1, 0.3)], base=RigidBase())


def test_breaks_of_a_table_lie_inside_the_layer():
    assert GradedLayer(([0, 1, 2, 3], [1.0, 2.0, 3.0, 4.0]), ([0, 1.5, 3], [0.1, 0.2, 0.3]), 2.0).breaks == (1.0, 1.5)
    assert DepthTable((0, 1), (1, 2)).breaks == ()


def test_power_law_half_space_limits_of_its_exponent():
    body = PowerLawHalfSpace(modulus=2e6, depth=0.1, exponent=1, poisson=0.5)
    assert replace(body, exponent=0.5).young_at(np.array([0.1, 0.4])) == pytest.approx([2e6, 4e6])
    assert body.surface_modulus == pytest.approx(2e6 / 0.75, rel=1e-15)
    assert body.length == 0.1
    for exponent, poisson in ((1, 0.3), (-0.5, 0.2), (1.2, 0.5)):
        with pytest.raises(ValueError, match=r"-0\.5 < exponent < 1.*Gibson"):
            PowerLawHalfSpace(2e6, 0.1, exponent, poisson)


def test_two_bodies_as_data():
    soft = Medium([Layer(1.0, 0.3, 2.0)], RigidBase())
    hard = HalfSpace(10.0, 0.2)
    pair = TwoBodies(hard, soft)
    assert pair.length == 2.0
    assert 1 / pair.surface_modulus == pytest.approx(1 / soft.surface_modulus + 1 / hard.surface_modulus, rel=1e-15)
    assert TwoBodies(soft, hard) == TwoBodies(soft, hard)
    assert TwoBodies(soft, RigidBase()).surface_modulus == soft.surface_modulus
    with pytest.raises(ValueError, match="both rigid"):
        TwoBodies(RigidBase(), RigidBase())
    with pytest.raises(TypeError, match=r"TwoBodies\.lower"):
        TwoBodies(soft, Layer(1.0, 0.3, 1.0))
    with pytest.raises(ValueError, match="one of its own exponent"):
        TwoBodies(soft, PowerLawHalfSpace(1.0, 1.0, 0.3, 0.3))


@pytest.mark.parametrize("law", [lambda z: 1 / 0, lambda: 3.0, lambda z: "a", indent])
def test_functions_that_fail_are_named(law):
    with pytest.raises(TypeError, match=r"GradedLayer\.young: the function fails with"):
        GradedLayer(law, 0.3, 1e-6)
