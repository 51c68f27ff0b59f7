"""Limits, layers, any history, both roads against each other, orders of convergence, refusals."""

from dataclasses import replace

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.contact.perturbation import first_order
from flatpunch.contact.viscoelastic.depth_history import followed
from flatpunch.contact.viscoelastic.elastic import elastic_curve
from flatpunch.contact.viscoelastic.series import exponential_series
from flatpunch.contact.viscoelastic.springs import Springs

GEL = fp.HalfSpace(young=1e6, poisson=0.5)
BALL = fp.Paraboloid(1e-5)
V = 1e-6
SOLID = fp.StandardLinearSolid(0.3, 0.2)
POWER = fp.PowerLawRelaxation(0.2, 1.0)
LAYER = fp.Medium([fp.Layer(1e4, 0.49, 3e-6)], base=fp.RigidBase())


def triangle(t):
    return V * np.minimum(t, 2 - t)


@pytest.mark.parametrize(("duration", "share"), [(1e-7, 1.0), (1e7, 0.3)])
@pytest.mark.parametrize("medium", [GEL, LAYER], ids=["half-space", "layer"])
def test_elastic_at_fast_and_slow_rates(medium, duration, share):
    t = np.linspace(0, 2, 101)
    curve = fp.indent(medium, BALL, time=t * duration, depth=triangle(t), relaxation=SOLID)
    elastic = fp.indent(medium, BALL, depth=np.maximum(triangle(t), 0))
    # duration over relaxation time, or its inverse, 5e-7, times the relaxing share over the lasting one
    scale = float(elastic.force.max())
    assert np.allclose(curve.force, share * elastic.force, rtol=0, atol=3e-6 * scale)
    # beside the last touch radii change like the square root of the depth
    assert np.allclose(curve.radius[:-3], elastic.radius[:-3], rtol=1e-4)


def springs(law, count, time, depth):
    """Force of all springs and of every other one, and contact depth, under BALL on LAYER."""
    elastic = elastic_curve(first_order.solve, compliance(LAYER), BALL, float(depth.max()), np.zeros(1))
    series = exponential_series(law, float(np.diff(time).min()), float(np.ptp(time)))
    return followed(Springs(elastic, series, float(depth.max()), count), time, depth).T


@pytest.mark.parametrize(("law", "order"), [(SOLID, 2.0), (POWER, 1.8)], ids=["solid", "power"])
def test_springs_agree_with_lee_radok_and_ting(law, order):
    t = np.linspace(0, 2, 101)
    exact = fp.indent(LAYER, BALL, time=t, depth=triangle(t), relaxation=law)
    scale = float(exact.force.max())
    # closed formulas on halved steps, by their own estimate
    assert (exact.force_error * exact.force).max() < 3e-5 * scale
    errors = []
    counts = [50, 100, 200, 400]
    for count in counts:
        force, rough, contact = springs(law, count, t, triangle(t))
        errors.append(np.abs(force - exact.force.values).max() / scale)
        # what is reported is no smaller
        assert errors[-1] <= np.abs(force - rough).max() / scale * 2 / 3 + 1e-6
        assert (force >= 0).all()
    # Q linear between springs: second order, at its edge like the distance to the power 1 - alpha under power laws
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(-order, abs=0.25)
    assert errors[-1] < 2e-5
    # the contact depth lies within a spring's distance
    assert np.allclose(contact, exact.contact_depth.values, rtol=0, atol=2 / 400 * V)


@pytest.mark.parametrize("law", [SOLID, POWER], ids=["solid", "power"])
def test_springs_need_no_more_steps_than_the_history_has_corners(law):
    corners, values = np.array([0, 1, 1.3, 2.0, 2.4, 3.0]), V * np.array([0, 1, 0.5, 0.5, 0.9, 0.1])
    t = np.linspace(0, 3, 301)
    few = springs(law, 200, corners, values)
    many = springs(law, 200, t, np.interp(t, corners, values))
    # in between all is exact; the series of the power law is good to 1e-9 at steps of either length
    assert np.allclose(few, many[:, ::10][:, np.round(corners * 10).astype(int)], rtol=0, atol=1e-8 * few.max())


