"""The judges judged: closed forms against quadrature, limits and each other."""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import dblquad, quad
from scipy.special import ellipe, ellipk, hyp2f1

from flatpunch.reference import adhesion, elliptic, half_space, layers, power_law

DATA = Path(__file__).parents[1] / "data"
MODULUS = 3.0


def table(name):
    with open(DATA / name, encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


PROFILES = {
    "paraboloid": (lambda a: half_space.paraboloid(a, 2.0, MODULUS), lambda r: r / 2.0),
    "cone": (lambda a: half_space.cone(a, 0.4, MODULUS), lambda r: np.tan(0.4)),
    "sphere": (lambda a: half_space.sphere(a, 1.0, MODULUS), lambda r: r / np.sqrt(1 - r * r)),
    "r^3.5": (lambda a: half_space.power_law(a, 3.5, 0.7, MODULUS), lambda r: 3.5 * 0.7 * r**2.5),
}


@pytest.mark.parametrize("radius", [0.01, 0.099, 0.101, 0.5, 0.94])
@pytest.mark.parametrize(("closed", "slope"), PROFILES.values(), ids=PROFILES.keys())
def test_round_contacts_equal_sneddons_integrals(closed, slope, radius):
    exact, integral = closed(radius), half_space.sneddon(slope, radius, MODULUS)
    # 1e-12: quadrature at 1e-13 and the sphere's cancellation just above its series
    for name in ("depth", "force", "stiffness"):
        assert getattr(exact, name) == pytest.approx(getattr(integral, name), rel=1e-12), name


def test_sneddon_splits_at_kinks():
    ring = 0.3
    contact = half_space.sneddon(lambda r: float(r > ring), 1.0, 1.0, kinks=[ring])
    # f = max(r - c, 0), a = 1: d = arccos c, F = 2 int r^2/sqrt(1 - r^2) from c
    assert contact.depth == pytest.approx(np.arccos(ring), rel=1e-13)
    assert contact.force == pytest.approx(np.arccos(ring) + ring * np.sqrt(1 - ring**2), rel=1e-13)


@pytest.mark.parametrize("name", ["paraboloid", "cone", "flat"])
def test_pressures_carry_the_force(name):
    a = 0.7
    contact, pressure = {
        "paraboloid": (
            half_space.paraboloid(a, 2.0, MODULUS),
            lambda r: half_space.paraboloid_pressure(r, a, 2.0, MODULUS),
        ),
        "cone": (half_space.cone(a, 0.4, MODULUS), lambda r: half_space.cone_pressure(r, a, 0.4, MODULUS)),
        "flat": (half_space.flat_punch(a, 0.1, MODULUS), lambda r: half_space.flat_punch_pressure(r, a, 0.1, MODULUS)),
    }[name]
    # r = a sin t tames the edge
    total, _ = quad(lambda t: 2 * np.pi * a**2 * np.sin(t) * np.cos(t) * pressure(a * np.sin(t)), 0, np.pi / 2)
    # QUADPACK's default is 1.5e-8
    assert contact.force == pytest.approx(total, rel=1e-8)


def test_elliptic_contact_is_that_of_elliptic_integrals():
    contact = elliptic.elliptic_paraboloid(0.1, 0.7, MODULUS, depth=0.02)
    a, b, p0 = contact.half_axis_x, contact.half_axis_y, contact.peak_pressure
    m = 1 - (b / a) ** 2
    # Johnson, Contact Mechanics, eq. 4.26; the differences K - E cancel a little
    assert contact.depth == pytest.approx(p0 * b / MODULUS * ellipk(m), rel=1e-14)
    assert p0 / MODULUS * b / (a**2 * m) * (ellipk(m) - ellipe(m)) == pytest.approx(0.1, rel=1e-13)
    assert p0 / MODULUS * b / (a**2 * m) * ((a / b) ** 2 * ellipe(m) - ellipk(m)) == pytest.approx(0.7, rel=1e-13)
    assert contact.force == pytest.approx(2 / 3 * contact.area * p0, rel=1e-14)


@pytest.mark.parametrize("k", [-0.4, 0.0, 0.3, 0.8])
def test_elliptic_contact_on_graded_media(k):
    constant = power_law.stiffness_constant(2.0, 1.0, k, 0.3)
    contact = elliptic.elliptic_paraboloid(0.3, 0.9, constant, depth=0.01, exponent=k)
    a, b, p0 = contact.half_axis_x, contact.half_axis_y, contact.peak_pressure
    # the circle of equal A and B is the round contact, here at a tiny asymmetry so that the ratio is searched
    # for
    nearly = elliptic.elliptic_paraboloid(0.5, 0.5 + 1e-7, constant, depth=0.01, exponent=k)
    round_contact = power_law.power_law(nearly.half_axis_x, 2, 0.5, constant, k)
    assert nearly.depth == pytest.approx(float(round_contact.depth), rel=1e-7)
    assert nearly.force == pytest.approx(float(round_contact.force), rel=1e-7)
    # hypergeometric form of the same integrals, through 1 - m where they are regular
    m = 1 - (b / a) ** 2
    assert contact.depth == pytest.approx(
        (1 + k) * p0 * a**-k * b / (4 * constant) * 2 * np.pi * hyp2f1((1 + k) / 2, 0.5, 1, m), rel=1e-12
    )
    assert (
        pytest.approx(
            (1 + k) ** 2 * p0 * a ** (-2 - k) * b / (4 * constant) * np.pi * hyp2f1((3 + k) / 2, 0.5, 2, m), rel=1e-12
        )
        == 0.3
    )
    # force and depth control meet, x and y can be exchanged, dF/dd is the stiffness
    turned = elliptic.elliptic_paraboloid(0.9, 0.3, constant, force=contact.force, exponent=k)
    assert (turned.half_axis_y, turned.half_axis_x) == pytest.approx((a, b), rel=1e-13)
    more = elliptic.elliptic_paraboloid(0.3, 0.9, constant, depth=0.01 * (1 + 1e-5), exponent=k)
    less = elliptic.elliptic_paraboloid(0.3, 0.9, constant, depth=0.01 * (1 - 1e-5), exponent=k)
    assert (more.force - less.force) / 2e-7 == pytest.approx(contact.stiffness, rel=1e-8)


@pytest.mark.parametrize("k", [-0.3, 0.0, 0.4])
def test_elliptic_pressure_gives_the_shape_by_direct_integration(k):
    # the compliance |q|^(k-1) is r^-(1+k) in space; its constant drops out of the ratio to the deflection at the centre
    contact = elliptic.elliptic_paraboloid(0.2, 0.5, 1.0, depth=1.0, exponent=k)
    a, b = contact.half_axis_x, contact.half_axis_y

    def deflection(x, y):
        # polar about the point: r^-(1+k) r dr = dr^(1-k)/(1-k); s = r^(1-k) removes the singularity
        def ray(u, phi):
            reach = rim(x, y, phi)
            r = reach * u ** (1 / (1 - k))
            return reach ** (1 - k) / (1 - k) * contact.pressure(x + r * np.cos(phi), y + r * np.sin(phi))

        return dblquad(ray, 0, 2 * np.pi, 0, 1, epsabs=1e-7, epsrel=1e-7)[0]

    def rim(x, y, phi):
        c, s = np.cos(phi) / a, np.sin(phi) / b
        p, q = x / a, y / b
        half = p * c + q * s
        square = c * c + s * s
        return (-half + np.sqrt(half**2 + square * (1 - p * p - q * q))) / square

    centre = deflection(0.0, 0.0)
    for x, y in ((0.6 * a, 0.0), (0.0, 0.7 * b)):
        gap = 0.2 * x**2 + 0.5 * y**2
        assert deflection(x, y) / centre == pytest.approx(1 - gap / contact.depth, abs=2e-6)


@pytest.mark.parametrize("expected", table("power_law_half_space.csv"), ids=lambda t: f"{t['k']}-{t['nu']}")
def test_constants_of_power_law_media(expected):
    k, nu = float(expected["k"]), float(expected["nu"])
    # printed to twelve digits
    assert power_law.booker_constant(k, nu) == pytest.approx(float(expected["hN_formula"]), rel=5e-11)
    c = power_law.compliance(1.0, power_law.stiffness_constant(1.0, 1.0, k, nu), k)
    # the numerical constant comes from a differential equation, good to 2e-9
    assert c == pytest.approx(float(expected["c_numeric"]), rel=2e-9)


def test_gibson_soil_is_the_limit_along_incompressible_media():
    near = [power_law.booker_constant(1 - step, 0.5) for step in (2e-3, 1e-3)]
    # linear in the step, so twice the nearer less the farther leaves its square
    assert power_law.booker_constant(1.0, 0.5) == pytest.approx(2 * near[1] - near[0], abs=1e-5)


@pytest.mark.parametrize("k", [-0.3, 0.0, 0.5])
def test_power_law_media_contain_their_limits(k):
    contact = power_law.flat_punch(0.7, 0.1, 2.0, k)
    total, _ = quad(
        lambda t: (
            2 * np.pi * 0.49 * np.sin(t) * np.cos(t) * power_law.flat_punch_pressure(0.7 * np.sin(t), 0.7, 0.1, 2.0, k)
        ),
        0,
        np.pi / 2,
        epsrel=1e-10,
    )
    assert contact.force == pytest.approx(total, rel=1e-7)
    if k == 0:
        assert contact.force == pytest.approx(float(half_space.flat_punch(0.7, 0.1, 2.0).force), rel=1e-15)
        ours, plain = power_law.power_law(0.7, 3, 0.2, 2.0, 0.0), half_space.power_law(0.7, 3, 0.2, 2.0)
        assert (ours.depth, ours.force) == pytest.approx((float(plain.depth), float(plain.force)), rel=1e-14)
    # dF = K dd along the loading curve
    a = 0.7 * (1 + np.array([-1e-5, 1e-5]))
    curve = power_law.power_law(a, 2.5, 0.3, 2.0, k)
    middle = power_law.power_law(0.7, 2.5, 0.3, 2.0, k)
    assert np.diff(curve.force)[0] / np.diff(curve.depth)[0] == pytest.approx(float(middle.stiffness), rel=1e-9)


def test_jkr_pull_off():
    radius, work = 2.0, 0.05
    a = np.linspace(0.05, 1.0, 200001)
    _, force = adhesion.jkr_paraboloid(a, radius, MODULUS, work)
    # the minimum of a parabola sampled at spacing 5e-6 of its width
    assert -force.min() == pytest.approx(adhesion.jkr_pull_off(radius, work), rel=1e-9)
    assert a[force.argmin()] == pytest.approx(adhesion.jkr_pull_off_radius(radius, MODULUS, work), abs=5e-6)
    for k in (0.0, 0.4):
        _, force = adhesion.jkr_power_law(a, 2, 1 / (2 * radius), MODULUS, k, work)
        assert -force.min() == pytest.approx(adhesion.jkr_pull_off(radius, work, k), rel=1e-9)


def test_jkr_forms_agree():
    a = np.array([0.2, 0.5])
    cone = adhesion.jkr_cone(a, 0.3, MODULUS, 0.05)
    power = adhesion.jkr_power_law(a, 1, np.tan(0.3), MODULUS, 0.0, 0.05)
    np.testing.assert_allclose(cone, power, rtol=1e-13)
    paraboloid = adhesion.jkr_paraboloid(a, 2.0, MODULUS, 0.05)
    np.testing.assert_allclose(paraboloid, adhesion.jkr_power_law(a, 2, 0.25, MODULUS, 0.0, 0.05), rtol=1e-13)


def test_kernels_as_they_are_usually_printed():
    x = np.array([0.3, 1.0, 2.5, 6.0])
    nu = 0.35
    sliding = 2 * np.sinh(x) ** 2 / (np.sinh(2 * x) + 2 * x)
    c = 3 - 4 * nu
    bonded = (c * np.sinh(x) * np.cosh(x) - x) / (c * np.cosh(x) ** 2 + x**2 + (1 - 2 * nu) ** 2)
    np.testing.assert_allclose(layers.frictionless_on_rigid(x), sliding, rtol=1e-14)
    np.testing.assert_allclose(layers.bonded_on_rigid(x, nu), bonded, rtol=1e-14)
    e, g = np.exp(-2 * x), 4.0
    lam, k = 1 - 4 * (1 - nu) / (1 + g * (3 - 4 * 0.2)), (g - 1) / (g + 3 - 4 * nu)
    burmister = (1 + 4 * x * k * e - lam * k * e**2) / (1 - (lam + k + 4 * k * x**2) * e + lam * k * e**2)
    young = g * (1 + nu) / (1 + 0.2)
    np.testing.assert_allclose(layers.bonded_on_half_space(x, young, nu, 1.0, 0.2), burmister, rtol=1e-13)


def test_layers_between_the_limits_of_their_base():
    x = np.geomspace(1e-3, 30, 50)
    # the difference to the limit is of the order of the modulus ratio over the compliance of the layer
    rigid = layers.bonded_on_half_space(x, 1.0, 0.3, 1e15, 0.3)
    np.testing.assert_allclose(rigid, layers.bonded_on_rigid(x, 0.3), rtol=1e-10)
    rigid = layers.sliding_on_half_space(x, 1.0, 1e15)
    np.testing.assert_allclose(rigid, layers.frictionless_on_rigid(x), rtol=1e-10)
    np.testing.assert_allclose(layers.bonded_on_half_space(x, 2.0, 0.3, 2.0, 0.3), 1.0, rtol=1e-14)


def test_thin_incompressible_paraboloid_from_the_flat_punch():
    # dF/dd at a^2 = 4 R d is the stiffness of the punch of that radius
    d, radius, h, young = 0.01, 50.0, 0.1, 3.0
    a = np.sqrt(4 * radius * d)
    slope = 3 * layers.thin_incompressible_paraboloid(d, radius, h, young) / d
    assert slope == pytest.approx(layers.thin_flat_punch(a, h, young, 0.5, bonded=True), rel=1e-14)
