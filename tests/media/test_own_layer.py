"""A layer kind of one's own, E = 3 G and nu = 1/2, in every use of a layer: equal to `Layer`, derivatives by the chain rule."""

from __future__ import annotations

import json
import runpy
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr

import flatpunch as fp
from flatpunch import kernels
from flatpunch.app.form import form_of
from flatpunch.app.jobs.common import case_of as plain_case_of
from flatpunch.app.jobs.press import sketch
from flatpunch.app.tables import page_tables
from flatpunch.compliances.response import uniform_compliance
from flatpunch.files.descriptions import describe_bodies
from flatpunch.media.paths import value_of, with_values
from support.rubber import RubberLayer

mpl.use("agg")

UM = 1e-6
SHEAR = 1.7e3
TIP, PYRAMID, PUNCH = fp.Sphere(10 * UM), fp.Pyramid(4, 0.3), fp.Cylinder(UM)
GLUE = fp.Interface(normal=3e9, shear=1e9)
BASE = fp.HalfSpace(2e3, 0.3)
SURFACE = fp.self_affine(16, UM / 10, rms_height=2e-9, seed=1)

Kind = Callable[..., Any]


def plain(shear: float, thickness: float, bonded: bool | fp.Interface = True) -> fp.Layer:
    """The same layer of the package."""
    return fp.Layer(3 * shear, 0.5, thickness, bonded)


def gel(kind: Kind) -> fp.Medium:
    return fp.Medium([kind(SHEAR, 2 * UM)], fp.RigidBase())


def coat(kind: Kind) -> fp.Medium:
    return fp.Medium([kind(SHEAR, 2 * UM), fp.Layer(9e3, 0.3, UM)], BASE)


def glued(kind: Kind) -> fp.Medium:
    return fp.Medium([fp.Layer(9e3, 0.3, UM), kind(SHEAR, 2 * UM, GLUE)], BASE)


def pair(kind: Kind) -> fp.TwoBodies:
    return fp.TwoBodies(coat(kind), gel(kind))


def many(kind: Kind) -> fp.Medium:
    return fp.Medium([kind(SHEAR * (1 + i / 5), UM / 2) for i in range(6)], BASE)


BODIES = (gel, coat, glued, pair, many)
_NO_VALUE = ("principal", "max_shear")  # eigenvalues of the stresses, which are compared themselves


def values(found: Any) -> dict[str, Any]:
    """All numbers of a result."""
    if isinstance(found, xr.Dataset):
        return {
            str(name): each.values
            for name, each in found.data_vars.items()
            if each.dtype.kind in "fcb" and name not in _NO_VALUE and "error" not in str(name)
        }
    if isinstance(found, (tuple, list)):
        return {str(i): np.asarray(each) for i, each in enumerate(found)}
    return {"": np.asarray(found)}


def same(use: Callable[[Kind], Any], rtol: float = 1e-13) -> None:
    """Both kinds of layer give the same to a share of the largest value of each quantity."""
    ours, theirs = values(use(RubberLayer)), values(use(plain))
    assert ours.keys() == theirs.keys()
    for name, expected in theirs.items():
        size = float(np.nanmax(np.abs(expected), initial=0.0))
        np.testing.assert_allclose(ours[name], expected, rtol=0, atol=rtol * size, err_msg=name)


@pytest.mark.parametrize("body", BODIES)
def test_compliance(body: Callable[[Kind], Any]) -> None:
    same(lambda kind: fp.compliance(body(kind))(np.geomspace(1e4, 1e8, 50)))
    same(lambda kind: uniform_compliance(body(kind)))


@pytest.mark.parametrize("body", BODIES)
def test_flat_punch_and_round_contact(body: Callable[[Kind], Any]) -> None:
    same(lambda kind: fp.flat_punch(body(kind), UM).stiffness)
    same(lambda kind: fp.indent(body(kind), PUNCH, depth=[1e-8, 1e-7]))
    same(lambda kind: fp.indent(body(kind), TIP, radius=[0.5 * UM, 2 * UM]))


def test_contact_that_is_not_round() -> None:
    same(lambda kind: fp.indent(coat(kind), PYRAMID, depth=[1e-7, 3e-7], method="second-order"))


def test_boundary_elements() -> None:
    # iterations end at a tolerance of 1e-9
    same(lambda kind: fp.indent(gel(kind), PYRAMID, depth=[2e-7], method=fp.BoundaryElements(32)).force.values, 1e-9)


