"""Pressure fields add up to the force, carry an error estimate, and say where they are not the method's own."""

import warnings

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import RegularGridInterpolator, make_interp_spline
from scipy.ndimage import binary_erosion

import flatpunch as fp
from flatpunch import bem
from flatpunch.contact import METHODS

HALF_SPACE = fp.HalfSpace(1.0, 0.3)
GEL = fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase())
FILM = fp.Medium([fp.Layer(12.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
MEDIA = {"half-space": HALF_SPACE, "gel": GEL, "film": FILM}
FLAT = {
    "square": fp.Truncated(fp.Pyramid(4, 0.3), height_removed=0.1),
    "triangle": fp.Truncated(fp.Pyramid(3, 0.4), height_removed=0.05),
}


def force_of(medium, tip, half_width, **what):
    """Integral of the pressure over a grid of points, with its estimated error."""
    x = (np.arange(400) + 0.5) / 400 * 2 * half_width - half_width
    p, error = fp.pressure(medium, tip, x[:, None], x, return_error=True, **what)
    cell = (x[1] - x[0]) ** 2
    return p.sum() * cell, p, error


@pytest.mark.parametrize("medium", MEDIA.values(), ids=MEDIA)
@pytest.mark.parametrize("tip", FLAT.values(), ids=FLAT)
def test_pressure_under_flat_ends_that_are_not_round(tip, medium):
    """The outline begins as a whole there: growing punches superposed over such a jump were off by ten orders."""
    curve = fp.indent(medium, tip, depth=0.15, method="second-order", angles=72)
    half_width = 1.1 * float(curve.contour.max())
    force, p, error = force_of(medium, tip, half_width, depth=0.15, method="second-order")
    # 400 points a side on 256 cells leave 0.5 % beside the edge of the flat, where the pressure is nearly singular
    assert force == pytest.approx(float(curve.force[0]), rel=float(curve.force_error[0]) + 0.01)
    assert p.min() == 0
    # the mean pressure is not exceeded by orders, and the error is known everywhere
    assert p.max() < 20 * force / float(curve.area[0])
    assert np.isfinite(error).all()


def test_first_order_says_why_it_has_no_pressure():
    points = np.array([0.0, 0.1]), np.array([0.05, 0.0])
    flat, same = FLAT["square"], {"depth": 0.15}
    with pytest.warns(fp.FlatpunchWarning, match="whole flat end of this tip is in contact at the first touch"):
        taken = fp.pressure(HALF_SPACE, flat, *points, method="first-order", **same)
    np.testing.assert_array_equal(taken, fp.pressure(HALF_SPACE, flat, *points, method="bem", **same))
    with pytest.warns(fp.FlatpunchWarning, match=r"outline does not exist .* \(a stiff film\)"):
        fp.pressure(FILM, fp.Pyramid(4, 0.3), *points, depth=0.3, method="first-order")


def test_first_order_says_by_how_much_it_differs():
    x, y = np.random.default_rng(5).uniform(-1, 1, (2, 1500))
    with pytest.warns(fp.FlatpunchWarning, match=r"differ from boundary elements by \d+% of the mean pressure"):
        p, error = fp.pressure(GEL, fp.Pyramid(4, 0.3), x, y, depth=0.3, method="first-order", return_error=True)
    truth, other = fp.pressure(GEL, fp.Pyramid(4, 0.3), x, y, depth=0.3, method="bem", return_error=True)
    np.testing.assert_allclose(error, np.abs(p - truth) + other, rtol=1e-12)


@pytest.mark.long
@pytest.mark.parametrize(
    ("tip", "medium"),
    [
        (fp.EllipticParaboloid(0.18, 0.5), GEL),
        (fp.Pyramid(4, 0.3), FILM),
        (fp.Pyramid(3, 0.3), HALF_SPACE),
        (fp.Rounded(fp.Pyramid(4, 0.3), 0.3), HALF_SPACE),
        (FLAT["triangle"], HALF_SPACE),
    ],
    ids=["ellipse", "square", "triangle", "rounded", "cut off"],
)
def test_errors_are_below_their_estimates(tip, medium):
    """At random points, against cells four times as narrow: in at least 95 % of them (99 % when it was written)."""
    depth = 0.3 if tip is not FLAT["triangle"] else 0.15
    fine = fp.indent(medium, tip, depth=depth, method=fp.BoundaryElements(grid=512, fields=True), angles=72)
    reach = float(fine.contour.max())
    x, y = np.random.default_rng(1).uniform(-reach, reach, (2, 3000))
    between = RegularGridInterpolator((fine.y.values, fine.x.values), fine.pressure.values[0], bounds_error=False)
    truth = np.nan_to_num(between(np.column_stack([y, x])))
    p, error = fp.pressure(medium, tip, x, y, depth=depth, method=fp.BoundaryElements(grid=128), return_error=True)
    touched = (p > 0) | (truth > 0)
    # the tolerance of the solver, 1e-6 of the depth, is some 1e-4 of the pressure
    outside = np.abs(p - truth) > error + 3e-4 * truth.max()
    assert outside[touched].mean() < 0.05
    # and not by being useless: with so few cells half of the points are known to a few per cent
    assert np.median(error[touched]) < 0.1 * truth[touched].mean()


@pytest.mark.long
@pytest.mark.parametrize(
    ("tip", "medium", "depth"),
    [
        (fp.Tilted(fp.Cone(0.32), 0.074), HALF_SPACE, 0.3),
        (fp.Tilted(fp.Truncated(fp.Cone(0.29), 0.034), 0.059), GEL, 0.3),
        # a flat whose width is known to a cell: the pressure is off everywhere, like the force
        (fp.Truncated(fp.EllipticParaboloid(0.2, 0.3), 0.1), HALF_SPACE, 0.03),
    ],
    ids=["cone", "truncated cone", "flat"],
)
def test_errors_hold_at_single_points(tip, medium, depth):
    """Near the apex of a tilted cone curvatures along x and y cancel: pressures there were off by up to 13 times their error."""
    (fine,) = bem.solve(fp.compliance(medium), tip, depths=depth, grid=768, tolerance=1e-8)
    inside = np.argwhere(binary_erosion(fine.contact, iterations=6))
    rows, columns = np.random.default_rng(3).choice(inside, 4000).T
    x, y, truth = fine.grid.x[columns], fine.grid.y[rows], fine.pressure[rows, columns]
    p, error = fp.pressure(medium, tip, x, y, depth=depth, return_error=True)
    # away from the rim and from places of infinite pressure
    smooth = error < 0.02 * truth.mean()
    assert smooth.mean() > 0.85
    assert (np.abs(p - truth) <= 1.2 * error)[smooth].all()
    assert np.median(error) < 3e-3 * truth.mean()


@pytest.mark.long
@pytest.mark.parametrize(
    ("tip", "medium", "depth"),
    [
        (fp.Pyramid(4, 0.3), HALF_SPACE, 0.3),
        (fp.Tilted(fp.Truncated(fp.Cone(0.29), 0.1), 0.02), GEL, 0.4),
    ],
    ids=["pyramid", "flat"],
)
def test_errors_at_a_given_radius(tip, medium, depth):
    """Depths of a radius are off by up to 1e-3, and pressures with them: by up to 90 times the error of a given depth."""
    (fine,) = bem.solve(fp.compliance(medium), tip, depths=depth, grid=768, tolerance=1e-8)
    inside = np.argwhere(binary_erosion(fine.contact, iterations=6))
    rows, columns = np.random.default_rng(3).choice(inside, 4000).T
    x, y, truth = fine.grid.x[columns], fine.grid.y[rows], fine.pressure[rows, columns]
    p, error = fp.pressure(medium, tip, x, y, radius=fine.radius, return_error=True)
    assert np.mean(np.abs(p - truth) > error) < 0.1
    assert np.median(error) < 5e-3 * truth.mean()


@pytest.mark.parametrize("method", METHODS)
def test_round_contacts_are_exact(method):
    r = np.linspace(0, 1.2, 200)
    p, error = fp.pressure(HALF_SPACE, fp.Paraboloid(1.0), r, 0.0, depth=1.0, method=method, return_error=True)
    exact = 2 / np.pi / (1 - 0.3**2) * np.sqrt(np.maximum(1 - r**2, 0))
    inside = r < 0.99
    assert (np.abs(p - exact) <= error + 1e-5)[inside].all()
    if method != "bem":
        assert error.max() < 1e-6


@pytest.mark.parametrize("control", ["depth", "force", "radius"])
def test_all_controls_lead_to_the_same_pressure(control):
    tip = fp.Pyramid(4, 0.3)
    curve = fp.indent(GEL, tip, depth=0.3, method="refined")
    x = np.linspace(-0.31, 0.29, 13)  # not on the edges of the tip, where the pressure is singular
    one = fp.pressure(GEL, tip, x, 0.065, depth=0.3)
    other = fp.pressure(GEL, tip, x, 0.065, **{control: float(curve[control][0])}, method="refined")
    # forces of the table and of cells differ by up to 2e-4, radii by more
    np.testing.assert_allclose(other, one, rtol=5e-3)


def test_negative_pressure_of_a_round_contact_is_marked():
    film = fp.Medium([fp.Layer(100.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    with pytest.warns(fp.FlatpunchWarning, match="negative in part, so the contact is no disc"):
        fp.pressure(film, fp.Cone(0.2), np.linspace(0, 3, 50), 0.0, radius=3.0)


@pytest.mark.long
@pytest.mark.parametrize(
    ("tip", "radius"), [(fp.Paraboloid(10.0), 14.0), (fp.Cone(0.05), 2.0)], ids=["paraboloid", "cone"]
)
def test_pressure_near_the_axis_under_a_stiff_film(tip, radius):
    """Against the flat punches of the history one by one: one panel for its long first part was 5 % off at the axis."""
    film = fp.Medium([fp.Layer(1000.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    r = 1e-3 * radius
    # a = r cosh v takes the square root out of the edge; 160 Gauss points, d'(a) from a spline through depths
    v, weight = np.polynomial.legendre.leggauss(160)
    half = np.arccosh(radius / r) / 2
    a = r * np.cosh(half * (v + 1))
    nodes = np.geomspace(0.5 * r, 1.5 * radius, 1500)
    depth = make_interp_spline(np.log(nodes), fp.indent(film, tip, radius=nodes, angles=1).depth.values, k=7)
    rate = depth.derivative()(np.log(a)) / a
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fp.FlatpunchWarning)  # some of these punches would pull
        punches = np.array([float(fp.flat_punch(film, each).pressure(r)) for each in a])
    expected = half * np.sum(weight * punches * rate * r * np.sinh(half * (v + 1)))
    found = fp.pressure(film, tip, np.array([r, 0.0]), 0.0, radius=radius)
    assert found[0] == pytest.approx(expected, rel=1e-6)
    if isinstance(tip, fp.Paraboloid):
        # smooth tips have a smooth pressure: it changes by (r/a)^2
        assert found[1] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("exponent", [-0.4, 0.5])
def test_flat_ended_cone_on_a_power_law_half_space(exponent):
    """Depth against adaptive quadrature, and the integral of the pressure against the force."""
    ground = fp.PowerLawHalfSpace(modulus=1.0, depth=1.0, exponent=exponent, poisson=0.3)
    slope, flat, a = np.tan(0.2), 0.1, 0.5
    tip = fp.Truncated(fp.Cone(0.2), height_removed=flat * slope)

    def integrand(theta):
        r = a * np.cos(theta)
        return ((1 + exponent) * slope * (r - flat) + slope * r) * np.cos(theta) * np.sinc(theta / np.pi) ** exponent

    expected = quad(integrand, 0, np.arccos(flat / a), weight="alg", wvar=(exponent, 0), epsabs=0, epsrel=1e-12)[0]
    contact = fp.indent(ground, tip, radius=a)
    assert float(contact.depth[0]) == pytest.approx(expected, rel=1e-10)
    t, weight = np.polynomial.legendre.leggauss(12)
    force = 0.0
    # geometric panels towards the axis, the kink and the rim
    for end, middle in ((0.0, 0.05), (flat, 0.05), (flat, 0.3), (a, 0.3)):
        cuts = end + (middle - end) * np.append(0.0, 4.0 ** np.arange(-12, 1))
        r = cuts[:-1, None] + np.diff(cuts)[:, None] * (t + 1) / 2
        p = fp.pressure(ground, tip, r.ravel(), 0.0, radius=a).reshape(r.shape)
        force += np.pi * np.sum(np.abs(np.diff(cuts))[:, None] * weight * r * p)
    assert force == pytest.approx(float(contact.force[0]), rel=1e-4)


def test_superposed_pressures_that_miss_their_force_are_not_given():
    """Beside the loss of the first-order outline under a film about 7 times stiffer."""
    film = fp.Medium([fp.Layer(young=200e9, poisson=0.3, thickness=1e-6)], base=fp.HalfSpace(30e9, 0.3))
    pyramid = fp.Pyramid(4, 0.3)
    curve = fp.indent(film, pyramid, depth=np.linspace(1e-8, 2e-6, 80), angles=12, method="first-order")
    last = float(curve.depth[int(np.argmin(np.isfinite(curve.area.values))) - 1])
    with pytest.warns(fp.FlatpunchWarning, match="none of the first order, as the superposed pressure adds up to"):
        fp.pressure(film, pyramid, 0.0, 0.0, depth=last, method="first-order")


def _drawn(rng):
    """A stack with strongly anisotropic, soft, stiff, sliding and graded layers, and a round tip."""

    def layer():
        thickness, bonded = 10 ** rng.uniform(-1, 0.5), bool(rng.random() < 0.7)
        if rng.random() < 0.25:
            return fp.GradedLayer(
                young=([0, thickness], 10 ** rng.uniform(-0.7, 0.7, 2)), poisson=0.3, thickness=thickness
            )
        if rng.random() < 0.4:
            return fp.Layer(10 ** rng.uniform(-1.5, 1.5), rng.uniform(0, 0.5), thickness, bonded=bonded)
        while True:
            try:
                axial = rng.uniform(0, 0.45)
                moduli, shear = 10 ** rng.uniform(-2, 2, 2), 10 ** rng.uniform(-3, 2)
                return fp.TransverselyIsotropicLayer(*moduli, rng.uniform(-0.3, 0.6), axial, shear, thickness, bonded)
            except ValueError:
                # no stable solid
                continue

    base = fp.HalfSpace(1.0, 0.3) if rng.random() < 0.6 else fp.RigidBase()
    flat = fp.Truncated(fp.Cone(0.2), height_removed=0.002)
    tips = fp.Paraboloid(1.0), fp.Sphere(5.0), fp.Cone(0.3), flat, fp.PowerLaw(rng.uniform(1.1, 4), 1.0)
    return fp.Medium([layer() for _ in range(rng.integers(1, 4))], base), tips[rng.integers(5)]


@pytest.mark.long
@pytest.mark.parametrize("seed", range(12))
def test_pressures_under_round_tips_agree_with_stresses_within_their_errors(seed):
    """Under graded and strongly anisotropic surfaces pressures were off by up to a million times the stated error."""
    rng = np.random.default_rng(700 + seed)
    medium, tip = _drawn(rng)
    radius = 10 ** rng.uniform(-1.0, 0.3)
    x = radius * np.array([0.01, 0.2, 0.4, 0.6, 0.8, 0.9, 0.96])
    p, error = fp.pressure(medium, tip, x, 0.0, radius=radius, return_error=True)
    inside = fp.fields(medium, tip, x=x, y=0.0, z=0.0, radius=radius)
    off = np.abs(p + inside.stress.sel(component="zz").values)
    # punches are interpolated over the radius to 1e-8
    allowed = error + inside.attrs["stress_error"] * np.abs(p).max() + 1e-8 * np.abs(p).max()
    assert (off < 3 * allowed).all()


def test_too_many_points_are_refused_before_any_work():
    with pytest.raises(ValueError, match="x and y make 1600000000 points"):
        fp.pressure(HALF_SPACE, fp.Sphere(5.0), np.zeros((40000, 1)), np.zeros(40000), depth=0.1)
