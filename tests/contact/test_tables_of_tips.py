"""Round contacts of measured profiles against Abel's integrals, taken from point to point of the table."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

import flatpunch as fp

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


@pytest.mark.parametrize("roughness", [0.0, 1e-2])
def test_pressure_states_its_error(roughness):
    rng = np.random.default_rng(int(1e3 * roughness))
    r = np.linspace(0, 2, 41)
    tip = fp.RadialProfile(r, np.maximum.accumulate(0.1 * r**2.2 + roughness * 0.1 * r * rng.uniform(-1, 1, r.size)))
    body, at = fp.Medium([fp.Layer(3.0, 0.4, 0.5)], fp.HalfSpace(1.0, 0.3)), np.linspace(0.05, 0.95, 19)
    pressure, error = fp.pressure(body, tip, at, 0.0, radius=1.0, return_error=True)
    # the other road: the surface stress of exact sources
    exact = -fp.fields(body, tip, at, 0.0, 0.0, radius=1.0).stress.values[2]
    # kinks of the curvature are rounded off by the history: the error is a local one, its largest value what can be promised
    assert np.all(np.abs(pressure - exact) <= 3 * error.max() + 1e-9 * exact.max())
