"""Stresses under round tips with a flat end, whose sources have a root at its border; laws that hold for every round load."""

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

import flatpunch as fp
from flatpunch.stresses.axisymmetric.contact_load import contact_load

ON_AXIS = 0.05, 0.3, 1.0, 3.0
"""Depths over the contact radius."""


def _cone(flat, rng):
    slope = np.tan(rng.uniform(0.02, 1.2))
    tip = fp.Truncated(fp.Cone(np.arctan(slope)), slope * flat)
    return tip, lambda t: slope * t * np.arccos(np.minimum(1, flat / t))


def _paraboloid(flat, rng):
    radius = rng.uniform(1.5, 50)
    tip = fp.Truncated(fp.Paraboloid(radius), flat**2 / (2 * radius))
    return tip, lambda t: t * np.sqrt(np.maximum(t * t - flat * flat, 0)) / radius


def _axial_stress(modulus, indentation, flat, z):
    """s_zz on the axis of a half-space under a contact of radius 1, with the root at the flat taken out."""
    x, w = leggauss(64)
    ends = np.linspace(0, 1, 17)
    u = (ends[:-1, None] + np.diff(ends)[:, None] * (1 + x) / 2).ravel()
    weight = (np.diff(ends)[:, None] * w / 2).ravel()
    # below the flat, where nothing is indented, and beyond it with t = b + (1 - b) u^2
    inner, outer = flat * u, flat + (1 - flat) * u**2
    t = np.concatenate([inner, outer])
    weights = np.concatenate([flat * weight, 2 * (1 - flat) * u * weight])
    depth = float(indentation(np.ones(1))[0])
    g = (depth - np.concatenate([np.zeros_like(inner), indentation(outer)])) * modulus / np.pi
    kernel = (1 / (z - 1j * t) ** 2 + 2 * z / (z - 1j * t) ** 3).real
    return -float(np.sum(weights * g * kernel))


@pytest.mark.parametrize("tip_of", [_cone, _paraboloid])
@pytest.mark.parametrize("flat", [0.01, 0.1, 0.5, 0.9, 0.99])
def test_axial_stress_is_the_closed_form(tip_of, flat):
    rng = np.random.default_rng([int(100 * flat), tip_of is _cone])
    tip, indentation = tip_of(flat, rng)
    body = fp.HalfSpace(young=2.0, poisson=rng.uniform(0, 0.5))
    found = fp.fields(body, tip, 0.0, 0.0, np.array(ON_AXIS), radius=1.0)
    wanted = [_axial_stress(2.0 / (1 - body.poisson**2), indentation, flat, z) for z in ON_AXIS]
    # rounding of g, which is a difference of depths
    np.testing.assert_allclose(found.stress.values[2], wanted, rtol=1e-11, atol=1e-11 * np.abs(wanted).max())


def test_axial_stress_of_a_truncated_cone_by_its_digits():
    """The numbers of an independent quadrature."""
    tip = fp.Truncated(fp.Cone(0.1), np.tan(0.1) * 0.5)
    found = fp.fields(fp.HalfSpace(1.0, 0.3), tip, 0.0, 0.0, np.array([0.3, 1.0, 3.0]), radius=1.0)
    np.testing.assert_allclose(found.stress.values[2], [-0.060473, -0.039258, -0.0078255], rtol=2e-5)


def _random_body(rng):
    layers = [
        fp.Layer(
            10 ** rng.uniform(-1, 1), rng.uniform(0, 0.5), 10 ** rng.uniform(-1, 0.3), bonded=bool(rng.random() > 0.2)
        )
        for _ in range(rng.integers(0, 4))
    ]
    base = fp.HalfSpace(10 ** rng.uniform(-1, 1), rng.uniform(0, 0.5))
    if not layers:
        return rng.choice(
            [base, fp.PowerLawHalfSpace(modulus=1.0, depth=1.0, exponent=rng.uniform(0.05, 0.6), poisson=0.3)]
        )
    return fp.Medium(layers, base)


def _random_tip(rng):
    slope, flat = rng.uniform(0.1, 1.0), rng.uniform(0.01, 0.99)
    return [
        lambda: fp.Truncated(fp.Cone(slope), np.tan(slope) * flat),
        lambda: fp.Truncated(fp.Sphere(4.0), flat**2 / 8),
        lambda: fp.Rounded(fp.Cone(slope), radius=rng.uniform(0.1, 2)),
        lambda: fp.Truncated(fp.Rounded(fp.Cone(slope), radius=0.3), 0.3 * np.tan(slope) * flat),
        lambda: fp.RadialProfile(np.linspace(0, 2, 21), 0.1 * np.linspace(0, 2, 21) ** rng.uniform(1.5, 2.5)),
        lambda: fp.Cone(slope),
    ][rng.integers(6)]()