@pytest.mark.parametrize("body", [gel, glued, pair])
def test_fields(body: Callable[[Kind], Any]) -> None:
    z = np.array([-1.5, -0.3, 0.4, 1.7]) * UM if body is pair else np.array([0.4, 1.7]) * UM
    same(lambda kind: fp.fields(body(kind), TIP, np.array([[0.0], [UM]]), 0.0, z, depth=2e-7))


def test_residual_stress() -> None:
    given = [100.0, 50.0]
    same(lambda kind: fp.fields(coat(kind), TIP, 0.0, 0.0, [0.4 * UM], depth=2e-7, residual_stress=given))


def test_energy() -> None:
    same(lambda kind: fp.energy_by_depth(coat(kind), TIP, depth=2e-7, z=[0.4 * UM]))


def test_critical_load() -> None:
    strong = [fp.Strength(yield_stress=400.0, interface_tension=900.0)] * 2

    def first(kind: Kind) -> tuple[Any, ...]:
        found = fp.critical_load(coat(kind), TIP, strong)
        return found.force, found.depth, found.radius

    # a search ends at a relative change of 1e-6 at most
    same(first, 1e-6)


def test_peak_stresses() -> None:
    # places are refined until the stress changes by less than 1e-8
    same(lambda kind: fp.peak_stresses(gel(kind), TIP, depth=2e-7)[["von_mises"]], 1e-8)


@pytest.mark.parametrize("body", [gel, coat, glued, pair])
def test_sensitivities_by_the_chain_rule(body: Callable[[Kind], Any]) -> None:
    """d ln F/d ln G is d ln F/d ln E, for the sensitivities are relative; all other numbers have the same."""
    ours, theirs = (fp.sensitivity(body(kind), TIP, depth=2e-7) for kind in (RubberLayer, plain))
    expected = {str(name): theirs.sel(parameter=name) for name in theirs.parameter.values}
    renamed = [str(name) for name in ours.parameter.values if str(name).endswith("].shear")]
    assert len(renamed) == (2 if body is pair else 1)
    for name in map(str, ours.parameter.values):
        other = name.replace("].shear", "].young") if name in renamed else name
        for quantity in ("force_sensitivity", "stiffness_sensitivity"):
            if quantity in ours:
                one, two = ours[quantity].sel(parameter=name), expected[other][quantity]
                np.testing.assert_allclose(one, two, rtol=1e-11, atol=1e-13)


def test_values_by_their_paths() -> None:
    medium = coat(RubberLayer)
    assert value_of(medium, TIP, "layers[0].shear") == SHEAR
    changed, _ = with_values(medium, TIP, {"layers[0].shear": 2e3})
    assert changed.layers[0].shear == 2e3
    changed, _ = with_values(medium, TIP, {"layers[0].young": 6e3})
    assert changed.layers[0].shear == pytest.approx(2e3, rel=1e-15)


def test_fit_of_its_modulus() -> None:
    depth = np.linspace(0, 4e-7, 60)
    force = fp.indent(gel(plain), TIP, depth=depth).force.values

    def fitted(kind: Kind) -> float:
        found = fp.fit(fp.Curve(depth, force), gel(kind), TIP, ["layers[0].young"])
        return float(found.values["layers[0].young"])

    assert fitted(RubberLayer) == pytest.approx(fitted(plain), rel=1e-9)


def test_adhesion() -> None:
    same(lambda kind: fp.indent(coat(kind), TIP, depth=[1e-7, 2e-7], work_of_adhesion=1e-6), 1e-12)

    def pulled(kind: Kind) -> tuple[float, ...]:
        found = fp.pull_off(coat(kind), TIP, work_of_adhesion=1e-6)
        return found.force, found.depth

    # the minimum of a curve: its force to rounding, its place to the root of it
    same(pulled, 1e-8)


@pytest.mark.parametrize("each", [False, True])
def test_relaxation(each: bool) -> None:
    law = fp.StandardLinearSolid(0.5, 2.0)
    relaxation: Any = [law] if each else law
    options: Any = {"time": [0.0, 1.0, 2.0], "relaxation": relaxation}
    same(lambda kind: fp.indent(gel(kind), TIP, depth=[0.0, 1e-7, 3e-7], **options).force.values, 1e-12)


def test_large_strain() -> None:
    same(lambda kind: fp.indent(gel(kind), TIP, depth=[1e-7], finite_strain="neo-hookean"))


@pytest.mark.long
def test_lift_off() -> None:
    same(lambda kind: fp.indent(fp.FreeLayer.of(kind(SHEAR, 2 * UM, False), BASE), TIP, radius=[UM, 2 * UM]))


