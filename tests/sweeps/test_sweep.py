"""Parameter studies: against single cases, with bad points, resumed, and refused before any work."""

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import flatpunch as fp
from flatpunch.files.units import LENGTH, to_si
from flatpunch.parallel import Folder
from flatpunch.sweeps import picture, save_table, study, table
from support import commands
from support.platforms import SIGNALS

CASE = """
title = "Ball on a film"
angles = 24
base = { kind = "half-space", young = "1 MPa", poisson = 0.3 }
indenter = { kind = "sphere", radius = "1 um" }
control = { depth = ["100 nm", "400 nm"] }

[[layers]]
young = "0.1 MPa"
poisson = 0
thickness = "1 um"
bonded = true
"""
THICKNESS, RADIUS = "layers.0.thickness", "indenter.radius"


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(CASE, encoding="utf-8")
    return path


run = partial(commands.run, columns=120)


def test_ranges_may_be_in_the_case_file(case):
    wanted = {THICKNESS: "0.5um:2um:3:log"}
    case.write_text(f'{CASE}\n[vary]\n"{THICKNESS}" = "{wanted[THICKNESS]}"\n', encoding="utf-8")
    inside = fp.sweep(case, workers=1)
    case.write_text(CASE, encoding="utf-8")
    xr.testing.assert_identical(inside.drop_attrs(), fp.sweep(case, wanted, workers=1).drop_attrs())
    missing = run("sweep", case, exits=2)
    assert "[vary]" in missing.output


def test_each_point_is_the_case_with_its_values(case):
    result = fp.sweep(case, {THICKNESS: "0.5um:2um:3:log", RADIUS: "1um, 2000 nm"}, workers=1)
    assert dict(result.sizes) == {THICKNESS: 3, RADIUS: 2, "step": 2}
    np.testing.assert_allclose(result[THICKNESS], [0.5e-6, 1e-6, 2e-6], rtol=1e-15)
    assert result[RADIUS].values.tolist() == [1e-6, 2e-6]
    assert result[THICKNESS].attrs["units"] == result[RADIUS].attrs["units"] == "m"
    for thickness in result[THICKNESS].values:
        for radius in result[RADIUS].values:
            film = fp.Medium([fp.Layer(1e5, 0.0, float(thickness))], base=fp.HalfSpace(1e6, 0.3))
            one = fp.indent(film, fp.Sphere(float(radius)), depth=[1e-7, 4e-7], angles=24)
            at = result.sel({THICKNESS: thickness, RADIUS: radius})
            for name in ("force", "radius", "stiffness", "force_error", "valid", "depth"):
                assert name in one
                np.testing.assert_array_equal(at[name], one[name])
                assert at[name].attrs == one[name].attrs
    assert (result["status"] == "solved").all()
    assert result.attrs["case"] == CASE
    assert json.loads(result.attrs["vary"])[RADIUS] == ["1e-06 m", "2e-06 m"]
    assert result.attrs["flatpunch_version"] == fp.__version__
    assert "contour" not in result


def test_kinds_of_values(case):
    flags = fp.sweep(case, {"layers[0].bonded": "true, false", "layers.0.poisson": "0:0.5:3"}, workers=1)
    assert flags["layers.0.bonded"].values.tolist() == [True, False]
    assert flags["layers.0.poisson"].values.tolist() == [0, 0.25, 0.5]
    assert float(flags["force"][0, 2, 1]) > float(flags["force"][1, 2, 1])  # a bonded film is stiffer
    counts = fp.sweep(fp.read_case(case), {"angles": [8, 16]}, workers=1)
    assert counts["angles"].dtype.kind == "i"
    lengths = fp.sweep(case, {RADIUS: np.array([1e-6, 2e-6])}, workers=1)  # Python's numbers are in SI units
    assert lengths.equals(fp.sweep(case, {RADIUS: ["1 um", "0.002 mm"]}, workers=1))
    case.write_text('method = "first-order"\n' + CASE, encoding="utf-8")
    methods = fp.sweep(case, {"method": "first-order, second-order"}, workers=1, contours=True)
    assert methods["method"].values.tolist() == ["first-order", "second-order"]
    assert methods["contour"].dims == ("method", "step", "phi")
    # all fast methods are exact for round contacts
    np.testing.assert_allclose(methods["force"][0], methods["force"][1], rtol=1e-9)


