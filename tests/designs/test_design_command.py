"""[design] of case files, `flatpunch design` and its picture."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import flatpunch as fp
from flatpunch.files import read_case
from support.commands import run

CASE = """
title = "Coating for a stiffness"
[[layers]]
young = "2 GPa"
poisson = 0.4
thickness = "1 um"
[base]
kind = "half-space"
young = "70 GPa"
poisson = 0.22
[indenter]
kind = "sphere"
radius = "20 um"
[control]
force = "2 mN"
"""

WANTED = """
[design]
quantity = "stiffness"
value = "50 kN/m"
force = "2 mN"
starts = 1
[design.vary]
"layers[0].young" = ["1 GPa", "9 GPa"]
"""

LOAD = """
[stress]
[[stress.strengths]]
yield_stress = "100 MPa"
[[stress.strengths]]
[design]
objective = "largest load"
starts = 1
[design.vary]
"layers[0].young" = ["1 GPa", "9 GPa"]
"""


def written(folder, text):
    path = folder / "case.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_command(tmp_path):
    csv, plot = tmp_path / "found.csv", tmp_path / "found.png"
    case = written(tmp_path, CASE + WANTED)
    result = run("design", case, "--csv", csv, "--plot", plot, exits=0)
    assert "3.64 GPa" in result.output
    assert "stiffness at force 2 mN: 50 kN/m, prescribed 50 kN/m" in " ".join(result.output.split())
    assert "layers[0].young,Pa,2000000000.0,3640097389" in csv.read_text(encoding="utf-8")
    assert plot.stat().st_size > 1000


def test_a_target_needs_no_control(tmp_path):
    """The case is then solved at the loads or depths of the target; a largest load has none and asks for [control]."""
    alone = CASE.replace('[control]\nforce = "2 mN"\n', "")
    case = written(tmp_path, alone + WANTED)
    read = read_case(case)
    assert (read.control, read.values.tolist()) == ("force", [2e-3])
    result = run("design", case, exits=0)
    assert "3.64 GPa" in result.output
    depths = 'quantity = "force"\nvalue = ["1 mN", "2 mN"]\ndepth = ["50 nm", "80 nm"]'
    read = read_case(
        written(tmp_path, alone + WANTED.replace('quantity = "stiffness"\nvalue = "50 kN/m"\nforce = "2 mN"', depths))
    )
    assert (read.control, read.values.tolist()) == ("depth", [5e-8, 8e-8])
    with pytest.raises(ValueError, match=r"give either a table \[control\]"):
        read_case(written(tmp_path, alone + LOAD))


def test_limits_and_loads_are_read(tmp_path):
    limits = '[[design.limits]]\nquantity = "depth"\nmaximum = "60 nm"\nforce = "2 mN"\n'
    asked = read_case(written(tmp_path, CASE + WANTED + limits)).design
    assert asked.vary == {"layers[0].young": (1e9, 9e9)}
    assert asked.limits[0].maximum == pytest.approx(60e-9)
    load = read_case(written(tmp_path, CASE + LOAD)).design.objective
    assert isinstance(load, fp.LargestLoad)
    assert load.strengths[0] == fp.Strength(yield_stress=100e6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('["1 GPa", "9 GPa"]', "[1, 9]"), "has no unit"),
        (('["1 GPa", "9 GPa"]', '"1 GPa"'), "must be a list of two bounds"),
        (('layers[0].young"', 'layers[0].yung"'), "did you mean"),
        (("50 kN/m", "50 kN"), "stiffness"),
        (('force = "2 mN"\nstarts', "starts"), "exactly one of depth and force"),
        (('quantity = "stiffness"', 'quantity = "weight"'), "quantity"),
        (
            ('quantity = "stiffness"', 'objective = "largest load"'),
            "value is given, but the largest load prescribes nothing",
        ),
        (('"layers[0].young" = ["1 GPa", "9 GPa"]', ""), "vary is empty"),
    ],
)
def test_mistakes_are_named(tmp_path, change, message):
    case = written(tmp_path, CASE + WANTED.replace(*change))
    result = run("design", case)
    assert result.exit_code != 0
    assert message in " ".join(result.output.split())


def test_a_case_without_a_design_is_refused(tmp_path):
    result = run("design", written(tmp_path, CASE))
    assert result.exit_code != 0
    assert "no table [design]" in " ".join(result.output.split())


def test_pictures():
    film = fp.Medium([fp.Layer(2.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.25))
    depth = [0.1, 0.2]
    force = 1.2 * fp.indent(film, fp.Paraboloid(1.0), depth=depth, angles=1).force.values
    target = fp.Target("force", force, depth=depth)
    found = fp.design(film, fp.Paraboloid(1.0), vary={"layers[0].young": (1.0, 9.0)}, objective=target, starts=1)
    axes = fp.plot_design(found, Figure().subplots())
    np.testing.assert_allclose(axes.lines[2].get_ydata() / axes.lines[1].get_ydata(), force / found.achieved)
    assert axes.get_xlabel().startswith("depth")


@pytest.mark.parametrize(
    ("bounds", "message"),
    [('["9 GPa", "1 GPa"]', "the smaller one first"), ('["3 GPa", "9 GPa"]', "outside its bounds")],
    ids=["order", "start"],
)
def test_check_refuses_bounds_that_hold_no_design(tmp_path, bounds, message):
    case = written(tmp_path, CASE + WANTED.replace('["1 GPa", "9 GPa"]', bounds))
    done = run("check", case, exits=2)
    assert message in " ".join(done.output.split())