def test_partial_withdrawal_and_hold():
    """The contact is lost, and comes back while the surface recovers."""
    law = fp.Prony([0.5, 0.2], [1, 0.1])
    t = np.linspace(0, 60, 601)
    depth = V * np.interp(t, [0, 1, 1.2], [0, 1, 0.3])
    curve = fp.indent(GEL, fp.Cone(0.3), time=t, depth=depth, relaxation=law)
    assert float(curve.force[12]) == 0
    assert float(curve.radius[12]) == 0
    assert (np.diff(curve.force[13:150]) > 0).all()
    held = fp.indent(GEL, fp.Cone(0.3), depth=0.3 * V)
    # the slowest mode recovers at 0.37/s
    assert float(curve.force[-1]) == pytest.approx(law.equilibrium * float(held.force[0]), rel=1e-6)
    assert float(curve.radius[-1]) == pytest.approx(float(held.radius[0]), rel=1e-6)
    assert curve.valid.all()


def test_the_contact_grows_while_the_depth_is_held():
    law = fp.Prony([0.5, 0.2], [1, 0.1])
    t = np.linspace(0, 20, 401)
    depth = V * np.interp(t, [0, 1, 1.05], [1, 1, 0.6])
    curve = fp.indent(GEL, fp.Cone(0.3), time=t, depth=depth, relaxation=law)
    assert (np.diff(curve.radius[21:]) >= -1e-12 * float(curve.radius[0])).all()
    assert float(curve.contact_depth[21]) < 0.55 * V
    # exp(-0.37 x 19) is left of the slowest mode
    assert float(curve.contact_depth[-1]) == pytest.approx(0.6 * V, rel=1e-3)


def test_few_times_are_as_good_as_many():
    """Three cycles by 17 points: linear in between, whatever the number of steps."""
    law = fp.Prony([0.5, 0.2], [1, 0.1])
    t = np.linspace(0, 3, 17)
    depth = V * np.sin(np.pi * t) ** 2
    few = fp.indent(GEL, fp.Cone(0.3), time=t, depth=depth, relaxation=law)
    fine = np.linspace(0, 3, 16 * 32 + 1)
    many = fp.indent(GEL, fp.Cone(0.3), time=fine, depth=np.interp(fine, t, depth), relaxation=law)
    assert np.allclose(few.force, many.force[::32], rtol=0, atol=1e-5 * float(many.force.max()))
    assert float(few.force_error.max()) < 1e-3


@pytest.mark.long
@pytest.mark.parametrize("law", [SOLID, POWER], ids=["solid", "power"])
def test_force_histories_within_their_estimate(law):
    """Loads up and down, one interval without contact; halved steps change the depth by less than is reported."""
    corners, loads = [0, 0.5, 0.8, 1.1, 1.3, 2.0], np.array([0, 1, 0.2, 0.8, 0, 0.5]) * 1e-6
    t = np.linspace(0, 2, 21)
    few = fp.indent(GEL, BALL, time=t, force=np.interp(t, corners, loads), relaxation=law)
    fine = np.linspace(0, 2, 81)
    many = fp.indent(GEL, BALL, time=fine, force=np.interp(fine, corners, loads), relaxation=law)
    off = np.abs(few.depth.values - many.depth.values[::4])
    # force over depth is two thirds of the stiffness under a paraboloid
    reported = few.depth.values * few.force_error.values
    loaded = few.force.values > 0
    assert (off[loaded] <= reported[loaded] + 1e-6 * V).all()
    assert off.max() < 2e-4 * float(many.depth.max())
    assert float(few.contact_depth[13]) == 0
    # the tip rests on the surface while it carries nothing
    assert (few.depth[13:] > 0).all()


