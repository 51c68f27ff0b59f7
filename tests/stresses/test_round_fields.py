"""Fields of round contacts: closed forms, continuity, two ways to compute them, bad input."""

import time

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.stresses.axisymmetric.contact_load import contact_load

NU = 0.3
BODY = fp.HalfSpace(1e9, NU)
FILM = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], base=fp.HalfSpace(210e9, 0.3))
STACK = fp.Medium(
    [fp.Layer(200e9, 0.25, 1e-6), fp.Layer(5e9, 0.5, 2e-6), fp.Layer(50e9, 0.1, 1e-6, bonded=False)],
    fp.HalfSpace(2e9, 0.3),
)


def peak(medium, tip, radius):
    return 1.5 * float(fp.indent(medium, tip, radius=radius).force[0]) / (np.pi * radius**2)


def component(result, name):
    return result.stress.sel(component=name).values


def test_hertz_on_the_axis():
    a = 0.01
    z = np.array([0.0, 1e-4, 0.1, 0.48, 1, 3, 30]) * a
    found = fp.fields(BODY, fp.Paraboloid(1.0), 0, 0, z, radius=a)
    p, s = peak(BODY, fp.Paraboloid(1.0), a), z / a
    around = np.where(s > 0, np.arctan(1 / np.maximum(s, 1e-300)), np.pi / 2)
    np.testing.assert_allclose(component(found, "zz") / p, -1 / (1 + s**2), atol=1e-9)
    expected = -(1 + NU) * (1 - s * around) + 0.5 / (1 + s**2)
    np.testing.assert_allclose(component(found, "xx") / p, expected, atol=1e-9)
    np.testing.assert_allclose(component(found, "yy") / p, expected, atol=1e-9)


def test_hertz_interior():
    """Huber 1904 in the variables of Johnson (1985), eq. (3.68)-(3.69): s_zz, s_rr + s_tt and s_tt off the axis."""
    a = 0.01
    rng = np.random.default_rng(2)
    r, z = rng.uniform(0.01, 2, (2, 60)) * a
    # right beside the rim, too
    r[:8], z[:8] = (
        a * (1 + 1e-6 * np.array([-9, -3, -1, -1, 1, 1, 3, 9])),
        a * 1e-6 * np.array([1, 2, 1, 5, 1, 5, 2, 1]),
    )
    found = fp.fields(BODY, fp.Paraboloid(1.0), r, 0, z, radius=a)
    p = peak(BODY, fp.Paraboloid(1.0), a)
    r, z = r / a, z / a
    u = (r**2 + z**2 - 1 + np.sqrt((r**2 + z**2 - 1) ** 2 + 4 * z**2)) / 2
    root = np.sqrt(u)
    szz = -((z / root) ** 3) * u / (u**2 + z**2)
    np.testing.assert_allclose(component(found, "zz") / p, szz, atol=1e-10)
    bracket = (1 - NU) * u / (1 + u) + (1 + NU) * root * np.arctan(1 / root) - 2
    first = (1 - 2 * NU) / (3 * r**2) * (1 - (z / root) ** 3)
    stt = -(first + z / root * (2 * NU + (1 - NU) * u / (1 + u) - (1 + NU) * root * np.arctan(1 / root)))
    np.testing.assert_allclose(component(found, "yy") / p, stt, atol=1e-10)
    srr = first + z / root * ((z / root) ** 2 * u / (u**2 + z**2) + bracket)
    np.testing.assert_allclose(component(found, "xx") / p, srr, atol=1e-10)
    srz = -r * z**2 / (u**2 + z**2) * root / (1 + u)
    np.testing.assert_allclose(component(found, "xz") / p, srz, atol=1e-10)


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.5])
def test_trailing_edge_of_a_sliding_sphere(friction):
    """Hamilton 1983: s_xx at x = -a."""
    a = 0.01
    found = fp.fields(BODY, fp.Paraboloid(1.0), -a, 0, 0, radius=a, friction=friction)
    p = peak(BODY, fp.Paraboloid(1.0), a)
    expected = (1 - 2 * NU) / 3 + (4 + NU) * np.pi * friction / 8
    np.testing.assert_allclose(component(found, "xx") / p, expected, atol=1e-9)


