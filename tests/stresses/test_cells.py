"""Pressures on cells: against exact round contacts, discs made of cells, elliptic contact, bad input."""

import numpy as np
import pytest
from scipy.integrate import quad

import flatpunch as fp
from flatpunch.reference.elliptic import elliptic_paraboloid

BODY = fp.HalfSpace(1e9, 0.3)
FILM = fp.Medium([fp.Layer(5e9, 0.3, 1e-6)], fp.HalfSpace(1e9, 0.3))
TIP = fp.Paraboloid(20e-6)


@pytest.mark.long
@pytest.mark.parametrize(("medium", "friction"), [(BODY, 0.3), (FILM, 0.0)], ids=["half-space", "film"])
def test_round_contact_by_boundary_elements(medium, friction):
    """0.5 % of the largest stress inside and at the surface away from the rim; the estimate holds there and beside it."""
    rng = np.random.default_rng(4)
    force = float(fp.indent(medium, TIP, radius=2e-6).force[0])
    for count, z in ((120, 0.3e-6), (120, 1.5e-6), (120, 0.0)):
        x, y = rng.uniform(-5e-6, 5e-6, (2, count))
        exact = fp.fields(medium, TIP, x, y, z, force=force, friction=friction)
        cells = fp.fields(medium, TIP, x, y, z, force=force, friction=friction, method=fp.BoundaryElements(grid=128))
        off = np.abs(cells.stress - exact.stress).values.max(axis=0)
        pressure = float(fp.pressure(medium, TIP, 0, 0, force=force))
        assert off.max() < max(cells.attrs["stress_error"], 1e-4) * pressure
        away = np.abs(np.hypot(x, y) - 2e-6) > 0.3e-6
        assert off[away].max() < 0.005 * float(np.abs(exact.stress).max())
        moved = np.abs(cells.displacement - exact.displacement).values
        assert moved.max() < 2e-3 * float(np.abs(exact.displacement).max())


@pytest.mark.long
def test_a_section_through_all_depths():
    """Many depths are interpolated between planes; 0.5 % of the largest stress."""
    rng = np.random.default_rng(5)
    x, z = rng.uniform(-5e-6, 5e-6, 300), rng.uniform(0.1e-6, 8e-6, 300)
    force = float(fp.indent(FILM, TIP, radius=2e-6).force[0])
    exact = fp.fields(FILM, TIP, x, 0.2e-6, z, force=force)
    cells = fp.fields(FILM, TIP, x, 0.2e-6, z, force=force, method=fp.BoundaryElements(grid=96))
    np.testing.assert_allclose(cells.stress, exact.stress, atol=0.005 * float(np.abs(exact.stress).max()))


def test_disc_made_of_cells():
    """Three-layer road under two wheels, as discs and as one patch: away from the edges of the discs 0.5 %."""
    road = fp.Medium([fp.Layer(3e9, 0.35, 0.15), fp.Layer(0.3e9, 0.4, 0.3)], fp.HalfSpace(50e6, 0.45))
    wheels = [fp.DiscLoad(0.7e6, 0.1, traction=0.1e6, center=(0.0, y)) for y in (-0.17, 0.17)]
    h = 0.005
    x, y = (np.arange(40) - 19.5) * h, (np.arange(108) - 53.5) * h
    fine = (np.arange(5) - 2) / 5 * h
    inside = np.zeros((108, 40))
    for _, wheel_y in (wheel.center for wheel in wheels):
        for dx in fine:
            for dy in fine:
                inside += ((x[None, :] + dx) ** 2 + (y[:, None] + dy - wheel_y) ** 2 < 0.01) / 25
    patch = fp.PatchLoad(0.7e6 * inside, h, traction=0.1e6 * inside)
    at = ([0.0, 0.05, 0.4, 2.0], [0.0, 0.1, 0.3, 1.0], [0.1, 0.15, 0.3, 1.0])
    for direction in (0.0, 0.7):
        discs = fp.fields(road, wheels, *at, direction=direction)
        cells = fp.fields(road, patch, *at, direction=direction)
        np.testing.assert_allclose(cells.stress, discs.stress, atol=2e-3 * 0.7e6)
        np.testing.assert_allclose(
            cells.displacement, discs.displacement, atol=2e-3 * float(np.abs(discs.displacement).max())
        )


