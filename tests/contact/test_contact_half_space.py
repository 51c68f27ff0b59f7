"""Round and pyramidal contact on a homogeneous half-space against closed forms (`flatpunch.reference.half_space`)."""

import numpy as np
import pytest
from scipy.integrate import quad

import flatpunch as fp
from flatpunch.reference import half_space as exact

BODY = fp.HalfSpace(young=70e9, poisson=0.22)
MODULUS = 70e9 / (1 - 0.22**2)
RADII = np.geomspace(1e-10, 1e-4, 25)

# Closed forms of a few operations on both sides: tens of eps, 1e-13 leaves room for the Beta functions.
ROUNDING = 1e-13


def agrees(curve, contact, rtol=ROUNDING):
    np.testing.assert_allclose(curve["depth"], contact.depth, rtol=rtol)
    np.testing.assert_allclose(curve["force"], contact.force, rtol=rtol)
    np.testing.assert_allclose(curve["stiffness"], contact.stiffness, rtol=rtol)
    np.testing.assert_allclose(curve["area"], np.pi * contact.radius**2, rtol=rtol)
    np.testing.assert_allclose(curve["radius"], contact.radius, rtol=rtol)
    assert curve["valid"].all()
    # exact, but pressed to strains at which no body is linear
    assert all("strains" in note for note in curve.attrs["notes"].splitlines())


def test_hertz():
    agrees(fp.indent(BODY, fp.Paraboloid(10e-6), radius=RADII), exact.paraboloid(RADII, 10e-6, MODULUS))


def test_cone():
    agrees(fp.indent(BODY, fp.Cone(0.35), radius=RADII), exact.cone(RADII, 0.35, MODULUS))


def test_sphere_of_true_shape_up_to_its_reach():
    radii = 10e-6 * np.concatenate([np.geomspace(1e-6, 0.5, 12), np.linspace(0.6, 0.95, 8)])
    # The force cancels to (a/R)^3 of its parts in `sphere`'s own closed form only; the rest is quadrature rounding.
    agrees(fp.indent(BODY, fp.Sphere(10e-6), radius=radii), exact.sphere(radii, 10e-6, MODULUS), rtol=2e-13)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 2.0, 3.7, 4.0, 8.0])
def test_power_law(exponent):
    indenter = fp.PowerLaw(exponent, 3.0)
    agrees(fp.indent(BODY, indenter, radius=RADII), exact.power_law(RADII, exponent, 3.0, MODULUS), rtol=5e-13)


def test_flat_end_is_proportional_with_any_depth():
    depth = np.array([0, 1e-30, 1e-9, 1e3])
    curve = fp.indent(BODY, fp.Cylinder(2e-6), depth=depth)
    np.testing.assert_allclose(curve["force"], exact.flat_punch(2e-6, depth, MODULUS).force, rtol=ROUNDING)
    np.testing.assert_array_equal(curve["radius"], 2e-6)


@pytest.mark.parametrize("quantity", ["depth", "force"])
def test_truncated_cone_begins_as_a_flat_punch(quantity):
    # A table with a kink at the edge of its flat face: r0 = 1 um, then a face of slope 0.3.
    edge, slope = 1e-6, 0.3
    r = edge * np.array([0, 0.5, 1, 1.5, 2, 3, 5])
    tip = fp.RadialProfile(r, slope * np.maximum(r - edge, 0), kinks=[edge])
    radii = edge * np.array([1 + 1e-9, 1.0001, 1.1, 2.0, 4.5])
    contacts = [exact.sneddon(lambda x: slope * (x > edge), a, MODULUS, kinks=[edge]) for a in radii]
    depth, force = (np.array([getattr(c, name) for c in contacts]) for name in ("depth", "force"))
    curve = fp.indent(BODY, tip, **{quantity: depth if quantity == "depth" else force})
    # Near the edge depth and force go like (a - r0)^(1/2), so the reference itself loses half its digits at 1e-9.
    np.testing.assert_allclose(curve["depth"], depth, rtol=2e-7)
    np.testing.assert_allclose(curve["force"], force, rtol=2e-7)
    # From r0 (1 + 1e-4) on both sides are rounding over sqrt(1e-4).
    np.testing.assert_allclose(curve["depth"][1:], depth[1:], rtol=1e-11)
    np.testing.assert_allclose(curve["force"][1:], force[1:], rtol=1e-11)
    # At depths that move the radius by less than its own rounding the tip is a punch of radius r0: F = 2 E* r0 d.
    tiny = fp.indent(BODY, tip, depth=[0.0, 1e-18, 1e-15])
    np.testing.assert_allclose(tiny["force"], 2 * MODULUS * edge * tiny["depth"], rtol=1e-6)
    np.testing.assert_array_equal(tiny["depth"], [0.0, 1e-18, 1e-15])


def test_table_of_a_paraboloid_is_the_paraboloid():
    r = np.linspace(0, 1e-6, 60)
    table = fp.RadialProfile(r, r**2 / 20e-6)
    radii = np.linspace(1e-9, 1e-6, 40)
    # The table's piecewise cubics reproduce a parabola exactly.
    agrees(fp.indent(BODY, table, radius=radii), exact.paraboloid(radii, 10e-6, MODULUS), rtol=1e-12)