def test_sliding_on_the_axis():
    """Hamilton 1983 on the axis: only s_xz of the friction remains, -(3/2)(...) from the same potentials by quadrature."""
    a, z = 1.0, np.array([0.2, 0.7, 1.5])
    found = fp.fields(BODY, fp.Paraboloid(1.0), 0, 0, z, radius=a, friction=1.0)
    # Cerruti's s_xz below a ring of tractions: -(3/2 pi) F z^2 x^2/R^5 averaged over the ring, with pressure p0 sqrt(1 - s^2)
    x, w = np.polynomial.legendre.leggauss(60)
    s, w = (x + 1) / 2, w / 2
    rho2 = s**2 + z[:, None] ** 2
    ring = 1.5 * z[:, None] * s**2 / rho2**2.5
    expected = -np.sum(np.sqrt(1 - s**2) * ring * s * w, axis=1)
    p = peak(BODY, fp.Paraboloid(1.0), a)
    # the root at s = 1 limits Gauss quadrature
    np.testing.assert_allclose(component(found, "xz") / p, expected, atol=2e-6)


def test_flat_punch_pressure_and_depth():
    """Sneddon: on the axis s_zz = -p (1 + 3 z^2)/(1 + z^2)^2, p = F/(2 pi a^2)."""
    z = np.array([0.0, 0.3, 1.0, 5.0])
    found = fp.fields(BODY, fp.Cylinder(1.0), 0, 0, z, depth=1e-3)
    p = float(fp.indent(BODY, fp.Cylinder(1.0), depth=1e-3).force[0]) / (2 * np.pi)
    np.testing.assert_allclose(component(found, "zz") / p, -(1 + 3 * z**2) / (1 + z**2) ** 2, atol=1e-10)
    np.testing.assert_allclose(found.displacement.sel(axis="z").values[0], 1e-3, rtol=1e-11)


@pytest.mark.parametrize("medium", [BODY, FILM, STACK], ids=["half-space", "film", "stack"])
@pytest.mark.parametrize(
    "tip",
    [fp.Sphere(20e-6), fp.Cone(0.3), fp.PowerLaw(3.3, 1e11), fp.SpheroCone(0.3, 2e-6)],
    ids=lambda t: type(t).__name__,
)
@pytest.mark.filterwarnings(
    "ignore:The pressure of this round contact is negative"
)  # formal, but the same on both roads
def test_surface_carries_the_pressure_and_nothing_beside_it(medium, tip):
    a = 1.5e-6
    r = np.array([0.05, 0.4, 0.8, 0.98, 1.02, 1.5, 4]) * a
    found = fp.fields(medium, tip, r, 0, 0, radius=a)
    pressure = fp.pressure(medium, tip, r, 0, radius=a)
    # the superposed pressure of `pressure` itself is good to 1e-8 beside kinks of the tip
    np.testing.assert_allclose(-component(found, "zz"), pressure, atol=2e-8 * pressure.max())
    for name in ("xz", "yz"):
        np.testing.assert_allclose(component(found, name), 0, atol=1e-12 * pressure.max())
    # the surface follows the tip
    inside = r < a
    depth = float(fp.indent(medium, tip, radius=a).depth[0])
    sunk = depth - tip.height(r[inside], np.zeros(1))
    np.testing.assert_allclose(found.displacement.sel(axis="z").values[inside], sunk, rtol=1e-8)


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_continuity_at_interfaces(friction):
    x, y = np.random.default_rng(1).uniform(-4e-6, 4e-6, (2, 50))
    for z, bonded in ((1e-6, True), (3e-6, True), (4e-6, False)):
        sides = [
            fp.fields(STACK, fp.Sphere(20e-6), x, y, z, radius=1.5e-6, friction=friction, side=side)
            for side in ("above", "below")
        ]
        scale = float(np.abs(sides[0].stress).max())
        for name in ("zz", "xz", "yz") if bonded else ("zz",):
            np.testing.assert_allclose(component(sides[0], name), component(sides[1], name), atol=1e-10 * scale)
        if not bonded:
            np.testing.assert_allclose(component(sides[1], "xz"), 0, atol=1e-10 * scale)
        moved = [side.displacement.values for side in sides]
        axes = slice(None) if bonded else slice(2, 3)
        np.testing.assert_allclose(moved[0][axes], moved[1][axes], atol=1e-10 * np.abs(moved[0]).max())
        np.testing.assert_array_equal(sides[0].layer + 1, sides[1].layer)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(8))
