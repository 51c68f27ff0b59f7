"""`indent`, `pressure` and `flat_punch`: bad input is refused before any work, and what a result carries."""

import json
import time
from dataclasses import FrozenInstanceError
from functools import partial

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.contact import METHODS

H = 1e-6
BODY = fp.HalfSpace(1e9, 0.3)
GEL = fp.Medium([fp.Layer(5e3, 0.5, H)], base=fp.RigidBase())
BALL = fp.Paraboloid(5 * H)

# arguments, error, and what its message must name: the argument, the value, the remedy
BAD_CONTROL = [
    ({}, ValueError, ["exactly one of depth, force and radius", "none"]),
    ({"depth": 1e-7, "force": 1e-3}, ValueError, ["exactly one", "depth and force"]),
    ({"depth": 1e-7, "force": 1e-3, "radius": 1e-6}, ValueError, ["depth and force and radius"]),
    ({"depth": -1e-7}, ValueError, ["depth = -1e-07", ">= 0"]),
    ({"depth": float("nan")}, ValueError, ["depth = nan", "finite"]),
    ({"force": float("inf")}, ValueError, ["force = inf", "finite"]),
    ({"force": [1e-3, -2.0]}, ValueError, ["force[1] = -2.0"]),
    ({"radius": [1e-7, float("nan")]}, ValueError, ["radius[1] = nan"]),
    ({"depth": []}, ValueError, ["depth", "non-empty"]),
    ({"depth": [[1e-7]]}, ValueError, ["depth has shape (1, 1)", "one-dimensional"]),
    ({"depth": "100 nm"}, TypeError, ["depth = '100 nm'", "SI units"]),
    ({"depth": 1e-7 + 0j}, TypeError, ["depth", "number"]),
    ({"depth": 1e-7, "method": "frist-order"}, ValueError, ["method = 'frist-order'", "'first-order'"]),
    ({"depth": 1e-7, "method": ["first-order"]}, ValueError, ["method", "'first-order'"]),
    ({"depth": 1e-7, "angles": 0}, ValueError, ["angles = 0", "whole number of at least 1"]),
    ({"depth": 1e-7, "angles": 12.5}, ValueError, ["angles = 12.5", "whole number"]),
    ({"depth": 1e-7, "angles": "many"}, TypeError, ["angles = 'many'"]),
    ({"depth": 1e-7, "anglse": 12}, TypeError, ["anglse"]),
]


@pytest.mark.parametrize(("arguments", "error", "says"), BAD_CONTROL, ids=lambda x: str(x)[:40])
@pytest.mark.parametrize("indenter", [BALL, fp.Pyramid(4, 0.3), fp.Cylinder(H)], ids=["ball", "pyramid", "cylinder"])
def test_bad_control_is_refused(indenter, arguments, error, says):
    with pytest.raises(error) as caught:
        fp.indent(GEL, indenter, **arguments)
    for text in says:
        assert text in str(caught.value)


BAD_SETTINGS = [
    ("refined", {"rtol": 0}, ValueError, ["rtol = 0", "> 0"]),
    ("refined", {"cells": "many"}, TypeError, ["cells = 'many'", "number"]),
    ("refined", {"cells": 7}, ValueError, ["cells = 7", "at least 8", "per side"]),
    ("refined", {"cells": 64.5}, ValueError, ["cells = 64.5", "whole number"]),
    ("refined", {"cells": float("nan")}, ValueError, ["cells = nan", "whole number"]),
    ("refined", {"cache": 3}, TypeError, ["cache = 3", "folder"]),
    ("bem", {"grid": [64, 64]}, TypeError, ["grid = [64, 64]", "number"]),
    ("bem", {"grid": 0}, ValueError, ["grid = 0", "at least 8", "or a Grid"]),
    ("bem", {"limit": 2.5}, ValueError, ["limit = 2.5", "whole number", "iterations"]),
    ("bem", {"limit": None}, TypeError, ["limit = None", "number"]),
    ("bem", {"tolerance": 0}, ValueError, ["tolerance = 0", "> 0"]),
    ("bem", {"tolerance": 2.5}, ValueError, ["tolerance = 2.5", "below 1", "1e-6"]),
]