def test_table_of_a_ball_converges_with_the_fourth_power_of_its_spacing():
    # Cubics through exact values with slopes of fourth order: f is good to h^4 (single steps scatter: radii fall
    # differently between the points).
    radii = np.linspace(0.2e-6, 0.8e-6, 7)
    truth = exact.sphere(radii, 1e-6, MODULUS)
    errors = []
    points = np.array([11, 21, 41, 81])
    for count in points:
        r = np.linspace(0, 0.9e-6, count)
        curve = fp.indent(BODY, fp.RadialProfile(r, 1e-6 - np.sqrt(1e-12 - r**2)), radius=radii)
        errors.append(np.abs(curve["force"].values / truth.force - 1).max())
    slope = np.polyfit(np.log(1 / (points - 1)), np.log(errors), 1)[0]
    assert 3.6 < slope < 5, (slope, errors)


def test_three_sided_and_square_pyramids_have_the_papers_force_constant():
    # The first-order force on a half-space is that of the mean profile: F = C E* d^2/tan with the cone's C = 2/pi over
    # the mean of cos over one face, for the square pyramid 1/sqrt(2).
    slope = np.tan(0.3)
    for sides in (3, 4, 6, 40):
        mean = np.sin(np.pi / sides) / (np.pi / sides)
        curve = fp.indent(BODY, fp.Pyramid(sides, 0.3), depth=[1e-9, 1e-6], method="first-order")
        constant = curve["force"].values * slope / (MODULUS * curve["depth"].values ** 2)
        np.testing.assert_allclose(constant, 2 / np.pi / mean, rtol=1e-12)
    square = fp.indent(BODY, fp.Pyramid(4, 0.3), depth=1e-6, method="first-order")
    assert float(square["force"][0]) * slope / (MODULUS * 1e-12) == pytest.approx(1 / np.sqrt(2), rel=1e-12)


@pytest.mark.parametrize("share", [1e-6, 0.1, 0.5, 0.9, 0.999999])
def test_pressures_have_their_closed_forms(share):
    a = 2e-6
    r = share * a
    hertz = fp.pressure(BODY, fp.Paraboloid(10e-6), r, 0.0, radius=a)
    # At 1e-6 from the edge both sides keep ten digits of a - r.
    np.testing.assert_allclose(hertz, exact.paraboloid_pressure(r, a, 10e-6, MODULUS), rtol=1e-9)
    cone = fp.pressure(BODY, fp.Cone(0.2), 0.0, r, radius=a)
    np.testing.assert_allclose(cone, exact.cone_pressure(r, a, 0.2, MODULUS), rtol=1e-9)
    punch = fp.pressure(BODY, fp.Cylinder(a), 0.6 * r, -0.8 * r, depth=1e-9)
    np.testing.assert_allclose(punch, exact.flat_punch_pressure(r, a, 1e-9, MODULUS), rtol=1e-10)


def test_pressure_under_a_ball_at_the_end_of_its_reach():
    # p = (E*/pi) int d'(s)/sqrt(s^2 - r^2) ds with d' of the ball, s = r cosh v
    ball, a = 3e-6, 0.95 * 3e-6

    def rate(s):
        return 0.5 * np.log((ball + s) / (ball - s)) + s * ball / (ball**2 - s**2)

    r = a * np.array([1e-9, 1e-4, 0.01, 0.3, 0.9, 0.999])
    field = fp.pressure(BODY, fp.Sphere(ball), r, np.zeros_like(r), radius=a)
    expected = [quad(lambda v, r=r: rate(r * np.cosh(v)), 0, np.arccosh(a / r), epsrel=1e-12)[0] for r in r]
    # measured 3e-10 at the axis: the history varies on 0.05 of the radius at its end
    np.testing.assert_allclose(field, MODULUS / np.pi * np.array(expected), rtol=2e-9)


@pytest.mark.parametrize("reach", [1.001, 1.05, 1.5, 4.0])
def test_pressure_under_a_truncated_cone(reach):
    # d'(a) starts anew at the kink like (a - r0)^(-1/2), and the pressure has a logarithm there.
    edge, slope = 1e-6, 0.3
    r = edge * np.array([0, 0.5, 1, 1.5, 2, 3, 5])
    tip, a = fp.RadialProfile(r, slope * np.maximum(r - edge, 0), kinks=[edge]), reach * edge

    def rate(s):
        return slope * (np.arccos(edge / s) + edge / np.sqrt((s - edge) * (s + edge)))

    def exactly(at):
        # s = max(r, r0) + q^2 takes the square root out of either end
        start = max(at, edge)
        if at < edge:
            kernel = lambda q: rate(start + q**2) * 2 * q / np.sqrt((start + q**2) ** 2 - at**2)  # noqa: E731
        else:
            kernel = lambda q: rate(start + q**2) * 2 / np.sqrt(2 * at + q**2)  # noqa: E731
        return MODULUS / np.pi * quad(kernel, 0, np.sqrt(a - start), epsrel=1e-11, limit=200)[0]

    points = np.concatenate([edge * np.array([1e-6, 0.5, 0.9, 0.99]), edge + (a - edge) * np.array([0.3, 0.9])])
    field = fp.pressure(BODY, tip, points, np.zeros_like(points), radius=a)
    # measured 1e-10 and below; the reference's q^2 beside the radius costs as much
    np.testing.assert_allclose(field, [exactly(at) for at in points], rtol=3e-9)


def test_pressure_at_many_points_costs_no_accuracy_and_little_time():
    # more points than one chunk: the seams between chunks must not show
    r = np.linspace(0, 1.9e-6, 9000)
    field = fp.pressure(BODY, fp.Paraboloid(1e-5), r, np.zeros_like(r), radius=2e-6)
    np.testing.assert_allclose(field, exact.paraboloid_pressure(r, 2e-6, 1e-5, MODULUS), rtol=1e-10)
