"""Fits with a range of action: the tables against the exact branch, flat ends, and synthetic truth."""

from dataclasses import replace

import numpy as np
import pytest

from flatpunch.contact import pull_off
from flatpunch.contact.physics import Physics
from flatpunch.fits import CurveError, Free, Sample, Settings, fit
from flatpunch.fits.adhesion.model import AdhesiveModel
from flatpunch.fits.case import FitCase
from flatpunch.fits.reading import reading_of, traces
from flatpunch.indenters import Cone, Paraboloid, Sphere, Truncated
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase
from support.sticky_curves import sticky

GEL = Medium([Layer(5e3, 0.5, 1e-6)], RigidBase())
YOUNG, WORK = "layers[0].young", "work_of_adhesion"
W = 1e-4
STIFF = HalfSpace(2e5, 0.5)
"""Pull-off under the tips below lies between JKR theory and that of rigid bodies, with most of the depth before they touch."""


@pytest.mark.long
@pytest.mark.parametrize(
    ("medium", "tip", "free", "more"),
    [
        (STIFF, Paraboloid(3e-6), ("base.young", WORK), {"range_of_action": 3e-8}),
        (STIFF, Paraboloid(3e-6), ("base.young", "indenter.radius", "strength"), {"strength": 2e3}),
        (STIFF, Cone(0.3), ("base.young", WORK, "indenter.inclination"), {"range_of_action": 3e-8}),
        (GEL, Sphere(3e-6), (YOUNG, WORK), {"range_of_action": 1e-7}),
        (GEL, Sphere(3e-6), (YOUNG,), {"strength": 1e5}),
    ],
    ids=["paraboloid", "strength", "cone", "gel", "nearly JKR"],
)
def test_tables_of_finite_range_give_the_exact_branch_and_its_derivatives(medium, tip, free, more):
    """Before the surfaces touch and after."""
    model = AdhesiveModel(Sample(medium, tip, Physics(W, **more)), free)
    theta = model.start()
    lost = pull_off(medium, tip, work_of_adhesion=W, **more).depth_minimum
    assert model.pull_off(theta)[0] == pytest.approx(lost.depth, rel=1e-4 if lost.radius else 1e-2)
    depth = np.linspace(0.97 * lost.depth, 3e-7, 60)
    force, _, derivatives = model.evaluate(depth, theta)
    np.testing.assert_allclose(force, model.exact(depth, {})[0], rtol=0, atol=5e-6 * np.abs(force).max())
    step = 1e-5
    for j in range(theta.size):
        up, down = theta.copy(), theta.copy()
        up[j], down[j] = up[j] + step, down[j] - step
        slope = (model.evaluate(depth, up)[0] - model.evaluate(depth, down)[0]) / (2 * step)
        inner = depth > 0.7 * lost.depth
        np.testing.assert_allclose(derivatives[j][inner], slope[inner], rtol=0, atol=1e-5 * np.abs(slope).max())


@pytest.mark.long
@pytest.mark.parametrize(
    ("medium", "tip", "free", "more"),
    [
        (STIFF, Truncated(Cone(0.3), 5e-8), ("base.young", WORK), {"range_of_action": 5e-8}),
        (STIFF, Truncated(Cone(0.3), 5e-8), ("base.young", WORK), {"range_of_action": 2e-9}),
        pytest.param(GEL, Truncated(Sphere(3e-6), 2e-8), (YOUNG,), {"strength": 2e4}, marks=pytest.mark.slow),
    ],
    ids=["before the surfaces touch", "nearly JKR", "gel"],
)
def test_contacts_of_finite_range_are_followed_over_a_flat_end(medium, tip, free, more):
    """They shrink over it until adhesion acts no further than its border, long after JKR theory lets go at the border."""
    model = AdhesiveModel(Sample(medium, tip, Physics(W, **more)), free)
    theta, (flat,) = model.start(), tip.rings
    lost = pull_off(medium, tip, work_of_adhesion=W, **more).depth_minimum
    assert lost.radius < 0.999 * flat
    assert model.pull_off(theta) == pytest.approx((lost.depth, lost.force), rel=1e-6)
    depth = np.linspace(0.97 * lost.depth, 3e-7, 80)
    exact = model.exact(depth, {})
    assert "flat end" not in exact.notes
    force, _, derivatives = model.evaluate(depth, theta)
    np.testing.assert_allclose(force, exact.force, rtol=0, atol=1e-6 * np.abs(exact.force).max())
    step = 1e-5
    for j in range(theta.size):
        up, down = theta.copy(), theta.copy()
        up[j], down[j] = up[j] + step, down[j] - step
        slope = (model.evaluate(depth, up)[0] - model.evaluate(depth, down)[0]) / (2 * step)
        # derivatives over the flat are differences by 1e-4
        np.testing.assert_allclose(derivatives[j], slope, rtol=0, atol=1e-4 * np.abs(slope).max())


@pytest.mark.long
@pytest.mark.parametrize("step", [-0.7, 0.0, 0.7])
def test_the_force_beyond_pull_off_changes_smoothly_where_surfaces_touch_over_the_flat_from_the_start(step):
    """The surfaces touch as soon as adhesion acts beyond the border of the flat: there is no branch before that."""
    tip, deepest = Truncated(Cone(0.3), 2e-7), np.array([2e-7])
    model = AdhesiveModel(Sample(HalfSpace(5e3, 0.45), tip, Physics(9e-6, 6e-9)), ("base.young", WORK))
    theta = model.start() + np.array([0.0, step])
    beyond = 1.2 * model.pull_off(theta)[0]

    def slope(theta):
        depth = np.append(beyond, deepest)
        return model.evaluate(depth, theta)[1][0]

    # by 1 % where theta changes by as much; in an empty part of the branch the slope is noise
    for shift in 1e-2 * np.eye(2):
        assert slope(theta + shift) == pytest.approx(slope(theta), rel=0.03)


