"""The tabs *Correct*, *Coating*, *Slip* and *Compare formulas* without a browser: the numbers and files of the command line."""

import json
import runpy
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import flatpunch as fp
from flatpunch.app.form import address_of, case_data, case_text, fields_of, form_of
from flatpunch.app.jobs.coating import QUANTITIES, coating
from flatpunch.app.jobs.formulas import correct_modulus
from flatpunch.app.jobs.press import slip
from flatpunch.app.page import start
from flatpunch.app.tabs import TABS
from flatpunch.cli.app import app
from flatpunch.files import load
from flatpunch.fits.fitting import forget_models

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def form(name, **more):
    """Form of a shipped case; empty texts take a field out."""
    found = form_of(tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8"))) | more
    return {name: text for name, text in found.items() if text}


def coat(**more):
    return form("hard_coating_on_steel", **{"map": "", **more})


GEL = form("fit/thin_gel", **{"control.quantity": "depth", "control.values": '["50 nm", "300 nm", "600 nm"]'})
COAT = coat()
SLIP = form("sphere_fretting_on_coating", **{"control.points": "2", "slip.displacement": '["50 nm", "120 nm", "1 um"]'})
MAP = coat(**{"map": "on", "vary.layers.0.thickness": "1 um:9 um:3:log", "control.points": "2"})


@pytest.mark.long
@pytest.mark.parametrize(
    ("tab", "fields", "command"),
    [
        ("correct", GEL, ["correct"]),
        ("compare", GEL, ["compare"]),
        ("coating", COAT, ["stress"]),
        ("coating", MAP, ["sweep", "--fresh"]),
        ("slip", SLIP, ["slip"]),
    ],
    ids=["correct", "compare", "stresses", "map", "slip"],
)
def test_files_are_those_of_the_command_line(ask, tmp_path, monkeypatch, capsys, tab, fields, command):
    """From the case file that the page saves: CSV byte for byte, NetCDF value for value, and the Python lines."""
    monkeypatch.chdir(tmp_path)
    # whatever the page has solved before
    for depth in ("500 nm", "20 nm"):
        ask.solve("correct", GEL | {"correct.depth": depth})
    saved = {kind: ask.post(f"/file/{tab}.{kind}", fields) for kind in ("toml", "csv", "nc", "py", "svg")}
    for answer in saved.values():
        assert answer.status == 200, answer.content
        (tmp_path / answer.name).write_bytes(answer.content)
    assert b"<svg" in saved["svg"].content
    output = ["-o", "line.nc", "--csv", "line.csv"] if tab == "coating" else ["-o", "line.csv"]
    forget_models()
    ran = CliRunner().invoke(app, [*command, saved["toml"].name, *output], env={"COLUMNS": "300"})
    assert ran.exit_code == 0, ran.output
    assert saved["csv"].content == (tmp_path / "line.csv").read_bytes()
    if tab != "coating":
        forget_models()
        assert CliRunner().invoke(app, [*command, saved["toml"].name, "-o", "line.nc"]).exit_code == 0
    page, line = load(tmp_path / saved["nc"].name), load(tmp_path / "line.nc")
    assert page.identical(line) or page.drop_attrs().identical(line.drop_attrs())
    assert len(saved["py"].content.decode().strip().splitlines()) in (5, 6)
    forget_models()
    runpy.run_path(saved["py"].name)
    printed = capsys.readouterr().out
    assert printed
    if tab == "correct":
        assert printed.strip() in ran.stdout


@pytest.mark.long
def test_what_is_shown_is_what_the_command_line_prints(ask):
    found = ask.solve("correct", GEL)
    forget_models()
    assert found["summary"] in CliRunner().invoke(app, ["correct", str(EXAMPLES / "fit" / "thin_gel.toml")]).stdout
    # the curve of this example was made with 2.6 kPa
    assert found["young"] == pytest.approx(2600, rel=5e-3)
    stress = (
        CliRunner().invoke(app, ["stress", str(EXAMPLES / "hard_coating_on_steel.toml")], env={"COLUMNS": "300"}).stdout
    )
    shown = ask.solve("coating", COAT)
    assert shown["first"]["line"] in stress
    for row in shown["rows"]:
        assert all(cell in stress for cell in row)


def test_every_example_is_a_case_of_its_tab():
    examples = start()["examples"]
    assert {example["tab"] for example in examples} == set(TABS)
    for example in examples:
        fields, tab = fields_of(example["form"]), example["tab"]
        data = case_data(fields, tab)
        # the case file that is saved holds all that the tab reads
        assert case_data(form_of(tomllib.loads(case_text(fields, tab))), tab) == data, example["title"]


def test_strengths_stay_with_their_layer():
    moved = dict(COAT)
    for name, text in {"young": "80 GPa", "poisson": "0.3", "thickness": "1 um"}.items():
        moved[f"layers.1.{name}"] = text
    assert case_data(moved, "coating")["stress"]["strengths"] == [
        {"yield_stress": "8 GPa", "tensile": "2 GPa", "interface_shear": "0.8 GPa"},
        {},
        {"yield_stress": "2 GPa"},
    ]
    assert case_data(moved, "coating")["stress"]["residual_stress"] == ["-1 GPa", "0 Pa"]
    turned = {
        name.replace("layers.0.", "layers.9.").replace("layers.1.", "layers.0.").replace("layers.9.", "layers.1."): text
        for name, text in moved.items()
    }
    assert case_data(turned, "coating")["stress"]["strengths"][:2] == [
        {},
        {"yield_stress": "8 GPa", "tensile": "2 GPa", "interface_shear": "0.8 GPa"},
    ]
    assert case_data(turned, "coating")["stress"]["residual_stress"] == ["0 Pa", "-1 GPa"]
    data = case_data(moved, "coating")
    assert case_data(fields_of(address_of(form_of(data))), "coating") == data


@pytest.mark.parametrize(
    ("change", "field", "words"),
    [
        ({"layers.0.stress.tensile": "x"}, "layers.0.stress.tensile", "does not start with a number"),
        ({"base.stress.yield_stress": "-1 GPa"}, "base.stress.yield_stress", "must be finite and > 0"),
        ({"layers.0.stress.residual_stress": "-1 N"}, "layers.0.stress.residual_stress", "dimension of a force"),
        ({"layers.0.stress.residual_stress": "-9 GPa"}, "layers.0.stress.residual_stress", "alone exceeds"),
        ({"stress.friction": "-1"}, "stress.friction", "must be finite and >= 0"),
        ({"map": "on", "vary.layers.0.thickness": "1um:2"}, "vary.layers.0.thickness", "is no range"),
        ({"map": "on", "vary.layers.0.thickness": "1N:2N:3"}, "vary.layers.0.thickness", "dimension of a force"),
        ({"map": "on", "vary.layers.0.thickness": ""}, "vary.layers.0.thickness", "is missing"),
        ({"map": "on", "vary.layers.0.thickness": "-1um:1um:3"}, "vary.layers.0.thickness", "describe no case"),
        ({"map": "on", "vary.layers.0.thickness": "1um:9um:999999999"}, "vary.layers.0.thickness", "must be a whole"),
        ({"stress.x": '{ start = "0 m", stop = "1 um", points = 999999999 }'}, "stress.x", "points"),
        ({"layers.0.stress.tensile": "[" * 30 + "]" * 30}, "layers.0.stress.tensile", "does not start with"),
        ({"map": "on", "vary.base.yong": "1GPa:2GPa:3"}, "vary.base.yong", "did you mean 'base.young'"),
        ({"control.quantity": "depth", "control.start": "-2 nm", "control.stop": "-1 nm"}, "control.start", "must be"),
    ],
)
def test_problems_of_coatings_find_their_field(change, field, words):
    problems = coating(coat(**change), True)["problems"]
    assert any(problem["field"] == field and words in problem["text"] for problem in problems), problems


@pytest.mark.parametrize(
    ("change", "field", "words"),
    [
        ({"correct.reported": "", "correct.depth": ""}, "correct.reported", "is missing"),
        ({"correct.depth": ""}, "correct.depth", "is missing"),
        ({"correct.reported": "8 N"}, "correct.reported", "dimension of a force"),
        ({"correct.depth": "-3 nm"}, "correct.depth", "> 0"),
        ({"correct.poisson": "0.7"}, "correct.poisson", "0.5"),
        ({"correct.model": "sneddon"}, "correct.model", "does not belong to a Sphere"),
        (
            {"layers.0.young": '{ law = "linear", top = "5 kPa", bottom = "9 kPa" }'},
            "layers.0.young",
            "homogeneous layer",
        ),
    ],
)
def test_problems_of_corrections_find_their_field(change, field, words):
    problems = correct_modulus({name: text for name, text in (GEL | change).items() if text}, True)["problems"]
    assert any(problem["field"] == field and words in problem["text"] for problem in problems), problems


@pytest.mark.parametrize(
    ("change", "field", "words"),
    [
        ({"slip.friction": ""}, "slip.friction", "is missing"),
        ({"slip.friction": "-1"}, "slip.friction", "must be finite and > 0"),
        ({"slip.friction": "0.3 N"}, "slip.friction", "plain number"),
        ({"slip.friction": "nan"}, "slip.friction", "plain number"),
        ({"slip.friction": "[0.1, 0.2]"}, "slip.friction", "plain number"),
        ({"slip.friction": "{" * 40}, "slip.friction", "plain number"),
        ({"slip.displacement": "5 N"}, "slip.displacement", "dimension of a force"),
        ({"slip.displacement": '["5 nm", "-1 nm"]'}, "slip.displacement", "must be"),
        ({"slip.displacement": "{ start = 1 }"}, "slip.displacement", "has no unit"),
        ({"slip.displacement": '{ start = "0 m", stop = "1 um", points = 999999999 }'}, "slip.displacement", "points"),
        ({"slip.displacement": "[" * 40 + "]" * 40}, "slip.displacement", "does not start with a number"),
        ({"slip.displacement": "", "slip.tangential_force": "5 N"}, "slip.tangential_force", "friction times"),
        ({"slip.displacement": "", "slip.stick_radius": "5 mm"}, "slip.stick_radius", "the radius of the contact"),
        ({"slip.stick_radius": "5 um"}, "slip", "exactly one of tangential_force, stick_radius and displacement"),
        ({"slip.friction.x": "0.3"}, "slip.friction.x", "lies in a field that has a value of its own"),
        ({"slip.fricton": "0.3"}, "slip.fricton", "did you mean 'friction'"),
        ({"indenter.kind": "cylinder", "indenter.radius": "5 um"}, "", "has a flat end"),
        ({"layers.0.bonded": "false"}, "", "slides without friction"),
        ({"control.quantity": "history"}, "", "[control]"),
        ({"control.start": "-1 N"}, "control.start", "must be"),
        ({"more": "[slip]\nfriction = 0.2"}, "more", "has fields of its own"),
    ],
)
def test_problems_of_slip_find_their_field(change, field, words):
    fields = {name: text for name, text in (SLIP | change).items() if text}
    problems = slip(fields, True)["problems"]
    assert any(problem["field"].startswith(field) and words in problem["text"] for problem in problems), problems


def test_slip_is_shown_as_the_command_line_prints_it(ask):
    shown = ask.solve("slip", SLIP)
    case = fp.read_case(EXAMPLES / "sphere_fretting_on_coating.toml")
    moved = [50e-9, 120e-9, 1e-6]
    pulled = fp.partial_slip(case.medium, case.indenter, friction=0.4, force=5.0, displacement=moved)
    np.testing.assert_allclose(shown["first"], [[0, *moved], [0, *pulled.tangential_force.values]], rtol=1e-4)
    assert len(shown["table"]["rows"]) == 3
    # to and fro between both ends
    ends = np.array(shown["cycle"])[:, [0, 3, 4, 7]]
    np.testing.assert_allclose(ends, np.array(shown["first"])[:, [-1]] * [1, -1, -1, 1], rtol=1e-4)
    many = SLIP | {"slip.displacement": '{ start = "0 nm", stop = "100 nm", points = 401 }'}
    assert "401" not in ask.solve("slip", many, run=False)["long"]


@pytest.mark.long
def test_maps_wait_for_the_button_and_need_a_strength():
    assert "long" in coating(MAP, False)
    weak = {name: text for name, text in MAP.items() if ".stress." not in name}
    assert "give a strength" in coating(weak, False)["problems"][0]["text"]
    assert coating({name: text for name, text in weak.items() if name != "map"}, False)["first"] is None


@pytest.mark.long
def test_map_is_that_of_critical_load(ask):
    study = ask.solve("coating", MAP)["study"]
    case = fp.read_case(EXAMPLES / "hard_coating_on_steel.toml")
    for thickness, force, place in zip(study["values"][0], study["force"], study["places"], strict=True):
        film = fp.Medium([fp.Layer(200e9, 0.25, thickness)], base=case.medium.base)
        first = fp.critical_load(
            film, case.indenter, list(case.stress.strengths), friction=0.15, residual_stress=[-1e9]
        )
        assert force == first.force
        assert place == f"{first.kind}, layer {first.layer + 1}"


def test_every_quantity_of_the_section_can_be_drawn(ask):
    ask.solve("coating", COAT)
    for i in range(len(QUANTITIES)):
        state = json.loads(ask.post(f"/api/detail?tab=coating&name=quantity&step={i}", COAT).content)
        while "key" in state:
            state = json.loads(ask.get(f"/api/job?key={state['key']}").content)
        values = np.array(state["result"]["values"], dtype=float)
        assert values.shape == (81, 121)
        assert np.isfinite(values).all()
    # von Mises stress over yield stress, which jumps at the interface: 1.6 of 8 and 2.2 of 2 GPa
    assert 1.0 < values.max() < 1.2


def test_compare_says_how_far_formulas_hold(ask):
    found = ask.solve("compare", GEL)
    assert found["names"][:3] == ["Hertz", "Dimitriadis", "Garcia"]
    hertz = found["deviation"][0]
    # the gel is stiffer than a half-space of it, the more so the deeper
    assert 0 > hertz[0] > hertz[1] > hertz[2]
    refused = ask.solve("compare", GEL | {"indenter.kind": "berkovich", "indenter.radius": ""})
    assert "no half-space formula is in use" in refused["problems"][0]["text"]
