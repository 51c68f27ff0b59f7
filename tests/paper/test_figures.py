"""One number of each figure, from the quick run; resuming; the command."""

import csv
import dataclasses
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flatpunch.reference import elliptic
from paper import plan as plans
from paper import points, reproduce, wanted_figures
from paper.__main__ import app


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """All figures from few points."""
    folder = tmp_path_factory.mktemp("figures")
    return folder, reproduce(folder, quick=True, jobs=1)


def table(folder, name):
    with (folder / f"{name}.csv").open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def numbers(report, name):
    return next(s.numbers for s in report.statements if s.name == name)


def hertz_excess(e_g):
    contact = elliptic.elliptic_paraboloid(1 - e_g**2, 1.0, 1.0, depth=1.0)
    return np.sqrt(1 - (contact.half_axis_y / contact.half_axis_x) ** 2) - e_g


def at(rows, e_g, log_h):
    """The row of a map nearest to a place."""
    key = min(rows, key=lambda r: abs(float(r["e_g"]) - e_g) * 10 + abs(float(r["log10_h_over_a0"]) - log_h))
    return float(key["e_g"]), float(key["e_minus_e_g"])


@pytest.mark.long
@pytest.mark.parametrize("figure", ["figure_02", "figure_04"])
def test_boundary_elements_on_thick_layers_are_hertz(quick, figure):
    e_g, excess = at(table(quick[0], figure), 0.6, 2.0)
    # 128 cells place the outline to a fifth of a cell, 0.4 % of a half-axis
    assert excess == pytest.approx(hertz_excess(e_g), abs=3e-3)


@pytest.mark.long
def test_second_order_on_thin_layers(quick):
    """ln a = -R ln psi, and R falls to 1/(2 + alpha) of power-law grading: 1/2 (k = 1, e = e_g) and 1/3 (k = 3)."""
    e_g, excess = at(table(quick[0], "figure_03_second_order"), 0.3, -1.0)
    assert 0 < excess < 0.005  # a tenth of the half-space's
    e_g, excess = at(table(quick[0], "figure_05_second_order"), 0.3, -1.0)
    limit = np.sqrt(1 - (1 - e_g**2) ** (2 / 3)) - e_g
    # at h = a0/10 the layer grades like k = 2.3 rather than 3 (the statements of the report)
    assert limit < excess < 0.6 * limit


@pytest.mark.long
@pytest.mark.parametrize(("figure", "base", "nu"), [("figure_03", "frictionless", None), ("figure_05", "bonded", 0.5)])
def test_first_order(quick, figure, base, nu):
    """(P23) at h = a0 with d* = Kbar d/(kappa_2 <psi> a0^2) from the tables of a flat punch on one layer."""
    path = Path(__file__).resolve().parents[1] / "data" / "layer_on_rigid_base.csv"
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = [r for r in csv.DictReader(lines) if r["base"] == base and float(r["beta"]) == 1]
    row = next(r for r in rows if nu is None or float(r["nu"]) == nu)
    d_star = float(row["Kbar"]) * float(row["d2"]) / float(row["kappa2"])
    e_g, excess = at(table(quick[0], figure), 0.6, 0.0)
    swing = (e_g**2 / 2) / (1 - e_g**2 / 2) * (4 / 3) / (4 - 2 * d_star)
    # the table's ten digits
    assert excess == pytest.approx(np.sqrt(1 - ((1 - swing) / (1 + swing)) ** 2) - e_g, abs=1e-8)


def curve(folder, figure, **wanted):
    rows = [r for r in table(folder, figure) if all(r[k] == str(v) for k, v in wanted.items())]
    return {name: np.array([float(r[name]) for r in rows]) for name in ("d_over_d_max", "a0_over_h", "F_over_F_exact")}


