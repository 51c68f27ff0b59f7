"""Round contacts of measured profiles against Abel's integrals, taken from point to point of the table."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.special import roots_legendre

import flatpunch as fp
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact

X, W = leggauss(24)


def _depth(tip, t):
    """t int_0^t f'(r)/sqrt(t^2 - r^2) dr."""
    knots = np.array(tip.r)
    ends = np.concatenate([[0], np.arcsin(knots[(knots > 0) & (knots < t)] / t), [np.pi / 2]])
    angle = ends[:-1, None] + np.diff(ends)[:, None] * (1 + X) / 2
    return t * float(np.sum(np.diff(ends)[:, None] / 2 * W * tip.slope(t * np.sin(angle), 0.0)))


@pytest.mark.parametrize("roughness", [0.0, 1e-3, 5e-2])
@pytest.mark.parametrize("points", [9, 60])
def test_depth_and_force_are_those_of_the_curve_through_the_table(points, roughness):
    rng = np.random.default_rng([points, int(1e3 * roughness)])
    r = np.append(0, np.sort(rng.uniform(0.01, 1, points)))
    tip = fp.RadialProfile(r, np.maximum.accumulate(0.2 * r**1.8 + roughness * 0.2 * r * rng.uniform(-1, 1, r.size)))
    a = 0.7 * r[-1]
    found = fp.indent(fp.HalfSpace(0.91, 0.3), tip, radius=a)
    depth, force = _depth(tip, a), 0.0
    knots = np.concatenate([[0], r[(r > 0) & (r < a)], [a]])
    for low, high in pairwise(knots):
        # beyond a point of the table the depth has a root
        u = (1 + X) / 2
        t = low + (high - low) * u**2
        force += 2 * np.sum(W * u * (high - low) * (depth - np.array([_depth(tip, each) for each in t])))
    # rounding of a few hundred terms
    assert float(found.depth[0]) == pytest.approx(depth, rel=1e-12)
    assert float(found.force[0]) == pytest.approx(force, rel=1e-11)


def _jagged(seed, points=41):
    rng = np.random.default_rng(seed)
    r = np.linspace(0, 2, points)
    rough = rng.choice([0.0, 1e-3, 5e-3]) * rng.uniform(-1, 1, r.size)
    return fp.RadialProfile(r, np.maximum.accumulate(0.1 * r**2.2 + 0.1 * r * rough)), float(rng.uniform(0.2, 1.8))


BODIES = {
    "half-space": fp.HalfSpace(1.0, 0.3),
    "soft film": fp.Medium([fp.Layer(1.0, 0.45, 0.4)], fp.RigidBase()),
    "stiff film": fp.Medium([fp.Layer(3.0, 0.3, 0.5)], fp.HalfSpace(1.0, 0.3)),
    "springs": fp.Medium([fp.Layer(2.0, 0.3, 0.2, bonded=fp.Interface(1.0, 0.5))], fp.HalfSpace(1.0, 0.3)),
    "soil": fp.PowerLawHalfSpace(1.0, 1.0, 0.3, 0.3),
}


@pytest.mark.long
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("seed", range(4))
def test_pressure_states_its_error(body, seed):
    """The curvature jumps at each point of the table: the history starts anew there, and the error holds point by point."""
    # stresses in power-law half-spaces take seconds a point of the table
    tip, radius = _jagged([seed, len(body)], 9 if body == "soil" else 41)
    at = radius * np.random.default_rng(seed).uniform(0, 0.999, 50)
    pressure, error = fp.pressure(BODIES[body], tip, at, 0.0, radius=radius, return_error=True)
    # the other road: the surface stress of exact sources, with an error of its own
    fields = fp.fields(BODIES[body], tip, at, 0.0, 0.0, radius=radius)
    off, largest = np.abs(pressure + fields.stress.values[2]), pressure.max()
    assert np.all(off <= error + (fields.attrs["stress_error"] + 1e-11) * largest)
    assert off.max() < 1e-6 * largest
    assert error.max() < 1e-4 * largest


@pytest.mark.parametrize("beyond", [1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-2])
def test_depth_grows_with_the_radius_as_the_curve_says_just_beyond_a_point_of_the_table(beyond):
    """a dd/da = int_0^a (a f' + a r f'')/sqrt(a^2 - r^2) dr, taken from point to point."""
    tip, _ = _jagged(7)
    a = tip.r[17] * (1 + beyond)
    knots = np.append(np.array(tip.r)[np.array(tip.r) < a], a)
    angle = np.arccos(knots / a)
    total = 0.0
    for start, high, low in zip(knots, angle, angle[1:], strict=False):
        r = a * np.cos(low + (high - low) * (1 + X) / 2)
        # the slope is a parabola between two points
        x, end = start + (knots[knots > start][0] - start) * np.array([0.1, 0.5, 0.9]), 1 - 1e-15
        parabola = np.polynomial.Polynomial.fit(x, tip.slope(x * end, 0.0), 2)
        total += (high - low) / 2 * float(W @ (a * parabola(r) + a * r * parabola.deriv()(r)))
    found = round_contact(fp.compliance(fp.HalfSpace(1.0, 0.3)), mean_profile(tip), np.array([a]))
    # 1e-9 and less, and 4e-5 without tangents at the points
    assert float(found.depth_slope[0]) == pytest.approx(total, rel=1e-7)


@pytest.mark.parametrize("radius", [1e-8, 3e-8, 1e-7, 1e-6])
def test_an_almost_flat_tip_states_its_error(radius):
    """The fit A = 24.5 h^2 + 10 h^(1/16) is all but flat up to nanometres: no rule of fixed order resolves its rise."""
    tip = fp.AreaFunction((24.5, 0, 0, 0, 0, 10.0), 2e-6, unit=1e-9)
    found = fp.indent(fp.HalfSpace(1.0, 0.3), tip, radius=radius)
    angle, weight = roots_legendre(4000)
    truth = radius * np.pi / 4 * float(weight @ tip.slope(radius * np.sin(np.pi / 4 * (1 + angle)), 0.0))
    assert abs(float(found.depth[0]) / truth - 1) <= float(found.force_error[0])
    assert float(found.force_error[0]) < 1e-3
