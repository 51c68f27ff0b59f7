"""Formulas in z: they mean what they say, and hostile text can do nothing."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flatpunch.media import Formula, GradedLayer
from flatpunch.media.formula import LONGEST

Z = np.array([0.0, 0.5e-6, 2e-6])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1e9*exp(z/2e-6)", 1e9 * np.exp(Z / 2e-6)),
        ("-2^2 + 3*-2**-1", -4 - 1.5),
        ("2**3**2", 512.0),
        ("8/4/2 - 1 - 1", -1.0),
        ("2*-z", -2 * Z),
        ("min(z, 1e-6) + max(1, 2)*.5", np.minimum(Z, 1e-6) + 1),
        ("sqrt(abs(-4)) + log(exp(1)) + tanh(0) + cos(0) + sin(0) + atan(0) + sinh(0) + cosh(0)", 5.0),
        (" ( 1.5E-3 ) *pi", 1.5e-3 * np.pi),
    ],
)
def test_formulas_mean_what_they_say(text, expected):
    # the same operations in the same order: equal to rounding of the library functions
    np.testing.assert_allclose(Formula(text)(Z), np.broadcast_to(expected, Z.shape), rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "ends where"),
        ("1 +", "ends where"),
        ("2 z", "found 'z' at character 3"),
        ("exp z", r"expected '\('"),
        ("min(z)", "expected ','"),
        ("exp(z, z)", r"expected '\)'"),
        ("1e999", "too large"),
        ("z = 1", "character 3 cannot be read"),
    ],
)
def test_faults_are_pointed_at(text, message):
    with pytest.raises(ValueError, match=message):
        Formula(text)


HOSTILE = [
    "__import__('os').system('true')",
    "z.__class__.__mro__",
    "().__class__.__bases__[0].__subclasses__()",
    "(lambda: 0)()",
    "[z for z in (1,)]",
    "exec(z)",
    "eval(z)",
    "open(z)",
    "getattr(z, z)",
    "os",
    "z if z else z",
    "z; z",
    "z\nz",
    "`z`",
    "{z}",
    "z := 1",
    "'a'*9",
    "1_000",
    "0x10",
    "ｚ",
    "１",
    "z\x00",
    "nan",
    "inf",
    "import os",
    "exp(__builtins__)",
    "%s" % ("(" * 200 + "z" + ")" * 200),
    "-" * 400 + "z",
    "2**" * 100 + "2",
    "z" + "+z" * LONGEST,
]


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_text_is_refused(text):
    with pytest.raises(ValueError, match=r"Formula\.text"):
        Formula(text)


def test_towers_of_powers_cost_nothing():
    start = time.perf_counter()
    tower = Formula("9**9**9**9**9**9")
    assert np.isinf(tower(Z)).all()
    # floats only: milliseconds; exact integers would never end
    assert time.perf_counter() - start < 1.0
    with pytest.raises(ValueError, match="young = inf"):
        GradedLayer(tower, 0.3, 1e-6)


@given(st.text(alphabet="z0123456789.e+-*/^(), expminlogsqrt_'\"[]{}\\", max_size=60))
@settings(max_examples=300, derandomize=True, deadline=None)
def test_any_text_gives_numbers_or_a_value_error(text):
    try:
        formula = Formula(text)
    except ValueError:
        return
    assert formula(Z).shape == Z.shape


def test_only_text_is_read():
    with pytest.raises(TypeError, match=r"Formula\.text"):
        Formula(3.0)
