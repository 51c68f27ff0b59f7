"""The tab *Fit* without a browser: previews, fits as on the command line, all curves of a file, files that are no curves."""

import json
import runpy
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flatpunch.app.form import FormError, case_text, form_of
from flatpunch.app.jobs.fit import fit_curve, preview
from flatpunch.app.store import Upload, Uploads
from flatpunch.cli.app import app

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "fit"
CURVE = (EXAMPLES / "thin_gel.csv").read_bytes()
STUCK = {"work_of_adhesion": "1 mJ/m^2", "strength": "1 MPa"}
PYRAMID = {"indenter.kind": "pyramid", "indenter.sides": "4", "indenter.inclination": "20 deg", "indenter.radius": ""}


def gel(**more):
    """Form of the shipped fit."""
    return {
        **form_of(tomllib.loads((EXAMPLES / "thin_gel.toml").read_text(encoding="utf-8"))),
        "upload": "shipped/thin_gel.csv",
        **more,
    }


@pytest.mark.long
def test_fit_is_that_of_the_command_line(ask, tmp_path):
    ran = CliRunner().invoke(
        app,
        ["fit", str(EXAMPLES / "thin_gel.csv"), str(EXAMPLES / "thin_gel.toml"), "-o", str(tmp_path / "a.csv")],
        env={"COLUMNS": "300"},
    )
    assert ran.exit_code == 0, ran.output
    sent = json.loads(ask.post("/api/curve?name=thin_gel.csv", body=CURVE).content)["upload"]
    form = gel(upload=sent)
    found = ask.solve("fit", form)
    assert found["summary"] in ran.stdout
    assert [row[0] for row in found["rows"]] == ["Young's modulus of layer 1", "contact point", "baseline"]
    assert ask.post("/file/fit.csv", form).content == (tmp_path / "a.csv").read_bytes()
    for kind in ("toml", "py"):
        saved = ask.post(f"/file/fit.{kind}", form)
        (tmp_path / saved.name).write_bytes(saved.content)
    assert len(saved.content.decode().strip().splitlines()) == 6
    (tmp_path / "thin_gel.csv").write_bytes(CURVE)
    ran = subprocess.run([sys.executable, saved.name], cwd=tmp_path, check=True, capture_output=True, text=True)
    assert ran.stdout.strip() == found["summary"]
    assert ask.post("/file/fit.png", form).content.startswith(b"\x89PNG")


def test_preview_says_what_is_taken_for_what():
    found = preview(gel(), Upload("thin_gel.csv", CURVE))
    assert found["roles"] == {"depth": 0, "force": 1}
    assert found["columns"] == [["depth", "nm"], ["force", "nN"]]
    assert found["count"] == 1
    assert found["points"] == 800
    parts = {each["name"]: len(each["depth"]) for each in found["traces"]}
    assert parts == {"approach": 800, "baseline": 800, "contact": 2}


@pytest.mark.long
def test_columns_are_chosen_in_the_form():
    text = CURVE.decode().replace("depth (nm)", "way").replace("force (nN)", "signal")
    upload = Upload("a.csv", text.encode())
    problem = preview(gel(), upload)["problems"][0]
    assert problem["field"] == "curve.columns.depth"
    assert problem["text"] == "no column of depth recognised: choose one of the file's columns here."
    assert fit_curve(gel(), True, upload)["problems"] == [problem]
    chosen = {
        "curve.columns.depth": "way",
        "curve.columns.force": "signal",
        "curve.units.depth": "nm",
        "curve.units.force": "nN",
    }
    assert "problems" not in preview(gel(**chosen), upload)
    assert "summary" in fit_curve(gel(**chosen), True, upload)


