"""A value of a wrong kind in the place of a word, a list, a mapping or a switch is refused by name."""

from pathlib import Path

import numpy as np
import pint
import pytest
import xarray as xr

import flatpunch as fp
from support.public_calls import CALLS

CURVE = Path(__file__).resolve().parents[2] / "examples" / "fit" / "thin_gel.csv"
REGISTRY = pint.UnitRegistry()

WRONG = {
    "quantity": REGISTRY.Quantity(3.0, "um"),
    "quantities": REGISTRY.Quantity([1.0, 2.0], "kPa"),
    "array": np.arange(3.0),
    "words": np.array(["auto", "first"]),
    "labelled": xr.DataArray([1.0, 2.0]),
    "range": range(5),
    "list": [1, 2],
    "nested": [[1], {}],
    "number": 3,
    "object": object(),
    "long": "x" * 10_000,
}
CALLED = {
    **CALLS,
    "read_curve": (fp.read_curve, {"path": CURVE}),
    "sweep": (
        fp.sweep,
        {"case": Path(__file__).resolve().parents[2] / "examples" / "knee_insert_sliding_on_tray.toml"},
    ),
}
ARGUMENTS = [
    ("design", "limits"),
    ("design", "vary"),
    ("design", "objective"),
    ("Limit", "quantity"),
    ("Target", "quantity"),
    ("correct", "method"),
    ("correct", "model"),
    ("correct", "over"),
    ("fields cells", "side"),
    ("pressure", "return_error"),
    ("HeightMap", "apex"),
    ("sweep", "contours"),
    *(("read_curve", name) for name in ("columns", "units", "calibration", "decimal", "sheet", "skip_nan", "flip")),
    *(
        ("Settings", name)
        for name in ("baseline", "loss", "adhesion", "segment", "direction", "quick", "drag", "method")
    ),
]


@pytest.mark.parametrize("kind", WRONG)
@pytest.mark.parametrize(("call", "name"), ARGUMENTS)
def test_it_is_refused_by_name(call, name, kind):
    if (name, kind) in (("drag", "number"), ("sheet", "long")):
        kind = "list"
    function, given = CALLED[call]
    with pytest.raises((TypeError, ValueError), match=rf"^(\w+\.)?{name}\b") as refused:
        function(**{**given, name: WRONG[kind]})
    assert len(str(refused.value)) < 450


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"columns": {"force": [1]}}, r"columns: \[1\] for force must be a title or the number of a column"),
        ({"columns": {"load": "force"}}, "columns = 'load' is no kind of column; it is one of 'depth', 'force'"),
        ({"units": {"load": "nN"}}, "units = 'load' is no kind of column"),
        ({"calibration": {"stiffness": 0.1}}, "calibration = 'stiffness' is unknown; it is one of 'spring_constant'"),
        ({"calibration": {"sensitivity": "10 %"}}, r"calibration\['sensitivity'\] = '10 %' must be a number"),
        ({"calibration": {"spring_constant": 10}}, r"calibration\['spring_constant'\] = 10.0 must be below 1"),
    ],
)
def test_entries_of_readings(given, message):
    with (
        pytest.raises(ValueError, match=message)
        if "10 %" not in str(given)
        else pytest.raises(TypeError, match=message)
    ):
        fp.read_curve(CURVE, **given)


def test_points_that_do_not_fit_together():
    with pytest.raises(ValueError, match=r"x and y have shapes \(3,\) and \(2,\)"):
        fp.pressure(fp.HalfSpace(5e3, 0.3), fp.Sphere(1e-6), np.zeros(3), np.zeros(2), depth=1e-8)


def test_one_limit_is_a_list_of_one():
    name, given = CALLS["design"]
    limit = fp.Limit("radius", maximum=1e-3, depth=1e-7)
    assert name(**given, limits=limit).values == name(**given, limits=[limit]).values


TIP = fp.Sphere(1e-6)
PLANE = fp.fields(fp.HalfSpace(5e3, 0.3), TIP, [[0.0], [1e-7]], 0.0, [0.0, 1e-7], depth=1e-8)
SHARES = fp.sensitivity(fp.HalfSpace(5e3, 0.3), TIP, depth=1e-8)
DRAWN = {
    "plot_curve": "result",
    "plot_design": "result",
    "plot_fields": "result",
    "plot_fit": "result",
    "plot_measured": "curve",
    "plot_medium": "medium",
    "plot_outline": "result",
    "plot_rough": "contact",
    "plot_sensitivity": "result",
    "plot_tip": "indenter",
}


FOREIGN = {
    **WRONG,
    "none": None,
    "mapping": {},
    "class": fp.Sphere,
    "plane": PLANE,
    "shares": SHARES,
    "one": PLANE.von_mises,
}


@pytest.mark.parametrize("foreign", FOREIGN)
@pytest.mark.parametrize(("picture", "name"), DRAWN.items())
def test_pictures_refuse_what_they_do_not_draw(picture, name, foreign):
    """Results of other functions and classes instead of their objects included."""
    if foreign == {"plot_fields": "plane", "plot_sensitivity": "shares"}.get(picture):
        return
    with pytest.raises((TypeError, ValueError), match=rf"^{name}\b") as refused:
        getattr(fp, picture)(FOREIGN[foreign])
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 450


@pytest.mark.parametrize(
    "call", [call for call, (_, given) in CALLS.items() if "indenter" in given and call != "fields load"]
)
def test_a_class_is_no_indenter(call):
    """`fp.Sphere` where `fp.Sphere(radius)` is meant."""
    function, given = CALLS[call]
    with pytest.raises(TypeError, match=r"^(\w+\.)?indenter = <class"):
        function(**{**given, "indenter": fp.Sphere})
