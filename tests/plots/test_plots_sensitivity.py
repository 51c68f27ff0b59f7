"""Pictures of depth sensitivities: the numbers of the result, with the share of each layer."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import flatpunch as fp
from flatpunch.plots.sensitivity import layer_shares

FILM = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(70e9, 0.22))
PAIR = fp.TwoBodies(fp.HalfSpace(1e9, 0.3), FILM)
TIP = fp.Sphere(20e-6)


def test_profile_draws_the_numbers_and_the_shares():
    found = fp.sensitivity(FILM, TIP, depth=100e-9)
    axes = fp.plot_sensitivity(found)
    film = axes.lines[0].get_xydata()
    inside = found.layer.values == 0
    # every tenth point is one of the result, after one up to the surface; per micrometre
    np.testing.assert_allclose(film[10::10, 0], found.depth_sensitivity.values[inside] * 1e-6)
    np.testing.assert_allclose(film[10::10, 1], found.z.values[inside] * 1e6)
    # between them no new extremes
    assert film[:, 0].min() >= film[::10, 0].min()
    assert film[:, 0].max() <= film[::10, 0].max()
    written = [text.get_text() for text in axes.texts]
    assert "88.3 %" in written
    assert axes.yaxis_inverted()


def test_shares_of_two_bodies_are_in_the_order_of_depth():
    found = fp.sensitivity(PAIR, TIP, depth=100e-9)
    shares = layer_shares(found)
    names = ["upper.base.young", "lower.layers[0].young", "lower.base.young"]
    assert shares == pytest.approx([float(found.force.sel(parameter=name)) for name in names])
    assert fp.plot_sensitivity(found).lines


def test_a_curve_is_drawn_as_a_map():
    found = fp.sensitivity(FILM, TIP, depth=[50e-9, 100e-9, 150e-9])
    axes = fp.plot_sensitivity(found, Figure().subplots())
    (mesh,) = [each for each in axes.collections if hasattr(each, "get_coordinates")]
    assert np.asarray(mesh.get_array()).shape[1] == 3
    assert "nm" in axes.get_xlabel()


def test_what_has_no_depth_sensitivity_is_refused():
    found = fp.sensitivity(fp.PowerLawHalfSpace(1e9, 1e-6, 0.3, 0.3), TIP, depth=1e-8)
    with pytest.raises(ValueError, match="no depth_sensitivity"):
        fp.plot_sensitivity(found)


def test_a_second_curve_keeps_the_units_and_has_its_own_colour():
    film = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(70e9, 0.22))
    thick = fp.Medium([fp.Layer(2e9, 0.4, 1e-3)], base=fp.HalfSpace(70e9, 0.22))
    axes = fp.plot_sensitivity(fp.sensitivity(film, fp.Sphere(20e-6), depth=100e-9), label="thin")
    before, low = axes.get_ylabel(), axes.get_ylim()
    fp.plot_sensitivity(fp.sensitivity(thick, fp.Sphere(20e-3), depth=100e-6), axes, label="thick")
    assert axes.get_ylabel() == before
    assert axes.get_ylim()[0] > 100 * low[0] > 0  # downwards, deep enough for both
    colours = {line.get_label(): line.get_color() for line in axes.get_lines()}
    assert colours["thin"] != colours["thick"]
