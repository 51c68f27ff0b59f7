"""Adhesive and viscoelastic cases on the command line: solved, described, saved, drawn."""

import pytest
import xarray as xr
from typer.testing import CliRunner

import flatpunch as fp
from flatpunch.cli.app import app
from flatpunch.files import load, read_case, shipped_cases


def run(*arguments):
    # The width fixes the line breaks of tables and help.
    return CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "140", "NO_COLOR": "1"})


@pytest.fixture
def shipped():
    return {path.stem: path for path in shipped_cases()}


@pytest.mark.long
def test_adhesive_case(shipped, tmp_path):
    path = shipped["sphere_sticking_to_gel_in_water"]
    nc, csv, png = (tmp_path / f"a.{ending}" for ending in ("nc", "csv", "png"))
    done = run("solve", path, "-o", nc, "--csv", csv, "--plot", png)
    assert done.exit_code == 0, done.output
    case = read_case(path)
    lost = fp.pull_off(case.medium, case.indenter, **case.physics.given)
    assert f"Pull-off under prescribed force: {lost.force * 1e12:.4g} pN" in done.output
    assert f"Pull-off under prescribed depth: {lost.depth_minimum.force * 1e12:.4g} pN" in done.output
    xr.testing.assert_identical(load(nc).drop_dims("phi"), load(csv))
    assert load(nc).attrs["work_of_adhesion"] == case.physics.work_of_adhesion
    assert png.stat().st_size > 10_000
    assert "Adhesion  work 20 µJ/m², range of action 1 nm" in run("check", path).output


def test_a_long_range_of_action(shipped, tmp_path):
    """As long as the neck: the tip holds on to the gel more strongly than in JKR theory."""
    mild = tmp_path / "mild.toml"
    text = shipped["sphere_sticking_to_gel_in_water"].read_text(encoding="utf-8")
    mild.write_text(text.replace('"1 nm"', '"20 nm"'), encoding="utf-8")
    done = run("solve", mild)
    assert done.exit_code == 0
    case = read_case(mild)
    lost = fp.pull_off(case.medium, case.indenter, **case.physics.given)
    jkr = fp.pull_off(case.medium, case.indenter, work_of_adhesion=case.physics.work_of_adhesion)
    assert lost.force < 1.01 * jkr.force < 0
    assert f"Pull-off under prescribed force: {lost.force * 1e12:.4g} pN" in done.output


@pytest.mark.long
def test_history(shipped, tmp_path):
    path = shipped["cell_ramp_hold_retract"]
    nc, csv, png = (tmp_path / f"a.{ending}" for ending in ("nc", "csv", "png"))
    done = run("solve", path, "-o", nc, "--csv", csv, "--plot", png)
    assert done.exit_code == 0, done.output
    assert "time" in done.output
    # the column would hold infinities only
    assert "N/m" not in done.output
    xr.testing.assert_identical(load(nc).drop_dims("phi"), load(csv))
    result = load(nc)
    # the cell is left behind: no force, and no contact, long before the tip is back at the surface
    gone = result["time"].values[(result["force"].values == 0) & (result["time"].values > 1)]
    assert result["depth"].sel(step=result["time"] == gone[0]).item() > 2e-7
    assert png.stat().st_size > 10_000
    assert "Relaxes   PowerLawRelaxation exponent 0.2, time 1 s" in run("check", path).output


def test_elastic_substrates_are_refused_with_the_reason(shipped, tmp_path):
    path = tmp_path / "cell.toml"
    text = shipped["cell_ramp_hold_retract"].read_text(encoding="utf-8")
    path.write_text(
        text.replace('kind = "rigid"', 'kind = "half-space"\nyoung = "70 GPa"\npoisson = 0.2'), encoding="utf-8"
    )
    for command in ("check", "solve"):
        done = run(command, path)
        assert done.exit_code == 2
        assert "the shape of its compliance changes with time" in done.stderr