@pytest.mark.parametrize(("method", "settings", "error", "says"), BAD_SETTINGS, ids=lambda x: str(x)[:40])
def test_bad_settings_are_refused(method, settings, error, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error) as caught:
        METHODS[method](**settings)
    for text in says:
        assert text in str(caught.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("call", [fp.indent, partial(fp.pressure, x=0.0, y=0.0)], ids=["indent", "pressure"])
def test_settings_belong_to_the_method(call):
    """A misspelt or misplaced keyword is an error, before any work."""
    tip = fp.Pyramid(4, 0.3)
    for wrong in ({"cells": 128}, {"anglse": 12}, {"grid": 64}):
        with pytest.raises(TypeError, match="unexpected keyword argument"):
            call(GEL, tip, depth=1e-7, method="refined", **wrong)
    with pytest.raises(TypeError, match="unexpected keyword argument"):
        fp.Refined(cels=128)
    with pytest.raises(TypeError, match=r"Refined is a class; write Refined\(\)"):
        call(GEL, tip, depth=1e-7, method=fp.Refined)


@pytest.mark.parametrize("method", METHODS)
def test_short_names_are_the_methods_with_their_defaults(method):
    """Round contacts by all of them; the result records name and settings."""
    configured = METHODS[method]()
    assert configured == METHODS[method]()
    assert hash(configured) == hash(METHODS[method]())
    named, same = (fp.indent(BODY, BALL, depth=1e-8, method=m, angles=4) for m in (method, configured))
    assert named.identical(same)
    assert configured.name == method
    # round contacts are exact by every fast method, and called so
    assert named.attrs["method"] == ("bem" if method == "bem" else "exact")
    if method != "bem":
        named = fp.indent(BODY, fp.EllipticParaboloid(1e5, 1.1e5), depth=1e-8, method=configured, angles=4)
        assert named.attrs["method"] == method
    settings = json.loads(named.attrs["method_settings"])
    assert settings == {name: getattr(configured, name) for name in settings}
    for name in settings:
        with pytest.raises(FrozenInstanceError):
            setattr(configured, name, None)


@pytest.mark.parametrize("indenter", [None, 3, "cone", fp.Paraboloid, BODY], ids=str)
def test_what_is_no_indenter_is_refused(indenter):
    with pytest.raises(TypeError, match=r"indenter = .* must be an indenter such as"):
        fp.indent(BODY, indenter, depth=1e-7)


@pytest.mark.parametrize(
    "medium", [None, "steel", fp.RigidBase(), fp.Layer(1e9, 0.3, H), [fp.Layer(1e9, 0.3, H)], fp.Medium]
)
def test_what_is_no_medium_is_refused(medium):
    for call in (
        lambda: fp.indent(medium, BALL, depth=1e-7),
        lambda: fp.flat_punch(medium, H),
        lambda: fp.pressure(medium, BALL, 0.0, 0.0, depth=1e-7),
        lambda: fp.compliance(medium),
    ):
        with pytest.raises(TypeError, match=r"medium = .* must be a Medium"):
            call()


@pytest.mark.parametrize(
    ("radius", "error", "says"),
    [
        (0, ValueError, "radius = 0.0 must be finite and > 0"),
        (-H, ValueError, "radius = -1e-06"),
        (float("nan"), ValueError, "radius = nan"),
        (float("inf"), ValueError, "radius = inf"),
        ("1 um", TypeError, "convert to SI"),
        (None, TypeError, "radius = None"),
        ([H, 2 * H], TypeError, "must be a number"),
    ],
)
def test_bad_punch_radii_are_refused(radius, error, says):
    for medium in (BODY, GEL):
        with pytest.raises(error) as caught:
            fp.flat_punch(medium, radius)
        assert says in str(caught.value)


def test_bad_points_of_a_pressure_field_are_refused():
    with pytest.raises(ValueError, match="depth has 2 values; a pressure field belongs to one of them"):
        fp.pressure(GEL, BALL, 0.0, 0.0, depth=[1e-7, 2e-7])
    with pytest.raises(ValueError, match="x and y must be finite"):
        fp.pressure(GEL, BALL, [0.0, np.nan], 0.0, depth=1e-7)
    with pytest.raises(ValueError, match="exactly one"):
        fp.pressure(GEL, BALL, 0.0, 0.0)


def test_targets_beyond_the_shape_or_the_resolution_are_refused_with_the_reason():
    ball = fp.Sphere(H)
    with pytest.raises(ValueError, match=r"depth = 1 m is beyond this indenter: its shape ends at the radius 950 nm"):
        fp.indent(BODY, ball, depth=1.0)
    with pytest.raises(ValueError, match=r"force = 1 N is beyond this indenter"):
        fp.indent(BODY, ball, force=[0.0, 1.0])
    with pytest.raises(ValueError, match=r"radius\[1\] = 960 nm is beyond this indenter"):
        fp.indent(BODY, ball, radius=[1e-7, 0.96e-6])
    with pytest.raises(ValueError, match=r"up to 200000 of them, .* are solved .* Check the units"):
        fp.indent(GEL, BALL, radius=3e5 * H)
    # the message names the contact that was asked for, not the radius at which the search stopped
    with pytest.raises(
        ValueError, match="depth = 10 km needs a contact radius above 200 mm, the largest that is solved"
    ):
        fp.indent(GEL, BALL, depth=1e4)
    with pytest.raises(ValueError, match="up to 200000 of them"):
        fp.flat_punch(GEL, 3e5 * H)


@pytest.mark.parametrize(
    "tip", [BALL, fp.Pyramid(3, 0.3), fp.Truncated(fp.Cone(0.2), 1e-8)], ids=["ball", "pyramid", "cut"]
)
@pytest.mark.parametrize(("name", "unit"), [("depth", "1 Mm"), ("force", r"1e\+18 TN")])
def test_what_no_layer_resolves_is_refused_at_once_and_by_name(tip, name, unit):
    start = time.process_time()
    with pytest.raises(ValueError, match=f"{name} = {unit} is far beyond this body: the contact would be wider than"):
        fp.indent(GEL, tip, **{name: 1e6 if name == "depth" else 1e30})
    # one flat punch, about half a second; a search up to there took 4 to 20 seconds
    assert time.process_time() - start < 3


@pytest.mark.parametrize("size", [1e-300, 1e280])
def test_targets_out_of_all_proportion_are_refused_instead_of_missed(size):
    with pytest.raises(ValueError, match="Check the units"):
        fp.indent(BODY, fp.PowerLaw(1.5, 1.0), depth=size)


def test_radius_cannot_control_a_flat_end():
    with pytest.raises(ValueError, match=r"its contact radius never changes\. Give depth or force"):
        fp.indent(GEL, fp.Cylinder(H), radius=H)


def test_the_reach_of_a_ball_itself_is_within_reach():
    # 0.95 R computed in two ways differs by rounding
    for radius in (0.95 * H, 0.95e-6):
        curve = fp.indent(BODY, fp.Sphere(H), radius=radius)
        for name in ("depth", "force"):
            again = fp.indent(BODY, fp.Sphere(H), **{name: float(curve[name][0])})
            assert float(again["radius"][0]) == pytest.approx(0.95 * H, rel=1e-14)


@pytest.mark.parametrize("medium", [BODY, GEL], ids=["half-space", "gel"])
@pytest.mark.parametrize(
    "indenter", [BALL, fp.Cone(0.3), fp.Pyramid(3, 0.3), fp.Sphere(H), fp.EllipticParaboloid(1e5, 2e5)], ids=repr
)
@pytest.mark.parametrize("name", ["depth", "force", "radius"])
def test_nothing_touched_gives_zeros(medium, indenter, name):
    curve = fp.indent(medium, indenter, **{name: [0.0, 1e-9 if name != "force" else 1e-12, 0.0]})
    for quantity in ("depth", "force", "radius", "area", "stiffness"):
        values = curve[quantity].values
        assert values[0] == values[2] == 0
        assert values[1] > 0
    assert np.all(curve["contour"].values[0] == 0)
    assert curve["valid"].all()


def test_scalars_sequences_and_arrays_are_one_curve():
    one = fp.indent(GEL, BALL, depth=1e-7)
    assert one["depth"].shape == (1,)
    for depth in ([1e-7], (1e-7,), np.array([1e-7]), np.float32(1e-7), np.array(1e-7)):
        again = fp.indent(GEL, BALL, depth=depth)
        # float32 has 6e-8
        np.testing.assert_allclose(again["force"], one["force"], rtol=3e-7)


def test_order_of_the_targets_is_kept():
    depth = np.array([3e-7, 1e-8, 2e-7, 1e-8, 0.0])
    curve = fp.indent(GEL, BALL, depth=depth)
    np.testing.assert_array_equal(curve["depth"], depth)
    alone = np.array([float(fp.indent(GEL, BALL, depth=d)["force"][0]) for d in depth])
    # each solved by itself: the same Newton iteration from other brackets
    np.testing.assert_allclose(curve["force"], alone, rtol=1e-11)


def test_dataset_says_what_was_solved():
    curve = fp.indent(GEL, fp.Pyramid(4, 0.3), force=[1e-10, 1e-9], angles=8, method="first-order")
    assert dict(curve.sizes) == {"step": 2, "phi": 8}
    units = {name: variable.attrs.get("units") for name, variable in curve.data_vars.items()}
    assert (
        units.items()
        >= {
            "depth": "m",
            "force": "N",
            "radius": "m",
            "area": "m^2",
            "stiffness": "N/m",
            "contour": "m",
        }.items()
    )
    assert curve["phi"].attrs["units"] == "rad"
    np.testing.assert_allclose(curve["phi"], np.arange(8) * np.pi / 4, rtol=1e-15)
    assert curve["valid"].dtype == bool
    assert curve.attrs["method"] == "first-order"
    assert curve.attrs["control"] == "force"
    assert curve.attrs["flatpunch_version"] == fp.__version__
    medium = json.loads(curve.attrs["medium"])
    assert medium["type"] == "Medium"
    assert medium["layers"][0] == {"type": "Layer", "young": 5e3, "poisson": 0.5, "thickness": H, "bonded": True}
    assert medium["base"] == {"type": "RigidBase"}
    assert json.loads(curve.attrs["indenter"]) == {"type": "Pyramid", "sides": 4, "inclination": 0.3}
    for variable in curve.data_vars.values():
        assert variable.attrs["long_name"]


def test_a_shape_of_the_users_own_can_be_pressed():
    class Mine(fp.indenters.Indenter):
        """A paraboloid of somebody who defines what differs."""

        round = True

        def height(self, r, phi):
            return r**2 / (10 * H) + 0 * phi

        def slope(self, r, phi):
            return r / (5 * H) + 0 * phi

    curve, known = (fp.indent(GEL, i, depth=[1e-8, 2e-7]) for i in (Mine(), BALL))
    np.testing.assert_allclose(curve["force"], known["force"], rtol=1e-11)
    assert json.loads(curve.attrs["indenter"]) == {"type": "Mine"}


def test_pressure_keeps_the_shape_of_its_points():
    x, y = np.meshgrid(np.linspace(-H, H, 5), np.linspace(-H, H, 3))
    field = fp.pressure(GEL, BALL, x, y, depth=1e-7)
    assert field.shape == (3, 5)
    assert fp.pressure(GEL, BALL, 0.0, 0.0, depth=1e-7).shape == ()
    assert fp.pressure(GEL, BALL, [], [], depth=1e-7).shape == (0,)
    np.testing.assert_array_equal(fp.pressure(GEL, BALL, x, y, depth=0.0), 0.0)
    row = fp.pressure(GEL, BALL, x[0], 0.0, depth=1e-7)
    assert row.shape == (5,)
    np.testing.assert_allclose(row, row[::-1], rtol=1e-12)
