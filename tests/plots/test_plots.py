"""Pictures: what is drawn is what the result says, in readable units, for every kind of indenter."""

import re

import numpy as np
import pytest
from matplotlib.figure import Figure

import flatpunch as fp
from flatpunch.bem.bounding_box import overlap_half_widths
from flatpunch.plots import result as plots
from flatpunch.plots.style import STYLES

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


def drawn_at(line, x):
    """Values of a drawn line at some of its points."""
    along, values = line.get_data()
    at = np.searchsorted(along, np.asarray(x) * (1 - 1e-12))
    np.testing.assert_allclose(along[at], x)
    return values[at]


def test_curve_goes_through_the_numbers(result, axes):
    assert fp.plot_curve(result, axes) is axes
    right = next(other for other in axes.figure.axes if other is not axes)
    depth = result["depth"] * 1e9  # nm
    # pN: the largest is below 1 nN
    np.testing.assert_allclose(drawn_at(axes.lines[0], depth), result["force"] * 1e12)
    np.testing.assert_allclose(drawn_at(right.lines[0], depth), result["stiffness"] * 1e3)  # mN/m
    assert axes.get_xlabel() == "indentation depth $d$ (nm)"
    assert axes.get_ylabel() == "normal force $F$ (pN)"
    assert "mN/m" in right.get_ylabel()


@pytest.mark.parametrize("indenter", [fp.Sphere(2e-6), fp.Cone(0.5), fp.Cylinder(5e-7)], ids=repr)
def test_curve_between_few_steps_is_that_of_many(indenter):
    """It starts at zero with its power law, and no chord shows: a hundredth of the force at eight steps."""
    few = fp.indent(GEL, indenter, depth=np.linspace(5e-8, 4e-7, 8))
    x, y = fp.plot_curve(few).lines[0].get_data()
    assert (x[0], y[0]) == (0, 0)
    factor = y[-1] / float(few["force"][-1])
    many = fp.indent(GEL, indenter, depth=x[1:] * 1e-9)
    np.testing.assert_allclose(y[1:], many["force"] * factor, atol=0.002 * y[-1])


def test_error_of_the_force_is_drawn_and_said(result, axes):
    rough = fp.indent(GEL, TIP, depth=result["depth"], angles=48, method="first-order")
    fp.plot_curve(rough, axes)
    error = float(rough["force_error"].max())
    assert axes.get_title() == f"Method first-order, force to {100 * error:.2g} %"
    (band,) = axes.collections
    top = band.get_paths()[0].vertices[:, 1].max()
    assert top == pytest.approx(float(rough["force"][-1]) * 1e12 * (1 + float(rough["force_error"][-1])), rel=1e-9)
    outline = fp.plot_outline(rough, indenter=TIP)
    assert f"{100 * float(rough['contour_error'][-1]):.0f} %" in outline.get_title()


def test_round_contacts_are_drawn_as_exact(axes):
    fp.plot_curve(fp.indent(GEL, fp.Paraboloid(2e-6), depth=1e-7), axes)
    assert axes.get_title() == "Exact (round tip)"


def test_steps_where_the_theory_fails_are_drawn_apart(result, axes):
    broken = result.copy(deep=True)
    broken["valid"][15:] = False
    fp.plot_curve(broken, axes)
    sound, grey = axes.lines[:2]
    depth = result["depth"] * 1e9
    assert np.isfinite(drawn_at(sound, depth)).sum() == 15
    assert np.isfinite(drawn_at(grey, depth)).sum() == 5


def test_outline_is_closed_and_of_the_last_valid_step(result, axes):
    broken = result.copy(deep=True)
    broken["valid"][15:] = False
    fp.plot_outline(broken, axes, indenter=TIP)
    x, y = axes.lines[-1].get_data()
    assert (x[0], y[0]) == pytest.approx((x[-1], y[-1]))
    # polar radii of the drawn curve are the contour of step 14, in nm
    np.testing.assert_allclose(np.hypot(x, y)[:-1], result["contour"][14] * 1e9, rtol=1e-12)
    assert axes.get_aspect() == 1