def test_estimates_of_the_method_are_part_of_the_error():
    t = np.linspace(0, 1, 21)
    pyramid = fp.Pyramid(3, 0.3)
    same = {"angles": 8, "method": "second-order"}
    curve = fp.indent(LAYER, pyramid, time=t, depth=V * t, relaxation=SOLID, **same)
    elastic = fp.indent(LAYER, pyramid, depth=V, **same)
    assert float(curve.force_error[-1]) >= float(elastic.force_error[0])
    assert float(curve.contour_error[-1]) == pytest.approx(float(elastic.contour_error[0]), rel=1e-6)


@pytest.mark.parametrize("law", [SOLID, POWER], ids=["solid", "power"])
def test_a_history_that_reloads_begins_like_one_that_does_not(law):
    t = np.linspace(0, 3, 1201)
    depth = V * np.interp(t, [0, 1, 1.4, 2.2, 3], [0, 1, 0.6, 1.2, 0])
    whole = fp.indent(GEL, BALL, time=t, depth=depth, relaxation=law)
    until = 561
    part = fp.indent(GEL, BALL, time=t[:until], depth=depth[:until], relaxation=law)
    # springs against Ting: second order in 1/400 springs and in the steps
    scale = float(part.force.max())
    assert np.allclose(whole.force[:until], part.force, rtol=0, atol=1e-4 * scale)
    assert (whole.force >= 0).all()
    # beyond the old maximum the contact has the extent of the depth again
    beyond = (t > 1.95) & (t < 2.2)
    assert np.allclose(whole.contact_depth[beyond], depth[beyond], rtol=1e-3)


@pytest.mark.long
def test_force_control_is_depth_control_read_the_other_way():
    t = np.linspace(0, 3, 1501)
    force = 1e-6 * np.interp(t, [0, 1, 2, 3], [0, 1, 1, 0.02])
    by_force = fp.indent(GEL, BALL, time=t, force=force, relaxation=SOLID)
    by_depth = fp.indent(GEL, BALL, time=t, depth=by_force.depth.values, relaxation=SOLID)
    # springs one way, Lee-Radok and Ting the other
    assert np.allclose(by_depth.force, force, rtol=0, atol=1e-4 * force.max())
    assert np.all(np.diff(by_force.depth[501:1000]) > 0)