def test_elliptic_contact_on_its_axis():
    """Pressure of an ellipse on a half-space; s_zz below its centre by one integral over confocal ellipses."""
    exact = elliptic_paraboloid(2e4, 5e4, BODY.surface_modulus, depth=1e-7)
    half_x, half_y, force = exact.half_axis_x, exact.half_axis_y, exact.force
    z = np.array([0.5e-6, 1.5e-6])
    fields = fp.fields(BODY, fp.EllipticParaboloid(2e4, 5e4), 0, 0, z, depth=1e-7)
    for i, depth in enumerate(z):

        def below(s, depth=depth):
            # s_zz of a point force under an elliptic ring of relative size s, averaged over the angle
            phi = (np.arange(64) + 0.5) * 2 * np.pi / 64
            r2 = (s * half_x * np.cos(phi)) ** 2 + (s * half_y * np.sin(phi)) ** 2 + depth**2
            return 3 * force * s * np.sqrt(1 - s * s) * np.mean(-3 * depth**3 / (2 * np.pi * r2**2.5))

        expected = quad(below, 0, 1, epsabs=0)[0]
        assert float(fields.stress[2, i]) == pytest.approx(expected, rel=3e-3)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:First-order pressures")
def test_first_order_gives_its_superposed_pressure():
    """A pyramid: boundary elements and the pressure of stretched punches agree to the estimates of both."""
    x = np.linspace(-1e-6, 1e-6, 9)
    ours, theirs = (
        fp.fields(BODY, fp.Pyramid(4, 0.3), x, 0.1e-6, 0.3e-6, depth=3e-7, method=m) for m in ("bem", "first-order")
    )
    largest = float(np.abs(ours.stress).max())
    np.testing.assert_allclose(theirs.stress, ours.stress, atol=0.1 * largest)
    assert theirs.attrs["stress_error"] > ours.attrs["stress_error"]


@pytest.mark.long
@pytest.mark.parametrize(
    "medium", [fp.HalfSpace(5e3, 0.3), fp.Medium([fp.Layer(5e3, 0.5, 3e-6)], fp.HalfSpace(50e3, 0.3))]
)
def test_adhesive_contact_on_cells(medium):
    """An ellipse that is all but round against the exact round contact; 1 % of the largest stress, from the rim of the cells."""
    rng = np.random.default_rng(4)
    work, ellipse = 1e-4, fp.EllipticParaboloid(5e4 * (1 + 1e-9), 5e4 * (1 - 1e-9))
    depth = float(fp.indent(medium, fp.Paraboloid(10e-6), radius=1.5e-6, work_of_adhesion=work).depth[0])
    x, y = rng.uniform(-3e-6, 3e-6, (2, 120))
    for z in (0.3e-6, 1e-6):
        cells, exact = (
            fp.fields(medium, tip, x, y, z, depth=depth, work_of_adhesion=work, friction=0.2)
            for tip in (ellipse, fp.Paraboloid(10e-6))
        )
        scale = float(np.abs(exact.stress).max())
        np.testing.assert_allclose(cells.stress, exact.stress, atol=0.01 * scale)
        assert cells.attrs["force"] == pytest.approx(exact.attrs["force"], rel=1e-6)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: fp.PatchLoad([1.0, 2.0], 1.0), ValueError, "two-dimensional"),
        (lambda: fp.PatchLoad([[1.0, np.nan]], 1.0), ValueError, r"\[0, 1\]"),
        (lambda: fp.PatchLoad([[1.0]], 0.0), ValueError, "spacing"),
        (lambda: fp.PatchLoad([[1.0]], 1.0, traction=[[1.0, 2.0]]), ValueError, "traction"),
        (lambda: fp.DiscLoad(1.0, -1.0), ValueError, "radius"),
        (lambda: fp.DiscLoad(1.0, 1.0, center=3.0), ValueError, "center"),
        (
            lambda: fp.fields(FILM, fp.Pyramid(4, 0.3), 0, 0, 0, depth=3e-7, method="first-order"),
            ValueError,
            "no outline",
        ),
        (lambda: fp.PatchLoad(np.zeros((4097, 1)), 1.0), ValueError, "at most 4096"),
        (lambda: fp.PatchLoad(np.broadcast_to(1.0, (100_000, 100_000)), 1.0), ValueError, "are the most"),
        (lambda: fp.PatchLoad([["1", "2"]], 1.0), TypeError, "pressure"),
        (
            lambda: fp.fields(FILM, fp.Pyramid(4, 0.3), 0, 0, 0, depth=1e-7, work_of_adhesion=1.0, method="bem"),
            ValueError,
            "adhesi",
        ),
    ],
)
def test_bad_input(make, error, words):
    with pytest.raises(error, match=words):
        make()


