"""Adhesion of finite range: closed forms, another way to the same contact on layers, limits of JKR and of rigid bodies."""

import json

import numpy as np
import pytest
import scipy

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.contact.adhesion.maugis import MaugisBranch
from flatpunch.contact.round.carried import on_moved_surface, round_pressures, wave_range
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.punch.wavenumbers import bessel_table
from flatpunch.reference.adhesion import maugis_paraboloid

R = 5e-6
GEL = fp.HalfSpace(young=1e6, poisson=0.3)
SILICA = fp.HalfSpace(young=70e9, poisson=0.17)
H = 1e-6
BODIES = {
    "on rigid": fp.Medium([fp.Layer(1e6, 0.3, H)], base=fp.RigidBase()),
    "incompressible": fp.Medium([fp.Layer(1e6, 0.5, H)], base=fp.RigidBase()),
    "film": fp.Medium([fp.Layer(1e8, 0.3, H)], base=GEL),
    "soft": fp.Medium([fp.Layer(1e4, 0.3, H)], base=GEL),
    "graded": fp.Medium([fp.GradedLayer(fp.ExponentialModulus(1e6, 5e6, H), 0.3, H)], base=fp.HalfSpace(5e6, 0.3)),
    "two": fp.Medium([fp.Layer(1e6, 0.3, H), fp.Layer(1e7, 0.4, H)], base=fp.HalfSpace(1e5, 0.3)),
}


# the numbers of the theory: a, c and s0 over R, R and E*
@pytest.mark.parametrize(
    ("a", "c", "stress"),
    [(0.1, 0.11, 0.05), (0.1, 0.15, 0.02), (0.05, 0.1, 0.01), (0.1, 0.102, 0.2), (0.001, 0.1, 0.01)],
)
def test_closed_form_of_maugis(a, c, stress):
    a, c, stress = a * R, c * R, stress * GEL.surface_modulus
    depth, force, gap = maugis_paraboloid(a, c, R, GEL.surface_modulus, stress)
    found = fp.indent(GEL, fp.Paraboloid(R), radius=a, work_of_adhesion=stress * gap, range_of_action=gap)
    # series end at 1e-10; a is a thousandth of c at most, and counts by its square
    assert found.depth.item() == pytest.approx(depth, rel=1e-10)
    assert found.force.item() == pytest.approx(force, rel=1e-10)
    assert found.adhesive_radius.item() == pytest.approx(c, rel=1e-10)
    assert found.force_error.item() < 1e-9


def _lifted(kernel, c, r):
    """Displacement under the uniform pressure 1 on a disc: elliptic integrals, and what the layers change."""
    half_space = 4 * c / (np.pi * kernel.modulus) * scipy.special.ellipe((r / c) ** 2)
    beta = c / kernel.length
    first, last = wave_range(kernel, beta, beta)
    table = bessel_table(0, 1, first, 4 * last)
    rest = kernel.remainder(table.x / beta) * table.w * scipy.special.j1(table.x) / table.x
    return half_space + 2 * c / kernel.modulus * rest @ scipy.special.j0(np.outer(table.x, r / c))


def _beside(kernel, contact, c):
    """Displacement at the radius c beside a contact."""
    pressure = round_pressures(kernel, contact)[0]
    t, v = np.polynomial.legendre.leggauss(200)
    end = np.arcsin(pressure.radius / c)
    shares = np.sin(end * (1 + t) / 2) * c / pressure.radius
    signed = pressure.series * (-1.0) ** np.arange(pressure.series.size)
    half_space = end * (np.polynomial.legendre.legvander(shares, 2 * signed.size - 2)[:, ::2] @ signed) @ v
    return half_space + pressure.displacement(kernel.remainder, np.array([c]))[0]


@pytest.mark.long
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize(("ratio", "wider"), [(0.3, 1.3), (2.0, 1.2)])
def test_layers_by_the_tip_on_the_surface_that_the_stress_moves(body, ratio, wider):
    kernel, tip, a = compliance(BODIES[body]), fp.Paraboloid(R), ratio * H
    c, stress, profile = wider * a, 0.1 * kernel.modulus * a / R, mean_profile(tip)
    moved = on_moved_surface(profile, lambda r: stress * _lifted(kernel, c, r), a)
    contact = round_contact(kernel, moved, np.array([a]))
    middle, end = _lifted(kernel, c, np.array([0.0, c])) * stress
    depth, force = contact.depth[0] - middle, contact.force[0] - np.pi * c**2 * stress
    gap = float(profile.height(np.array([c]))[0] - depth + _beside(kernel, contact, c) - end)
    found = fp.indent(BODIES[body], tip, radius=a, work_of_adhesion=stress * gap, range_of_action=gap)
    # the pressures of the other way end with their punches' terms, and integrals over graded surfaces with 1e-6
    rtol = 1e-6 if body == "graded" else 1e-9
    assert found.depth.item() == pytest.approx(depth, rel=rtol)
    assert found.force.item() == pytest.approx(force, rel=rtol)
    assert found.adhesive_radius.item() == pytest.approx(c, rel=rtol)
    assert abs(found.force.item() / force - 1) < found.force_error.item()