def test_random_stacks(seed):
    """Continuity at every interface and no traction beside the contact, to 1e-10 of the largest stress or displacement.

    One to ten layers, moduli over eight decades, Poisson ratios up to 1/2, every fourth interface sliding.
    """
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 11))
    layers = [
        fp.Layer(
            1e9 * 10 ** rng.uniform(-4, 4),
            0.5 if rng.random() < 0.3 else rng.uniform(0, 0.49),
            1e-6 * rng.uniform(0.3, 2),
            bonded=bool(rng.random() > 0.25),
        )
        for _ in range(count)
    ]
    medium = fp.Medium(layers, fp.HalfSpace(1e9, rng.uniform(0, 0.5)))
    a = 1e-6 * rng.uniform(0.5, 2)
    arguments = {"radius": a, "friction": 0.2}
    x, y = rng.uniform(-3e-6, 3e-6, (2, 20))
    surface = fp.fields(medium, fp.Sphere(50e-6), x, y, 0.0, **arguments)
    scale = float(np.abs(surface.stress).max())
    outside = np.hypot(x, y) > a
    np.testing.assert_allclose(surface.stress.values[2:5, outside], 0, atol=1e-10 * scale)
    depth = 0.0
    for layer in layers:
        depth += layer.thickness
        sides = [
            fp.fields(medium, fp.Sphere(50e-6), x, y, depth, side=side, **arguments) for side in ("above", "below")
        ]
        across = slice(2, 5) if layer.bonded else slice(2, 3)
        stress = [side.stress.values[across] for side in sides]
        scale = max(scale, float(np.abs(sides[0].stress).max()), float(np.abs(sides[1].stress).max()))
        np.testing.assert_allclose(stress[0], stress[1], atol=1e-10 * scale)
        axes = slice(None) if layer.bonded else slice(2, 3)
        moved = [side.displacement.values[axes] for side in sides]
        np.testing.assert_allclose(moved[0], moved[1], atol=1e-10 * float(np.abs(surface.displacement).max()))
        if not layer.bonded:
            np.testing.assert_allclose(sides[0].stress.values[3:5], 0, atol=1e-10 * scale)


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_equilibrium_at_points(friction):
    """div(stress) = 0 by central differences; their error is (step/length)^2 = 1e-7 of the largest gradient."""
    rng = np.random.default_rng(3)
    step = 1e-9
    for medium, low, high in ((FILM, 0.2e-6, 1.9e-6), (FILM, 2.1e-6, 6e-6), (STACK, 1.1e-6, 2.8e-6)):
        x, y = rng.uniform(-3e-6, 3e-6, (2, 12))
        z = rng.uniform(low, high, 12)
        offsets = step * np.concatenate([np.eye(3), -np.eye(3)])
        points = np.stack([x, y, z])[:, None, :] + offsets.T[:, :, None]
        stress = fp.fields(medium, fp.Sphere(20e-6), *points, radius=1.5e-6, friction=friction).stress.values
        slope = (stress[:, :3] - stress[:, 3:]) / (2 * step)
        xx, yy, zz, yz, xz, xy = slope
        for balance in (xx[0] + xy[1] + xz[2], xy[0] + yy[1] + yz[2], xz[0] + yz[1] + zz[2]):
            np.testing.assert_allclose(balance, 0, atol=1e-5 * np.abs(slope).max())


def test_strain_follows_from_displacement():
    """Hooke's law between differences of the displacement and the stress, in the film and below."""
    step = 1e-9
    for z, body in ((1.2e-6, FILM.layers[0]), (3e-6, FILM.base)):
        point = np.array([0.9e-6, 0.4e-6, z])
        offsets = step * np.concatenate([np.eye(3), -np.eye(3), np.zeros((1, 3))])
        found = fp.fields(FILM, fp.Sphere(20e-6), *(point + offsets).T, radius=1.5e-6, friction=0.3)
        u = found.displacement.values
        gradient = (u[:, :3] - u[:, 3:6]) / (2 * step)
        strain = (gradient + gradient.T) / 2
        mu = body.young / (2 * (1 + body.poisson))
        lam = 2 * mu * body.poisson / (1 - 2 * body.poisson)
        stress = lam * np.trace(strain) * np.eye(3) + 2 * mu * strain
        xx, yy, zz, yz, xz, xy = found.stress.values[:, 6]
        expected = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        np.testing.assert_allclose(stress, expected, atol=1e-5 * np.abs(expected).max())


