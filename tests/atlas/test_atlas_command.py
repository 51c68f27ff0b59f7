"""`flatpunch atlas` as a user meets it, and the program that makes tables."""

import csv

import numpy as np
import pytest
from typer.testing import CliRunner

import atlas_tables
from atlas_tables.__main__ import app as making
from flatpunch import atlas
from flatpunch.cli.app import app
from support.atlas_families import FAMILY_FILE

TERMINAL = {"COLUMNS": "140", "NO_COLOR": "1", "TERM": "dumb"}


def run(*arguments):
    return CliRunner().invoke(app, ["atlas", *map(str, arguments)], env=TERMINAL)


def make(*arguments):
    return CliRunner().invoke(making, [*map(str, arguments)], env=TERMINAL)


def test_list_and_show():
    listed = run("list")
    assert listed.exit_code == 0, listed.output
    assert all(name in listed.output for name in (*atlas.families(), "power-law"))
    shown = run("show", "bonded-layer")
    for text in ("poisson: 0 ... 0.5", "0.001 ... 100", "below 2e-10", "CC-BY", "Verified points         2000"):
        assert text in shown.output, text


def test_query():
    found = run("query", "bonded-layer", "--beta", "1,2", "--set", "poisson=0.3")
    assert found.exit_code == 0, found.output
    # tests/data/layer_on_rigid_base.csv
    assert "2.48352462" in found.output
    assert "4.3532442" in found.output
    assert "takes --set poisson=..., not nothing" in run("query", "bonded-layer").output
    assert "not nu, poisson" in run("query", "bonded-layer", "--set", "nu=0.3", "--set", "poisson=0.3").output
    assert "lies outside the table" in run("query", "sliding-layer", "--beta", "1e4").output
    assert "neither a number" in run("query", "sliding-layer", "--beta", "one").output
    assert "atlas export" in run("query", "sliding-layer", "--beta", "0.1:1:99").output
    assert run("query", "nothing").exit_code == 2


def test_export(tmp_path):
    path = tmp_path / "layer.csv"
    done = run(
        "export", "bonded-layer", "--csv", path, "--beta", "0.1:10:5:log", "--set", "poisson=0.2,0.5", "--terms", 3
    )
    assert done.exit_code == 0, done.output
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[1].endswith("CC-BY-4.0")
    rows = list(csv.DictReader(lines[2:]))
    assert len(rows) == 10
    row = rows[7]
    solution = atlas.table("bonded-layer").at(poisson=float(row["poisson"]))
    assert float(row["Kbar"]) == pytest.approx(float(solution.normalized_stiffness(float(row["beta"]))), rel=1e-11)
    assert float(row["c_0"]) * np.pi == pytest.approx(float(row["Kbar"]), rel=1e-11)
    assert "does not exist" in run("export", "sliding-layer", "--csv", tmp_path / "no" / "x.csv").output
    assert run("export", "power-law", "--csv", tmp_path / "p.csv", "--set", "poisson=0.3").exit_code == 0


@pytest.mark.long
def test_build_verify_and_use_a_family_of_ones_own(tmp_path):
    path = tmp_path / "gel.toml"
    path.write_text(FAMILY_FILE, encoding="utf-8")
    done = make("build", path, "-o", tmp_path, "--workers", 1, "--check", 20)
    assert done.exit_code == 0, done.output
    made = tmp_path / "gel-on-pdms.nc"
    assert "Written" in done.output
    assert atlas.read_table(made).attributes["family_file"] == FAMILY_FILE
    checked = make("verify", made, "--points", 10, "--workers", 1)
    assert checked.exit_code == 0, checked.output
    assert "keeps its bound" in checked.output
    assert "gel: 10000 ... 1e+06 Pa" in run("show", made).output
    refused = make("build", "nothing", "-o", tmp_path)
    assert refused.exit_code == 2
    assert "is no family" in refused.output
    nowhere = path / "tables"  # in a file, not in a folder
    assert nowhere.name in make("build", "bonded-layer", "-o", nowhere).output
    path.write_text(FAMILY_FILE.replace("gel-on-pdms", "bonded-layer"), encoding="utf-8")
    assert "is that of a shipped family" in make("build", path, "-o", tmp_path).output


def test_a_table_that_does_not_keep_its_bound_is_told(tmp_path):
    from dataclasses import replace

    table = replace(atlas.table("sliding-layer"), bound=1e-18)
    path = atlas_tables.write_table(table, tmp_path / "sliding-layer.nc")
    found = make("verify", path, "--points", 3, "--workers", 1)
    assert found.exit_code == 1
    assert "DOES NOT KEEP" in found.output
