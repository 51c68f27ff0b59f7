"""[stress] of case files, `flatpunch stress`, critical loads in sweeps, pictures."""

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import flatpunch as fp
from flatpunch.cli.app import app
from flatpunch.files import CaseError, read_case
from flatpunch.plots import fields as pictures
from flatpunch.sweeps.picture import figure, is_map, map_figure

COATING = """
title = "Hard coating on steel"
[[layers]]
young = "300 GPa"
poisson = 0.25
thickness = "2 um"
[base]
kind = "half-space"
young = "210 GPa"
poisson = 0.3
[indenter]
kind = "sphere"
radius = "50 um"
[control]
force = ["100 mN", "500 mN"]
"""
STRESS = """
[stress]
friction = 0.1
residual_stress = ["-1 GPa"]
[[stress.strengths]]
yield_stress = "8 GPa"
tensile = "2 GPa"
interface_shear = "500 MPa"
[[stress.strengths]]
yield_stress = "1.5 GPa"
"""
POINTS = """
[stress]
x = { start = "-3 um", stop = "3 um", points = 4 }
z = ["1 um", "3 um"]
"""


def written(tmp_path, text):
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_points_and_strengths_of_a_case(tmp_path):
    case = read_case(written(tmp_path, COATING + STRESS))
    assert case.stress.friction == 0.1
    assert case.stress.residual_stress == (-1e9,)
    assert case.stress.strengths == (
        fp.Strength(yield_stress=8e9, tensile=2e9, interface_shear=0.5e9),
        fp.Strength(yield_stress=1.5e9),
    )
    x, y, z = read_case(written(tmp_path, COATING + POINTS)).stress.points(1.0, 1.0)
    assert x.shape == y.shape == z.shape == (4, 2)
    np.testing.assert_allclose(x[:, 0], [-3e-6, -1e-6, 1e-6, 3e-6])
    np.testing.assert_allclose(z[0], [1e-6, 3e-6])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[stress]\nfriction = -0.1\n", "friction"),
        ("[stress]\nz = 3\n", "length"),
        ('[stress]\nat = "points"\nx = ["1 um", "2 um"]\ny = "0 um"\nz = ["1 um", "2 um", "3 um"]\n', "one length"),
        ('[[stress.strengths]]\nyield_stress = "-1 GPa"\n', "yield_stress"),
        ("[stress]\nfrction = 0.1\n", "friction"),
    ],
)
def test_bad_tables(tmp_path, text, words):
    with pytest.raises(CaseError, match=words):
        read_case(written(tmp_path, COATING + text))


@pytest.mark.long
def test_command_writes_and_says_what_fails_first(tmp_path):
    case = written(tmp_path, COATING + STRESS)
    targets = [tmp_path / name for name in ("out.nc", "out.csv", "out.png")]
    arguments = ["stress", str(case), "-o", str(targets[0]), "--csv", str(targets[1]), "--plot", str(targets[2])]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "First failure: yield in layer 2" in result.output
    assert all(path.stat().st_size > 1000 for path in targets)
    loaded = fp.load(targets[0])
    assert loaded.stress.dims == ("component", "axis_0", "axis_1")
    first = fp.critical_load(
        read_case(case).medium,
        fp.Sphere(50e-6),
        list(read_case(case).stress.strengths),
        friction=0.1,
        residual_stress=[-1e9],
    )
    assert f"{first.force * 1e3:.4g} mN" in result.output
    assert len(targets[1].read_text(encoding="utf-8").splitlines()) == 1 + loaded.von_mises.size


@pytest.mark.long
def test_command_without_a_table_and_with_bad_input(tmp_path):
    result = CliRunner().invoke(app, ["stress", str(written(tmp_path, COATING))])
    assert result.exit_code == 0, result.output
    assert "von Mises" in result.output
    wrong = CliRunner().invoke(app, ["stress", str(written(tmp_path, COATING)), "--plot", "x.gif"])
    assert wrong.exit_code == 2
    shown = CliRunner().invoke(app, ["check", str(written(tmp_path, COATING + STRESS))])
    assert "strengths of 2 layers" in shown.output


@pytest.mark.long
def test_sweep_and_its_map(tmp_path):
    """The kind of the first failure changes over the map, and each point is what `critical_load` says."""
    case = written(tmp_path, COATING + STRESS)
    study = fp.sweep(case, {"layers.0.thickness": "0.3um:10um:3:log", "layers.0.young": "100GPa, 800GPa"})
    assert study.critical_force.dims == ("layers.0.thickness", "layers.0.young", "step")
    assert (
        len(
            {
                (k, i)
                for k, i in zip(study.critical_kind.values.ravel(), study.critical_layer.values.ravel(), strict=True)
            }
        )
        > 1
    )
    medium = fp.Medium([fp.Layer(800e9, 0.25, 10e-6)], fp.HalfSpace(210e9, 0.3))
    one = fp.critical_load(
        medium, fp.Sphere(50e-6), list(read_case(case).stress.strengths), friction=0.1, residual_stress=[-1e9]
    )
    assert float(study.critical_force[-1, -1, 0]) == pytest.approx(one.force, rel=1e-9)
    assert study.critical_margin.min("criterion").values == pytest.approx(1.0, abs=1e-6)
    assert is_map(study, "critical_force")
    assert not is_map(study, None)
    drawn = map_figure(study)
    assert [text.get_text() for text in drawn.legends[0].get_texts()]
    assert "GPa" in drawn.axes[0].get_ylabel()
    # loads of the first failure belong to no step of the case
    line = figure(study.isel({"layers.0.young": [0]}), quantity="critical_force")
    assert line.axes[0].get_ylabel() == "load at the first failure (mN)"