@pytest.mark.long
def test_all_curves_of_a_file_are_fitted(ask, tmp_path, monkeypatch):
    lines = CURVE.decode().splitlines()
    two = "\n".join([*lines, "second curve,,", *lines]).encode()
    upload = Upload("map.csv", two)
    assert preview(gel(), upload)["count"] == 2
    assert "holds 2 curves" in fit_curve(gel(), True, upload)["problems"][0]["text"]
    found = fit_curve(gel(all="on"), True, upload)
    monkeypatch.chdir(tmp_path)
    form = gel(all="on", upload=json.loads(ask.post("/api/curve?name=map.csv", body=two).content)["upload"])
    for kind in ("toml", "py"):
        saved = ask.post(f"/file/fit.{kind}", form)
        Path(saved.name).write_bytes(saved.content)
    Path("map.csv").write_bytes(two)
    runpy.run_path(saved.name)
    assert Path(saved.name).with_suffix(".csv").read_bytes() == ask.post("/file/fit.csv", form).content
    assert found["all"]["caption"] == "2 of 2 curves fitted"
    assert len(found["all"]["rows"]) == 2


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"layers.0.young.min": "6 kPa"}, "layers.0.young"),
        ({"layers.0.young.max": "6 kN"}, "layers.0.young"),
        ({"layers.0.young.min": "-6 kPa"}, "layers.0.young"),
        ({**STUCK, **PYRAMID}, "strength"),
        ({"fit.baseline": "wavy"}, "fit.baseline"),
        ({"fit.depth_to": "3 N"}, "fit.depth_to"),
        ({"curve.spring_constant": "3 N"}, "curve.spring_constant"),
        ({"layers.0.poisson.fit": "on", "layers.0.poisson": "x"}, "layers.0.poisson"),
    ],
)
def test_problems_find_their_field(change, field):
    form = {name: text for name, text in gel(**change).items() if text}
    found = fit_curve(form, True, Upload("thin_gel.csv", CURVE))
    assert [problem["field"] for problem in found["problems"]] == [field], found


@pytest.mark.parametrize(
    "upload",
    [
        Upload("a.csv", b""),
        Upload("a.csv", b"\x00" * 1000),
        Upload("a.xlsx", b"PK\x03\x04 no archive"),
        Upload("a.jpk-force", b"no archive"),
        Upload("a.exe", CURVE),
        Upload("a.csv", b"depth (nm),force (nN)\n1,2\n"),
    ],
    ids=lambda upload: f"{upload.name}-{len(upload.content)}",
)
def test_files_that_are_no_curves_are_messages(upload):
    for found in (preview(gel(), upload), fit_curve(gel(), True, upload)):
        (problem,) = found["problems"]
        assert problem["field"] == "upload"
        assert "mistake of flatpunch" not in problem["text"]


@pytest.mark.parametrize("size", [500_000, pytest.param(20_000_000, marks=pytest.mark.slow)])
def test_large_files_are_read(size):
    lines = CURVE.decode().splitlines()
    rows = lines[1:]
    # the same points again and again, between each other
    many = [lines[0], *(row for row in rows for _ in range(size // (len(rows) * 13)))]
    upload = Upload("large.csv", "\n".join(many).encode())
    assert len(upload.content) > 0.9 * size
    found = preview(gel(), upload)
    assert found["points"] > size / 16
    assert all(len(each["depth"]) <= 1500 for each in found["traces"])


def test_names_of_uploads_lead_nowhere(tmp_path):
    kept = Uploads()
    for name in ("../../etc/passwd", "..\\..\\boot.ini", "/etc/passwd", "a/b.csv", "", "\0", "x" * 500 + ".csv", ".."):
        key = kept.put(name, b"1")
        with kept.get(key).written() as path:
            assert path.read_bytes() == b"1"
            assert path.parent.name.startswith("flatpunch-")
        assert not path.exists()
    for key in ("shipped/../../pyproject.toml", "shipped/thin_gel.toml", "guessed/a.csv", ""):
        with pytest.raises(FormError):
            kept.get(key)


def test_an_upload_that_is_gone_is_said_beside_the_file(ask):
    found = json.loads(ask.post("/api/solve?tab=fit&run=1", gel(upload="0" * 64 + "/old.csv")).content)
    assert found["problems"] == [{"field": "upload", "text": "old.csv is no longer in memory; drop it here again."}]


def test_drift_over_depth_tells_the_layer_from_a_half_space(ask):
    form = gel()
    ask.solve("fit", form)
    state = json.loads(ask.post("/api/detail?tab=fit&name=drift", form).content)
    while "key" in state:
        state = json.loads(ask.get(f"/api/job?key={state['key']}").content)
    layered, bulk = state["result"]["layered"]["value"], state["result"]["half_space"]["value"]
    # made with 2.6 kPa
    assert all(abs(value / 2600 - 1) < 0.05 for value in layered)
    assert bulk[-1] > 1.5 * bulk[0]


def test_tables_of_other_tabs_are_left_out():
    assert "[correct]" not in case_text(gel(), "fit")
    assert "[control]" not in case_text(gel(**{"control.quantity": "depth", "control.values": "1 nm"}), "fit")
    assert "[curve]" not in case_text(gel(**{"curve.flip": "true"}), "press")


def test_a_fit_of_nothing_is_refused_with_the_box_to_tick():
    form = {name: value for name, value in gel().items() if not name.endswith(".fit")}
    (problem,) = fit_curve(form, True, Upload("thin_gel.csv", CURVE))["problems"]
    assert "tick “fit”" in problem["text"]
