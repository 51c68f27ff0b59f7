"""The paper's first-order method: (P17), (P22), (P23), force constants, where it ends (theory page 7)."""

import numpy as np
import pytest

import flatpunch as fp

H = 1e-6
GEL = fp.Medium([fp.Layer(5e3, 0.5, H)], base=fp.RigidBase())
SLIDING = fp.Medium([fp.Layer(5e3, 0.3, H, bonded=False)], base=fp.RigidBase())
FILM = fp.Medium([fp.Layer(3e9, 0.3, H)], base=fp.HalfSpace(1e9, 0.3))
BODY = fp.HalfSpace(1e9, 0.3)
MEDIA = {"half-space": BODY, "gel": GEL, "sliding": SLIDING, "film": FILM}
media = pytest.mark.parametrize("medium", MEDIA.values(), ids=MEDIA)

SHAPES = {
    "ellipse": fp.EllipticParaboloid(0.05 / H, 0.12 / H),
    "pyramid": fp.Pyramid(4, 0.3),
    "three-sided": fp.Pyramid(3, 0.2),
    "lobes": fp.PowerLaw(1.5, lambda phi: 1 + 0.1 * np.cos(3 * phi) + 0.05 * np.sin(2 * phi)),
}
shapes = pytest.mark.parametrize("indenter", SHAPES.values(), ids=SHAPES)


formal = pytest.mark.filterwarnings("ignore:First-order pressures")
"""What they differ by from boundary elements is of no interest."""


def indent(*what, **how):
    return fp.indent(*what, method="first-order", **how)


def pressure(*what, **how):
    return fp.pressure(*what, method="first-order", **how)


class Anonymous(fp.indenters.Indenter):
    """The same shape, without saying that it is a power law."""

    corners = ()

    def __init__(self, shape):
        self.shape = shape
        self.corners = shape.corners

    def height(self, r, phi):
        return self.shape.height(r, phi)

    def slope(self, r, phi):
        return self.shape.slope(r, phi)


def mean_of(indenter):
    """<psi> by the midpoint rule, which is 1e-9 at the corners of a pyramid."""
    phi = 2 * np.pi * (np.arange(72_000) + 0.5) / 72_000
    return float(np.mean(indenter.angular(phi) if hasattr(indenter, "angular") else indenter.height(1.0, phi)))


@media
@shapes
@pytest.mark.parametrize("beta", [0.05, 0.7, 3.0])
def test_closed_forms_p22_and_p23(medium, indenter, beta):
    # Everything on the right comes from flat punches; (a Kbar)' and kappa_n' from Chebyshev interpolation in ln a.
    n, a0 = indenter.exponent, beta * H
    t = np.cos(np.pi * (np.arange(12) + 0.5) / 12)
    radii = a0 * np.exp(0.1 * t)
    punches = [fp.flat_punch(medium, a) for a in radii]

    def slope(values):
        series = np.polynomial.chebyshev.chebfit(t, values, 11)
        return np.polynomial.chebyshev.chebval(0.0, np.polynomial.chebyshev.chebder(series)) / 0.1

    middle = fp.flat_punch(medium, a0)
    bar, kappa = middle.normalized_stiffness, middle.moment(n)
    d_bar = slope([p.normalized_stiffness for p in punches])
    d_kappa = slope([p.moment(n) for p in punches])
    mean = mean_of(indenter)
    depth = (kappa + d_kappa / (n + 1)) / (bar + d_bar) * mean * a0**n
    d_star = bar / (bar + d_bar) * (1 + d_kappa / kappa / (n + 1))
    curve = indent(medium, indenter, radius=a0, angles=24)
    phi = curve["phi"].values
    psi = indenter.height(np.ones_like(phi), phi)
    outline = a0 * (1 + (mean - psi) / mean * (n + 2) / (n + 1) / (n + 2 - 2 * d_star))
    # 1e-9 of <psi> by the midpoint rule, and the differentiation, 12^2/0.1 of 1e-13
    assert float(curve["depth"][0]) == pytest.approx(depth, rel=2e-9)
    np.testing.assert_allclose(curve["contour"][0], outline, rtol=5e-9)
    # Kbar d = d* kappa_n <psi> a0^n in (18) with (21)
    force = 2 * middle.modulus * a0 * (depth * bar - kappa * mean * a0**n / (n + 1))
    assert float(curve["force"][0]) == pytest.approx(force, rel=1e-8)