def test_points_by_tables_and_one_by_one():
    """Many points are interpolated, few are not: 1e-9 of the largest stress between the two."""
    rng = np.random.default_rng(7)
    x, y = rng.uniform(-8e-6, 8e-6, (2, 4000))
    z = rng.uniform(0, 8e-6, 4000)
    many = fp.fields(STACK, fp.Sphere(20e-6), x, y, z, radius=1.5e-6, friction=0.3)
    few = fp.fields(STACK, fp.Sphere(20e-6), x[:12], y[:12], z[:12], radius=1.5e-6, friction=0.3)
    scale = float(np.abs(many.stress).max())
    np.testing.assert_allclose(many.stress[:, :12], few.stress, atol=1e-9 * scale)
    np.testing.assert_allclose(
        many.displacement[:, :12], few.displacement, atol=1e-9 * float(np.abs(many.displacement).max())
    )


def test_adhesive_contact():
    """JKR: the surface follows the tip, and far below the load is the force."""
    a = 1.5e-6
    soft = fp.Medium([fp.Layer(5e3, 0.5, 3e-6)], fp.HalfSpace(50e3, 0.3))
    tip, work = fp.Paraboloid(10e-6), 1e-4
    curve = fp.indent(soft, tip, radius=a, work_of_adhesion=work)
    r = np.array([0.1, 0.5, 0.9]) * a
    found = fp.fields(soft, tip, r, 0, 0, radius=a, work_of_adhesion=work)
    np.testing.assert_allclose(found.displacement.values[2], float(curve.depth[0]) - r**2 / 20e-6, atol=1e-9 * 1e-6)
    pressure = fp.pressure(soft, tip, r, 0, radius=a, work_of_adhesion=work)
    np.testing.assert_allclose(-component(found, "zz"), pressure, rtol=1e-8)


def test_two_bodies():
    """Both sides of the contact carry the same traction, and the gap closes by the sum of both displacements."""
    pair = fp.TwoBodies(fp.Medium([fp.Layer(5e9, 0.3, 1e-6)], fp.HalfSpace(70e9, 0.2)), FILM)
    r = np.array([0.1, 0.6]) * 1e-6
    tip = fp.Paraboloid(20e-6)
    upper, lower = (fp.fields(pair, tip, r, 0, 0, radius=1e-6, friction=0.2, side=side) for side in ("above", "below"))
    scale = float(np.abs(lower.stress).max())
    for name in ("zz", "xz", "yz"):
        np.testing.assert_allclose(component(upper, name), component(lower, name), atol=1e-11 * scale)
    depth = float(fp.indent(pair, tip, radius=1e-6).depth[0])
    plain = [
        fp.fields(pair, tip, r, 0, 0, radius=1e-6, side=side).displacement.values[2] for side in ("above", "below")
    ]
    np.testing.assert_allclose(plain[1] - plain[0], depth - r**2 / 40e-6, rtol=1e-8)
    one = fp.fields(pair, tip, r, 0, -0.5e-6, radius=1e-6)
    assert np.all(component(one, "zz") < 0)


def test_invariants():
    found = fp.fields(FILM, fp.Sphere(20e-6), 0.7e-6, 0.4e-6, [0.5e-6, 3e-6], radius=1.5e-6, friction=0.3)
    for i in range(2):
        xx, yy, zz, yz, xz, xy = found.stress.values[:, i]
        values = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])[::-1]
        np.testing.assert_allclose(found.principal.values[:, i], values, rtol=1e-9)
        assert float(found.max_shear[i]) == pytest.approx((values[0] - values[2]) / 2)
        mises = np.sqrt(
            ((values[0] - values[1]) ** 2 + (values[1] - values[2]) ** 2 + (values[2] - values[0]) ** 2) / 2
        )
        assert float(found.von_mises[i]) == pytest.approx(mises)


