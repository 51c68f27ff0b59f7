"""Every number of every public constructor and function: what is no real number is refused by name, quantities are converted.

`support.public_calls` has one valid call of each; each number in it, also in lists, is replaced by each kind of bad value.
"""

import contextlib
import inspect
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pint
import pytest

import flatpunch as fp
from support.public_calls import BALL, BODY, CALLS

REGISTRY = pint.UnitRegistry()
UNITS = {
    **dict.fromkeys(("young", "modulus", "top", "bottom", "reported", "pressure"), "Pa"),
    **dict.fromkeys(("thickness", "depth", "depths", "radius", "x", "y", "z", "r", "f", "kinks", "limit", "unit"), "m"),
    **dict.fromkeys(("start", "smoothing", "near", "reach", "half_x", "half_y", "half_z", "height_at_axes"), "m"),
    **dict.fromkeys(
        ("half_width", "half_height", "half_widths", "tip_radius", "height_removed", "spacing", "center"), "m"
    ),
    **dict.fromkeys(("range_of_action", "contact", "depth_to", "piezo"), "m"),
    **dict.fromkeys(("time", "times"), "s"),
    **dict.fromkeys(("force", "force_to"), "N"),
    **dict.fromkeys(("inclination", "inclinations", "directions", "tilt_x", "tilt_y", "front", "back", "side"), "rad"),
    **dict.fromkeys(("A", "B", "k"), "1/m"),
    **dict.fromkeys(("spring_constant", "stiffness"), "N/m"),
    **dict.fromkeys(("traction", "yield_stress", "strength", "tensile", "residual_stress"), "Pa"),
    **dict.fromkeys(
        ("heights", "rms_height", "roll_off", "cut_off", "length", "crown", "end_radius", "corner_radius", "positions"),
        "m",
    ),
    "direction": "rad",
    "work_of_adhesion": "J/m**2",
    "area": "m**2",
    "frame": "m/N",
}

BAD = {
    "text": "5e3",
    "bytes": b"1",
    "truth": True,
    "numpy truth": np.True_,
    "complex": 1 + 0j,
    "numpy complex": np.complex128(1 + 1j),
    "nan": float("nan"),
    "inf": np.inf,
    "huge integer": 10**400,
    "very long integer": 10**5000,
    "masked": np.ma.masked,
    "masked entry": np.ma.masked_array([1.0], mask=[True]),
    "date": np.datetime64("2020-01-01"),
    "duration": np.timedelta64(5, "s"),
    "mapping": {"value": 1.0},
    "set": {1.0},
    "object": object(),
    "temperature": REGISTRY.Quantity(3.0, "kelvin"),
}
SOME = {
    "list of texts": ["1", "2"],
    "list with truth": [1.0, True],
    "list with None": [1.0, None],
    "complex array": np.array([1 + 1j, 2.0]),
    "nan within": np.array([1.0, np.nan]),
    "bytes within": bytearray(b"12"),
    "view of bytes": memoryview(b"12"),
    "masked within": np.ma.masked_array([1.0, 2.0], mask=[False, True]),
    "three dimensions": np.ones((2, 2, 2)),
    "ragged": [[1.0], [1.0, 2.0]],
    "durations": np.array([1, 2], dtype="timedelta64[s]"),
}
NAN_IS_NONE = {("Curve", "stiffness")}
"""Measured stiffnesses have gaps."""
ANY_SHAPE = {
    ("pressure", "x"),
    ("pressure", "y"),
    ("pressure adhesive", "x"),
    ("pressure adhesive", "y"),
    ("FlatPunch.pressure", "r"),
    *((call, name) for call in CALLS if call.startswith("fields ") for name in "xyz"),
}
NO_LIMIT = {
    ("conductance", "conductivity"),
    ("Free", "minimum"),
    ("Free", "maximum"),
    ("Interface", "normal"),
    ("Interface", "shear"),
}
"""Infinite limits are none, infinite stiffnesses do not yield, and bases of infinite conductivity are at one temperature."""