@pytest.mark.long
def test_the_force_has_no_step_where_the_contact_reaches_the_border_of_a_flat():
    """There the depth rises steeply below the border and hardly above it."""
    tip = Truncated(Paraboloid(1.25e-6), 3e-8)
    model = AdhesiveModel(Sample(HalfSpace(2.9e4, 0.5), tip, Physics(1.2e-4, 2.6e-8)), ("base.young", WORK))
    branch = model.branch(model.start(), 1.25e-7)
    border = branch.at(np.array([branch.edge])).depth[0]
    # the deepest reading tells how far the branch is followed
    depth = np.append(border * np.linspace(1.01, 0.99, 2001), 1.25e-7)
    force = model.evaluate(depth, model.start())[0]
    assert np.abs(np.diff(force[:-1], 2)).max() < 1e-5 * np.abs(force).max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("modulus", "poisson", "tip", "work", "within", "deepest", "noise"),
    [
        pytest.param(2e5, 0.5, Truncated(Cone(0.3), 5e-8), W, 1e-8, 2e-7, 0.005, id="half of the adhesive way"),
        pytest.param(5.2e3, 0.45, Truncated(Cone(0.3), 2.05e-7), 9e-6, 6e-9, 2e-7, 0.008, id="touching from the start"),
        pytest.param(7e4, 0.5, Truncated(Cone(0.475), 3.7e-7), 4e-4, 1.6e-7, 2.8e-7, 0.0135, id="long range"),
        pytest.param(3e4, 0.2, Truncated(Sphere(1.6e-6), 5e-9), 6e-5, 2.4e-8, 1.6e-7, 0.012, id="small flat"),
    ],
)
def test_fits_of_finite_range_under_a_flat_end(modulus, poisson, tip, work, within, deepest, noise):
    """Much of the adhesive way is over the flat."""
    curve = sticky(HalfSpace(modulus, poisson), tip, work, deepest, noise=noise, range_of_action=within)
    begun = HalfSpace(1.5 * modulus, poisson), tip, ["base.young", WORK]
    result = fit(curve, *begun, work_of_adhesion=2 * work, range_of_action=within)
    for name, truth in (("base.young", modulus), (WORK, work)):
        assert abs(result[name] - truth) < 3 * result.estimates[name].stderr
    assert not any("flat" in note or "correlated" in note or "held" in note for note in result.notes)


def test_tables_asked_beyond_the_end_of_a_tip_are_empty_there():
    tip = Truncated(Sphere(1.6e-6), 5e-9)
    model = AdhesiveModel(Sample(HalfSpace(3e4, 0.2), tip, Physics(6e-5)), ("base.young", WORK))
    table = model._tables.functions[0]
    assert np.isnan(table.solve((), np.array([2e-6, 3e-6]))).all()


def test_a_range_that_reaches_beyond_the_tip_is_refused_with_its_value():
    tip = Sphere(3e-6)
    model = AdhesiveModel(Sample(STIFF, tip, Physics(W, 2e-6)), ("base.young", "range_of_action"))
    with pytest.raises(ValueError, match=r"range_of_action = 2 µm is too long for fits under this tip"):
        model.evaluate(np.array([1e-7]), model.start())


@pytest.mark.long
@pytest.mark.parametrize("spring", [None, 0.5])
@pytest.mark.parametrize("free", [("base.young", WORK), ("base.young", WORK, "range_of_action")])
def test_the_truth_comes_back_with_a_range_of_action(free, spring):
    """JKR theory would give 2.4 times the work of adhesion."""
    tip, within = Paraboloid(3e-6), 3e-8
    curve = sticky(STIFF, tip, W, 1e-7, spring=spring, noise=0.005, range_of_action=within)
    start = {"work_of_adhesion": 2 * W, "range_of_action": within * (2 if len(free) == 3 else 1)}
    result = fit(curve, HalfSpace(4e5, 0.5), tip, free, **start)
    for name, truth in zip(free, (2e5, W, within), strict=False):
        assert abs(result[name] - truth) < 4 * result.estimates[name].stderr, name
    assert result.estimates[WORK].stderr < 0.05 * W


def test_a_curve_is_read_without_the_tables_of_a_range_of_action():
    """They would take minutes, on the page at every change of the form."""
    curve, free = sticky(GEL, Sphere(3e-6), W, 3e-7), {YOUNG: Free(), "range_of_action": Free(maximum=1e-8)}
    jkr = FitCase("", GEL, Sphere(3e-6), {YOUNG: Free()}, Settings(), physics=Physics(W))
    lines = reading_of(curve, replace(jkr, free=free, physics=Physics(W, 1e-9))).lines
    without = " (without the range of action)"
    assert without in " ".join(lines)
    assert [line.replace(without, "") for line in lines] == list(reading_of(curve, jkr).lines)
    # the background is that of the readings without contact, whatever the contact is taken for
    level = float(np.median(curve.force[-80:]))
    shown = next(force for name, _, force in traces(reading_of(curve, jkr)) if name == "baseline")
    np.testing.assert_allclose(shown, level, atol=3e-3 * np.ptp(curve.force))


@pytest.mark.long
def test_a_curve_that_the_fit_misses_is_not_simply_called_pinned():
    curve = sticky(STIFF, Paraboloid(3e-6), W, 1e-7, noise=0.005, range_of_action=3e-8)
    with pytest.raises(CurveError, match=r"nearly all the way, or the fit has missed the curve: give other starts"):
        fit(curve, STIFF, Paraboloid(3e-6), ["base.young", WORK], work_of_adhesion=W, range_of_action=30.0)
