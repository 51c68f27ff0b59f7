"""Half-space: JKR sphere, Maugis cone, power laws, Kendall's flat end, in closed form."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.reference import adhesion as closed

R, W = 1e-5, 0.05
GEL = fp.HalfSpace(young=1e6, poisson=0.5)
E = GEL.surface_modulus
TENSION = 1.5 * np.pi * W * R
RADII = np.geomspace(1e-8, 1e-4, 41)


@pytest.mark.parametrize(
    ("indenter", "solution"),
    [
        (fp.Paraboloid(R), lambda a: closed.jkr_paraboloid(a, R, E, W)),
        (fp.Cone(0.1), lambda a: closed.jkr_cone(a, 0.1, E, W)),
        (fp.PowerLaw(4.0, 1e14), lambda a: closed.jkr_power_law(a, 4.0, 1e14, E, 0.0, W)),
    ],
    ids=["sphere", "cone", "fourth power"],
)
def test_branch_by_radius(indenter, solution):
    curve = fp.indent(GEL, indenter, radius=RADII, work_of_adhesion=W)
    depth, force = solution(RADII)
    # rounding of the larger of the two terms that each is the difference of
    plain = fp.indent(GEL, indenter, radius=RADII)
    assert np.all(np.abs(curve.depth - depth) <= 1e-13 * (plain.depth + np.abs(depth)))
    assert np.all(np.abs(curve.force - force) <= 1e-13 * (plain.force + np.abs(force)))


def test_pull_off_of_a_sphere():
    point = fp.pull_off(GEL, fp.Paraboloid(R), work_of_adhesion=W)
    # minima are found to rounding; radii only to its square root times a small factor of the root finder's own 1e-13
    assert point.force == pytest.approx(closed.jkr_pull_off(R, W) * -1, rel=1e-13)
    radius = closed.jkr_pull_off_radius(R, E, W)
    assert point.radius == pytest.approx(radius, rel=1e-11)
    assert point.depth == pytest.approx(radius**2 / R - np.sqrt(2 * np.pi * radius * W / E), rel=1e-10)
    # fixed grips: d = a^2/R - sqrt(2 pi a w/E*) is least at a^(3/2) = sqrt(pi w R^2/(8 E*)), and F = -5/6 pi w R there
    least = (np.pi * W * R**2 / (8 * E)) ** (1 / 3)
    assert point.depth_minimum.radius == pytest.approx(least, rel=1e-11)
    assert point.depth_minimum.force == pytest.approx(-5 / 6 * np.pi * W * R, rel=1e-10)
    assert len(point.force_instabilities) == len(point.depth_instabilities) == 1


def test_pull_off_of_a_cone():
    slope = np.tan(0.1)
    point = fp.pull_off(GEL, fp.Cone(0.1), work_of_adhesion=W)
    # F = (pi/2) E* a^2 t - sqrt(8 pi w E* a^3): dF/da = 0 at a = 18 w/(pi E* t^2), where F = -54 w^2/(pi E* t^3)
    assert point.radius == pytest.approx(18 * W / (np.pi * E * slope**2), rel=1e-11)
    assert point.force == pytest.approx(-54 * W**2 / (np.pi * E * slope**3), rel=1e-12)


def test_flat_end_is_lost_at_once():
    tip = fp.Cylinder(2e-6)
    kendall = np.sqrt(8 * np.pi * E * W * tip.radius**3)
    point = fp.pull_off(GEL, tip, work_of_adhesion=W)
    assert point.force == pytest.approx(-kendall, rel=1e-14)
    assert point.depth_minimum.radius == tip.radius
    stiffness = 2 * E * tip.radius
    depth = np.array([-1.01, -0.99, 0.0, 1.0]) * kendall / stiffness
    curve = fp.indent(GEL, tip, depth=depth, work_of_adhesion=W)
    assert np.allclose(curve.force[1:], stiffness * depth[1:], rtol=1e-14)
    assert curve.force[0] == 0
    assert curve.radius[0] == 0
    assert "separated" in curve.attrs["notes"]


def test_flat_end_on_a_graded_body():
    # K grows as a^(1 + k), so that 2 pi a w = d^2 K'/2 is F^2 = 4 pi a^2 w K/(1 + k); k = 0 is Kendall's
    body, tip = fp.PowerLawHalfSpace(modulus=1e6, depth=1e-6, exponent=0.3, poisson=0.3), fp.Cylinder(2e-6)
    stiffness = float(fp.indent(body, tip, depth=1e-8).stiffness[0])
    point = fp.pull_off(body, tip, work_of_adhesion=W)
    # rounding
    assert point.force == pytest.approx(-tip.radius * np.sqrt(4 * np.pi * W * stiffness / 1.3), rel=1e-13)
    assert point.depth == pytest.approx(point.force / stiffness, rel=1e-13)


def test_controls_agree():
    force = np.linspace(-0.9999, 5, 300) * TENSION
    by_force = fp.indent(GEL, fp.Paraboloid(R), force=force, work_of_adhesion=W)
    by_depth = fp.indent(GEL, fp.Paraboloid(R), depth=by_force.depth.values, work_of_adhesion=W)
    by_radius = fp.indent(GEL, fp.Paraboloid(R), radius=by_force.radius.values, work_of_adhesion=W)
    # close to the instability rounding of the force enters the depth by its square root over the distance: 1e-16/1e-2
    assert np.allclose(by_depth.force, force, rtol=0, atol=1e-12 * TENSION)
    assert np.allclose(by_radius.force, force, rtol=0, atol=1e-12 * TENSION)
    assert np.allclose(by_depth.radius, by_force.radius, rtol=1e-11)
    assert by_force.stable_force.all()
    assert by_force.stable_depth.all()


def test_stable_parts_are_marked_on_the_branch():
    point = fp.pull_off(GEL, fp.Paraboloid(R), work_of_adhesion=W)
    curve = fp.indent(GEL, fp.Paraboloid(R), radius=RADII, work_of_adhesion=W)
    assert np.array_equal(curve.stable_force, point.force_minimum.radius < RADII)
    assert np.array_equal(curve.stable_depth, point.depth_minimum.radius < RADII)


def test_beyond_pull_off():
    curve = fp.indent(GEL, fp.Paraboloid(R), force=[-2 * TENSION, 0.0], work_of_adhesion=W)
    assert np.isnan(curve.depth[0])
    assert not curve.valid[0]
    assert curve.valid[1]
    assert "pull-off" in curve.attrs["notes"]
    curve = fp.indent(GEL, fp.Paraboloid(R), depth=[-1e-6, 0.0], work_of_adhesion=W)
    assert curve.force[0] == curve.radius[0] == 0


def test_stiffness_is_the_slope_of_the_curve():
    depth = np.linspace(-3e-7, 1e-6, 14)
    step = 1e-10
    curve = fp.indent(GEL, fp.Paraboloid(R), depth=depth, work_of_adhesion=W)
    above, below = (
        fp.indent(GEL, fp.Paraboloid(R), depth=depth + sign * step, work_of_adhesion=W).force.values for sign in (1, -1)
    )
    # central difference: step^2 over the distance to the instability squared, (1e-10/9e-8)^2, plus rounding 1e-16 F/(step K)
    assert np.allclose((above - below) / (2 * step), curve.stiffness, rtol=3e-6)


def test_pressure_carries_the_force_and_pulls_at_the_edge():
    t, v = np.polynomial.legendre.leggauss(60)
    theta = np.pi / 4 * (t + 1)
    for indenter in (fp.Paraboloid(R), fp.Cone(0.2), fp.Cylinder(2e-6)):
        depth = -1e-8
        curve = fp.indent(GEL, indenter, depth=depth, work_of_adhesion=W)
        a = float(curve.radius[0])
        r = a * np.sin(theta)
        p = fp.pressure(GEL, indenter, r, 0.0, depth=depth, work_of_adhesion=W)
        total = 2 * np.pi * a**2 * np.sum(p * np.sin(theta) * np.cos(theta) * v * np.pi / 4)
        # Gauss rule through the logarithm of the cone's pressure at the axis: 1e-5; smooth otherwise, and the pressure of the
        # contact without adhesion is superposed to 1e-9
        assert total == pytest.approx(float(curve.force[0]), rel=1e-5 if isinstance(indenter, fp.Cone) else 1e-8)
        assert p[-1] < 0
        edge = fp.pressure(GEL, indenter, [a, 1.001 * a], 0.0, depth=depth, work_of_adhesion=W)
        assert edge[0] == -np.inf
        assert edge[1] == 0