def is_number(value):
    if isinstance(value, (tuple, list, np.ndarray)):
        return len(value) > 0 and all(map(is_number, value))
    return isinstance(value, (int, float, np.floating)) and not isinstance(value, bool)


CASES = [(call, name) for call, (_, given) in CALLS.items() for name, value in given.items() if is_number(value)]


def refused(call, name, bad):
    function, given = CALLS[call]
    with pytest.raises((TypeError, ValueError)) as caught:
        function(**{**given, name: bad})
    message = str(caught.value)
    # a table of the angle or of the depth is named by what it is
    assert name.removesuffix("s") in message, message
    assert len(message) < 700, message


@pytest.mark.parametrize(("call", "name"), CASES, ids=[f"{call}: {name}" for call, name in CASES])
def test_what_is_no_number_is_refused_by_name(call, name):
    for kind, bad in {**BAD, **SOME}.items():
        if ("nan" in kind and (call, name) in NAN_IS_NONE) or (kind == "inf" and (call, name) in NO_LIMIT):
            continue
        if kind == "three dimensions" and (call, name) in ANY_SHAPE:
            continue
        if name == "contact" and isinstance(bad, list) and len(bad) == 2:
            # a pair of limits, either of which may be left open
            continue
        refused(call, name, bad)
        listed = CALLS[call][1][name]
        if isinstance(listed, (list, tuple)) and kind in BAD:
            refused(call, name, [*listed[:-1], bad])


@pytest.mark.parametrize("call", CALLS)
def test_the_calls_themselves_are_valid(call):
    function, given = CALLS[call]
    function(**given)


SCALED = [
    (call, name)
    for call, name in CASES
    if name in UNITS and call not in ("Free", "GradedLayer table", "BoundaryElements")
]


@pytest.mark.parametrize(("call", "name"), SCALED, ids=[f"{call}: {name}" for call, name in SCALED])
def test_quantities_are_converted(call, name):
    """A quantity in thousandths of the SI unit gives what the plain number gives; that of another dimension is refused."""
    function, given = CALLS[call]
    unit = UNITS[name]
    plain = np.asarray(given[name], dtype=float)
    small = (
        REGISTRY.Quantity(plain * 1e3, f"milli{'radian' if unit == 'rad' else 'meter'}")
        if unit in ("m", "rad")
        else None
    )
    quantity = small if small is not None else REGISTRY.Quantity(plain, unit)
    if plain.ndim == 0:
        quantity = REGISTRY.Quantity(float(quantity.magnitude), quantity.units)
    ours = function(**{**given, name: quantity})
    assert_same(ours, function(**given))
    for other in ("kg", "m**7"):
        with pytest.raises(TypeError, match=r"must be in|must be without dimension"):
            function(**{**given, name: REGISTRY.Quantity(plain if plain.ndim else float(plain), other)})
    masked = REGISTRY.Quantity(np.ma.masked_array([1.0, 2.0], mask=[False, True]), unit)
    with pytest.raises(ValueError, match="masked entries"):
        function(**{**given, name: masked})


def assert_same(found, wanted):
    if hasattr(wanted, "data_vars"):
        for variable in wanted.data_vars:
            if wanted[variable].dtype.kind == "f":
                # 1e-9: milli is no power of two
                np.testing.assert_allclose(found[variable], wanted[variable], rtol=1e-9)
            else:
                np.testing.assert_array_equal(found[variable], wanted[variable])
    elif isinstance(wanted, np.ndarray):
        np.testing.assert_allclose(found, wanted, rtol=1e-9)
    else:
        assert type(found) is type(wanted)


@pytest.mark.parametrize(
    "number",
    [
        5000,
        np.float32(5000),
        np.int64(5000),
        np.array(5000.0),
        Decimal(5000),
        Fraction(5000),
        np.ma.masked_array(5000.0),
    ],
    ids=lambda number: type(number).__name__,
)
def test_real_numbers_of_every_type_are_taken(number):
    assert fp.HalfSpace(number, 0.3) == BODY