@pytest.mark.parametrize("exponent", [1.0, 2.0, 3.3])
def test_d_star_is_one_on_a_half_space(exponent):
    indenter = fp.PowerLaw(exponent, lambda phi: 1 + 0.2 * np.cos(2 * phi))
    curve = indent(BODY, indenter, radius=[1e-9, 1.0], angles=4)
    # 1 + (1 - psi/<psi>) (n + 2)/(n + 1)/n
    growth = 0.2 * (exponent + 2) / (exponent + 1) / exponent
    expected = np.outer([1e-9, 1.0], [1 - growth, 1 + growth, 1 - growth, 1 + growth])
    np.testing.assert_allclose(curve["contour"], expected, rtol=1e-12)


@media
@shapes
def test_general_profile_path_agrees_with_the_power_law_path(medium, indenter):
    radii = np.geomspace(0.02, 3, 9) * H
    one, other = (indent(medium, i, radius=radii, angles=36) for i in (indenter, Anonymous(indenter)))
    for name in ("depth", "force", "stiffness", "area", "contour"):
        # (P17) takes its second derivative by a five-point difference: 1e-10; 1e-8 is the requirement
        np.testing.assert_allclose(other[name], one[name], rtol=1e-8, err_msg=name)


@media
@shapes
def test_controls_are_inverse_and_the_stiffness_is_the_slope(medium, indenter):
    radii = np.geomspace(0.05, 5, 12) * H
    curve = indent(medium, indenter, radius=radii, angles=12)
    for name in ("depth", "force"):
        again = indent(medium, indenter, **{name: curve[name].values}, angles=12)
        for other in ("depth", "force", "radius", "area", "contour"):
            # panels of the family jump by up to 1e-11 under gels; (P23) magnifies that where its denominator is small
            np.testing.assert_allclose(again[other], curve[other], rtol=1e-10)
    a = 2 * H
    step = 1e-3
    near = indent(medium, indenter, radius=a * np.exp(step * np.array([-2, -1, 0, 1, 2])), angles=4)
    weights = np.array([1, -8, 0, 8, -1]) / 12
    slope = (near["force"].values @ weights) / (near["depth"].values @ weights)
    # five points: step^4/30 = 3e-14 of the fifth derivatives, and rounding over the step: 1e-13/1e-3
    assert float(near["stiffness"][2]) == pytest.approx(slope, rel=1e-9)


@shapes
def test_mean_radius_and_area_are_those_of_the_outline(indenter):
    curve = indent(GEL, indenter, radius=[0.1 * H, H], angles=7200)
    outline = curve["contour"].values
    # the midpoint-like rule over corners leaves (2 pi/7200)^2
    np.testing.assert_allclose(outline.mean(axis=1), curve["radius"], rtol=1e-6)
    np.testing.assert_allclose(np.pi * (outline**2).mean(axis=1), curve["area"], rtol=1e-6)


@pytest.mark.long
@formal
def test_pressure_has_its_integral_and_outline():
    indenter = fp.EllipticParaboloid(0.05 / H, 0.08 / H)
    for medium in (BODY, GEL, FILM):
        curve = indent(medium, indenter, radius=1.5 * H, angles=96)
        phi, edge = curve["phi"].values, curve["contour"].values[0]
        t, w = np.polynomial.legendre.leggauss(64)
        theta, weight = np.pi / 4 * (t + 1), np.pi / 4 * w
        r = edge[:, None] * np.cos(theta)
        field = pressure(medium, indenter, r * np.cos(phi)[:, None], r * np.sin(phi)[:, None], radius=1.5 * H)
        total = np.sum(field * np.cos(theta) * np.sin(theta) * weight * edge[:, None] ** 2) * 2 * np.pi / phi.size
        # increments are scaled to carry the force of the method; quadrature is spectral in both directions
        assert total == pytest.approx(float(curve["force"][0]), rel=1e-7)
        assert np.all(field > 0)
        outside = 1.0001 * edge
        assert np.all(pressure(medium, indenter, outside * np.cos(phi), outside * np.sin(phi), radius=1.5 * H) == 0)


@formal
def test_pressure_of_a_pyramid_turns_with_its_faces():
    indenter = fp.Pyramid(4, 0.3)
    r = 0.4 * H
    angles = np.array([0.2, 0.2 + np.pi / 2, -0.2, np.pi - 0.2])
    field = pressure(GEL, indenter, r * np.cos(angles), r * np.sin(angles), depth=0.3 * H)
    np.testing.assert_allclose(field, field[0], rtol=1e-10)


