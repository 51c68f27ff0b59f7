"""Known thicknesses: how far they move the modulus, beside its interval."""

from dataclasses import replace

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.fits import Normal
from support.sticky_curves import sticky

TIP, YOUNG = fp.Sphere(5e-6), ["layers[0].young"]
GEL = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], base=fp.RigidBase())
THICK = fp.Medium([fp.Layer(5e3, 0.5, 50e-6)], base=fp.RigidBase())


def curve_on(body, name="curve", seed=0):
    depth = np.linspace(-2e-7, 4e-7, 300)
    force = np.zeros(300)
    force[depth > 0] = fp.indent(body, TIP, depth=depth[depth > 0]).force
    return fp.Curve(depth, force + 0.01 * force.max() * np.random.default_rng(seed).normal(size=300), name=name)


def about(notes):
    return [note for note in notes if "takes the thickness as known" in note]


@pytest.mark.long
@pytest.mark.parametrize("options", [{}, {"finite_strain": "neo-hookean"}])
def test_the_note_gives_the_change_that_another_thickness_makes(options):
    curve = curve_on(GEL)
    found = fp.fit(curve, GEL, TIP, YOUNG, **options)
    thicker = fp.Medium([replace(GEL.layers[0], thickness=2.2e-6)], base=GEL.base)
    change = fp.fit(curve, thicker, TIP, YOUNG, **options)[YOUNG[0]] / found[YOUNG[0]] - 1
    (note,) = about(found.notes)
    assert f"changes by {change:+.1%} where layers[0].thickness is 10% larger than the 2 µm given" in note


def test_a_thickness_that_the_modulus_does_not_feel_or_that_is_fitted_needs_no_note():
    assert not about(fp.fit(curve_on(THICK), THICK, TIP, YOUNG).notes)
    assert not about(fp.fit(curve_on(GEL), GEL, TIP, [*YOUNG, "layers[0].thickness"]).notes)


def test_batches_note_a_thickness_that_is_not_given_for_each_curve():
    curves = [curve_on(GEL, str(i), i) for i in range(2)]
    assert "takes the thickness as known" in fp.fit_batch(curves, GEL, TIP, YOUNG, workers=1).rows[1]["notes"]
    given = {"layers[0].thickness": [2e-6, 2e-6]}
    assert "thickness" not in fp.fit_batch(curves, GEL, TIP, YOUNG, workers=1, values=given).rows[1]["notes"]


@pytest.mark.long
def test_the_note_of_a_sticking_tip_says_what_its_posterior_takes():
    """Numbers that are held are drawn in elastic fits of one curve only."""
    free = [*YOUNG, "work_of_adhesion"]
    result = fp.fit(sticky(GEL, TIP, 1e-4, 4e-7, noise=0.005), GEL, TIP, free, work_of_adhesion=1e-4)
    known = {"layers[0].thickness": Normal(2e-6, 1e-7)}
    (note, *_) = about(result.notes)
    assert "Measure it; fitted as well, with a prior of it" in note
    with pytest.raises(ValueError, match="was not fitted"):
        result.posterior(priors=known)
    elastic = fp.fit(curve_on(GEL), GEL, TIP, YOUNG)
    assert "Measure it; with a prior of it" in about(elastic.notes)[0]
    assert "layers[0].thickness" in elastic.posterior(draws=100, priors=known).numbers


@pytest.mark.long
def test_several_curves_of_one_sample_and_every_layer_on_them():
    body = fp.Medium([fp.Layer(20e3, 0.5, 1e-6), fp.Layer(5e3, 0.5, 1e-6)], base=fp.RigidBase())
    curves = [curve_on(body, str(i), i) for i in range(2)]
    notes = about(fp.fit_together(curves, body, TIP, ["layers[1].young"]).notes)
    assert ["layers[0].thickness" in notes[0], "layers[1].thickness" in notes[-1]] == [True, True]
    measured = [fp.Measured(each, values={"layers[1].thickness": 1e-6}) for each in curves]
    assert len(about(fp.fit_together(measured, body, TIP, ["layers[1].young"]).notes)) == 1
