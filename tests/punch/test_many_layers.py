"""Many layers and thin skins: interpolated recursion, smooth half of the far integrals, limits of what is resolved."""

import warnings

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.compliances.response import layered_response
from flatpunch.punch import matrix
from flatpunch.punch.harmonics import solve_edges
from flatpunch.punch.wavenumbers import bessel_table
from support import integral_equation


def random_stack(rng, layers):
    """Layers of modulus ratios up to 100, some sliding, on an elastic or rigid base."""
    stack = [
        fp.Layer(
            young=float(10 ** rng.uniform(-1, 1)),
            poisson=float(rng.uniform(0, 0.5)),
            thickness=float(rng.uniform(0.5, 2)),
            bonded=bool(rng.uniform() < 0.85),
        )
        for _ in range(layers)
    ]
    return fp.Medium(stack, base=fp.HalfSpace(1.0, 0.3) if rng.uniform() < 0.6 else fp.RigidBase())


@pytest.mark.parametrize("layers", [5, 20, 100])
def test_interpolated_response_is_that_of_the_recursion(layers):
    medium = random_stack(np.random.default_rng(layers), layers)
    kernel = compliance(medium)
    kappa = np.geomspace(1e-5 / layers, 40.0, 400)
    # 1e-10: the target of C(k) for any number of layers; pieces end at 2e-12
    np.testing.assert_allclose(kernel.response(kappa), layered_response(medium, kappa / kernel.length), rtol=1e-10)


@pytest.mark.parametrize(("layers", "beta"), [(1, 50.0), (3, 100.0), (30, 60.0)])
def test_the_smooth_half_of_far_integrals_is_enough(layers, beta, monkeypatch):
    kernel = compliance(random_stack(np.random.default_rng(7 * layers), layers))
    radii, orders = np.array([beta]), np.array([1, 2, 3, 4, 12, 40])
    terms = matrix.sufficient_terms(kernel, beta)
    assert matrix._table(0, terms, 0, kernel.cutoff * beta).split

    def solved():
        responses, edges = matrix.solve_round(kernel, radii, terms), solve_edges(kernel, radii, orders)
        flat = responses.flat / responses.flat[0, 0]
        return flat, responses.edge, responses.slope, edges.stiffening(orders), edges.power_edge(1.0, orders)

    split = solved()
    monkeypatch.setattr(matrix, "_table", lambda parity, n, first, needed: bessel_table(parity, n, first, needed))
    # rounding; the slope functional has weights of x = 25 beta in its integrand
    for one, other, rtol in zip(split, solved(), [1e-11, 1e-11, 1e-9, 1e-11, 1e-11], strict=True):
        np.testing.assert_allclose(one, other, rtol=rtol, atol=rtol * np.abs(other).max())


def test_a_stack_of_equal_layers_is_one_body():
    body = {"young": 2.0, "poisson": 0.3}
    medium = fp.Medium([fp.Layer(**body, thickness=0.01) for _ in range(100)], base=fp.HalfSpace(**body))
    # 1e-10: log L is interpolated to 2e-12
    assert fp.flat_punch(medium, 1.0).normalized_stiffness == pytest.approx(1.0, rel=1e-10)


def compared(medium, radius):
    """Relative errors of Kbar, pi e and of the first moment, and stated ones of the first two, by the integral equation."""
    exact = integral_equation.solve(medium, radius)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fp.FlatpunchWarning)
        punch = fp.flat_punch(medium, radius)
    depth, force = exact.cone
    return (
        abs(punch.normalized_stiffness / exact.kbar - 1),
        abs(punch.edge_coefficient / exact.edge - 1),
        abs(punch.moment(1.0) / (2 * (depth * exact.kbar - force)) - 1),
        punch,
    )


# what the reference leaves
REFERENCE = 2e-11


def skin(rng):
    """A film of 1e-5 to 1e-2 of the contact on an elastic half-space."""
    young, poisson, thin = 10 ** rng.uniform(-2, 2), rng.uniform(0, 0.5), 10 ** rng.uniform(-5, -2)
    return fp.Medium([fp.Layer(float(young), float(poisson), float(thin))], base=fp.HalfSpace(1.0, 0.3)), 1.0


def many(rng):
    """20 to 300 layers under a contact of a tenth to three times their thickness."""
    medium = random_stack(rng, int(rng.integers(20, 301)))
    return medium, medium.thickness * float(10 ** rng.uniform(-1, 0.5))


