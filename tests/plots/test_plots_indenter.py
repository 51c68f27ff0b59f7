"""Pictures of indenters: every kind is drawn, in readable units, with level lines where the heights say."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import flatpunch as fp
from flatpunch.plots import bodies
from flatpunch.plots import result as plots

X = np.linspace(-1e-6, 1e-6, 41)
TIPS = [
    fp.Vickers(tip_radius=1e-7),
    fp.Berkovich(height_removed=5e-8),
    fp.Knoop(),
    fp.Tilted(fp.Sphere(1e-6), 0.1),
    fp.Superellipse(1e-6, 6e-7, 1e-7),
    fp.SpheroCone(0.9, 5e-8),
    fp.HeightMap(X, X, (X**2 + X[:, None] ** 2) / 4e-6),
    fp.AreaFunction((24.5, 300.0), 1e-6, unit=1e-9),
]


@pytest.mark.long
@pytest.mark.parametrize("tip", TIPS, ids=lambda tip: type(tip).__name__)
def test_every_tip_is_drawn(tip, tmp_path):
    figure = bodies.indenter_figure(tip, extent=4e-7)
    assert len(figure.axes) == 3
    assert all("(nm)" in axes.get_xlabel() for axes in figure.axes)
    assert plots.save_figure(figure, tmp_path / "tip.png").stat().st_size > 20_000


@pytest.mark.parametrize("extent", [None, 1e-6, 5e-6])
@pytest.mark.parametrize("view", ["sections", "levels", "surface"])
def test_a_flat_end_is_drawn_with_its_side(view, extent):
    axes = fp.plot_tip(fp.Cylinder(2e-6), view=view, extent=extent)
    assert axes.get_title().startswith({"levels": "flat, dashed"}.get(view, view))
    if view == "sections":
        assert (np.ptp(axes.lines[0].get_ydata()) > 0) == (
            extent != 1e-6
        )  # a picture that ends within the face has no side


def test_level_lines_lie_at_their_heights():
    tip = fp.EllipticParaboloid(2e5, 5e5)
    axes = fp.plot_tip(tip, Figure().subplots(), extent=1e-6, view="levels")
    # the lowest height on the border is 2e5 (1e-6)^2 = 200 nm
    assert axes.get_title() == "level lines every 20 nm"
    line = axes.patches[-1].get_xy() * 1e-6  # drawn in um
    np.testing.assert_allclose(2e5 * line[:, 0] ** 2 + 5e5 * line[:, 1] ** 2, 2e-7, rtol=1e-12)


def test_sections_go_where_the_tip_is_steepest_and_flattest():
    axes = fp.plot_tip(fp.EllipticParaboloid(2e5, 5e5), Figure().subplots(), extent=1e-6)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["along 90°", "along 0°"]
    assert max(axes.lines[0].get_ydata()) == pytest.approx(500)  # nm
    assert len(fp.plot_tip(fp.Sphere(1e-6), Figure().subplots(), extent=1e-6).lines) == 1


def test_a_flat_without_anything_beyond_is_refused():
    with pytest.raises(ValueError, match="Draw a larger extent"):
        bodies.indenter_figure(fp.Vickers(height_removed=1e-7), extent=1e-8)
    with pytest.raises(ValueError, match="extent"):
        bodies.indenter_figure(fp.Cone(0.4), extent=0)


@pytest.mark.parametrize("view", ["sections", "levels", "surface"])
def test_a_second_tip_keeps_units_and_has_its_own_colours(view):
    axes = fp.plot_tip(fp.Sphere(1e-6), extent=4e-7, view=view, label="bead")
    before = axes.get_xlabel(), axes.get_ylabel()
    assert fp.plot_tip(fp.EllipticParaboloid(2e5, 5e5), axes, extent=4e-6, view=view, label="tip") is axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == before
    assert axes.get_xlim()[1] == pytest.approx(4000, rel=0.3)  # nm
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert {name.split(",")[0] for name in names} == {"bead", "tip"}
    # level lines of a surface have the colour of their tip
    named = {line.get_color() for line in axes.get_legend().get_lines()}
    assert len(named) == len(names)