@pytest.mark.parametrize(("law", "order"), [(SOLID, 2.0), (POWER, 1.8)], ids=["solid", "power"])
def test_convergence_in_the_time_steps(law, order):
    def force(n):
        t = np.linspace(0, 1, n + 1)
        return fp.indent(GEL, BALL, time=t, depth=V * np.sin(np.pi * t), relaxation=law).force.values

    best = force(8192)
    counts = np.array([64, 128, 256, 512])
    # times at which the contact grows well after the touch: there d(t), taken as linear over steps, is off by step^2 and its
    # slope by the step; the last step then weighs step times int psi = step^(1 - alpha)
    error = [np.abs(force(n) - best[:: 8192 // n])[n // 8 : n // 2].max() for n in counts]
    slope = np.polyfit(np.log(counts), np.log(error), 1)[0]
    assert slope == pytest.approx(-order, abs=0.1)


@pytest.mark.parametrize("law", [SOLID, POWER], ids=["solid", "power"])
def test_oscillation_about_a_static_indentation(law):
    # held until the static force changes little, then a small oscillation: K(a) psi*(omega)
    omega, amplitude = 2 * np.pi, 1e-3
    start, cycles, per = 40.0, 12, 100
    t = np.concatenate(
        [np.linspace(0, 1, 50), np.linspace(1.1, start, 200), start + np.arange(1, cycles * per + 1) / per]
    )
    wave = np.where(t > start, np.sin(omega * (t - start)), 0.0)
    steady = np.minimum(t, 1.0)
    moving = fp.indent(GEL, BALL, time=t, depth=V * (steady + amplitude * wave), relaxation=law).force.values
    still = fp.indent(GEL, BALL, time=t, depth=V * steady, relaxation=law).force.values
    last = slice(-4 * per, None)
    answer = 2 * np.mean((moving - still)[last] * np.exp(-1j * (omega * (t[last] - start) - np.pi / 2)))
    stiffness = 2 * GEL.surface_modulus * np.sqrt(BALL.radius * V)
    expected = law.dynamic(np.array(omega)) * stiffness * V * amplitude
    # the contact breathes by the amplitude over the depth; the start of the oscillation fades like a power of time
    assert answer.real == pytest.approx(expected.real, rel=1e-2)
    assert answer.imag == pytest.approx(expected.imag, rel=2e-2)


def test_non_round_tip_and_flat_end():
    t = np.linspace(0, 1, 101)
    pyramid = fp.Pyramid(4, 0.3)
    same = {"angles": 8, "method": "second-order"}
    curve = fp.indent(LAYER, pyramid, time=t, depth=np.full(t.size, V), relaxation=SOLID, **same)
    elastic = fp.indent(LAYER, pyramid, depth=V, **same)
    assert np.allclose(curve.force, SOLID(t) * float(elastic.force[0]), rtol=1e-8)
    assert np.allclose(curve.contour, elastic.contour.values, rtol=1e-8)
    flat = fp.indent(GEL, fp.Cylinder(1e-6), time=t, depth=V * t, relaxation=SOLID)
    exact = 2 * GEL.surface_modulus * 1e-6 * V * SOLID.integral(t)
    assert np.allclose(flat.force, exact, rtol=1e-12)
    assert np.all(flat.radius[1:] == pytest.approx(1e-6, rel=1e-12))


def test_before_touch_nothing_happens():
    t = np.linspace(0, 2, 401)
    late = fp.indent(GEL, BALL, time=t, depth=V * (t - 0.5013), relaxation=SOLID)
    assert (late.force[t < 0.5] == 0).all()
    shifted = fp.indent(
        GEL, BALL, time=np.linspace(0, 1.4987, 400), depth=V * np.linspace(0, 1.4987, 400), relaxation=SOLID
    )
    # the touch falls between two steps and is found there
    assert float(late.force[-1]) == pytest.approx(float(shifted.force[-1]), rel=1e-8)


@pytest.mark.parametrize(
    ("medium", "arguments", "message"),
    [
        (fp.Medium([fp.Layer(1e6, 0.3, 1e-6)], base=fp.HalfSpace(1e9, 0.3)), {}, "RigidBase"),
        (GEL, {"depth": None, "force": [0.0, -1.0]}, "force"),
        (GEL, {"time": [1.0, 0.0]}, "after"),
        (GEL, {"time": [0.0, 1.0, 2.0]}, "as many"),
        (GEL, {"relaxation": None}, "go together"),
        (GEL, {"depth": [-1.0, -2.0]}, "nowhere positive"),
        (GEL, {"radius": 1e-6}, "exactly one"),
        (GEL, {"work_of_adhesion": 0.1}, "do not go together"),
        (GEL, {"method": "bem"}, "elastic curve"),
    ],
)
def test_refused(medium, arguments, message):
    given = {"time": [0.0, 1.0], "depth": [0.0, 1e-6], "relaxation": SOLID, **arguments}
    with pytest.raises(ValueError, match=message):
        fp.indent(medium, BALL, **given)


def test_a_contact_of_several_parts_has_no_history():
    """A stiff film lifts off between the edges of a three-sided tip: forces are known there, outlines are not."""
    tip, kernel, phi = fp.Pyramid(3, 0.3), compliance(fp.HalfSpace(1.0, 0.3)), np.zeros(1)

    def parted(*given):
        curve = fp.SecondOrder().solve(*given)
        return replace(curve, contour=np.where(curve.depth[:, None] > 0.5, np.nan, curve.contour))

    with pytest.raises(ValueError, match="no outline at depth 1 m"):
        elastic_curve(parted, kernel, tip, 1.0, phi)
