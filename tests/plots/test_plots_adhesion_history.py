"""Pictures of adhesive and of viscoelastic contacts: the loop and its points, the history, pressure with tension."""

import json

import numpy as np
import pytest
from matplotlib.figure import Figure

import flatpunch as fp
from flatpunch.plots import loops
from flatpunch.plots import result as plots

GEL = fp.Medium([fp.Layer(young=3e3, poisson=0.48, thickness=1e-6)], base=fp.RigidBase())
BALL = fp.Sphere(5e-6)
WORK = 2e-5
STRETCHED = fp.EllipticParaboloid(1e5, 1.4e5)
TIME = np.linspace(0, 3, 61)
DEPTH = 3e-7 * np.interp(TIME, [0, 1, 2, 3], [0, 1, 1, 0])


@pytest.fixture
def axes():
    return Figure().subplots()


@pytest.mark.parametrize("control", ["depth", "force"])
def test_loop_marks_its_jumps(axes, control):
    largest = {"depth": 1e-7, "force": 1e-9}[control]
    result = fp.indent(GEL, BALL, work_of_adhesion=WORK, **{control: largest * np.array([0.5, 1.0])})
    cycle = loops.loop_of(result, GEL, BALL)
    assert cycle is not None
    assert cycle.attrs["control"] == control
    assert float(cycle[control].max()) == pytest.approx(largest, rel=1e-15)
    loops.loop(cycle, axes)
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert [label.split(":")[0] for label in labels] == ["withdrawal", "approach", "jump-in", "pull-off"]
    assert all(line.get_linestyle() in ("-", "None") for line in axes.lines)
    assert "-" not in "".join(labels).replace("jump-in", "").replace("pull-off", "")  # true minus signs
    drawn = {line.get_marker(): line.get_xydata() for line in axes.lines if line.get_marker() == "s"}
    jumps = json.loads(cycle.attrs["jumps"])
    units = {"nm": 1e9, "pN": 1e12, "nN": 1e9}
    by_depth, by_force = (units[label[label.index("(") + 1 : -1]] for label in (axes.get_xlabel(), axes.get_ylabel()))
    np.testing.assert_allclose(drawn["s"], [[jumps[-1]["depth"] * by_depth, jumps[-1]["force"] * by_force]], rtol=1e-14)
    # the shaded loop has the area of the energy lost; trapezoids of 200 steps a leg, and force control jumps off at fixed depth
    x, y = axes.patches[0].get_xy().T
    area = abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) / 2 / (by_depth * by_force)
    assert area == pytest.approx(float(cycle.attrs["energy_lost"]), rel=2e-3)


def test_adhesive_pressure_map_has_its_tension(axes):
    result = fp.indent(GEL, BALL, work_of_adhesion=WORK, depth=[-2e-8, 1e-7], angles=24)
    fp.plot_pressure(result, GEL, BALL, axes)
    mesh = axes.collections[0]
    low, high = mesh.get_clim()
    assert low == -high
    along = mesh.get_coordinates()[:, 0, 0]
    drawn = np.asarray(mesh.get_array()).reshape(mesh.get_coordinates().shape[:2])[:, 0]
    assert drawn[0] > 0 > drawn[-1] == low
    # the mesh ends at the outline, and its colours are the pressures where they are not infinite
    assert along[-1] == pytest.approx(float(result["radius"][1]) * 1e6, rel=1e-3)
    unit = {"Pa": 1.0, "kPa": 1e3}[axes.figure.axes[1].get_ylabel().split("(")[1][:-1]]
    wanted = fp.pressure(GEL, BALL, along * 1e-6, 0, depth=1e-7, work_of_adhesion=WORK) / unit
    np.testing.assert_allclose(drawn, np.clip(wanted, low, high), rtol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize(
    ("indenter", "control"),
    [
        (BALL, {"depth": np.linspace(1e-7, -8e-8, 12)}),
        (BALL, {"radius": np.geomspace(5e-8, 1.2e-6, 30)}),
        (BALL, {"force": [-1e-10, -3e-10]}),
        (STRETCHED, {"depth": [-1e-8, 5e-8, 1e-7]}),
        (fp.Cylinder(5e-7), {"depth": [-1e-8, 5e-8]}),
    ],
    ids=["depth", "radius", "tension", "ellipse", "flat"],
)
def test_figures_of_adhesion(indenter, control, tmp_path):
    result = fp.indent(GEL, indenter, work_of_adhesion=WORK, angles=24, **control)
    drawn = plots.figure(result, GEL, indenter, title="A title")
    assert plots.save_figure(drawn, tmp_path / "figure.png").stat().st_size > 10_000
    legend = drawn.axes[0].get_legend()
    texts = "" if legend is None else " ".join(text.get_text() for text in legend.get_texts())
    assert ("pull-off" in texts) == (indenter is not BALL or "force" not in control)


def test_nothing_to_draw():
    apart = fp.indent(GEL, BALL, work_of_adhesion=WORK, depth=[-2e-7, -3e-7], angles=24)
    with pytest.raises(ValueError, match="no step with a contact"):
        plots.figure(apart, GEL, BALL)


def test_history_draws_the_numbers():
    result = fp.indent(GEL, BALL, time=TIME, depth=DEPTH, relaxation=fp.StandardLinearSolid(0.3, 0.5), angles=24)
    drawn = plots.figure(result, GEL, BALL)
    left, middle, right, twin = drawn.axes
    np.testing.assert_allclose(left.lines[0].get_xydata(), np.stack([TIME, result["force"] * 1e9], axis=1), rtol=1e-14)
    np.testing.assert_allclose(twin.lines[0].get_ydata(), DEPTH * 1e9, rtol=1e-14)
    np.testing.assert_allclose(middle.lines[0].get_xydata()[:, 0], DEPTH * 1e9, rtol=1e-14)
    np.testing.assert_allclose(right.lines[0].get_ydata(), result["radius"] * 1e6, rtol=1e-14)
    assert "(s)" in left.get_xlabel()
    assert "(nN)" in left.get_ylabel()


@pytest.mark.long
@pytest.mark.parametrize(
    "relaxation", [fp.PowerLawRelaxation(0.2, 1.0), fp.Prony([0.5], [1.0])], ids=["power", "prony"]
)
def test_figures_of_histories(relaxation, tmp_path):
    """Sudden steps too: under a power law the force there is infinite, and left out of the picture."""
    for indenter, control in (
        (BALL, {"depth": np.maximum(DEPTH, 1e-7)}),
        (STRETCHED, {"depth": DEPTH}),
        (BALL, {"force": 1e-9 * (1 + np.sin(TIME))}),
    ):
        result = fp.indent(GEL, indenter, time=TIME, relaxation=relaxation, angles=24, **control)
        drawn = plots.figure(result, GEL, indenter, title="A title")
        assert plots.save_figure(drawn, tmp_path / "figure.png").stat().st_size > 10_000
        low, high = drawn.axes[0].get_ylim()
        assert low <= 0 < high < np.inf
