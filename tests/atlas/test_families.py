"""Families: media of given parameters, parameters of given media, and what Dundurs promises."""

import numpy as np
import pytest

import flatpunch as fp
from atlas_tables import FAMILIES, Family, Parameter
from atlas_tables.families import layer_on
from flatpunch import atlas
from flatpunch.atlas import dundurs
from flatpunch.atlas.library import identify


@pytest.mark.parametrize("family", FAMILIES.values(), ids=lambda f: f.name)
def test_media_and_parameters_belong_to_each_other(family):
    rng = np.random.default_rng(1)
    for _ in range(20):
        wanted = {p.name: float(p.at(rng.uniform(-1, 1))) for p in family.parameters}
        medium = family.make(**wanted)
        assert medium.length == 1.0
        # 1e-8: E1*/E2* at the ends of the range comes from differences of numbers a thousand times larger
        name, found = identify(medium)
        assert found == pytest.approx(wanted, rel=1e-8, abs=1e-9)
        assert name == family.name


def test_dundurs_parameters_of_known_pairs():
    same = fp.Layer(young=3.0, poisson=0.2, thickness=1.0)
    assert dundurs(same, fp.HalfSpace(young=3.0, poisson=0.2)) == pytest.approx((0.0, 0.0), abs=1e-15)
    # two incompressible materials have beta = 0
    soft, hard = fp.Layer(young=1.0, poisson=0.5, thickness=1.0), fp.HalfSpace(young=3.0, poisson=0.5)
    assert dundurs(soft, hard) == pytest.approx((-0.5, 0.0), abs=1e-15)


def test_media_with_the_same_dundurs_parameters_have_the_same_compliance():
    rng = np.random.default_rng(2)
    k = np.geomspace(1e-3, 30, 60)
    family = FAMILIES["bonded-coating"]
    for _ in range(10):
        young, nu1, nu2 = 10 ** rng.uniform(-2.5, 2.5), *rng.uniform(0, 0.5, 2)
        real = fp.Medium([fp.Layer(young=young, poisson=nu1, thickness=1.0)], base=fp.HalfSpace(young=1.0, poisson=nu2))
        twin = family.make(**identify(real)[1])
        ratio = fp.compliance(real)(k) * real.surface_modulus / (fp.compliance(twin)(k) * twin.surface_modulus)
        # C(k) itself is good to a few 1e-13
        np.testing.assert_allclose(ratio, 1, rtol=2e-11)


def test_gradings_are_told_from_others():
    def coated(law, poisson=0.3, base=1.0):
        layer = fp.GradedLayer(young=law, poisson=poisson, thickness=2.0)
        return fp.Medium([layer], base=fp.HalfSpace(young=base, poisson=0.3))

    name, values = identify(coated(fp.LinearModulus(5.0, 1.0, 2.0)))
    assert name == "linear-coating"
    assert values == pytest.approx({"modulus_ratio": 5.0, "poisson": 0.3})
    assert identify(coated(fp.LinearModulus(5.0, 1.0, 2.0), base=1.1)) is None  # it does not end in its base
    assert identify(coated(fp.LinearModulus(5.0, 1.0, 2.0), poisson=0.2)) is None
    assert identify(coated(fp.ExponentialModulus(5.0, 1.0, 2.0)))[0] == "exponential-coating"
    # half a linear law is a linear law
    _, values = identify(coated(fp.LinearModulus(5.0, 0.0 + 1e-9, 4.0), base=2.5 + 0.5e-9))
    assert values["modulus_ratio"] == pytest.approx(2.0)


def test_what_a_family_may_not_be():
    with pytest.raises(ValueError, match="range of a/l"):
        Family("x", "", (), layer_on, beta=(0.0, 1.0))
    three = tuple(Parameter(name, "", 0.0, 1.0) for name in "abc")
    with pytest.raises(ValueError, match=r"3 parameters \(a, b, c\); two beside beta"):
        Family("x", "", three, layer_on)


def test_public_names():
    assert set(atlas.families()) == set(FAMILIES)
