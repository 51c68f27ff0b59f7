"""Limits, layers, any history, both roads against each other, orders of convergence, refusals."""

import numpy as np
import pytest

import flatpunch as fp

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


@pytest.mark.parametrize("law", [SOLID, POWER], ids=["solid", "power"])
def test_springs_agree_with_ting(law):
    from flatpunch.compliance import compliance
    from flatpunch.contact.perturbation import first_order
    from flatpunch.contact.viscoelastic.elastic import elastic_curve
    from flatpunch.contact.viscoelastic.series import exponential_series
    from flatpunch.contact.viscoelastic.springs import Springs

    exact_time = np.linspace(0, 2, 2001)
    exact = fp.indent(LAYER, BALL, time=exact_time, depth=triangle(exact_time), relaxation=law)
    elastic = elastic_curve(first_order.solve, compliance(LAYER), BALL, V, np.zeros(1), {})
    errors = []
    for n in (40, 80, 200, 400):
        t = np.linspace(0, 2, n + 1)
        springs = Springs(elastic, exponential_series(law, 2 / n, 2.0), V)
        _, force, contact = springs.follow(t, triangle(t), by_force=False)
        assert (force >= 0).all()
        errors.append(np.abs(force - exact.force.values[:: 2000 // n]).max() / float(exact.force.max()))
    slope = np.polyfit(np.log([40, 80, 200, 400]), np.log(errors), 1)[0]
    # linear deflections over each step: second order under smooth psi, 2 - alpha under a power law
    assert slope < -1.6
    assert errors[-1] < 2e-4
    assert np.allclose(contact, exact.contact_depth.values[:: 2000 // 400], rtol=0, atol=3e-3 * V)


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
