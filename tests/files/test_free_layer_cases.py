"""Case files of a layer that lifts off: what they build and solve, and what they refuse."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import flatpunch as fp
from flatpunch.app.form import form_of
from flatpunch.app.jobs.press import press, pressure_map
from flatpunch.cli.app import app
from flatpunch.files import CaseError, describe
from flatpunch.fits.case import read_fit_case

LAYER = """
[[layers]]
young = "1 MPa"
poisson = 0.3
thickness = "1 mm"
lifts_off = true
"""
BASE = """
[base]
kind = "rigid"
"""
REST = """
[indenter]
kind = "paraboloid"
radius = "5 mm"

[control]
depth = ["10 um", "100 um"]
"""
ELASTIC = 'kind = "half-space"\nyoung = "10 MPa"\npoisson = 0.3'


@pytest.fixture
def case(tmp_path):
    def written(text) -> Path:
        path = tmp_path / "sheet.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return written


@pytest.mark.long
@pytest.mark.parametrize(
    ("base", "body"), [('kind = "rigid"', fp.RigidBase()), (ELASTIC, fp.HalfSpace(10e6, 0.3))], ids=["rigid", "elastic"]
)
def test_solved_as_in_python_and_read_back(case, base, body, tmp_path):
    path = case(LAYER + BASE.replace('kind = "rigid"', base) + REST)
    sheet = fp.read_case(path)
    assert sheet.medium == fp.FreeLayer(1e6, 0.3, 1e-3, body)
    assert any("the layer lifts off" in line for line in describe(sheet))
    target = tmp_path / "sheet.nc"
    done = CliRunner().invoke(app, ["solve", str(path), "-o", str(target)])
    assert done.exit_code == 0, done.output
    assert "base radius" in done.output
    expected = fp.indent(sheet.medium, fp.Paraboloid(5e-3), depth=[1e-5, 1e-4])
    for name in ("force", "radius", "base_radius"):
        assert fp.load(target)[name].values.tolist() == expected[name].values.tolist()


@pytest.mark.long
def test_pictures_sweeps_and_the_page(case, tmp_path):
    path = case(LAYER + BASE + REST)
    picture = tmp_path / "medium.png"
    assert CliRunner().invoke(app, ["show-medium", str(path), "-o", str(picture)]).exit_code == 0
    assert picture.stat().st_size > 1000
    swept = fp.sweep(path, {"layers.0.thickness": "0.5 mm:2 mm:2"})
    assert (np.diff(swept["base_radius"].values, axis=0) > 0).all()
    form = form_of(tomllib.loads(path.read_text(encoding="utf-8")))
    shown = press(form, True)
    assert "base radius" in [name for name, _ in shown["table"]["columns"]]
    assert [layer["bonded"] for layer in shown["sketch"]["layers"]] == [False]
    assert "lifts off" in pressure_map(form, shown["kept"], 0)["none"]
    json.dumps({name: value for name, value in shown.items() if name != "kept"})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (LAYER + LAYER + BASE + REST, r"layers\[0\].lifts_off = True is solved for one homogeneous"),
        (LAYER.replace("true", "false") + LAYER + BASE + REST, r"layers\[1\].lifts_off = True"),
        (LAYER.replace('"1 MPa"', '{ formula = "1e6 + z" }') + BASE + REST, "lifts_off = True is solved"),
        (LAYER + 'interface_shear = "1 GPa/um"' + BASE + REST, "lifts_off = True is solved"),
        (
            LAYER
            + '[base]\nkind = "power-law-half-space"\nmodulus = "1 MPa"\ndepth = "1 mm"\nexponent = 0.5\npoisson = 0.3\n'
            + REST,
            "lifts_off = True is solved",
        ),
        ('method = "bem"\n' + LAYER + BASE + REST, "method = 'bem' takes the layer as held down"),
        ('work_of_adhesion = "1 mJ/m^2"\n' + LAYER + BASE + REST, "work_of_adhesion does not go with a FreeLayer"),
        (LAYER + BASE + REST + "[stress]\n", "stress does not go with a FreeLayer"),
        (LAYER + BASE + REST.replace('"paraboloid"\nradius = "5 mm"', '"vickers"'), "is not round"),
        (LAYER + BASE + REST.replace('depth = ["10 um", "100 um"]', 'radius = "21 mm"'), "hardly lifts off there"),
        (
            LAYER + BASE + '[indenter]\nkind = "cylinder"\nradius = "1 mm"\n[control]\nradius = "1 mm"\n',
            "radius cannot control a cylinder",
        ),
        (
            LAYER.replace("[[layers]]", "[[upper.layers]]")
            + BASE.replace("base", "upper.base")
            + BASE.replace("base", "lower.base")
            + REST,
            r"lifts_off = True goes with neither two bodies",
        ),
    ],
)
def test_refusals(case, text, words):
    with pytest.raises(CaseError, match=words):
        fp.read_case(case(text))


@pytest.mark.long
def test_fits_and_stresses_refuse(case):
    fitted = LAYER.replace('"1 MPa"', '{ fit = "1 MPa" }') + BASE + REST
    with pytest.raises(CaseError, match=r"layers\[0\].lifts_off = True goes with neither two bodies, fits"):
        read_fit_case(case(fitted))
    done = CliRunner().invoke(app, ["stress", str(case(LAYER + BASE + REST))])
    assert done.exit_code != 0
    assert "lifts off" in done.output