def test_a_point_that_fails_is_kept_as_a_record(case, tmp_path):
    """A ball of 0.2 um has no shape at a depth of 0.4 um."""
    result = fp.sweep(case, {RADIUS: "0.2um, 1um", THICKNESS: "1um, 2um"}, workers=1)
    assert result["status"].values.tolist() == [["failed"] * 2, ["solved"] * 2]
    assert "beyond this indenter" in str(result["reason"].values[0, 0])
    assert result["reason"].values.tolist()[1] == ["", ""]
    assert np.isnan(result["force"][0]).all()
    assert not result["valid"][0].any()
    assert (result["force"][1] > 0).all()
    fp.save(result, tmp_path / "study.nc")
    xr.testing.assert_identical(fp.load(tmp_path / "study.nc"), result)


def test_adhesive_and_relaxing_cases(case):
    case.write_text('work_of_adhesion = "1 mJ/m^2"\n' + CASE, encoding="utf-8")
    sticky = fp.sweep(case, {"work_of_adhesion": "1 mJ/m^2, 10 mJ/m^2"}, workers=1)
    assert sticky["work_of_adhesion"].attrs["units"] == "J/m^2"
    assert (sticky["force"][1] < sticky["force"][0]).all()
    history = """[relaxation]
kind = "standard-linear-solid"
equilibrium = 0.5
time = "1 s"
[history]
segments = [{ kind = "ramp", depth = "300 nm", duration = "1 s", points = 10 }]
"""
    lines = [line for line in CASE.splitlines() if not line.startswith("control")]
    relaxing = "\n".join(lines).replace('kind = "half-space", young = "1 MPa", poisson = 0.3', 'kind = "rigid"')
    case.write_text(f"{relaxing}\n{history}", encoding="utf-8")
    slower = fp.sweep(case, {"history.segments.0.duration": "0.01s, 100s"}, workers=1)
    assert slower["time"].dims == ("history.segments.0.duration", "step")
    # a fast ramp meets the instantaneous modulus, a slow one half of it
    ratio = float(slower["force"][1, -1] / slower["force"][0, -1])
    assert 0.5 < ratio < 0.52