def test_contacts_without_an_outline(result, axes):
    """The last that has one is drawn; if none has, what the indenter would overlap bounds the picture."""
    apart = result.copy(deep=True)
    apart["contour"][15:] = np.nan
    fp.plot_outline(apart, axes, indenter=TIP)
    x, y = axes.lines[-1].get_data()
    np.testing.assert_allclose(np.hypot(x, y)[:-1], result["contour"][14] * 1e9, rtol=1e-12)
    apart["contour"][:] = np.nan
    axes.clear()
    fp.plot_outline(apart, axes, indenter=TIP)
    assert axes.get_title().startswith("Several parts, no outline")
    depth = float(result["depth"][-1])
    across = max(overlap_half_widths(TIP, depth))
    factor = 1e9 if "nm" in axes.get_xlabel() else 1e6
    assert axes.get_xlim() == pytest.approx((-across * factor, across * factor))
    axes.clear()
    fp.plot_pressure(apart, GEL, TIP, axes)
    assert np.isfinite(axes.get_xlim()).all()


def total(mesh):
    """Integral of a coloured mesh, by two triangles a cell."""
    corners = mesh.get_coordinates()
    values = np.asarray(mesh.get_array()).reshape(corners.shape[:2])
    sum_of = 0.0
    for first, second in (((1, 0), (1, 1)), ((1, 1), (0, 1))):
        a = corners[:-1, :-1]
        b, c = (corners[i : i - 1 or None, j : j - 1 or None] for i, j in (first, second))
        height = values[:-1, :-1]
        for i, j in (first, second):
            height = height + values[i : i - 1 or None, j : j - 1 or None]
        u, v = b - a, c - a
        sum_of += (np.abs(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]) / 2 * height / 3).sum()
    return sum_of


def test_pressure_map_integrates_to_the_force(result, axes):
    assert fp.plot_pressure(result, GEL, TIP, axes) is axes
    # kPa over nm^2 down to the outline; colours are linear between rays, which adds a per cent along edges
    assert total(axes.collections[0]) * 1e3 * 1e-18 == pytest.approx(float(result["force"][-1]), rel=0.02)


@pytest.mark.long
@pytest.mark.parametrize("style", STYLES)
def test_styles_have_the_width_of_their_columns(result, style, tmp_path):
    drawn = plots.figure(result, GEL, TIP, title="A title", style=style)
    width = STYLES[style].width
    assert width is None or drawn.get_size_inches()[0] == width
    assert plots.save_figure(drawn, tmp_path / "figure.pdf").read_bytes().startswith(b"%PDF")
    # nothing is cut off at the sides
    box = drawn.get_tightbbox()
    assert box.x0 > -0.02
    assert box.x1 < drawn.get_size_inches()[0] + 0.02
    with pytest.raises(
        ValueError, match=r"style = 'poster' is unknown; choose one of 'screen', 'one-column', 'two-columns'\."
    ):
        plots.figure(result, GEL, TIP, style="poster")


@pytest.mark.long
@pytest.mark.parametrize("indenter", INDENTERS, ids=lambda indenter: type(indenter).__name__)
def test_figure_of_every_indenter(indenter, tmp_path):
    result = fp.indent(GEL, indenter, depth=[1e-8, 3e-8, 5e-8], angles=48)
    drawn = plots.figure(result, GEL, indenter, title="A title")
    assert plots.save_figure(drawn, tmp_path / "figure.png").stat().st_size > 10_000
    assert [path.name for path in tmp_path.iterdir()] == ["figure.png"]


@pytest.mark.long
def test_single_step(tmp_path):
    result = fp.indent(GEL, TIP, depth=1e-7, angles=48)
    plots.save_figure(plots.figure(result, GEL, TIP), tmp_path / "one.svg")
    assert (tmp_path / "one.svg").read_text(encoding="utf-8").lstrip().startswith("<?xml")