def test_homogenised() -> None:
    def mean(kind: Kind) -> tuple[float, ...]:
        return fp.homogenised([kind(SHEAR, UM), fp.Layer(9e3, 0.3, UM), kind(2 * SHEAR, UM, GLUE)]).constants

    same(mean)


def test_rough() -> None:
    # conjugate gradients end at a tolerance of 1e-7
    same(lambda kind: fp.rough_contact(gel(kind), SURFACE, pressure=20.0)[["mean_pressure", "area_fraction"]], 1e-7)


@pytest.mark.parametrize("body", [gel, coat, glued])
def test_kernels(body: Callable[[Kind], Any]) -> None:
    q = np.geomspace(1e5, 1e7, 6)
    same(lambda kind: kernels.surface_compliance(body(kind), q, 0.5 * q))
    same(lambda kind: kernels.interior(body(kind), q, 0.5 * q, [0.4 * UM, 1.6 * UM]))
    same(lambda kind: kernels.influence_coefficients(body(kind), UM / 4, (4, 4)), 1e-9)


def test_plug_in_by_kernels(tmp_path: Path) -> None:
    from flatpunch.plugins.slippy import write_slippy_material

    texts = [
        write_slippy_material(tmp_path / f"{kind.__name__}.py", coat(kind)).read_text() for kind in (RubberLayer, plain)
    ]
    assert len(texts[0]) == pytest.approx(len(texts[1]), rel=0.01)


def test_pictures_and_description() -> None:
    fp.plot_medium(coat(RubberLayer))
    drawn = [sketch(coat(kind), TIP, UM, UM / 10) for kind in (RubberLayer, plain)]
    assert drawn[0] == drawn[1]
    assert "5.1 kPa  0.5" in str(gel(RubberLayer))
    lines = list(describe_bodies(gel(RubberLayer)))
    assert lines[0].startswith("Body      RubberLayer shear 1.7 kPa, thickness 2 µm, bonded to the base")
    record = json.loads(fp.indent(gel(RubberLayer), TIP, depth=1e-7).attrs["medium"])
    assert record["layers"][0] == {"type": "RubberLayer", "shear": SHEAR, "thickness": 2 * UM, "bonded": True}


def test_fit_of_its_own_number() -> None:
    depth = np.linspace(1e-9, 4e-7, 40)
    force = fp.indent(gel(plain), TIP, depth=depth).force.values
    start = fp.Medium([RubberLayer(2 * SHEAR, 2 * UM)], fp.RigidBase())
    found = fp.fit(fp.Curve(depth, force), start, TIP, ["layers[0].shear"], contact=0.0, baseline="none")
    assert found["layers[0].shear"] == pytest.approx(SHEAR, rel=1e-6)


CASE = """
layers = [{ kind = "rubber", shear = "1.7 kPa", thickness = "2 um", interface_shear = "3 GPa/m" }]
base = { kind = "rigid" }
indenter = { kind = "sphere", radius = "10 um" }
control = { depth = "100 nm" }
"""


def test_case_file_and_page(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    medium = fp.read_case(path).medium
    assert medium == fp.Medium([RubberLayer(SHEAR, 2 * UM, fp.Interface(shear=3e9))], fp.RigidBase())
    assert plain_case_of(form_of(tomllib.loads(CASE))).medium == medium
    fields = {field["name"]: field for field in page_tables()["layers"]["rubber"]["fields"]}
    assert (fields["shear"]["label"], fields["shear"]["value"]) == ("Shear modulus", "5 kPa")
    assert "young" not in fields


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"1.7 kPa"', '"-1 kPa"', r"layers\[0\].shear = '-1 kPa' must be finite and > 0"),
        ('"1.7 kPa"', '"1 um"', r"layers\[0\].shear = '1 um' has the dimension of a length"),
        ('shear = "1.7 kPa",', "", r"layers\[0\].shear is missing; it needs a pressure such as '5 kPa'"),
        ("shear =", "shaer =", r"layers\[0\].shaer is no known field; did you mean 'shear'"),
        ('"rubber"', '"rubbr"', r"layers\[0\].kind = 'rubbr' is unknown; it is one of 'rubber'"),
        ('"rubber"', "3", r"layers\[0\].kind = 3 is unknown; it is one of 'rubber'"),
    ],
)
def test_messages_of_its_case_file(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "case.toml"
    path.write_text(CASE.replace(old, new, 1))
    with pytest.raises(fp.files.CaseError, match=message):
        fp.read_case(path)


def test_plug_in_by_numbers(tmp_path: Path) -> None:
    from flatpunch.plugins.force_models import write_nanite_model

    runpy.run_path(str(write_nanite_model(tmp_path / "model.py", gel(RubberLayer), TIP)))