def assert_as_stated(medium, radius):
    stiffness, edge, moment, punch = compared(medium, radius)
    floor = REFERENCE * max(1.0, punch.normalized_stiffness)
    assert stiffness <= punch.error + floor
    assert moment <= punch.error + floor
    assert edge <= punch.edge_error + floor
    return punch


@pytest.mark.long
@pytest.mark.parametrize(("kind", "seed"), [(skin, 1), (skin, 2), (skin, 3), (many, 11), (many, 12)])
def test_punches_are_those_of_the_integral_equation(kind, seed):
    assert_as_stated(*kind(np.random.default_rng(seed)))


@pytest.mark.slow
@pytest.mark.parametrize("kind", [skin, many])
def test_300_punches_are_those_of_the_integral_equation(kind):
    rng = np.random.default_rng(42)
    for _ in range(150):
        assert_as_stated(*kind(rng))


@pytest.mark.long
@pytest.mark.parametrize(("young", "radius"), [(5.0, 1e3), (5.0, 1e5), (0.2, 1e5)])
def test_round_contacts_on_thin_skins_are_those_of_the_integral_equation(young, radius):
    medium = fp.Medium([fp.Layer(young, 0.25, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    exact = integral_equation.solve(medium, radius)
    scale = 2 * medium.surface_modulus * radius
    for tip, (depth, force), height in (
        (fp.Paraboloid(radius), exact.paraboloid, radius / 2),
        (fp.Cone(np.pi / 4), exact.cone, radius),
    ):
        contact = fp.indent(medium, tip, depth=depth * height)
        # the stiffness is good to 1e-6, and forces at given depth are stationary in the radius
        assert abs(float(contact.force[0]) / (scale * force * height) - 1) <= float(contact.force_error[0]) < 1e-6
        assert abs(float(contact.radius[0]) / radius - 1) <= float(contact.contour_error[0]) < 1e-3


def test_the_rim_of_a_thin_skin_is_as_strong_as_its_base_asks():
    # K = 2 E2* a and Krein's identity give (pi e)^2 = E2*/E1*, but for a part h/a ln(a/h) of the contrast
    skinned = fp.Medium([fp.Layer(5.0, 0.25, 1e-5)], base=fp.HalfSpace(1.0, 0.3))
    punch = fp.flat_punch(skinned, 1.0)
    assert punch.edge_coefficient**2 == pytest.approx((1 / 0.91) / (5 / (1 - 0.25**2)), rel=3e-4)
    assert punch.edge_error < 2e-6


def test_thin_incompressible_layers_keep_the_digits_of_extended_precision():
    # Kbar with 134 terms in 64-bit significands (numpy.longdouble), layer closed form, plain panels: the double-precision
    # sum D + B has 1.4e-10 of it, a sum of positive terms 9e-13
    gel = fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase())
    assert fp.flat_punch(gel, 100.0).normalized_stiffness == pytest.approx(156045.88411231598997, rel=4e-12)
    # and as a thin layer it has Kbar = 3 pi beta^3/64 (1 + 5.8363/beta + 13/beta^2 ...), extrapolated from beta = 300 .. 1e4
    for beta in (1e4, 1e5):
        punch = fp.flat_punch(gel, beta)
        ratio = punch.normalized_stiffness / (3 * np.pi / 64 * beta**3)
        assert abs(ratio - 1 - 5.8363 / beta) < punch.error + 30 / beta**2
        assert punch.error < 1e-5


@pytest.mark.parametrize("quantity", ["depth", "force"])
def test_ball_on_a_skin_a_hundred_thousand_times_thinner_is_a_ball_on_its_base(quantity):
    base, ball = fp.HalfSpace(1.0, 0.3), fp.Paraboloid(1.0)
    bare = fp.indent(base, ball, **{quantity: 1.0})
    thickness = 1e-5 * float(bare.radius[0])
    coated = fp.indent(fp.Medium([fp.Layer(3.0, 0.25, thickness)], base=base), ball, **{quantity: 1.0})
    # a film's share is h/a times a contrast of order 1
    np.testing.assert_allclose(coated.force[0] / bare.force[0], 1.0, atol=3e-5)
    np.testing.assert_allclose(coated.depth[0] / bare.depth[0], 1.0, atol=3e-5)