def test_all_combinations_are_checked_before_any_work(case, monkeypatch):
    monkeypatch.setattr(study, "solve_points", lambda *_, **__: pytest.fail("work began"))
    for vary, words in [
        ({"layers.0.thicknes": "1um"}, r"layers.0.thicknes is not in the case file; did you mean 'layers.0.thickness'\?"),
        ({"x": "1"}, r"It holds angles = 24, base.kind = 'half-space'.*indenter.radius = '1 um'.*at its default"),
        ({"layers.0": "1um"}, r"is a table or a list; vary a value in it: layers.0.young, .*layers.0.bonded"),
        ({RADIUS: "1 kPa"}, r"indenter.radius = '1 kPa' has the dimension of a pressure; a length .* holds '1 um'"),
        ({RADIUS: "1, 2"}, r"indenter.radius = '1' has no unit; a length such as"),
        ({RADIUS: "1um:2:3"}, r"indenter.radius = '2' has no unit"),
        ({RADIUS: "1um:2um"}, r"is no range. Write start:stop:count"),
        ({RADIUS: "1um:2um:1"}, r"the count '1' must be a whole number from 2 to"),
        ({RADIUS: "1um:2um:x"}, r"the count 'x' must be"),
        ({RADIUS: "1um:2um:3:cubic"}, r"the spacing 'cubic' must be 'log' or 'lin'"),
        ({RADIUS: "0um:2um:3:log"}, r"'log' has no zero"),
        ({RADIUS: "1um:1um:3"}, r"starts where it stops"),
        ({RADIUS: "1um, 1000nm"}, r"holds 1e-06 twice"),
        ({RADIUS: "1um,,2um"}, r"holds no values"),
        ({RADIUS: []}, r"holds no values"),
        ({RADIUS: "1um", "indenter .radius": "2um"}, r"is not in the case file"),
        ({"layers.0.thickness": "1um", "layers[0].thickness": "2um"}, r"varied twice"),
        ({"layers.0.bonded": "yes"}, r"must be true or false"),
        ({"layers.0.bonded": "0:1:2"}, r"is no range"),
        ({"layers.0.poisson": "0.3 um"}, r"must be a plain number, without a unit. The case file holds 0\."),
        ({"layers.0.poisson": [True]}, r"must be a plain number"),
        ({"indenter.kind": [1]}, r"must be a text"),
        ({"indenter.kind": "sphere, spere"}, r"1 of 2 combinations describe no case.*'spere' is unknown"),
        ({RADIUS: "-1um:1um:3", THICKNESS: "1um,2um"}, r"(?s)4 of 6 .*With indenter.radius = -1 µm, .*must be finite and > 0"),
        ({"layers.0.poisson": "0.3:0.6:4"}, r"(?s)1 of 4 .*layers\[0\].poisson = 0.6 must lie in"),
        ({}, r"vary = \{\} must say"),
        (None, r"vary = None must say"),
    ]:  # fmt: skip
        with pytest.raises(ValueError, match=f"(?s){words.removeprefix('(?s)')}"):
            fp.sweep(case, vary)
    with pytest.raises(TypeError, match="path of a case file"):
        fp.sweep(3, {RADIUS: "1um"})
    with pytest.raises(ValueError, match="not readable"):
        fp.sweep(case.with_name("other.toml"), {RADIUS: "1um"})
    case.write_text(
        CASE.replace('depth = ["100 nm", "400 nm"]', 'depth = { start = "1 nm", stop = "9 nm", points = 3 }')
    )
    with pytest.raises(ValueError, match="changes the number of steps, from 3 to 4"):
        fp.sweep(case, {"control.depth.points": "3,4"})


def test_more_values_solve_only_the_new_ones(case, tmp_path):
    store, seen = tmp_path / "points", []
    fp.sweep(case, {RADIUS: "1um, 2um"}, store=store, workers=1)
    case.write_text(CASE.replace("Ball", "The same ball"), encoding="utf-8")  # the title moves no numbers
    longer = fp.sweep(case, {RADIUS: "1um, 2um, 3um"}, store=store, workers=1, progress=lambda *at: seen.append(at))
    assert seen == [(2, 3), (3, 3)]
    assert longer.attrs["title"] == "Parameter study: The same ball on a film"
    seen.clear()
    fp.sweep(case, {RADIUS: "1um, 2um, 3um"}, store=store, workers=1, anew=True, progress=lambda *at: seen.append(at))
    assert seen[0] == (0, 3)


@pytest.mark.long
def test_the_command(case, tmp_path):
    nc, png = tmp_path / "study.nc", tmp_path / "study.png"
    command = ["sweep", case, "--vary", "indenter.radius=0.2um,1um,2um", "--vary", "layers.0.bonded=true,false"]
    done = run(*command, "-o", nc, "--plot", png, exits=0)
    assert "force [nN] at depth 400 nm" in done.output
    assert "6 points, 2 failed." in done.output
    assert "Failed at indenter.radius = 200 nm, layers.0.bonded = true: depth" in done.output
    result = fp.load(nc)
    assert f"{float(result['force'][1, 0, 1]) * 1e9:.4g}" in done.output
    assert png.stat().st_size > 5000
    states = Folder(tmp_path / "study.points").path
    assert len(list(states.glob("*.npz"))) == 4
    before = {path: path.stat().st_mtime_ns for path in states.glob("*.npz")}
    assert run(*command, "-o", nc, "--quantity", "radius", "--step", 0).exit_code == 0
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert run(*command, "-o", nc, "--fresh").exit_code == 0
    assert all(path.stat().st_mtime_ns > then for path, then in before.items())