@pytest.mark.long
@pytest.mark.parametrize("body", [GEL, BODIES["incompressible"]], ids=["half-space", "layer"])
def test_short_ranges_are_jkr(body):
    tip, work = fp.Sphere(R), 1e-3
    jkr = fp.pull_off(body, tip, work_of_adhesion=work)
    off = [
        fp.pull_off(body, tip, work_of_adhesion=work, range_of_action=z0).force / jkr.force - 1 for z0 in (1e-10, 1e-11)
    ]
    # on half-spaces and layers the first term is (c/a - 1), which goes like z0^2
    assert 0 < off[1] < off[0] < 1e-4
    assert off[0] / off[1] == pytest.approx(100, rel=0.5)


@pytest.mark.long
def test_stiff_bodies_are_rigid():
    # Bradley, with a constant stress over gaps below z0: f(r0) = z0 on the true sphere is r0^2 = 2 R z0 - z0^2
    stiff = fp.Medium([fp.Layer(1e16, 0.3, H)], base=fp.RigidBase())
    found = fp.pull_off(stiff, fp.Sphere(H), work_of_adhesion=0.05, range_of_action=1e-8)
    # the bodies yield by 1e-5 of the range
    assert found.force == pytest.approx(-0.05 / 1e-8 * np.pi * (2e-14 - 1e-16), rel=1e-4)
    assert found.depth_minimum.depth == pytest.approx(-1e-8, rel=1e-4)
    assert found.depth_minimum.radius == 0


@pytest.mark.long
def test_pull_off_rises_from_jkr_to_rigid_bodies():
    ranges, tip = [3e-9, 3e-10, 3e-11, 3e-12], fp.Paraboloid(20e-9)
    found = [fp.pull_off(SILICA, tip, work_of_adhesion=0.1, range_of_action=z0) for z0 in ranges]
    shares = np.array([each.force for each in found]) / (-np.pi * 0.1 * 20e-9)
    assert (np.diff(shares) < 0).all()
    assert 1.5 < shares[-1] < 1.502
    assert 1.997 < shares[0] < 2.0
    assert all(each.force_minimum.force_error < 1e-9 for each in found)


@pytest.mark.long
@pytest.mark.parametrize("quantity", ["depth", "force"])
@pytest.mark.parametrize("body", [GEL, BODIES["on rigid"]], ids=["half-space", "layer"])
@pytest.mark.parametrize("z0", [1e-9, 1e-8])
def test_losses_are_the_area_of_the_loop(quantity, body, z0):
    tip, most = fp.Sphere(R), {"depth": 2e-8, "force": 2e-8}[quantity]
    loop = fp.adhesion_loop(body, tip, work_of_adhesion=1e-3, range_of_action=z0, points=2000, **{quantity: most})
    depth, force = loop.depth.values, loop.force.values
    # a thousandth is left by straight lines between points beside folds
    assert loop.attrs["energy_lost"] == pytest.approx(-np.trapezoid(force, depth), rel=1e-3)
    jumps = json.loads(loop.attrs["jumps"])
    assert jumps[0]["kind"] == "jump_in"
    if quantity == "depth":
        assert jumps[0]["depth"] == -z0


@pytest.mark.long
def test_steep_tips_come_and_go_without_a_jump():
    cone = fp.Cone(0.3)
    lost = fp.pull_off(GEL, cone, work_of_adhesion=1e-3, range_of_action=1e-7).depth_minimum
    assert (lost.force, lost.depth, lost.radius) == (0.0, -1e-7, 0.0)
    loop = fp.adhesion_loop(GEL, cone, work_of_adhesion=1e-3, range_of_action=1e-7, depth=1e-7, points=20)
    assert loop.attrs["energy_lost"] < 1e-12 * 1e-7 * abs(loop.force.values).max()