def test_areas_of_a_map_end_where_criteria_cross():
    """Two criteria whose loads cross at x = 2.3, between the points 2 and 3; at x = 4, y = 1 nothing was found."""
    x, y = np.array([4.0, 1.0, 2.0, 3.0]), np.array([1.0, 2.0])
    first, second = np.maximum(x - 2.3, 0), np.maximum(2.3 - x, 0)
    margin = np.exp(np.stack([first, second], axis=-1)[:, None] * np.ones((4, 2, 1)))
    margin[0, 0] = np.nan
    force = np.where(np.isnan(margin[..., 0]), np.nan, 1e-3 * np.add.outer(x, y))
    study = xr.Dataset(
        {
            "status": (("a", "b"), np.full((4, 2), "solved", dtype=object)),
            "critical_force": (("a", "b", "step"), force[..., None]),
            "critical_margin": (("a", "b", "criterion"), margin),
        },
        {"a": x, "b": y, "criterion": ["layers[0].yield", "layers[1].yield"]},
    )
    axes = map_figure(study).axes[0]
    seen = axes.collections[0].get_array()[0]
    at = np.linspace(1, 4, seen.size)
    assert (seen[at < 2.29] == 0).all()
    assert (seen[(at > 2.31) & (at < 2.99)] == 1).all()
    assert np.ma.getmaskarray(seen)[at > 3.01].all()


@pytest.mark.long
def test_a_search_that_ends_takes_nothing_else_away(tmp_path):
    """A film too thin for the contact at which its strong base would fail: stresses and curves are there, with a note."""
    thin = COATING.replace("2 um", "100 nm").replace('"sphere"', '"paraboloid"').replace("50 um", "1 mm")
    case = written(tmp_path, thin + '[stress]\nstrengths = [{}, { yield_stress = "1e6 GPa" }]\n')
    done = CliRunner().invoke(app, ["stress", str(case)])
    assert done.exit_code == 0, done.output
    assert "Estimated error of stresses" in done.output
    ended = "First failure: strengths are not reached up to a load of"
    assert ended in " ".join(done.output.split())
    study = fp.sweep(case, {"layers.0.young": ["100 GPa", "300 GPa"]})
    assert set(study.status.values.ravel().tolist()) == {"solved"}
    assert np.isfinite(study.force.values).all()
    assert np.isnan(study.critical_force.values).all()
    assert all(ended in note for note in study.notes.values.ravel().tolist())


@pytest.mark.long
def test_pictures():
    film = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], fp.HalfSpace(210e9, 0.3))
    x, z = np.meshgrid(np.linspace(-5e-6, 5e-6, 12), np.linspace(0, 5e-6, 10))
    found = fp.fields(film, fp.Sphere(50e-6), x, 0.0, z, force=0.1)
    for quantity in ("von_mises", "principal", "xx", "hydrostatic"):
        axes = fp.plot_fields(found, quantity=quantity, medium=film)
        assert axes.yaxis_inverted()
    axes = fp.plot_fields(found, quantity="utilisation", strengths=[None, fp.Strength(yield_stress=1e9)])
    assert "µm" in axes.get_xlabel()
    drawn = pictures.figure(found, film, fp.Sphere(50e-6), {"force": 0.1, "friction": 0.1})
    lines = drawn.axes[1].get_lines()
    assert len(lines) >= 5  # two stresses in two layers, and the interface
    # the shear changes its sign on the axis, and a round tip without friction is the same on both sides
    sides = [
        pictures.figure(found, film, fp.Sphere(50e-6), {"force": 0.1, "friction": f}).axes[2].get_xlim()[0] < -1
        for f in (0.0, 0.1)
    ]
    assert sides == [False, True]
    # over the yield stress only where no layer would be blank
    steel = fp.Strength(yield_stress=1e9)
    for strengths, words in (([steel, steel], "yield stress"), ([None, steel], "GPa"), ([steel], "GPa")):
        drawn = pictures.figure(found, film, fp.Sphere(50e-6), {"force": 0.1}, strengths=strengths)
        assert any(words in axes.get_ylabel() and "Mises" in axes.get_ylabel() for axes in drawn.axes)
    with pytest.raises(ValueError, match="plane"):
        fp.plot_fields(found.isel(axis_0=0))
    with pytest.raises(ValueError, match="unknown"):
        fp.plot_fields(found, quantity="colour")
    with pytest.raises(ValueError, match="strengths"):
        fp.plot_fields(found, quantity="utilisation")


def test_strengths_of_two_bodies(tmp_path):
    """[stress] of a case of two bodies: each has its strengths."""
    body = """
    base = { kind = "half-space", young = "210 GPa", poisson = 0.3 }
    """
    text = f"""
    [upper]{body}
    [lower]{body}
    [indenter]
    kind = "paraboloid"
    radius = "50 um"
    [control]
    force = "10 mN"
    [stress]
    x = ["0 um"]
    y = ["0 um"]
    z = ["1 um"]
    strengths = [{{ yield_stress = "2 GPa" }}]
    upper_strengths = [{{ yield_stress = "1 GPa" }}]
    """
    path = tmp_path / "pair.toml"
    path.write_text(text)
    found = CliRunner().invoke(app, ["stress", str(path)])
    assert found.exit_code == 0, found.output
    assert "of the upper body" in " ".join(found.output.split())
    case = read_case(path)
    first = fp.critical_load(case.medium, case.indenter, **case.stress.critical(case.medium))
    assert (first.body, first.kind) == ("upper", "yield")