@pytest.mark.parametrize("medium", [BODY, FILM], ids=["half-space", "film"])
def test_points_far_from_the_load_and_from_each_other(medium):
    """Each is what it is alone: no grid is laid over the metres between them."""
    load = fp.PatchLoad([[1e5, 2e5, 1e5], [1e5, 2e5, 1e5]], 1e-7, traction=2e4)
    x = np.array([0.0, 1e-5, 2e-4, 2.5e-4, 4e-3])
    together = fp.fields(medium, load, x, 0.0, 1e-6)["von_mises"].values
    alone = [float(fp.fields(medium, load, each, 0.0, 1e-6)["von_mises"]) for each in x]
    np.testing.assert_allclose(together, alone, rtol=1e-9)


def test_far_away_cells_act_like_a_disc():
    load, s = fp.PatchLoad([[1e5, 2e5, 1e5], [1e5, 2e5, 1e5]], 1e-7), np.array([3e-5, 3e-4, 3e-3])
    disc = fp.DiscLoad(8e-9 / (np.pi * 1e-14), 1e-7)
    found, wanted = (fp.fields(BODY, each, s, 0.0, s / 2)["von_mises"] for each in (load, disc))
    # the load is as large as 3 by 2 cells: it counts like size/distance, at an angle to the surface
    np.testing.assert_array_less(abs(found / wanted - 1), 0.5e-6 / s)


def far_points(size):
    """Points at 3 to 3000 times a length from the origin, in all directions of the body."""
    rng = np.random.default_rng(7)
    away = size * np.geomspace(3, 3000, 40)
    turn, down = rng.uniform(0, 2 * np.pi, 40), rng.uniform(0, np.pi / 2, 40)
    return away * np.sin(down) * np.cos(turn), away * np.sin(down) * np.sin(turn), away * np.cos(down)


def point_force_stress(x, y, z, nu):
    """Stress (xx, yy, zz, yz, xz, xy) under a unit normal force on a half-space (Boussinesq)."""
    r = np.sqrt(x**2 + y**2 + z**2)
    plain, bent = 1 / (r * (r + z)), (2 * r + z) / (r**3 * (r + z) ** 2)
    shear = 1 - 2 * nu
    along = [3 * a * a * z / r**5 - shear * (z / r**3 - plain + a * a * bent) for a in (x, y)]
    rest = [3 * z**3 / r**5, 3 * y * z * z / r**5, 3 * x * z * z / r**5, 3 * x * y * z / r**5 - shear * x * y * bent]
    return -np.stack([*along, *rest]) / (2 * np.pi)


@pytest.mark.parametrize("shape", [(1, 1), (4, 4), (3, 5), (9, 2), (33, 50)])
def test_far_fields_are_those_of_point_forces(shape):
    """1e-4 of the local stress at any distance; the stated error holds."""
    h = 1e-7
    pressure = 1e6 * np.random.default_rng(3).random(shape)
    at = far_points(h * max(shape))
    found = fp.fields(BODY, fp.PatchLoad(pressure, h), *at)
    # six Gauss points along each side of a cell
    nodes, weights = np.polynomial.legendre.leggauss(6)
    gy, gx = (((np.arange(n)[:, None] - (n - 1) / 2 + nodes / 2) * h).ravel() for n in shape)
    force = np.kron(pressure, np.outer(weights, weights) / 4) * h**2
    exact = np.array(
        [(point_force_stress(x - gx, y - gy[:, None], z, 0.3) * force).sum((1, 2)) for x, y, z in np.transpose(at)]
    ).T
    off = np.abs(found.stress.values - exact).max(0)
    assert (off / np.abs(exact).max(0)).max() < 1e-4
    assert off.max() < max(found.attrs["stress_error"], 1e-12) * pressure.max()


@pytest.mark.long
@pytest.mark.parametrize("shape", [(1, 2), (3, 5)])
def test_far_fields_in_a_film_are_those_of_discs_in_each_cell(shape):
    """1e-3 of the local stress and displacement, under pressure and traction."""
    pressure, h = np.kron(1e6 * np.random.default_rng(3).random(shape), np.ones((2, 2))), 5e-8
    traction = pressure[::-1] / 2
    ny, nx = pressure.shape
    discs = [
        fp.DiscLoad(
            pressure[i, j],
            h / np.sqrt(np.pi),
            traction=traction[i, j],
            center=((j - (nx - 1) / 2) * h, (i - (ny - 1) / 2) * h),
        )
        for i in range(ny)
        for j in range(nx)
    ]
    at = far_points(h * nx)
    exact, found = (fp.fields(FILM, load, *at) for load in (discs, fp.PatchLoad(pressure, h, traction=traction)))
    for name, over in (("stress", "component"), ("displacement", "axis")):
        off = np.abs(found[name] - exact[name]).max(over)
        assert float((off / np.abs(exact[name]).max(over)).max()) < 1e-3
