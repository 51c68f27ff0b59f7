"""Where the theory ends: layers pressed through, large strains, pressures that no solid bears."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.contact.limits import compression, deepest, judged

H = 1e-7
LAYER = fp.Medium([fp.Layer(5e3, 0.45, H)], fp.RigidBase())
BALL = fp.Paraboloid(5e-6)


@pytest.mark.parametrize(
    "tip", [BALL, fp.Cone(0.3), fp.Pyramid(4, 0.5), fp.Cylinder(1e-7)], ids=lambda tip: type(tip).__name__
)
def test_a_tip_cannot_go_through_a_layer_on_a_rigid_base(tip):
    curve = fp.indent(LAYER, tip, depth=np.array([0.1, 0.3, 0.4, 0.9, 1.0, 4.0]) * H, method="second-order")
    assert curve.valid.values.tolist() == [True] * 4 + [False] * 2
    through, compressed = (
        next(note for note in curve.attrs["notes"].splitlines() if words in note)
        for words in ("pressed through", "more than a third")
    )
    assert through.startswith("At depths of 100 nm and more: ")
    # up to the depth from which on the other note holds
    assert compressed.startswith("Between depths of 40 nm and 90 nm: ")
    assert "more than a third" not in fp.indent(LAYER, tip, depth=0.3 * H, method="second-order").attrs["notes"]


def test_forces_and_radii_that_lead_there_are_marked_alike():
    curve = fp.indent(LAYER, BALL, depth=np.array([0.5, 1.5]) * H)
    for name in ("force", "radius"):
        again = fp.indent(LAYER, BALL, **{name: curve[name].values})
        assert again.valid.values.tolist() == [True, False]


def test_histories_are_marked():
    time = np.linspace(0, 2, 21)
    curve = fp.indent(
        LAYER, BALL, depth=1.2 * H * np.minimum(time, 1), time=time, relaxation=fp.StandardLinearSolid(0.5, 1.0)
    )
    assert curve.valid[:9].all()
    assert not curve.valid[10:].any()


def test_fields_and_loops_beyond_the_base_are_refused():
    with pytest.raises(ValueError, match=r"depth = 400 nm is more than the 100 nm of the layers on their rigid base"):
        fp.pressure(LAYER, BALL, 0.0, 0.0, depth=4 * H)
    with pytest.raises(ValueError, match="on their rigid base"):
        fp.adhesion_loop(LAYER, BALL, work_of_adhesion=1e-5, depth=4 * H)


def test_a_soft_layer_on_glass_is_like_one_on_a_rigid_base():
    glass = fp.Medium([fp.Layer(5e3, 0.45, H)], fp.HalfSpace(70e9, 0.2))
    assert fp.indent(glass, BALL, depth=np.array([0.9, 1.1]) * H).valid.values.tolist() == [True, False]
    # a second, stiff layer does not help
    more = fp.Medium([fp.Layer(5e3, 0.45, H), fp.Layer(5e9, 0.3, 50 * H)], fp.RigidBase())
    assert fp.indent(more, BALL, depth=np.array([0.9, 1.1]) * H).valid.values.tolist() == [True, False]


def test_films_on_soft_bases_go_down_with_their_base():
    film = fp.Medium([fp.Layer(70e9, 0.2, H)], fp.HalfSpace(5e3, 0.45))
    curve = fp.indent(film, fp.Cylinder(100 * H), depth=np.array([0.5, 1.1, 3.0]) * H)
    assert "layer" not in curve.attrs["notes"]


def test_what_the_base_takes_is_at_least_what_it_takes_on_a_half_space():
    """A layer as stiff as its base: compressed is at most the depth, and never more than the exact displacement difference."""
    body = fp.Medium([fp.Layer(5e3, 0.3, H)], fp.HalfSpace(5e3, 0.3))
    curve = fp.indent(body, fp.Cylinder(10 * H), depth=H)
    # a flat punch on one half-space: F = 2 E* a d, so F/(E* a) = 2 d is more than all of it
    assert compression(body, *(curve[n].values for n in ("depth", "force", "radius")))[0] == 0


def test_two_bodies_share_the_depth():
    pair = fp.TwoBodies(LAYER, LAYER)
    assert deepest(pair) == pytest.approx(2 * H)
    assert fp.indent(pair, BALL, depth=np.array([1.9, 2.1]) * H).valid.values.tolist() == [True, False]
    assert deepest(fp.TwoBodies(LAYER, fp.HalfSpace(1e3, 0.3))) == np.inf
    assert deepest(fp.TwoBodies(LAYER, fp.RigidBase())) == pytest.approx(H)


@pytest.mark.parametrize(("depth", "noted"), [(0.03, False), (0.3, True)])
def test_depth_over_radius_is_a_strain(depth, noted):
    body, ball = fp.HalfSpace(5e3, 0.5), fp.Paraboloid(1e-6)
    notes = fp.indent(body, ball, depth=[0.5e-6 * depth, depth * 1e-6 + 1e-7]).attrs["notes"]
    assert ("strains are about" in notes) == noted


def test_cones_are_noted_by_their_slope():
    body = fp.HalfSpace(5e3, 0.3)
    assert "strains are about 14 %" in fp.indent(body, fp.Cone(np.radians(35)), depth=1e-7).attrs["notes"]
    assert "strains are about" not in fp.indent(body, fp.Cone(np.radians(20)), depth=1e-7).attrs["notes"]
    # where the table of large strains has the case, its number takes the place of the slope
    gel, steep = fp.HalfSpace(5e3, 0.5), fp.Cone(np.radians(35))
    assert "a neo-Hookean solid takes 5.1 % less force" in fp.indent(gel, steep, depth=1e-7).attrs["notes"]


def test_pressures_above_the_strength_of_solids_are_noted():
    # mean pressure under a cone E* tan(beta)/2: a tenth of E* at 11.3 degrees
    steel = fp.HalfSpace(200e9, 0.3)
    for degrees, noted in ((11.0, False), (11.6, True)):
        notes = fp.indent(steel, fp.Cone(np.radians(degrees)), depth=1e-8).attrs["notes"]
        assert ("Solids that yield have done so" in notes) == noted
    # confined incompressible layers bear any pressure
    thin = fp.Medium([fp.Layer(1e6, 0.5, H)], fp.RigidBase())
    assert "Solids that yield" not in fp.indent(thin, fp.Paraboloid(1e-4), depth=0.2 * H).attrs["notes"]


def test_area_functions_say_what_they_are():
    tip = fp.AreaFunction((24.5, 100.0), limit=1e-6, unit=1e-9)
    assert "body of revolution" in fp.indent(fp.HalfSpace(1e9, 0.3), tip, depth=1e-7).attrs["notes"]


def test_numbers_that_are_not_finite_are_never_valid():
    from dataclasses import replace

    from flatpunch.contact.curve import Curve

    one = np.ones(2)
    curve = Curve(one, one, one, one, 1e9 * one, np.ones((2, 8)), np.ones(2, dtype=bool))
    broken = judged(replace(curve, force=np.array([1.0, np.nan])), fp.HalfSpace(1e9, 0.3), BALL)
    assert broken.valid.tolist() == [True, False]
    assert "not finite" in " ".join(broken.notes)


def test_forces_whose_error_is_as_large_as_themselves_are_not_valid():
    # three sides on a stiff film: second order is off many times over before the film goes down with its base
    film = fp.Medium([fp.Layer(30.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    curve = fp.indent(film, fp.Pyramid(3, 0.35), depth=np.geomspace(1e-3, 3, 60), method="second-order")
    known = curve.force_error.values < 1
    assert 0.3 < known.mean() < 1
    assert (curve.valid.values == known).all()
    # what such a force would say of the layers is not said
    assert "pressed through" not in curve.attrs["notes"]


@pytest.mark.long
@pytest.mark.parametrize("tip", [fp.Truncated(fp.Cone(0.1), 0.05), fp.Truncated(fp.EllipticParaboloid(0.5, 1.0), 0.1)])
def test_no_contact_has_a_radius_inside_a_flat_end(tip):
    curve = fp.indent(fp.HalfSpace(1e9, 0.3), tip, radius=[0.1, 0.3, 0.8])
    assert curve.valid.values.tolist() == [False, False, True]
    assert "At radii up to 300 mm: the flat end of the tip is larger" in curve.attrs["notes"]
    assert fp.indent(fp.HalfSpace(1e9, 0.3), tip, depth=[0.0, 0.01]).valid.all()
