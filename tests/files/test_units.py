"""Quantities with units: the number and the unit both count, and every refusal says what to write instead."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flatpunch.files import units


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("1.2 um", units.LENGTH, 1.2e-6),
        ("1.2 µm", units.LENGTH, 1.2e-6),  # micro sign U+00B5
        ("1.2 μm", units.LENGTH, 1.2e-6),  # Greek mu U+03BC
        ("1.2um", units.LENGTH, 1.2e-6),
        (" 3e2 nm ", units.LENGTH, 3e-7),
        ("5 kPa", units.PRESSURE, 5e3),
        ("5 N/mm^2", units.PRESSURE, 5e6),
        ("-2 MPa", units.PRESSURE, -2e6),  # the sign is for the objects to refuse: they know why
        ("2.5 nN", units.FORCE, 2.5e-9),
        ("35 deg", units.ANGLE, math.radians(35)),
        ("0.6 rad", units.ANGLE, 0.6),
        ("0.05 1/um", units.CURVATURE, 5e4),
        ("0.05 um^-1", units.CURVATURE, 5e4),
    ],
)
def test_reads_quantities(text, dimension, expected):
    # one multiplication by a power of ten or pi/180: a few roundings
    assert units.to_si(text, dimension) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("value", "dimension", "message"),
    [
        ("5 kPa", units.LENGTH, "has the dimension of a pressure; a length such as '1.2 um' is needed"),
        ("5 um", units.PRESSURE, "has the dimension of a length; a pressure such as '5 kPa' is needed"),
        ("5 deg", units.LENGTH, "has the dimension of an angle"),
        ("5 s", units.LENGTH, "has the dimension of a time"),
        ("5 degC", units.LENGTH, r"has the dimension \[temperature\]"),
        ("5 octave", units.LENGTH, "has no dimension"),
        ("5 kpa", units.PRESSURE, r"unknown unit 'kpa' \(did you mean 'kPa'\?\)"),
        ("5 micrn", units.LENGTH, "unknown unit 'micrn'"),
        ("5 )(", units.LENGTH, "unknown unit"),
        ("5", units.LENGTH, "has no unit"),
        (5, units.LENGTH, "has no unit; a length such as '1.2 um' is needed, in quotation marks"),
        (5.0, units.LENGTH, "has no unit"),
        ("35", units.ANGLE, "has no unit"),
        ("35 percent", units.ANGLE, "has no dimension; an angle such as"),
        ("um", units.LENGTH, "does not start with a number"),
        ("", units.LENGTH, "does not start with a number"),
        ("nan um", units.LENGTH, "does not start with a number"),
        ("1e400 um", units.LENGTH, "is not finite"),
        (True, units.LENGTH, "is no quantity"),
        (["1 um"], units.LENGTH, "is no quantity"),
        (None, units.LENGTH, "is no quantity"),
    ],
)
def test_refusals_name_the_remedy(value, dimension, message):
    with pytest.raises(ValueError, match=message):
        units.to_si(value, dimension)


def test_huge_powers_are_not_evaluated():
    """`pint` evaluates expressions; the reader hands it the unit alone, so a number cannot take for ever."""
    with pytest.raises(ValueError, match="unknown unit"):
        units.to_si("9**9**9**9 um", units.LENGTH)


_WORDS = ("um", "Pa", "dB", "degC", "octave", "π", "**", "1e999", "lambda", "\n")
_PIECES = st.sampled_from([*"mNsJ10.+-*/^()[]{}<=@#$%²½µé'_ ", *_WORDS])


@pytest.mark.long
@settings(max_examples=400, derandomize=True, deadline=None)
@given(st.one_of(st.lists(_PIECES, max_size=8).map("".join), st.text(max_size=8)), st.sampled_from(units.DIMENSIONS))
def test_whatever_stands_for_a_unit_is_read_or_refused(text, dimension):
    try:
        value, refusal = units.to_si(f"5 {text}", dimension), ""
    except ValueError as error:
        value, refusal = 0.0, str(error)
    assert math.isfinite(value)
    assert not refusal or dimension.example in refusal


@given(st.floats(min_value=1e-14, max_value=1e13), st.sampled_from(["m", "N", "Pa", "N/m", "m^2"]))
def test_readable_keeps_three_digits_before_the_point(value, unit):
    factor, prefixed = units.readable(value, unit)
    # 1 to 1000, squared for areas; the bound has room for the rounding of the logarithm
    assert 1 - 1e-6 <= value * factor <= (1e6 if unit == "m^2" else 1e3) * (1 + 1e-6) or prefixed[0] in "fT"


def test_readable_text():
    assert units.text(1.2e-6, "m") == "1.2 µm"
    assert units.text(1e-6, "m") == "1 µm"
    assert units.text(0.0, "N") == "0 N"
    assert units.text(4e-13, "m^2") == "4e+05 nm^2"