def test_labelled_arrays_are_taken_in_their_own_unit_only():
    depth = fp.indent(BODY, BALL, depth=[1e-7, 2e-7])["depth"]
    assert (fp.indent(BODY, BALL, depth=depth)["depth"] == depth).all()
    with pytest.raises(TypeError, match="labelled as in 'N'"):
        fp.indent(BODY, BALL, depth=depth.assign_attrs(units="N"))


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::flatpunch.FlatpunchWarning")
@pytest.mark.parametrize("call", CALLS)
def test_sizes_that_overflow_are_refused_or_solved_without_a_warning(call):
    """Warnings are errors in this suite."""
    function, given = CALLS[call]
    for name in [name for called, name in CASES if called == call]:
        plain = np.asarray(given[name], dtype=float)
        for size in (5e-324, 1e-300, 1e-150, 1e150, 1e300):
            far = np.full(plain.shape, size) if plain.ndim else size
            with contextlib.suppress(TypeError, ValueError):
                function(**{**given, name: far})


@pytest.mark.parametrize("size", [5e-324, 1e-150, 1e300])
def test_lengths_and_moduli_of_no_body_are_refused(size):
    for make in (
        lambda: fp.HalfSpace(size, 0.3),
        lambda: fp.Layer(1e3, 0.3, size),
        lambda: fp.Sphere(size),
        lambda: fp.flat_punch(BODY, size),
        lambda: fp.indent(BODY, BALL, depth=size),
        lambda: fp.indent(BODY, BALL, force=[1e-9, size]),
        lambda: fp.pull_off(BODY, BALL, work_of_adhesion=size),
    ):
        with pytest.raises(ValueError, match="Check the units"):
            make()


def test_every_public_constructor_and_function_is_here():
    """A new one joins `CALLS`, or is named here with the reason."""
    without = {
        # no numbers: bodies of bodies, texts, errors, files
        *("Medium", "RigidBase", "TwoBodies", "Formula", "CurveError", "FlatpunchWarning", "homogenised"),
        *("Exact", "FirstOrder", "SecondOrder", "FourthOrder"),
        # their arguments pass the checks of critical_load and fields
        *("critical_loads", "peak_stresses"),
        *("load", "save", "read_case", "read_curve", "cite"),
        # no numbers of their own; test_theories
        *("full_contact", "rough_theories"),
        # side_calls; stresses/test_repeating
        "rough_stresses",
        # what functions return, and pictures of it
        *("plot_fields", "plot_sensitivity", "plot_design"),
        *("plot_curve", "plot_rough", "plot_outline", "plot_pressure", "plot_fit", "plot_measured", "plot_posterior"),
        # names and their values; test_together
        "Measured",
        # take case files and curves; their own tests
        *("read_height_map", "read_topography", "sweep", "fit_batch"),
    }
    public = {name for name in fp.__all__ if callable(getattr(fp, name)) and not inspect.ismodule(getattr(fp, name))}
    assert public - without <= {call.split(" ")[0] for call in CALLS}


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda x: fp.adhesion_loop(BODY, x, work_of_adhesion=1e-5, depth=1e-8), "indenter"),
        (lambda x: fp.plot_tip(x), "indenter"),
        (lambda x: fp.plot_medium(x), "medium"),
        (lambda x: fp.indenters.Truncated.across(x, 1e-6), "tip"),
        (lambda x: CALLS["oliver_pharr"][0](**{**CALLS["oliver_pharr"][1], "tip": x}), "tip"),
    ],
)
@pytest.mark.parametrize(
    "value", [1e308, b"x", range(3), {}, np.zeros((3, 3, 3))], ids=lambda value: type(value).__name__
)
def test_what_is_no_body_or_tip_is_refused_by_name(call, name, value):
    with pytest.raises(TypeError, match=rf"(?s){name} = .* must be a"):
        call(value)


def test_a_depth_below_the_end_of_the_tip_is_refused():
    ellipsoid = fp.Ellipsoid(half_x=5.9e-6, half_y=1.06e-5, half_z=9.65e-8)
    with pytest.raises(ValueError, match=r"reach|deep|depth"):
        fp.indent(BODY, ellipsoid, depth=6.2e-7)