@pytest.mark.long
def test_stiff_film_is_drawn_up_to_where_the_outline_ends(tmp_path):
    """A film about 7 times stiffer: first-order outlines end at some depth and exist again beyond it."""
    film = fp.Medium([fp.Layer(young=200e9, poisson=0.3, thickness=1e-6)], base=fp.HalfSpace(30e9, 0.3))
    pyramid = fp.Pyramid(4, 0.3)
    result = fp.indent(film, pyramid, depth=np.linspace(1e-8, 2e-6, 80), angles=48, method="first-order")
    valid = result["valid"].values
    assert not valid.all()
    first_failure = int(np.argmin(valid))
    assert valid[first_failure:].any()
    # drawn at the last step whose force is known
    with pytest.warns(fp.FlatpunchWarning, match="are those of stretched flat punches"):
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


@pytest.mark.parametrize("indenter", [TIP, fp.EllipticParaboloid(2e5, 4e5), fp.Tilted(TIP, 0.05, 0.02)], ids=repr)
def test_level_lines_are_named_in_the_legend(indenter, axes):
    """Where no label can cross a line or the frame; they are a round height apart."""
    result = fp.indent(GEL, indenter, depth=[1e-7, 2e-7, 4e-7], method="second-order", angles=48)
    fp.plot_outline(result, axes, indenter=indenter)
    assert not axes.texts
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names[0] == "contact"
    assert "earlier" in names
    (spacing,) = (re.fullmatch(r"tip, every ([\d.]+) [nµ]m", name)[1] for name in names if name.startswith("tip"))
    assert spacing.strip("0.") in ("1", "2", "5")
    assert len(axes.collections[0].get_paths()) >= 4


@pytest.mark.parametrize("view", ["sections", "levels", "surface"])
def test_public_pictures_make_axes_of_their_own(result, view):
    tip = fp.plot_tip(TIP, extent=1e-6, view=view)
    others = fp.plot_curve(result), fp.plot_outline(result), fp.plot_pressure(result, GEL, TIP), fp.plot_medium(GEL)
    assert len({id(axes.figure) for axes in (tip, *others)}) == 5


def test_what_is_no_axes_and_no_step_is_refused(result):
    for draw in (lambda: fp.plot_curve(result, GEL), lambda: fp.plot_medium(GEL, TIP), lambda: fp.plot_tip(TIP, GEL)):
        with pytest.raises(TypeError, match="must be axes of Matplotlib"):
            draw()
    with pytest.raises(TypeError, match="must be axes of Matplotlib"):
        fp.plot_sensitivity(fp.sensitivity(GEL, fp.Sphere(2e-6), depth=1e-8), GEL)
    for step in (99, 0.5, "last"):
        with pytest.raises((TypeError, ValueError), match="step"):
            fp.plot_outline(result, indenter=TIP, step=step)


def test_utilisation_is_drawn_as_stress_over_the_strength_of_each_layer(axes):
    film = fp.Medium([fp.Layer(3e9, 0.3, 1e-6)], base=fp.HalfSpace(1e9, 0.3))
    x, z = np.linspace(-2e-6, 2e-6, 5), np.array([0.3e-6, 0.7e-6, 1.5e-6])
    inside = fp.fields(film, fp.Paraboloid(1e-5), x=x, y=0.0, z=z[:, None], force=1e-3)
    fp.plot_fields(inside, quantity="utilisation", strengths=[fp.Strength(2e9), fp.Strength(0.5e9)], axes=axes)
    map_ = axes.collections[0]
    drawn, expected = map_.get_array(), inside.von_mises.values / np.array([[2e9], [2e9], [0.5e9]])
    assert float(drawn.max()) == pytest.approx(float(expected.max()), rel=1e-6)
