"""Requests of the page, without a browser: numbers and files of the command line, jobs that are stopped, what is refused."""

import json
import subprocess
import sys
import tomllib
from urllib.parse import urlencode

import numpy as np
import pytest
from typer.testing import CliRunner

import flatpunch as fp
from flatpunch.app.form import form_of
from flatpunch.app.page import read_case_text, start
from flatpunch.app.store import Store
from flatpunch.cli.app import app
from flatpunch.files import shipped_cases

FILM = next(path for path in shipped_cases() if path.stem == "elliptic_tip_on_carbon_film")
SLOW = {
    "method": "bem",
    "control.quantity": "depth",
    "control.start": "10 nm",
    "control.stop": "100 nm",
    "control.points": "500",
}


def film():
    """Form of a shipped case that takes milliseconds."""
    return form_of(tomllib.loads(FILM.read_text(encoding="utf-8")))


def test_numbers_are_those_of_the_command_line_digit_for_digit(ask, tmp_path):
    assert CliRunner().invoke(app, ["solve", str(FILM), "--csv", str(tmp_path / "a.csv")]).exit_code == 0
    expected = fp.load(tmp_path / "a.csv")
    shown = ask.solve("press", film())
    for name in ("depth", "force", "radius", "stiffness", "area", "force_error"):
        assert shown["curve"][name] == expected[name].values.tolist(), name
    saved = ask.post("/file/press.csv", film())
    assert saved.status == 200
    assert saved.content == (tmp_path / "a.csv").read_bytes()
    (tmp_path / "b.nc").write_bytes(ask.post("/file/press.nc", film()).content)
    assert fp.load(tmp_path / "b.nc").drop_dims("phi").identical(expected)


def test_table_is_the_one_of_the_command_line(ask):
    printed = CliRunner().invoke(app, ["solve", str(FILM)], env={"COLUMNS": "200"}).stdout
    table = ask.solve("press", film())["table"]
    assert len(table["rows"]) == 10
    for row in table["rows"]:
        assert all(cell in printed for cell in row)
    assert table["caption"] in printed


@pytest.mark.long
def test_python_lines_do_the_same(ask, tmp_path):
    for kind in ("toml", "py"):
        saved = ask.post(f"/file/press.{kind}", film())
        (tmp_path / saved.name).write_bytes(saved.content)
    assert len(saved.content.decode().strip().splitlines()) == 5
    subprocess.run([sys.executable, saved.name], cwd=tmp_path, check=True)
    (written,) = tmp_path.glob("*.csv")
    assert written.read_bytes() == ask.post("/file/press.csv", film()).content


def test_pictures_are_pictures(ask):
    assert ask.post("/file/press.png", film()).content.startswith(b"\x89PNG")
    assert b"<svg" in ask.post("/file/press.svg", film()).content


def test_link_with_the_form_saves_the_same_file(ask):
    assert ask.get("/file/press.toml?" + urlencode(film())).content == ask.post("/file/press.toml", film()).content


def test_case_file_goes_round(ask):
    saved = ask.post("/file/press.toml", film()).content
    loaded = json.loads(ask.post("/api/case", body=saved).content)["form"]
    assert read_case_text(saved) == film()
    assert "elliptic" in loaded


def test_pressure_integrates_to_the_force(ask):
    form = {name: text for name, text in film().items() if not name.startswith("indenter.")}
    form |= {"indenter.kind": "sphere", "indenter.radius": "10 um"}
    curve = ask.solve("press", form)["curve"]
    state = json.loads(ask.post("/api/detail?tab=press&name=pressure&step=39", form).content)
    while "key" in state:
        state = json.loads(ask.get(f"/api/job?key={state['key']}").content)
    found = state["result"]
    values = np.array([[value or 0.0 for value in row] for row in found["values"]])
    cell = (2 * found["half"] / (len(values) - 1)) ** 2
    # squares of 1/32 of the radius: the edge leaves some per mille
    assert values.sum() * cell == pytest.approx(curve["force"][-1], rel=5e-3)
    assert found["mean"] == pytest.approx(curve["force"][-1] / curve["area"][-1])


def test_long_cases_are_only_checked_until_they_are_asked_for(ask):
    found = ask.solve("press", {**film(), **SLOW}, run=False)
    assert found["long"]
    assert "curve" not in found
    assert any(line.startswith("Takes") for line in found["about"])


@pytest.mark.long
def test_a_job_is_stopped_and_the_page_answers_meanwhile(page, ask):
    state = json.loads(ask.post("/api/solve?tab=press&run=1", {**film(), **SLOW}).content)
    assert state["state"] in ("running", "waiting")
    job = page.workers.find(state["key"])
    while job.progress is None and not job.ended.is_set():
        job.wait(0.1)
    done, total = job.progress
    assert total == 500
    assert done < total
    # a short case is solved while the long one goes on
    assert "curve" in ask.solve("press", {**film(), "control.points": "7"}, run=False)
    assert not job.ended.is_set()
    assert json.loads(ask.post(f"/api/stop?key={state['key']}").content)["state"] == "stopped"
    assert json.loads(ask.get(f"/api/job?key={state['key']}").content)["state"] == "stopped"
    assert "curve" in ask.solve("press", {**film(), "control.points": "8"})


def test_two_visitors_get_their_own_results(ask):
    forms = [{**film(), "indenter.radius_x": f"{radius} um"} for radius in (18, 25)]
    found = [ask.solve("press", form)["curve"]["depth"] for form in forms]
    assert found[0] != found[1]
    assert ask.solve("press", forms[0])["curve"]["depth"] == found[0]


def test_problems_are_answers(ask):
    assert ask.solve("press", {**film(), "layers.0.young": "5 kN"})["problems"][0]["field"] == "layers.0.young"
    refused = ask.post("/file/press.csv", {**film(), "layers.0.young": "5 kN"})
    assert refused.status == 400
    assert "layers[0].young" in json.loads(refused.content)["problems"][0]["text"]


@pytest.mark.parametrize(
    "path",
    [
        "/nothing",
        "/static/../page.py",
        "/static/page.py",
        "/file/press.exe",
        "/file/other.csv",
        "/api/job?key=guessed",
        "//etc/passwd",
    ],
)
def test_what_is_not_there_is_said_to_be_missing(ask, path):
    assert ask.get(path).status == 404


@pytest.mark.parametrize(
    "body", [b"\xff\xfe\x00", b"a = [", b"[" * 100_000, b"x" * 6_000_000], ids=["bytes", "toml", "deep", "large"]
)
def test_hostile_case_files_are_refused(ask, body):
    answer = ask.post("/api/case", body=body)
    assert answer.status == 400
    assert json.loads(answer.content)["problems"][0]["text"]


def test_hostile_formulas_are_refused(ask):
    young = "{ formula = \"__import__('os').system('true')\", unit = \"Pa\" }"
    problems = ask.solve("press", {**film(), "layers.0.young": young})["problems"]
    assert problems[0]["field"] == "layers.0.young"


def test_page_offers_every_shipped_case():
    titles = [example["title"] for example in start()["examples"]]
    for path in shipped_cases():
        assert tomllib.loads(path.read_text(encoding="utf-8"))["title"] in titles


def test_store_forgets_the_oldest():
    store = Store(10, len)
    for name in "abc":
        store.put(name, "12345")
    assert store.get("a") is None
    assert store.get("b") == store.get("c") == "12345"
    store.put("c", "1")
    store.put("d", "12345")
    assert store.get("b") is None
    assert store.get("c") == "1"
