"""Half-space: ramps, steps, creep and withdrawal in closed form, for spheres and cones."""

import numpy as np
import pytest
from scipy.special import beta as beta_function
from scipy.special import betainc

import flatpunch as fp

GEL = fp.HalfSpace(young=1e6, poisson=0.5)
E = GEL.surface_modulus
R, SLOPE = 1e-5, 0.3
BALL, CONE = fp.Paraboloid(R), fp.Cone(np.arctan(SLOPE))
# F_el = c d^p
LAWS = {"ball": (BALL, 4 / 3 * E * np.sqrt(R), 1.5), "cone": (CONE, 2 / np.pi * E / SLOPE, 2.0)}
POWER = fp.PowerLawRelaxation(0.25, 0.7)
SOLID = fp.StandardLinearSolid(0.3, 0.2)
V = 1e-6
T = np.linspace(0, 1, 401)


@pytest.mark.parametrize("name", LAWS)
def test_ramp_under_a_power_law(name):
    indenter, c, p = LAWS[name]
    curve = fp.indent(GEL, indenter, time=T, depth=V * T, relaxation=POWER)
    alpha = POWER.exponent
    # F = c p v^p tau^alpha int (t - s)^-alpha s^(p-1) ds
    exact = c * p * V**p * POWER.time**alpha * beta_function(p, 1 - alpha) * T ** (p - alpha)
    # within the first step d^(1/2) is followed on sixteen pieces; afterwards quadratic stiffness and 1e-10 of the series
    assert np.allclose(curve.force[1:], exact[1:], rtol=2e-5)
    assert np.allclose(curve.force[20:], exact[20:], rtol=1e-7 if name == "ball" else 1e-9)


def test_ramp_and_hold_of_a_cone_on_a_standard_solid():
    _, c, _ = LAWS["cone"]
    t = np.linspace(0, 3, 601)
    depth = V * np.minimum(t, 1.0)
    curve = fp.indent(GEL, CONE, time=t, depth=depth, relaxation=SOLID)
    g, tau = SOLID.equilibrium, SOLID.time
    end = np.minimum(t, 1.0)
    # int_0^end exp(-(t - s)/tau) 2 s ds
    memory = 2 * tau * (np.exp((end - t) / tau) * (end - tau) + tau * np.exp(-t / tau))
    exact = c * V**2 * (g * end**2 + (1 - g) * memory)
    # K is linear in d under a cone: exact but for the table's 1e-10
    assert np.allclose(curve.force[1:], exact[1:], rtol=1e-8)
    assert np.all(np.diff(curve.force[201:]) < 0)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("law", [POWER, SOLID], ids=["power", "solid"])
def test_step_in_depth(name, law):
    indenter, c, p = LAWS[name]
    curve = fp.indent(GEL, indenter, time=T, depth=np.full(T.size, V), relaxation=law)
    exact = c * V**p * law(T)
    assert np.allclose(curve.force, exact, rtol=1e-9)  # the series of the power law; the table
    assert np.allclose(curve.radius, curve.radius[0], rtol=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_creep_under_a_sudden_force(name):
    indenter, c, p = LAWS[name]
    load = c * V**p
    curve = fp.indent(GEL, indenter, time=T, force=np.full(T.size, load), relaxation=SOLID)
    g = SOLID.equilibrium
    creep = 1 / g - (1 / g - 1) * np.exp(-g * T / SOLID.time)
    # F_el linear over steps of tau/80: (1/80)^2/12 of its curvature
    assert np.allclose(curve.depth, V * creep ** (1 / p), rtol=1e-5)


def test_creep_under_a_power_law():
    _, c, p = LAWS["ball"]
    load = c * V**p
    curve = fp.indent(GEL, BALL, time=T, force=np.full(T.size, load), relaxation=POWER)
    alpha = POWER.exponent
    creep = np.sin(np.pi * alpha) / (np.pi * alpha) * (T / POWER.time) ** alpha
    # F_el ~ t^alpha starts infinitely fast; sixteen pieces of the first step leave 1e-3 after it, which fades like 1/t
    assert np.allclose(curve.depth[10:], V * creep[10:] ** (1 / p), rtol=1e-3)
    assert np.allclose(curve.depth[200:], V * creep[200:] ** (1 / p), rtol=5e-5)


@pytest.mark.parametrize("name", LAWS)
def test_withdrawal_at_the_speed_of_approach(name):
    indenter, c, p = LAWS[name]
    t = np.linspace(0, 2, 801)
    curve = fp.indent(GEL, indenter, time=t, depth=V * np.minimum(t, 2 - t), relaxation=POWER)
    alpha = POWER.exponent
    back = t > 1
    # Ting: (t - t1)^(1-alpha) = 2 (t - 1)^(1-alpha)
    t1 = np.maximum(t[back] - 2 ** (1 / (1 - alpha)) * (t[back] - 1), 0)
    assert np.allclose(curve.contact_depth[back], V * t1, rtol=1e-8, atol=1e-10 * V)
    share = betainc(p, 1 - alpha, t1 / t[back])
    exact = c * p * V**p * POWER.time**alpha * beta_function(p, 1 - alpha) * t[back] ** (p - alpha) * share
    # as for the ramp, relative to the largest force: the first step errs by 2e-5 of its own small one
    assert np.allclose(curve.force[back], exact, rtol=1e-6, atol=1e-8 * exact[0])
    assert (curve.force >= 0).all()
    lost = t > 1 + 1 / (2 ** (1 / (1 - alpha)) - 1)
    assert (curve.force[lost] == 0).all()
    assert (curve.radius[lost] == 0).all()


def test_shrinking_after_a_sudden_step():
    # d = d0 at once, then withdrawal at v: springs deflected at once leave when psi(t) (d0 - g) = v int_0^t psi
    t = np.linspace(0, 1, 201)
    curve = fp.indent(GEL, BALL, time=t, depth=V * (1 - 0.5 * t), relaxation=SOLID)
    contact = V * np.maximum(1 - 0.5 * SOLID.integral(t) / SOLID(t), 0)
    assert np.allclose(curve.contact_depth, contact, rtol=1e-9)
    _, c, p = LAWS["ball"]
    assert np.allclose(curve.force, c * SOLID(t) * contact**p, rtol=1e-9)