def test_the_output_may_be_a_table(case, tmp_path):
    good = ["sweep", case, "--vary", "indenter.radius=1um,2um", "--workers", 1]
    assert run(*good, "-o", tmp_path / "a.CSV", "--csv", tmp_path / "b.csv", "--contours").exit_code == 0
    found = fp.load(tmp_path / "a.CSV")
    assert dict(found.sizes) == {"indenter.radius": 2, "step": found.sizes["step"]}
    save_table(found, tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    # people find the varied values and the steps beside the numbers
    lines = pd.read_csv(tmp_path / "a.CSV", comment="#")
    assert list(lines)[:3] == ["row", "indenter.radius", "step"]
    np.testing.assert_array_equal(lines["force [N]"], found.force.values.ravel())
    np.testing.assert_array_equal(lines["indenter.radius"], np.repeat(found["indenter.radius"], found.sizes["step"]))


def test_tables_of_studies_are_read_back(case, tmp_path):
    """Failed points, texts of points and outlines among them."""
    found = fp.sweep(case, {"indenter.radius": "1um, 2um", "layers.0.poisson": "0.3, 0.4"}, workers=1, contours=True)
    assert fp.load(fp.save(found, tmp_path / "study.csv", outlines=True)).identical(found)
    assert fp.load(fp.save(found, tmp_path / "study.csv")).identical(found.drop_dims("phi"))


def test_the_command_refuses(case, tmp_path):
    good = ["sweep", case, "--vary", "indenter.radius=1um,2um"]
    for arguments, words in [
        ([*good, "-o", "x.txt"], "--output x.txt: the ending must be .nc or .csv"),
        ([*good, "--plot", "missing/x.png"], "the folder missing does not exist"),
        (["sweep", case, "--vary", "indenter.radius"], "must be PATH=VALUES"),
        ([*good, "--vary", "indenter.radius=3um"], "varied twice"),
        (["sweep", case, "--vary", "indenter.radios=1um"], "did you mean 'indenter.radius'"),
        ([*good, "--workers", 0], "workers = 0 must be"),
        ([*good, "--quantity", "colour"], "quantity = 'colour' is not in this study"),
        ([*good, "--step", 2], "step = 2 is not in this study"),
        ([*good, "--scheduler", "nonsense://x"], "does not answer"),
    ]:
        done = run(*arguments, exits=2)
        assert words in done.output.replace("\n", " "), done.output
    everything_fails = run("sweep", case, "--vary", "indenter.radius=0.1um,0.2um", "-o", tmp_path / "bad.nc", exits=1)
    assert "2 points, 2 failed." in everything_fails.output
    kept = fp.load(tmp_path / "bad.nc")
    assert (kept["status"] == "failed").all()
    with pytest.raises(ValueError, match="no point of this study was solved"):
        picture.figure(kept)


@pytest.mark.long
@SIGNALS
def test_an_interrupted_study_goes_on(case, tmp_path):
    """Ctrl-C in a terminal reaches the workers too; status 130, nothing half-written, and the rest is solved later."""
    case.write_text('method = "bem"\n' + CASE.replace('"100 nm", "400 nm"', '"100 nm"'), encoding="utf-8")
    nc = tmp_path / "study.nc"
    command = ["sweep", str(case), "--vary", "indenter.radius=1um:2um:6", "-o", str(nc), "--workers", "2"]
    store = tmp_path / "study.points"
    with subprocess.Popen(
        [sys.executable, "-m", "flatpunch", *command], stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        end = time.monotonic() + 60
        while not (store.exists() and len(list(store.glob("[!.]*.npz"))) >= 1):
            assert time.monotonic() < end, "no point was solved"
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)
        told = process.stderr.read()
    assert process.returncode == 130, told
    assert "Finished points are in" in told
    assert "Traceback" not in told
    assert not nc.exists()
    kept, seen = len(list(store.glob("[!.]*.npz"))), []
    assert 1 <= kept < 6
    result = fp.sweep(case, {RADIUS: "1um:2um:6"}, store=store, workers=1, progress=lambda *at: seen.append(at))
    assert seen[0] == (kept, 6)
    assert (result["status"] == "solved").all()


def test_table_for_spreadsheets(case, tmp_path):
    result = fp.sweep(case, {THICKNESS: "0.5um,5um", RADIUS: "0.3um,2um"}, workers=1, contours=True)
    save_table(result, tmp_path / "study.csv")
    found = pd.read_csv(tmp_path / "study.csv", keep_default_na=False, na_values=[""])
    assert len(found) == 2 * 2 * result.sizes["step"]
    assert list(found.columns[:4]) == ["layers.0.thickness [m]", "indenter.radius [m]", "step", "depth [m]"]
    assert not [name for name in found.columns if "contour [" in name or "notes" in name]
    line = found.iloc[2 * result.sizes["step"] + 1]  # second thickness, first radius, second step
    assert line["layers.0.thickness [m]"] == 5e-6
    assert line["force [N]"] == float(result["force"][1, 0, 1])
    failed = found[found["status"] == "failed"]
    assert (failed["indenter.radius [m]"] == 0.3e-6).all()
    assert failed["force [N]"].isna().all()
    assert failed["reason"].str.contains("beyond this indenter").all()
    csv = tmp_path / "again.csv"
    command = ["sweep", case, "--vary", f"{RADIUS}=1um,2um", "--csv"]
    assert run(*command, csv).exit_code == 0
    assert csv.read_text(encoding="utf-8").startswith("indenter.radius [m],step,depth [m],force [N]")
    refused = run(*command, tmp_path / "study.xlsx", exits=2)
    assert "--csv" in refused.output
    assert "must be .csv" in refused.output


def test_table_where_every_point_failed(case, tmp_path):
    result = fp.sweep(case, {RADIUS: "0.1um,0.2um"}, workers=1)
    assert (result["status"] == "failed").all()
    found = table(result)
    assert len(found) == 2
    assert found["reason"].str.len().min() > 0


@pytest.mark.long
def test_pictures(case):
    result = fp.sweep(
        case, {THICKNESS: "0.5um:5um:4:log", RADIUS: "0.2um:1um:9", "layers.0.bonded": "true,false"}, workers=1
    )
    drawn = picture.figure(result)
    *panels, bar = drawn.axes
    assert [axes.get_title() for axes in panels] == ["bonded = true", "bonded = false"]
    assert panels[0].get_xscale() == "log"
    assert panels[0].get_xlabel() == "thickness of layer 1 (µm)"
    assert panels[0].get_ylabel() == "normal force $F$ at depth 400 nm (nN)"
    assert bar.get_ylabel() == "indenter radius (µm)"  # nine lines are distinguished by colour
    drawn.canvas.draw()
    force = panels[0].get_lines()[-3].get_ydata()
    np.testing.assert_allclose(force, result["force"][:, -1, 0, 1] * 1e9, rtol=1e-12)
    categories = picture.figure(
        result.isel({RADIUS: [5, 0]}).transpose("layers.0.bonded", ...), quantity="radius", step=0
    )
    assert [label.get_text() for label in categories.axes[0].get_xticklabels()] == ["true", "false"]
    assert categories.axes[0].get_ylabel().startswith("mean contact radius")
    many = xr.concat([result.isel({RADIUS: [1]})] * 5, "indenter.sides").transpose(*result["force"].dims[:3], ...)
    with pytest.raises(ValueError, match=r"would need 10 panels.*9 is the most"):
        picture.figure(many)


def test_ranges_end_where_they_say(case):
    axis = fp.sweep(case, {RADIUS: "700nm:3um:3:log"}, workers=1)[RADIUS].values
    assert axis[0] == to_si("700 nm", LENGTH)
    assert axis[-1] == to_si("3 um", LENGTH)