def test_stiffness_is_the_slope_of_force_over_depth():
    given = {"work_of_adhesion": 1e-3, "range_of_action": 1e-8}
    depth, step = np.array([-2e-8, 0.0, 5e-8]), 1e-11
    below, at, above = (fp.indent(GEL, fp.Sphere(R), depth=depth + by, **given) for by in (-step, 0.0, step))
    slope = (above.force.values - below.force.values) / (2 * step)
    # squared steps over squared distances to the fold, and rounding over steps
    np.testing.assert_allclose(at.stiffness.values, slope, rtol=1e-5)


@pytest.mark.parametrize("body", [GEL, BODIES["incompressible"]], ids=["half-space", "layer"])
def test_pressure_has_the_force_and_is_the_stress_beside_the_contact(body):
    given = {"work_of_adhesion": 1e-3, "range_of_action": 1e-8}
    curve = fp.indent(body, fp.Sphere(R), depth=2e-8, **given)
    a, c = curve.radius.item(), curve.adhesive_radius.item()
    t, v = np.polynomial.legendre.leggauss(60)
    angle = np.pi / 4 * (1 + t)
    r = a * np.sin(angle)
    inside, error = fp.pressure(body, fp.Sphere(R), r, 0.0, depth=2e-8, return_error=True, **given)
    force = 2 * np.pi * (inside * r * a * np.cos(angle)) @ v * np.pi / 4 - 1e5 * np.pi * (c**2 - a**2)
    # the pressure is a series in the root of the distance from the edge
    assert force == pytest.approx(curve.force.item(), rel=1e-6)
    assert error.max() < 1e-4 * abs(inside).max()
    beside = fp.pressure(body, fp.Sphere(R), np.array([1.001 * a, 0.999 * c, 1.001 * c]), 0.0, depth=2e-8, **given)
    np.testing.assert_array_equal(beside, [-1e5, -1e5, 0.0])


@pytest.mark.parametrize("wider", [1e-2, 1e-4, 1e-6, 1e-8])
def test_pressure_of_narrow_rings_is_that_of_maugis(wider):
    """As the range goes to zero; half-space, 2/pi s0 arctan of the root of (c^2 - a^2)/(a^2 - r^2) less than that of Hertz."""
    a, tip, modulus = 0.1 * R, fp.Paraboloid(R), GEL.surface_modulus
    c, stress = a * (1 + wider), 0.005 * modulus / np.sqrt(wider)
    _, _, gap = maugis_paraboloid(a, c, R, modulus, stress)
    r = a * np.array([0.0, 0.5, 0.9, 0.999, 1 - 1e-5])
    given = {"radius": a, "work_of_adhesion": stress * gap, "range_of_action": gap}
    found, error = fp.pressure(GEL, tip, r, 0.0, return_error=True, **given)
    drawn = 2 / np.pi * stress * np.arctan(np.sqrt((c - a) * (c + a) / ((a - r) * (a + r))))
    closed = 2 * modulus / (np.pi * R) * np.sqrt((a - r) * (a + r)) - drawn
    # the gap of narrow rings is a difference in the closed form
    np.testing.assert_allclose(found, closed, rtol=1e-5, atol=1e-7 * stress)
    assert error.max() < 1e-4 * abs(found).max()


def test_radii_on_layers_that_bulge_are_those_prescribed():
    """Under a wide ring an incompressible layer rises again beside it, with a gap as wide as the range."""
    a, tip = 6 * H, fp.Paraboloid(10 * R)
    jkr = fp.indent(BODIES["incompressible"], tip, radius=a, work_of_adhesion=1e-3)
    found = fp.indent(BODIES["incompressible"], tip, radius=a, work_of_adhesion=1e-3, range_of_action=1e-12)
    assert found.radius.item() == pytest.approx(a, rel=1e-9)
    assert found.force.item() == pytest.approx(jkr.force.item(), rel=1e-6)


@pytest.mark.parametrize(
    ("body", "tip"),
    [
        (GEL, fp.Cylinder(1e-6)),
        (GEL, fp.Pyramid(4, 0.4)),
        (fp.PowerLawHalfSpace(1e6, 0.3, 1e-6, 0.3), fp.Paraboloid(R)),
    ],
    ids=["flat end", "pyramid", "power law"],
)
def test_what_is_solved_by_jkr_only_is_refused(body, tip):
    with pytest.raises(ValueError, match=r"range_of_action = 1 nm does not go with"):
        fp.pull_off(body, tip, work_of_adhesion=1e-3, range_of_action=1e-9)


