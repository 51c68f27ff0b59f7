"""Pictures: what is drawn is what the result says, in readable units, for every kind of indenter."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import flatpunch as fp
from flatpunch.bem.height import overlap_half_widths
from flatpunch.plots import result as plots

GEL = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1.2e-6)], base=fp.RigidBase())
TIP = fp.Pyramid(sides=4, inclination=0.9)
INDENTERS = [
    TIP,
    fp.Paraboloid(2e-6),
    fp.EllipticParaboloid(2e5, 4e5),
    fp.Sphere(2e-6),
    fp.Cone(0.5),
    fp.Cylinder(5e-7),
    fp.RadialProfile([0, 2e-7, 4e-7, 8e-7], [0, 1e-8, 5e-8, 3e-7]),
]


@pytest.fixture(scope="module")
def result():
    return fp.indent(GEL, TIP, depth=np.linspace(1e-8, 4e-7, 20), angles=48)


@pytest.fixture
def axes():
    return Figure().subplots()


def test_force_depth_draws_the_numbers(result, axes):
    plots.force_depth(result, axes)
    right = next(other for other in axes.figure.axes if other is not axes)
    depth, force = axes.lines[0].get_data()
    np.testing.assert_allclose(depth, result["depth"] * 1e9)  # nm
    np.testing.assert_allclose(force, result["force"] * 1e12)  # pN: the largest is below 1 nN
    np.testing.assert_allclose(right.lines[0].get_ydata(), result["stiffness"] * 1e3)  # mN/m
    assert "nm" in axes.get_xlabel()
    assert "pN" in axes.get_ylabel()
    assert "mN/m" in right.get_ylabel()


def test_error_of_the_force_is_drawn_and_said(result, axes):
    rough = fp.indent(GEL, TIP, depth=result["depth"], angles=48, method="first-order")
    plots.force_depth(rough, axes)
    error = float(rough["force_error"].max())
    assert f"force to {100 * error:.2g} %" in axes.texts[0].get_text()
    (band,) = axes.collections
    top = band.get_paths()[0].vertices[:, 1].max()
    assert top == pytest.approx(float(rough["force"][-1]) * 1e12 * (1 + float(rough["force_error"][-1])), rel=1e-9)
    plots.outline(rough, TIP, axes)
    assert f"{100 * float(rough['contour_error'][-1]):.0f} %" in axes.get_title()


def test_round_contacts_are_drawn_as_exact(axes):
    plots.force_depth(fp.indent(GEL, fp.Paraboloid(2e-6), depth=1e-7), axes)
    assert axes.texts[0].get_text() == "exact (round tip)"


def test_steps_where_the_theory_fails_are_drawn_apart(result, axes):
    broken = result.copy(deep=True)
    broken["valid"][15:] = False
    plots.force_depth(broken, axes)
    sound, grey = (line.get_ydata() for line in axes.lines)
    assert np.isfinite(sound).sum() == 15
    assert np.isfinite(grey).sum() == 5


def test_outline_is_closed_and_of_the_last_valid_step(result, axes):
    broken = result.copy(deep=True)
    broken["valid"][15:] = False
    plots.outline(broken, TIP, axes)
    x, y = axes.lines[-1].get_data()
    assert (x[0], y[0]) == pytest.approx((x[-1], y[-1]))
    # polar radii of the drawn curve are the contour of step 14, in nm
    np.testing.assert_allclose(np.hypot(x, y)[:-1], result["contour"][14] * 1e9, rtol=1e-12)
    assert axes.get_aspect() == 1


def test_contacts_without_an_outline(result, axes):
    """The last that has one is drawn; if none has, what the indenter would overlap bounds the picture."""
    apart = result.copy(deep=True)
    apart["contour"][15:] = np.nan
    plots.outline(apart, TIP, axes)
    x, y = axes.lines[-1].get_data()
    np.testing.assert_allclose(np.hypot(x, y)[:-1], result["contour"][14] * 1e9, rtol=1e-12)
    apart["contour"][:] = np.nan
    axes.clear()
    plots.outline(apart, TIP, axes)
    assert axes.get_title().startswith("Several parts, no outline")
    depth = float(result["depth"][-1])
    across = max(overlap_half_widths(TIP, depth))
    factor = 1e9 if "nm" in axes.get_xlabel() else 1e6
    assert axes.get_xlim() == pytest.approx((-across * factor, across * factor))
    axes.clear()
    plots.pressure_map(apart, GEL, TIP, axes, points=21)
    assert np.isfinite(axes.get_xlim()).all()


def test_pressure_map_integrates_to_the_force(result, axes):
    plots.pressure_map(result, GEL, TIP, axes, points=161)
    mesh = axes.collections[0]
    x = np.linspace(*axes.get_xlim(), 161) * 1e-9
    phi = np.mod(np.arctan2(x[:, None], x), 2 * np.pi)
    outline = np.interp(phi, result["phi"], result["contour"][-1], period=2 * np.pi)
    # the map is cut off at the outline
    assert mesh.get_clip_path() is not None
    field = np.where(np.hypot(x[:, None], x) < outline, np.asarray(mesh.get_array().filled(np.nan)), 0.0)
    cell = (np.diff(axes.get_xlim())[0] / 160 * 1e-9) ** 2
    # kPa on a grid of 160 cells a side: the edge of the contact and the apex leave about a per cent
    assert field.sum() * 1e3 * cell == pytest.approx(float(result["force"][-1]), rel=0.02)


@pytest.mark.parametrize("indenter", INDENTERS, ids=lambda indenter: type(indenter).__name__)
def test_figure_of_every_indenter(indenter, tmp_path):
    result = fp.indent(GEL, indenter, depth=[1e-8, 3e-8, 5e-8], angles=48)
    drawn = plots.figure(result, GEL, indenter, title="A title")
    assert plots.save_figure(drawn, tmp_path / "figure.png").stat().st_size > 10_000
    assert [path.name for path in tmp_path.iterdir()] == ["figure.png"]


def test_single_step(tmp_path):
    result = fp.indent(GEL, TIP, depth=1e-7, angles=48)
    plots.save_figure(plots.figure(result, GEL, TIP), tmp_path / "one.svg")
    assert (tmp_path / "one.svg").read_text(encoding="utf-8").lstrip().startswith("<?xml")


def test_stiff_film_is_drawn_up_to_where_the_outline_ends(tmp_path):
    """A film about 7 times stiffer: first-order outlines end at some depth and exist again beyond it."""
    film = fp.Medium([fp.Layer(young=200e9, poisson=0.3, thickness=1e-6)], base=fp.HalfSpace(30e9, 0.3))
    pyramid = fp.Pyramid(4, 0.3)
    result = fp.indent(film, pyramid, depth=np.linspace(1e-8, 2e-6, 80), angles=48, method="first-order")
    valid = result["valid"].values
    assert not valid.all()
    first_failure = int(np.argmin(valid))
    assert valid[first_failure:].any()
    with pytest.warns(
        fp.FlatpunchWarning, match="there are none of the first order, as the superposed pressure adds up to"
    ):
        drawn = plots.figure(result, film, pyramid)
    last = float(result["depth"][first_failure - 1]) * 1e9
    assert f"{last:.3g} nm" in drawn.axes[1].get_title()
    only_beyond = fp.indent(film, pyramid, depth=[1.9e-6, 2e-6], angles=48, method="first-order")
    with pytest.warns(fp.FlatpunchWarning, match="first-order outline does not exist along the whole history"):
        assert plots.figure(only_beyond, film, pyramid).axes[2].get_title().startswith("Pressure at")


def test_refusals(result, tmp_path):
    with pytest.raises(ValueError, match="the ending must be one of"):
        plots.save_figure(Figure(), tmp_path / "figure.docx")
    nowhere = result.copy(deep=True)
    nowhere["valid"][:] = False
    with pytest.raises(ValueError, match="no step with a contact at which the theory holds"):
        plots.figure(nowhere, GEL, TIP)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("indenter", [TIP, fp.EllipticParaboloid(2e5, 4e5), fp.Tilted(TIP, 0.05, 0.02)], ids=str)
def test_labels_of_level_lines_are_clear_of_the_frame(indenter, axes):
    result = fp.indent(GEL, indenter, depth=[4e-7], method="second-order", angles=48)
    plots.outline(result, indenter, axes)
    frame = axes.get_xlim()[1]
    labels = [text for text in axes.texts if text.get_text().endswith("m")]
    assert len(labels) > 2
    # without, those of a tilted pyramid's lines lay on it
    assert all(np.abs(text.get_position()).max() < 0.9 * frame for text in labels)