@pytest.mark.long
@pytest.mark.parametrize("seed", range(12))
def test_every_plane_carries_the_force_and_the_error_is_honest(seed):
    rng = np.random.default_rng(seed)
    body, tip = _random_body(rng), _random_tip(rng)
    force = float(fp.indent(body, tip, radius=1.0).force[0])
    x, w = leggauss(24)
    z = rng.uniform(0.1, 1.5)
    ends = np.concatenate([np.linspace(0, 2, 9), 2 + (1 + z) * np.geomspace(0.3, 4000, 22)])
    r = (ends[:-1, None] + np.diff(ends)[:, None] * (1 + x) / 2).ravel()
    weight = (np.diff(ends)[:, None] * w / 2).ravel()
    plane = fp.fields(body, tip, r, 0.0, z, radius=1.0)
    carried = -float(np.sum(2 * np.pi * r * weight * plane.stress.values[2]))
    # the sum itself ends at 4000 radii and is known to 1e-8
    assert carried == pytest.approx(force, rel=1e-8 + 3 * plane.attrs["stress_error"])
    # the boundary condition at points that nothing was made from
    r = np.sort(rng.uniform(0.05, 0.97, 6))
    surface = fp.fields(body, tip, r, 0.0, 0.0, radius=1.0, friction=0.2)
    pressure, error = fp.pressure(body, tip, r, 0.0, radius=1.0, return_error=True)
    mean = force / np.pi
    allowed = 3 * (surface.attrs["stress_error"] * mean + error) + 1e-10 * mean
    assert np.all(np.abs(surface.stress.values[2] + pressure) <= allowed)
    assert np.all(np.abs(surface.stress.values[4] + 0.2 * pressure) <= allowed)


@pytest.mark.parametrize("tip", [fp.Truncated(fp.Cone(0.3), 0.1), fp.Truncated(fp.Sphere(3.0), 0.1)])
def test_the_border_of_a_flat_end_fails_at_once(tip):
    found = fp.critical_load(fp.HalfSpace(1.0, 0.3), tip, [fp.Strength(yield_stress=0.05)])
    assert found.force == 0
    assert found.place[0] == pytest.approx(tip.rings[0])
    # below an incompressible surface shear stays finite, and so does the load
    soft = fp.critical_load(fp.HalfSpace(1.0, 0.5), tip, [fp.Strength(yield_stress=0.05)])
    assert 0 < soft.force < np.inf
    # what the search for the load leaves is part of it
    assert soft.error < 1e-7


@pytest.mark.parametrize("beyond", [1e-7, 1e-5, 1e-3])
def test_few_panels_just_beyond_a_flat(beyond):
    """Panels were halved thousands of times where places between flat and rim are rounded: a critical load took minutes."""
    kernel, tip = fp.compliance(fp.HalfSpace(1.0, 0.3)), fp.Truncated(fp.Cone(0.1), 0.5 * np.tan(0.1))
    load = contact_load(kernel, tip, 0.5 * (1 + beyond), 0.0, edge=False)
    assert len(load.series) < 8
    # beside the flat g is that of its depth, (E*/pi) a tan(alpha) arccos(b/a)
    depth = np.tan(0.1) * load.radius * np.arccos(0.5 / load.radius)
    assert load.value(np.zeros(1))[0] == pytest.approx(depth / np.pi / 0.91, rel=1e-15 / beyond)


def test_points_at_the_rim_have_no_stress():
    """They count for nothing: neither for the error nor for the stresses beside them."""
    medium, tip = fp.Medium([fp.Layer(50e6, 0.3, 1.0)], fp.HalfSpace(20e6, 0.3)), fp.Cylinder(radius=0.5)
    x = np.array([0.0, 0.25, 0.5, -0.5, 0.75])
    found = fp.fields(medium, tip, x, 0.0, 0.0, force=1e5, friction=0.2)
    at_rim = np.abs(x) == 0.5
    np.testing.assert_array_equal(np.isnan(found.stress).any("component"), at_rim)
    np.testing.assert_array_equal(np.isnan(found.principal).any("order"), at_rim)
    assert found.attrs["stress_error"] < 1e-9
    assert "2 of 5 points have no stress, the first at x = 500 mm" in found.attrs["notes"]
    alone = fp.fields(medium, tip, x[~at_rim], 0.0, 0.0, force=1e5, friction=0.2)
    np.testing.assert_allclose(found.stress[:, ~at_rim], alone.stress, rtol=1e-12, atol=1e-12 * 1e5)
    below = fp.fields(medium, tip, 0.5, 0.0, 1e-3, force=1e5)
    assert np.isfinite(below.stress).all()


def test_a_traction_that_jumps_has_no_stress_at_its_rim():
    pressed, dragged = (
        fp.fields(fp.HalfSpace(1e6, 0.3), fp.DiscLoad(1e5, 0.5, traction=t), 0.5, 0, 0) for t in (0.0, 1e4)
    )
    assert float(pressed.stress.sel(component="zz")) == pytest.approx(-5e4)
    assert np.isnan(dragged.stress).all()