def test_ranges_across_the_whole_tip_are_refused():
    with pytest.raises(ValueError, match=r"strength = 1 MPa does not go with the indenter Pyramid"):
        fp.pull_off(GEL, fp.Pyramid(4, 0.4), work_of_adhesion=1e-3, strength=1e6)
    with pytest.raises(ValueError, match=r"strength = 500 Pa reaches across the gap"):
        fp.adhesion_loop(GEL, fp.Sphere(H), work_of_adhesion=1e-3, strength=500.0, depth=1e-7)
    with pytest.raises(ValueError, match=r"range_of_action = 2 µm reaches across the gap"):
        fp.pull_off(GEL, fp.Sphere(H), work_of_adhesion=1e-3, range_of_action=2e-6)


@pytest.mark.long
def test_discs_of_long_ranges_on_graded_layers_are_no_wider_than_what_is_solved():
    """The rim of the flat is touched where adhesion acts far outside of it."""
    tip = fp.Truncated(fp.Cone(0.3), 5e-8)
    branch = MaugisBranch(compliance(BODIES["graded"]), mean_profile(tip), tip.reach, 1e-3, 5e-7)
    # rigid bodies: the cone is as far away as the range
    assert max(branch.kinks) == pytest.approx((5e-7 + 5e-8) / np.tan(0.3), rel=0.01)


@pytest.mark.long
def test_contacts_that_just_pass_the_border_of_a_flat_are_solved():
    """The series did not end there: rounding of the distance from the border is left, however short the pieces are."""
    body, tip = fp.Medium([fp.Layer(6e3, 0.2, 5e-7)], base=fp.HalfSpace(4e4, 0.45)), fp.Truncated(fp.Cone(0.3), 3e-7)
    branch = MaugisBranch(compliance(body), mean_profile(tip), tip.reach, 1e-7, 7e-9)
    outer = branch.passed(np.array(tip.rings)) * (1 + np.array([1e-9, 1e-4]))
    # beside the border the depth rises like the root of the distance from it
    rounding = np.tan(0.3) * tip.rings[0] * np.sqrt(2 * np.finfo(float).eps)
    np.testing.assert_allclose(branch.at(outer).depth + 7e-9, branch.solved(outer)[:, 0], rtol=0, atol=rounding)


def test_radii_beside_the_end_of_the_tip_are_refused():
    with pytest.raises(
        ValueError, match=r"radius = 949\.9 nm is so large that adhesion acts beyond the end of the tip"
    ):
        fp.indent(GEL, fp.Sphere(H), radius=0.9499e-6, work_of_adhesion=1e-3, range_of_action=1e-8)


def test_a_strength_gives_the_range_of_action():
    tip, work = fp.Paraboloid(R), 1e-3
    by_range, by_strength = {"range_of_action": 1e-8}, {"strength": 1e5}
    lost = [fp.pull_off(GEL, tip, work_of_adhesion=work, **more).force for more in (by_range, by_strength)]
    loops = [fp.adhesion_loop(GEL, tip, work_of_adhesion=work, depth=1e-7, **more) for more in (by_range, by_strength)]
    curves = [fp.indent(GEL, tip, depth=1e-7, work_of_adhesion=work, **more) for more in (by_range, by_strength)]
    tensions = [
        float(fp.pressure(GEL, tip, 1.001 * c.radius.item(), 0.0, depth=1e-7, work_of_adhesion=work, **more))
        for c, more in zip(curves, (by_range, by_strength), strict=True)
    ]
    np.testing.assert_allclose(tensions, -1e5, rtol=1e-12)
    for first, second in (lost, (curves[0].force.item(), curves[1].force.item())):
        assert second == pytest.approx(first, rel=1e-12)
    assert loops[1].attrs["energy_lost"] == pytest.approx(loops[0].attrs["energy_lost"], rel=1e-9)
    assert curves[1].attrs["range_of_action"] == loops[1].attrs["range_of_action"] == pytest.approx(1e-8, rel=1e-15)
    with pytest.raises(ValueError, match=r"strength = 100 kPa is work_of_adhesion over range_of_action; leave one"):
        fp.pull_off(GEL, tip, work_of_adhesion=work, **by_range, **by_strength)
    with pytest.raises(ValueError, match=r"strength = 100000\.0 has no meaning without work_of_adhesion"):
        fp.indent(GEL, tip, depth=1e-7, **by_strength)
