"""What is particular to each shape, and the refusal of bad input."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flatpunch.indenters import (
    AngularTable,
    Cone,
    Cylinder,
    EllipticParaboloid,
    Paraboloid,
    PowerLaw,
    Pyramid,
    RadialProfile,
    Sphere,
)

seeded = settings(max_examples=60, derandomize=True, deadline=None)


@seeded
@given(st.integers(3, 12), st.floats(0.01, 1.5), st.floats(-3, 3), st.floats(-3, 3))
def test_pyramid_is_the_highest_of_its_faces(sides, inclination, x, y):
    normals = 2 * np.pi * np.arange(sides) / sides
    faces = math.tan(inclination) * (x * np.cos(normals) + y * np.sin(normals))
    r, phi = math.hypot(x, y), math.atan2(y, x)
    # angles and products at rounding
    assert Pyramid(sides, inclination).height(r, phi) == pytest.approx(faces.max(), rel=1e-13, abs=1e-300)


def test_first_face_of_a_pyramid_looks_along_x():
    tip = Pyramid(4, math.pi / 4)
    assert tip.height(1.0, 0.0) == pytest.approx(1.0)
    assert tip.corners[0] == pytest.approx(math.pi / 4)


def test_elliptic_paraboloid_in_cartesian_coordinates():
    tip = EllipticParaboloid(0.3, 0.8)
    assert tip.height(math.hypot(2, 3), math.atan2(3, 2)) == pytest.approx(0.3 * 4 + 0.8 * 9, rel=1e-14)
    assert EllipticParaboloid(0.25, 0.25).round
    assert EllipticParaboloid(0.25, 0.25).height(1.0, 0.3) == pytest.approx(Paraboloid(2.0).height(1.0, 0.0))


def test_sphere_is_exact_at_its_apex_and_ends_at_its_equator():
    ball = Sphere(2.0)
    assert ball.reach == pytest.approx(1.9)
    # r^2/(2R) + r^4/(8R^3): the next term is below rounding
    assert ball.height(1e-5, 0.0) == pytest.approx(1e-10 / 4 + 1e-20 / 64, rel=1e-15)
    assert ball.height(2.0, 0.0) == 2.0
    assert ball.height(2.1, 0.0) == np.inf
    assert ball.slope(2.0, 0.0) == np.inf


def test_cylinder_has_no_surface_beyond_its_rim():
    np.testing.assert_array_equal(Cylinder(1.0).height(np.array([0.0, 1.0, 1.01]), 0.0), [0, 0, np.inf])


def test_power_law_kinds_agree():
    for tip in (PowerLaw(2, 0.25), PowerLaw(2, lambda phi: np.full(np.shape(phi), 0.25))):
        assert tip.height(1.3, 0.7) == pytest.approx(Paraboloid(2.0).height(1.3, 0.7))
        assert tip.round
    assert PowerLaw(2, 0.25) == PowerLaw(2.0, 0.25)
    assert not PowerLaw(2, lambda phi: 1 + 0.1 * np.cos(phi)).round


def test_a_table_converges_with_the_fourth_power_of_its_spacing():
    errors = []
    for points in (24, 48, 96):
        phi = 2 * np.pi * np.arange(points) / points
        tip = PowerLaw(1, (phi, np.exp(np.sin(phi))))
        fine = np.linspace(0, 2 * np.pi, 997)
        errors.append(np.abs(tip.angular(fine) - np.exp(np.sin(fine))).max())
    # cubic splines: factor 16 per halving
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(16, rel=0.2)


def test_a_table_keeps_its_corners_sharp():
    square = Pyramid(4, 0.4)
    phi = (2 * np.arange(32) + 1) * np.pi / 32
    corners = tuple((2 * j + 1) * np.pi / 4 for j in range(4))
    points = np.unique(np.concatenate([phi, corners]))
    tip = PowerLaw(1, (points, square.angular(points)), corners)
    fine = np.linspace(-1, 9, 1203)
    # spline error of a cosine at spacing pi/16: (5/384) h^4 inside, not-a-knot ends a few times that
    np.testing.assert_allclose(tip.angular(fine), square.angular(fine), atol=1e-4)
    assert tip.angular(np.array(corners)) == pytest.approx(square.angular(np.array(corners)), rel=1e-14)
    assert tip.angular == AngularTable(points, square.angular(points), corners)


@pytest.mark.parametrize("tip", [Cone(0.4), Paraboloid(1.3)], ids=["cone", "parabola"])
@pytest.mark.parametrize("spacing", ["even", "uneven"])
def test_a_measured_tip_finds_out_whether_it_is_sharp(tip, spacing):
    r = np.linspace(0, 1, 12) if spacing == "even" else np.array([0, 0.05, 0.2, 0.24, 0.5, 0.7, 1.0])
    table = RadialProfile(r, tip.height(r, 0.0))
    fine = np.linspace(0, 1, 301)
    # both lie within the quartics from which slopes are taken; limits of 3 chord slopes do not touch either
    # (the parabola's slope over its smaller chord is at most 2 + widths' ratio, which the uneven table keeps
    # below 3 at its kinks)
    np.testing.assert_allclose(table.height(fine, 0.0), tip.height(fine, 0.0), rtol=1e-11, atol=1e-15)


def test_a_measured_sphere_converges():
    ball, fine = Sphere(1.0), np.linspace(0, 0.9, 777)
    errors = []
    for points in (20, 40, 80, 160):
        r = np.linspace(0, 0.9, points + 1)
        table = RadialProfile(r, ball.height(r, 0.0))
        errors.append(np.abs(table.height(fine, 0.0) - ball.height(fine, 0.0)).max())
    # cubic Hermite with slopes of fourth order: at least a factor 12 per halving once the steep rim is
    # resolved
    assert errors[2] / errors[3] > 12
    assert errors[3] < 1e-7


@seeded
@given(st.lists(st.tuples(st.floats(1e-3, 1), st.floats(0, 1)), min_size=3, max_size=25))
def test_measured_profiles_rise_and_meet_their_points(steps):
    r = np.concatenate([[0], np.cumsum([s[0] for s in steps])])
    f = np.concatenate([[0], np.cumsum([s[1] for s in steps])])
    if f[-1] == 0:
        return
    table = RadialProfile(r, f)
    fine = np.linspace(0, 1.2 * r[-1], 500)
    # monotone up to rounding of the cubic's terms
    assert (np.diff(table.height(fine, 0.0)) >= -1e-13 * f[-1]).all()
    assert (table.slope(fine, 0.0) >= 0).all()
    np.testing.assert_allclose(table.height(r, 0.0), f, rtol=1e-12, atol=1e-13 * f[-1])


def test_a_named_kink_stays_a_kink():
    r = np.linspace(0, 1, 11)
    table = RadialProfile(r, np.maximum(r - 0.3, 0), kinks=[0.3])
    fine = np.linspace(0, 1, 101)
    # a straight line on each side
    np.testing.assert_allclose(table.height(fine, 0.0), np.maximum(fine - 0.3, 0), atol=4e-15)
    assert table.rings == pytest.approx((0.3,))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Paraboloid(0), "Paraboloid.radius = 0.0 must be finite and > 0"),
        (lambda: Paraboloid(math.nan), "Paraboloid.radius = nan must be finite and > 0"),
        (lambda: Sphere(-1), "Sphere.radius"),
        (lambda: Cylinder(math.inf), "Cylinder.radius"),
        (lambda: EllipticParaboloid(1, -2), "EllipticParaboloid.B"),
        (lambda: Cone(math.pi / 2), "0 < inclination < pi/2"),
        (lambda: Cone(0.0), "Cone.inclination"),
        (lambda: Cone(65), "math.radians"),
        (lambda: Pyramid(2, 0.3), "Pyramid.sides = 2"),
        (lambda: Pyramid(4, -0.3), "Pyramid.inclination"),
        (lambda: PowerLaw(0, 1.0), "PowerLaw.exponent"),
        (lambda: PowerLaw(1, -1.0), "PowerLaw.angular"),
        (lambda: PowerLaw(1, lambda phi: np.cos(phi)), "must be finite and > 0"),
        (lambda: PowerLaw(1, lambda phi: 2 + np.cos(phi / 2)), "not periodic"),
        (lambda: PowerLaw(1, lambda phi: 1.0), "one value per angle"),
        (lambda: PowerLaw(1, ([0, 1], [1, 1])), "3 or more"),
        (lambda: PowerLaw(1, ([0, 2, 1], [1, 1, 1])), "increase strictly"),
        (lambda: PowerLaw(1, ([0, 2, 2 * math.pi], [1, 1, 1])), "repeated first point"),
        (lambda: PowerLaw(1, ([0, 2, 4], [1, 0, 1])), "psi"),
        (lambda: PowerLaw(1, ([0, 1, 2], [1, 2, 3], [4, 5, 6])), "pair"),
        (lambda: PowerLaw(1, ([0, 0.1, 3, 3.1], [1, 0.01, 0.01, 1])), "must be finite and > 0"),
        (lambda: PowerLaw(1, ([0, 2, 4], [1, 2, 1]), corners=[1]), "no angle of the table"),
        (lambda: RadialProfile([0, 1, 2], [0, 1]), "equally many"),
        (lambda: RadialProfile([0.1, 1, 2], [0, 1, 2]), "must start at r = 0"),
        (lambda: RadialProfile([0, 1, 2], [0.1, 1, 2]), "must start at r = 0"),
        (lambda: RadialProfile([0, 1, 1], [0, 1, 2]), "increase strictly"),
        (lambda: RadialProfile([0, 1, 2], [0, -1, 2]), r"RadialProfile.f\[1\] = -1"),
        (lambda: RadialProfile([0, 1, 2], [0, 2, 1]), "falls: smooth the measured profile, smoothing ="),
        (lambda: RadialProfile([0, 1, 2], [0, -1, 1]), "lowest point of an indenter.*smoothing ="),
        (lambda: RadialProfile([0, 1, 2], [0, 0, 0]), "does not rise"),
        (lambda: RadialProfile([0, 1, math.nan], [0, 1, 2]), r"RadialProfile.r\[2\]"),
        (lambda: RadialProfile([0, 1, 2], [0, 1, 2], kinks=[1.5]), "no inner radius"),
    ],
)
def test_bad_shapes_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize(
    "make",
    [
        lambda: Cone("steep"),
        lambda: PowerLaw(1, math.cos),
        lambda: RadialProfile("ab", [0, 1, 2]),
        lambda: PowerLaw(1, lambda phi: 1 + 0 * np.cos(phi), corners=3),
    ],
)
def test_wrong_types_are_refused(make):
    with pytest.raises(TypeError):
        make()
