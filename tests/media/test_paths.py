"""Numbers of media, tips and case files by their paths, in both spellings."""

import pytest

import flatpunch as fp
from flatpunch._support.paths import entries, put, steps
from flatpunch.media.paths import value_of, with_values

GEL = fp.Medium([fp.Layer(5e3, 0.5, 2e-6), fp.Layer(7e3, 0.4, 1e-6)], base=fp.HalfSpace(1e5, 0.3))
TWO = fp.TwoBodies(upper=fp.HalfSpace(2e9, 0.3), lower=GEL)
TIP = fp.Sphere(radius=5e-6)


@pytest.mark.parametrize("written", ["layers[1].young", "layers.1.young", " layers[1].young "])
def test_both_spellings_are_one_path(written):
    assert steps(written) == ["layers", 1, "young"]
    data = {"layers": [{"young": 1.0}, {"young": 2.0}]}
    put(data, written, 3.0)
    assert dict(entries(data)) == {"layers.0.young": 1.0, "layers.1.young": 3.0}


@pytest.mark.parametrize(
    ("medium", "name", "value"),
    [
        (GEL, "layers[1].young", 7e3),
        (GEL, "layers.0.thickness", 2e-6),
        (GEL, "base.poisson", 0.3),
        (fp.HalfSpace(2e6, 0.4), "base.young", 2e6),
        (TWO, "upper.base.young", 2e9),
        (TWO, "lower.layers[1].young", 7e3),
        (GEL, "indenter.radius", 5e-6),
    ],
)
def test_numbers_are_read_and_replaced(medium, name, value):
    assert value_of(medium, TIP, name) == value
    changed = with_values(medium, TIP, {name: 0.9 * value})
    assert value_of(*changed, name) == 0.9 * value
    assert with_values(*changed, {name: value}) == (medium, TIP)
