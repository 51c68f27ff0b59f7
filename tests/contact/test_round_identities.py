"""Round contact on layered media: two roads, energy, inverse controls, scaling, limits (T6.1)."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

import flatpunch as fp
from flatpunch.reference import half_space as exact
from flatpunch.reference import layers as thin

H = 1e-6
GEL = fp.Medium([fp.Layer(5e3, 0.5, H)], base=fp.RigidBase())
SLIDING = fp.Medium([fp.Layer(5e3, 0.45, H, bonded=False)], base=fp.RigidBase())
COATING = fp.Medium([fp.Layer(200e9, 0.25, H)], base=fp.HalfSpace(70e9, 0.3))
SOFT = fp.Medium([fp.Layer(2e9, 0.4, H)], base=fp.HalfSpace(70e9, 0.22))
AUXETIC = fp.Medium([fp.Layer(1e9, -0.5, H), fp.Layer(3e9, -0.9, 2 * H)], base=fp.HalfSpace(2e9, -0.5))
THREE = fp.Medium(
    [fp.Layer(2e9, 0.4, H), fp.Layer(70e9, 0.2, 0.3 * H, bonded=False), fp.Layer(5e6, 0.5, 2 * H)],
    base=fp.RigidBase(),
)
MEDIA = {"gel": GEL, "sliding": SLIDING, "coating": COATING, "soft": SOFT, "auxetic": AUXETIC, "three": THREE}

BALL = fp.Sphere(20 * H)
TABLE_R = np.linspace(0, 12 * H, 80)
TABLE = fp.RadialProfile(TABLE_R, 0.2 * (np.sqrt(TABLE_R**2 + (0.3 * H) ** 2) - 0.3 * H))
TRUNCATED = fp.RadialProfile(TABLE_R, 0.2 * np.maximum(TABLE_R - TABLE_R[6], 0), kinks=[TABLE_R[6]])
INDENTERS = {
    "paraboloid": fp.Paraboloid(5 * H),
    "cone": fp.Cone(0.2),
    "ball": BALL,
    "flat-bottomed": fp.PowerLaw(6, 1e28),
    "table": TABLE,
    "truncated": TRUNCATED,
}

media = pytest.mark.parametrize("medium", MEDIA.values(), ids=MEDIA)
indenters = pytest.mark.parametrize("indenter", INDENTERS.values(), ids=INDENTERS)


@pytest.mark.long
@media
@indenters
def test_depth_force_and_radius_control_are_inverse_to_each_other(medium, indenter):
    radii = np.geomspace(0.02, 9, 30) * H
    if indenter is TRUNCATED:
        radii = np.linspace(1.05, 8, 30) * TABLE_R[6]
    curve = fp.indent(medium, indenter, radius=radii)
    assert np.all(np.diff(curve["depth"]) > 0)
    for name in ("depth", "force"):
        again = fp.indent(medium, indenter, **{name: curve[name].values})
        # 1e-12 is asked for. The functions of the radius jump by up to 1e-11 between panels under gels, and a table's
        # piecewise cubics leave the area the square of what rounding of the depth leaves of the radius.
        rtol = 2e-11 if medium in (GEL, THREE) else 4e-12 if indenter is TABLE else 1e-12
        for other in ("depth", "force", "radius", "stiffness", "area"):
            np.testing.assert_allclose(again[other], curve[other], rtol=rtol, err_msg=f"{name} -> {other}")
        np.testing.assert_array_equal(again[name], curve[name])


@pytest.mark.long
@media
@indenters
def test_stiffness_is_the_slope_of_the_force(medium, indenter):
    # dF/da = K dd/da by Chebyshev interpolation in ln a, half-width 0.05: d(F) itself has no smooth inverse where the
    # depth stands almost still (stiff films). Fourteen nodes leave 1e-13; differentiating costs 14^2/0.05 of rounding.
    t = np.cos(np.pi * (np.arange(14) + 0.5) / 14)
    curve = fp.indent(medium, indenter, radius=3 * H * np.exp(0.05 * t))

    def slope(name):
        series = np.polynomial.chebyshev.chebfit(t, curve[name].values, 13)
        return np.polynomial.chebyshev.chebval(t, np.polynomial.chebyshev.chebder(series))

    # A table's second derivative jumps at its points, so the interpolation converges like the square of the spacing.
    rtol = 1e-3 if indenter in (TABLE, TRUNCATED) else 3e-8
    np.testing.assert_allclose(slope("force"), curve["stiffness"] * slope("depth"), rtol=rtol)


@media
@pytest.mark.parametrize("exponent", [1.0, 2.0, 4.0])
def test_depth_by_the_papers_road_p7_and_force_by_p5(medium, exponent):
    # (P7): d = (G Kbar)'/(a Kbar)' with a Kbar and G Kbar from flat punches alone; `indent` uses the vanishing edge
    # singularity. Derivatives by Chebyshev interpolation in ln a, as above.
    a0 = 1.7 * H
    t = np.cos(np.pi * (np.arange(14) + 0.5) / 14)
    radii = a0 * np.exp(0.05 * t)
    with warnings.catch_warnings():
        # tension under a flat punch is no matter here
        warnings.simplefilter("ignore", fp.FlatpunchWarning)
        punches = [fp.flat_punch(medium, a) for a in radii]
        middle = fp.flat_punch(medium, a0)
    bar = np.array([p.normalized_stiffness for p in punches])
    # T{r^n} Kbar = a^(n+1) kappa_n/(n+1)
    transform = np.array([p.moment(exponent) for p in punches]) * radii ** (exponent + 1) / (exponent + 1)

    def slope(values):
        series = np.polynomial.chebyshev.chebfit(t, values, 13)
        return np.polynomial.chebyshev.chebval(0.0, np.polynomial.chebyshev.chebder(series))

    depth = slope(transform) / slope(radii * bar)
    g = middle.moment(exponent) * a0 ** (exponent + 1) / (exponent + 1) / middle.normalized_stiffness
    force = 2 * middle.modulus * middle.normalized_stiffness * (depth * a0 - g)
    curve = fp.indent(medium, fp.PowerLaw(exponent, 1.0), radius=a0)
    # rounding of the punches, 1e-14, over the interval's half-width 0.05, times 14^2
    assert float(curve["depth"][0]) == pytest.approx(depth, rel=3e-10)
    assert float(curve["force"][0]) == pytest.approx(force, rel=3e-10)


@settings(derandomize=True, deadline=None, max_examples=25)
@given(
    length=st.floats(-4, 4),
    stress=st.floats(-6, 6),
    ratio=st.floats(-2, 2),
    nu=st.floats(-0.4, 0.5),
    beta=st.floats(-2, 0.7),
    exponent=st.floats(0.7, 5),
)
def test_lengths_and_moduli_scale_out(length, stress, ratio, nu, beta, exponent):
    size, scale = 10**length, 10**stress

    def solved(size, scale):
        medium = fp.Medium(
            [fp.Layer(scale * 1e9, nu, size * H), fp.Layer(scale * 3e9, 0.2, 0.7 * size * H, bonded=False)],
            base=fp.HalfSpace(scale * 1e9 * 10**-ratio, 0.3),
        )
        # f = size H (r/(size H))^n
        indenter = fp.PowerLaw(exponent, (size * H) ** (1 - exponent))
        return fp.indent(medium, indenter, radius=size * H * 10**beta)

    one, other = solved(1.0, 1.0), solved(size, scale)
    # rounding of 10**x and of the powers, times the panels' own 1e-11
    assert float(other["depth"][0]) == pytest.approx(size * float(one["depth"][0]), rel=1e-9)
    assert float(other["force"][0]) == pytest.approx(scale * size**2 * float(one["force"][0]), rel=1e-9)
    assert float(other["stiffness"][0]) == pytest.approx(scale * size * float(one["stiffness"][0]), rel=1e-9)


@indenters
def test_equal_layers_are_one_body(indenter):
    body = fp.HalfSpace(3e9, 0.35)
    stack = fp.Medium([fp.Layer(3e9, 0.35, h * H) for h in (1, 0.2, 5, 0.01)], base=body)
    radii = np.geomspace(2e-1, 10, 12) * H
    one, other = fp.indent(body, indenter, radius=radii), fp.indent(stack, indenter, radius=radii)
    for name in ("depth", "force", "stiffness"):
        # L - 1 is rounding here, times the thousand layer thicknesses of the largest contact
        np.testing.assert_allclose(other[name], one[name], rtol=1e-10)


@pytest.mark.parametrize("medium", [SOFT, COATING, AUXETIC], ids=["soft", "coating", "auxetic"])
def test_small_contacts_feel_the_layer_and_large_ones_the_base(medium):
    indenter = fp.Paraboloid(1.0)
    small, large = 1e-7 * H, 200 * H
    top, base = medium.layers[0], medium.base
    near = fp.indent(medium, indenter, radius=small)
    far = fp.indent(medium, indenter, radius=large)
    # the correction is of the order of a/h times the contrast of the moduli (35 at most)
    hertz = exact.paraboloid(small, 1.0, top.surface_modulus)
    assert float(near["force"][0]) == pytest.approx(float(hertz.force), rel=1e-5)
    assert float(near["depth"][0]) == pytest.approx(float(hertz.depth), rel=1e-5)
    # and of h/a far out, times the compliance of a soft layer over that of its base
    hertz = exact.paraboloid(large, 1.0, base.surface_modulus)
    assert float(far["stiffness"][0]) == pytest.approx(float(hertz.stiffness), rel=0.4)
    farther = fp.indent(medium, indenter, radius=large / 2)
    miss = [abs(float(c["stiffness"][0] / c["radius"][0]) / (2 * base.surface_modulus) - 1) for c in (far, farther)]
    # halving the radius doubles it in the limit; two layers are not quite there
    assert miss[0] < 0.65 * miss[1]


def test_thin_incompressible_layer_has_its_lubrication_limit():
    indenter = fp.Paraboloid(1e-3)
    ratios = []
    for beta in (25.0, 50.0, 100.0):
        curve = fp.indent(GEL, indenter, radius=beta * H)
        limit = thin.thin_incompressible_paraboloid(float(curve["depth"][0]), 1e-3, H, 5e3)
        ratios.append(float(curve["force"][0]) / limit - 1)
        assert float(curve["radius"][0]) ** 2 == pytest.approx(4e-3 * float(curve["depth"][0]), rel=5 / beta)
    # Leading order only. With the depth given the correction to the force falls like (h/a)^2 (lubrication).
    np.testing.assert_allclose(np.array(ratios[:-1]) / ratios[1:], 4, rtol=0.1)


@pytest.mark.parametrize("beta", [0.1, 3, 20, 95, 140, 299])
@pytest.mark.parametrize("quantity", ["depth", "force"])
def test_thin_layers_are_reached_by_force_and_depth_up_to_the_limit_of_resolution(beta, quantity):
    # The half-space radius for the same force is hundreds of times larger here; the search must not start there.
    medium = fp.Medium([fp.Layer(5e3, 0.49, H)], base=fp.RigidBase())
    curve = fp.indent(medium, fp.Cone(0.3), radius=beta * H)
    again = fp.indent(medium, fp.Cone(0.3), **{quantity: float(curve[quantity][0])})
    assert float(again["radius"][0]) == pytest.approx(beta * H, rel=1e-9)


@pytest.mark.long
def test_nanometre_film_on_a_micrometre_film():
    medium = fp.Medium([fp.Layer(300e9, 0.2, 1e-9), fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(70e9, 0.22))
    bare = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(70e9, 0.22))
    force = np.geomspace(1e-12, 1e-6, 50)
    thin_film, without = (fp.indent(m, fp.Paraboloid(5e-6), force=force) for m in (medium, bare))
    ratio = (thin_film["depth"] / without["depth"]).values
    # the film stiffens, the less the larger the contact
    assert np.all(ratio < 1)
    assert ratio[-1] > 0.98
    assert ratio[0] < ratio[-1]


def test_ten_layers_by_depth_over_many_decades():
    rng = np.random.default_rng(7)
    layers = [
        fp.Layer(10 ** rng.uniform(8, 11), rng.uniform(-0.3, 0.5), 10 ** rng.uniform(-7, -6), bonded=bool(i % 3))
        for i in range(10)
    ]
    medium = fp.Medium(layers, base=fp.HalfSpace(70e9, 0.2))
    depth = np.geomspace(1e-18, 1e-6, 400)
    curve = fp.indent(medium, fp.Paraboloid(1e-6), depth=depth)
    # F = int K dd: cumulative trapezoid over ln d is good to (step^2)/12 times the curvature, some 1e-3
    work = np.concatenate(
        [[0], np.cumsum(np.diff(depth) * (curve["stiffness"][1:].values + curve["stiffness"][:-1].values) / 2)]
    )
    np.testing.assert_allclose(curve["force"][100:], work[100:], rtol=2e-3)
    assert np.all(np.diff(curve["force"]) > 0)


@media
@pytest.mark.parametrize("indenter", [fp.Paraboloid(5 * H), fp.Cone(0.2), BALL], ids=["paraboloid", "cone", "ball"])
@pytest.mark.parametrize("beta", [0.3, 4.0])
def test_pressure_integrates_to_the_force(medium, indenter, beta):
    a = beta * H
    t, w = np.polynomial.legendre.leggauss(120)
    # r = a cos(theta) takes the square root out of the edge; theta = pi/2 (1 - u^3) tames the logarithm at a cone's tip
    u = (t + 1) / 2
    theta = np.pi / 2 * (1 - u**3)
    weight = w / 2 * np.pi / 2 * 3 * u**2
    r = a * np.cos(theta)
    field = fp.pressure(medium, indenter, r, np.zeros_like(r), radius=a)
    force = float(fp.indent(medium, indenter, radius=a)["force"][0])
    # measured 1e-10 and below; panels of the family leave 1e-11
    assert 2 * np.pi * a**2 * (weight * np.cos(theta) * np.sin(theta)) @ field == pytest.approx(force, rel=1e-8)


def test_round_indenters_do_not_care_which_way_they_are_written():
    radii = np.geomspace(0.1, 5, 9) * H
    pairs = [
        (fp.Cone(0.2), fp.PowerLaw(1, np.tan(0.2))),
        (fp.Paraboloid(5 * H), fp.EllipticParaboloid(0.1 / H, 0.1 / H)),
        (fp.Paraboloid(5 * H), fp.PowerLaw(2.0, lambda phi: np.full(np.shape(phi), 0.1 / H))),
    ]
    for left, right in pairs:
        one, other = fp.indent(COATING, left, radius=radii), fp.indent(COATING, right, radius=radii)
        for name in ("depth", "force", "stiffness", "area", "contour"):
            np.testing.assert_allclose(one[name], other[name], rtol=1e-13)


@pytest.mark.long
def test_general_round_path_agrees_with_the_power_law_path():
    class Anonymous(fp.indenters.Indenter):
        """A paraboloid that does not say it is one."""

        round = True

        def height(self, r, phi):
            return r**2 / (10 * H) + 0 * phi

        def slope(self, r, phi):
            return r / (5 * H) + 0 * phi

    radii = np.geomspace(1e-3, 20, 40) * H
    for medium in (GEL, COATING, THREE):
        one, other = (fp.indent(medium, i, radius=radii) for i in (fp.Paraboloid(5 * H), Anonymous()))
        for name in ("depth", "force", "stiffness"):
            # the same matrices; quadrature of polynomials is exact
            np.testing.assert_allclose(one[name], other[name], rtol=1e-11)


def test_slope_of_the_moment_is_consistent_with_quadrature():
    # kappa_n of (P21) for a real exponent, from the punch's own pressure field
    punch = fp.flat_punch(COATING, 1.3 * H)
    for n in (0.4, 1.0, 2.7):
        value = quad(
            lambda theta, n=n: (
                float(punch.pressure(punch.radius * np.sin(theta))) * np.sin(theta) ** (n + 1) * np.cos(theta)
            ),
            0,
            np.pi / 2 - 1e-9,
            epsrel=1e-11,
        )[0]
        normalised = value * (n + 1) * np.pi * punch.radius / punch.modulus
        # the strip left out at the edge carries 1e-9
        assert punch.moment(n) == pytest.approx(normalised, rel=5e-9)