def test_residual_stress_and_direction():
    plain = fp.fields(FILM, fp.Sphere(20e-6), 1e-6, 0.5e-6, [1e-6, 3e-6], radius=1.5e-6)
    strained = fp.fields(FILM, fp.Sphere(20e-6), 1e-6, 0.5e-6, [1e-6, 3e-6], radius=1.5e-6, residual_stress=[-2e9])
    np.testing.assert_allclose((strained.stress - plain.stress).values[:, 0], [-2e9, -2e9, 0, 0, 0, 0], atol=1)
    np.testing.assert_allclose((strained.stress - plain.stress).values[:, 1], 0)
    along_x = fp.fields(FILM, fp.Sphere(20e-6), 1e-6, 0.5e-6, 1e-6, radius=1.5e-6, friction=0.3)
    along_y = fp.fields(FILM, fp.Sphere(20e-6), -0.5e-6, 1e-6, 1e-6, radius=1.5e-6, friction=0.3, direction=np.pi / 2)
    assert float(along_x.von_mises) == pytest.approx(float(along_y.von_mises), rel=1e-10)
    assert component(along_x, "xx") == pytest.approx(component(along_y, "yy"), rel=1e-10)


def test_no_contact_and_notes():
    assert not np.any(fp.fields(FILM, fp.Sphere(20e-6), 0, 0, [0, 1e-6], force=0.0).stress)
    assert "rigid shift" in fp.fields(STACK, fp.Sphere(20e-6), 0, 0, 0, radius=1e-6, friction=0.1).attrs["notes"]
    assert "rigid shift" not in fp.fields(STACK, fp.Sphere(20e-6), 0, 0, 0, radius=1e-6).attrs["notes"]


@pytest.mark.long
def test_graded_surface():
    """A linear grading that hardly varies is its half-space, and equilibrium of the surface holds under a strong one."""
    weak = fp.Medium([fp.GradedLayer(fp.LinearModulus(1e9, 1.0001e9, 5e-6), 0.3, 5e-6)], fp.HalfSpace(1.0001e9, 0.3))
    at = (0.3e-6, 0.2e-6, [0.1e-6, 0.6e-6, 3e-6])
    found = fp.fields(weak, fp.Sphere(20e-6), *at, radius=1e-6)
    plain = fp.fields(BODY, fp.Sphere(20e-6), *at, radius=1e-6)
    np.testing.assert_allclose(found.stress, plain.stress, atol=2e-4 * float(np.abs(plain.stress).max()))
    strong = fp.Medium([fp.GradedLayer(fp.LinearModulus(1e9, 9e9, 2e-6), 0.3, 2e-6)], fp.HalfSpace(9e9, 0.3))
    thin = [fp.Layer(1e9 + 8e9 * (i + 0.5) / 30, 0.3, 2e-6 / 30) for i in range(30)]
    steps = fp.Medium(thin, fp.HalfSpace(9e9, 0.3))
    at = (0.0, 0.0, [0.5e-6, 1e-6, 3e-6])
    exact = fp.fields(steps, fp.Sphere(20e-6), *at, radius=1e-6)
    found = fp.fields(strong, fp.Sphere(20e-6), *at, radius=1e-6)
    # steps of modulus of a quarter of the surface's leave two per cent
    np.testing.assert_allclose(found.stress[2], exact.stress[2], rtol=2e-2)


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"z": -1e-6}, ValueError, "above the surface"),
        ({"z": np.nan}, ValueError, "finite"),
        ({"friction": -0.1}, ValueError, "friction"),
        ({"side": "left"}, ValueError, "side"),
        ({"residual_stress": [1.0, 2.0, 3.0]}, ValueError, "residual_stress"),
        ({"x": [0.0, 1.0], "z": [0.0, 1.0, 2.0]}, ValueError, "broadcast"),
        ({"radius": [1e-6, 2e-6]}, ValueError, "one contact"),
        ({"radius": None}, ValueError, "exactly one"),
        ({"depth": 1e-8}, ValueError, "exactly one"),
        ({"method": "third-order"}, ValueError, "method"),
        ({"medium": fp.Layer(1e9, 0.3, 1e-6)}, TypeError, "medium"),
        ({"indenter": 3.0}, TypeError, "indenter"),
        ({"indenter": fp.Sphere}, TypeError, "indenter"),
        ({"indenter": []}, ValueError, "empty"),
        ({"x": np.zeros((1500, 1)), "z": np.zeros(1500)}, ValueError, "points"),
        ({"x": []}, ValueError, "points"),
        ({"friction": 1e3}, ValueError, "friction"),
        ({"medium": fp.TwoBodies(BODY, FILM), "residual_stress": [1.0]}, ValueError, "residual_stress"),
        ({"indenter": [fp.Sphere(1e-6)]}, TypeError, "DiscLoad"),
        ({"indenter": fp.DiscLoad(1.0, 1.0)}, ValueError, "belongs to an indenter"),
        ({"medium": fp.Medium([fp.Layer(1e9, 0.3, 1e-6)], fp.RigidBase()), "z": 2e-6}, ValueError, "rigid base"),
    ],
)
def test_bad_input(arguments, error, words):
    given = {"medium": FILM, "indenter": fp.Sphere(20e-6), "x": 0.0, "y": 0.0, "z": 1e-6, "radius": 1e-6, **arguments}
    with pytest.raises(error, match=words):
        fp.fields(given.pop("medium"), given.pop("indenter"), given.pop("x"), given.pop("y"), given.pop("z"), **given)