@pytest.mark.long
@pytest.mark.parametrize(
    ("pair", "case", "first", "second"),
    [
        # largest deviations at d_max: of first order by its error at given depth, of second order by the cells
        (("figure_06", "figure_07"), {"shape": "ellipse", "body": "unbonded", "e_g": 0.5}, 0.012, 5e-4),
        (("figure_08", "figure_09"), {"shape": "ellipse", "body": "bonded", "e_g": 0.8}, 0.16, 3e-3),
        (("figure_11", "figure_12"), {"shape": "pyramid", "body": "unbonded", "e_g": 0}, 0.06, 4e-3),
        (("figure_11", "figure_12"), {"shape": "pyramid", "body": "bonded", "e_g": 0}, 0.065, 4e-3),
    ],
)
def test_curves(quick, pair, case, first, second):
    folder, _ = quick
    case = {**case, "h_over_a_half_space": 0.5}
    for figure in pair:
        exact = curve(folder, figure, method="bem", **case)
        for method, limit in (("first-order", first), ("second-order", second)):
            line = curve(folder, figure, method=method, **case)
            force = line["F_over_F_exact"][-1] / exact["F_over_F_exact"][-1] - 1
            assert abs(force) < limit
            # radii follow the force to about its own relative error, and cells to 0.5 %
            assert abs(line["a0_over_h"][-1] / exact["a0_over_h"][-1] - 1) < limit + 0.01
        assert exact["d_over_d_max"][-1] == pytest.approx(1.0, rel=1e-5)  # depths are kept to six figures


@pytest.mark.long
def test_outline_of_the_pyramid(quick):
    """First order cuts the corners by a tenth and more, less so on the bonded layer."""
    found = numbers(quick[1], "corners of the pyramid")
    assert -0.17 < found["unbonded first-order corner"] < found["bonded first-order corner"] < -0.08
    assert found["unbonded first-order sides"] < 0.06


@pytest.mark.long
def test_statements(quick):
    _, report = quick
    verdicts = {s.name: s.verdict for s in report.statements}
    assert len(verdicts) == 7
    assert all(v.startswith("confirmed") for v in verdicts.values()), verdicts
    thin = numbers(report, "thin layers as power-law grading")
    # corrections fall like h/a: k is within 3 h/a of 1 and 9 h/a of 3
    assert thin["unbonded ellipse k at 50"] == pytest.approx(1, abs=3 / 50)
    assert thin["bonded ellipse k at 50"] == pytest.approx(3, abs=9 / 50)
    assert numbers(report, "tension at the base")["worst"] == pytest.approx(0.0097, abs=2e-4)


@pytest.mark.long
def test_every_figure_comes_in_three_forms(quick):
    folder, _ = quick
    page = (folder / "index.html").read_text(encoding="utf-8")
    names = [f"figure_{n:02}" for n in range(2, 13)] + ["base_tension"]
    for name in names:
        for ending in ("png", "pdf", "csv"):
            assert (folder / f"{name}.{ending}").stat().st_size > 300
        assert f"{name}.png" in page
    assert not list(folder.rglob(".unfinished-*"))


@pytest.mark.long
def test_finished_points_are_used_again(quick):
    """A second run solves nothing; a point that was lost is solved alone, to the same numbers."""
    folder, _ = quick
    wanted, store, seen = plans.quick().points((10,)), points.Store(folder / "points"), []
    assert store.solve(wanted, jobs=1) == 0
    there = set((folder / "points").iterdir())
    before = store.load(wanted[0])
    (lost,) = (path for path in there if np.array_equal(np.load(path)["force"], before["force"]))
    lost.unlink()
    assert store.solve(wanted, jobs=1, progress=lambda *at: seen.append(at)) == 1
    assert seen == [(1, 2), (2, 2)]
    assert set((folder / "points").iterdir()) == there
    for name, value in store.load(wanted[0]).items():
        np.testing.assert_array_equal(value, before[name])


def test_a_point_that_cannot_be_solved_stops_the_run(tmp_path):
    bad = dataclasses.replace(plans.quick().points((6,))[0], depth=-1.0)
    with pytest.raises(ValueError, match=r"Point\(.*depth=-1.0.*BadValue: depth"):
        points.Store(tmp_path).solve([bad], jobs=1)


def test_figure_numbers():
    assert wanted_figures("2,3") == (2, 3)
    assert wanted_figures("6-8, 12") == (6, 7, 8, 12)
    for text in ("1", "13", "x", "5-4", ""):
        with pytest.raises(ValueError, match="must name figures"):
            wanted_figures(text)


@pytest.mark.long
def test_command(tmp_path):
    done = CliRunner().invoke(app, ["--quick", "--figures", "10", "--jobs", "1", "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert "corners of the pyramid" in done.output
    refused = CliRunner().invoke(app, ["--figures", "14"])
    assert refused.exit_code == 2
    assert "must name figures" in refused.output
    nowhere = Path(__file__) / "paper"  # in a file, not in a folder
    refused = CliRunner().invoke(app, ["-o", str(nowhere)])
    assert refused.exit_code == 2
    assert "test_figures.py/paper" in refused.output.replace("\n", "").replace("\\", "/")