@pytest.mark.long
@pytest.mark.parametrize(
    ("indenter", "sound", "lost"),
    [(fp.Pyramid(4, 0.2), 3.9, 7.0), (fp.EllipticParaboloid(0.05 / H, 0.06 / H), 7.0, 10.0)],
    ids=["pyramid", "ellipse"],
)
def test_outline_is_lost_under_stiff_films_and_the_result_says_so(indenter, sound, lost):
    # (P23)'s denominator reaches zero between E1/E2 = 4 and 5 for pyramids, 7 and 8 for mild ellipses (theory page 7).
    radii = np.geomspace(0.05, 20, 120) * H

    def solved(ratio):
        film = fp.Medium([fp.Layer(ratio * 1e9, 0.3, H)], base=fp.HalfSpace(1e9, 0.3))
        return indent(film, indenter, radius=radii, angles=24)

    good = solved(sound)
    assert np.isfinite(good["area"]).all()
    assert np.isfinite(good["contour"]).all()
    # close to the loss the estimate reaches the force itself: such steps are no longer valid either
    known = good["force_error"].values < 1
    assert known.mean() > 0.9
    assert (good["valid"].values == known).all()
    bad = solved(lost)
    gone = ~np.isfinite(bad["area"].values)
    assert gone.any()
    assert not gone.all()
    assert not bad["valid"].values[gone].any()
    assert (bad["valid"].values[~gone] == (bad["force_error"].values[~gone] < 1)).all()
    assert np.isnan(bad["contour"].values[gone]).all()
    assert "outline does not exist" in bad.attrs["notes"]
    # it names the depth from which on, and force and depth are still those of the mean profile
    first = float(bad["depth"].values[gone].min())
    assert f"{first * 1e9:.4g} nm" in bad.attrs["notes"]
    assert np.isfinite(bad["force"]).all()
    with pytest.warns(fp.FlatpunchWarning, match="outline does not exist along the whole history"):
        pressure(
            fp.Medium([fp.Layer(lost * 1e9, 0.3, H)], base=fp.HalfSpace(1e9, 0.3)),
            indenter,
            0.1 * H,
            0.0,
            radius=float(radii[gone][-1]),
        )


def test_within_a_flat_end_there_is_no_outline_and_the_note_says_why():
    """On a half-space, where nothing is stiff."""
    tip = fp.Truncated(fp.Pyramid(4, 0.3), height_removed=0.1 * H)
    curve = indent(BODY, tip, radius=np.array([0.2, 0.5]) * H, angles=8)
    np.testing.assert_array_equal(curve["valid"], [False, True])
    assert "within the flat end of the tip" in curve.attrs["notes"]
    assert "stiff films" not in curve.attrs["notes"]


@pytest.mark.parametrize("stiff", [0.1, 3.0, 5.0])
def test_estimate_grows_with_what_the_medium_makes_of_the_outline(stiff):
    """The terms that are left out go with the square of the outline's deviation; fourth order knows them."""
    tip, radius = fp.EllipticParaboloid(1e6, 1.4e6), 0.3 * H
    film = fp.Medium([fp.Layer(stiff * 1e9, 0.3, H)], base=fp.HalfSpace(1e9, 0.3))

    def solved(medium, method="first-order", **control):
        return fp.indent(medium, tip, method=method, angles=64, **control).isel(step=0)

    here, there = solved(film, radius=radius), solved(fp.HalfSpace(1e9, 0.3), radius=radius)
    square, plain = (float(((one.contour / one.radius - 1) ** 2).mean()) for one in (here, there))
    grown = float(here.force_error / there.force_error)
    assert grown == pytest.approx(max(square / plain, 1.0), rel=1e-2)
    assert (grown > 1.2) == (stiff > 1)
    off = abs(float(here.force / solved(film, "fourth-order", depth=float(here.depth)).force) - 1)
    assert float(here.force_error) / 12 < off < float(here.force_error)


def test_no_outline_no_estimate():
    film = fp.Medium([fp.Layer(1e11, 0.3, H)], base=fp.HalfSpace(1e9, 0.3))
    curve = indent(film, fp.Pyramid(4, 0.3), radius=np.array([0.01, 1.0]) * H, angles=8)
    np.testing.assert_array_equal(np.isfinite(curve.area), [True, False])
    np.testing.assert_array_equal(np.isfinite(curve.force_error), [True, False])