@pytest.mark.long
def test_contacts_far_wider_than_a_film_are_refused_at_once():
    start = time.process_time()
    with pytest.raises(ValueError, match="wavenumbers"):
        fp.fields(FILM, fp.Paraboloid(1e4), 0, 0, [0, 1e-6], radius=0.1)
    assert time.process_time() - start < 3  # 0.4 s on a free core


def test_far_away_only_the_base_is_felt():
    """Hundreds of film thicknesses away the surface sinks as under a point force on the base."""
    r = np.array([1e-3, 1e-2])
    found = fp.fields(FILM, fp.Sphere(50e-6), r, 0, 0, force=0.5).displacement.sel(axis="z").values
    np.testing.assert_allclose(found, 0.5 * (1 - 0.3**2) / (np.pi * 210e9 * r), rtol=1e-4)


R = np.linspace(0, 4e-6, 41)
GRADED = fp.Medium([fp.GradedLayer(fp.LinearModulus(400e9, 210e9, 2e-6), 0.3, 2e-6)], fp.HalfSpace(210e9, 0.3))


@pytest.mark.long
@pytest.mark.parametrize("tip", [fp.Sphere(20e-6), fp.RadialProfile(R, R**2 / 40e-6)], ids=["smooth", "table"])
@pytest.mark.parametrize(
    "medium", [GRADED, fp.PowerLawHalfSpace(1e9, 1e-6, 0.3, 0.3), FILM], ids=["graded", "power", "film"]
)
def test_sliding_surface_has_no_rings_where_panels_meet(medium, tip):
    """The pressure is known on panels that are halved until they are fine enough: stresses there are those beside them."""
    a = 1.5e-6
    r = np.arange(-64, 65) / 64 * a
    at, beside = (fp.fields(medium, tip, r * s, 0, 0, radius=a, friction=0.3).stress.values for s in (1, 1 - 1e-7))
    # beside the rim the stress changes like the root of the distance
    np.testing.assert_allclose(at, beside, atol=2e-3 * np.abs(beside).max())


@pytest.mark.long
@pytest.mark.parametrize("tip", [fp.Paraboloid(1e-3), fp.Sphere(4e-4), fp.Cone(0.1)])
def test_transform_interpolated_over_dense_wavenumbers(tip):
    """P at many wavenumbers is P at each by itself, to rounding of P(0), whatever their order."""
    load = contact_load(compliance(FILM), tip, 1.5e-4, 0.0, edge=False)
    k = np.random.default_rng(1).permutation(np.concatenate([np.linspace(0, 300, 3000), [1e3, 1e5]])) / load.radius
    alone = np.array([load.transform(each)[0] for each in k[:200, None]])
    assert load.transform(k)[:200] == pytest.approx(alone, abs=1e-14 * load.force)
