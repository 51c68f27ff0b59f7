"""Fields in power-law half-spaces: exact limits, radial stresses, equilibrium, the shape of the surface, cells, bad input."""

import numpy as np
import pytest

import flatpunch as fp

TIP = fp.Paraboloid(10e-6)
A = 1e-6


def body(exponent, poisson=0.3):
    return fp.PowerLawHalfSpace(1e9, 1e-6, exponent, poisson)


def test_exponent_zero_is_hertz():
    rng = np.random.default_rng(2)
    x, y = rng.uniform(-3e-6, 3e-6, (2, 60))
    z = 1e-12 + 3e-6 * rng.uniform(0, 1, 60) ** 3
    arguments = {"radius": A, "friction": 0.3}
    hertz = fp.fields(fp.HalfSpace(1e9, 0.3), TIP, x, y, z, **arguments)
    ours = fp.fields(body(1e-7), TIP, x, y, z, **arguments)
    # the exponent itself changes 1e-7
    np.testing.assert_allclose(ours.stress, hertz.stress, atol=1e-6 * float(np.abs(hertz.stress).max()))
    moved = float(np.abs(hertz.displacement).max())
    np.testing.assert_allclose(ours.displacement, hertz.displacement, atol=1e-6 * moved)


@pytest.mark.long
@pytest.mark.parametrize(("exponent", "poisson"), [(0.25, 1 / 2.25), (0.5, 0.4), (-0.3, 0.5), (1.0, 0.5)])
def test_stresses_below_the_centre(exponent, poisson):
    """For nu = 1/(2 + k) a point force makes radial stresses only, (k + 3) F cos^(k+1)/(2 pi R^2) (Froehlich 1934).

    The incompressible Gibson soil (k = 1) has those of the homogeneous incompressible half-space (Gibson 1967). For the third
    case there is no closed form: its s_zz is checked by the balance of forces over a plane.
    """
    medium = body(exponent, poisson)
    z = np.array([0.05, 0.3, 1.0, 3.0]) * A
    force = float(fp.indent(medium, TIP, radius=A).force[0])
    if exponent < 0:
        r = np.linspace(0, 60, 4001) * A
        plane = fp.fields(medium, TIP, r, 0.0, 2e-6, radius=A).stress.values[2]
        total = np.trapezoid(2 * np.pi * r * plane, r)
        # beyond the last radius there is 1e-4 of the force
        assert -total == pytest.approx(force, rel=1e-3)
        return
    found = fp.fields(medium, TIP, 0.0, 0.0, z, radius=A).stress.values
    power = 0.0 if exponent == 1 else exponent

    def pressure(r):
        return float(fp.pressure(medium, TIP, r, 0.0, radius=A))

    grid, weights = np.polynomial.legendre.leggauss(80)
    theta = np.pi / 4 * (1 + grid)
    r = A * np.sin(theta)
    w = weights * np.pi / 4 * A * np.cos(theta) * r * np.array([pressure(each) for each in r])
    for i, depth in enumerate(z):
        distance2 = r**2 + depth**2
        cosine = depth / np.sqrt(distance2)
        radial = -(power + 3) * cosine ** (power + 1) / distance2
        # s_zz = s_R cos^2, s_xx on the axis half of s_R sin^2; for the smallest depth 80 nodes leave 1e-6
        assert found[2, i] == pytest.approx(np.sum(w * radial * cosine**2), rel=2e-6)
        assert found[0, i] == pytest.approx(np.sum(w * radial * (1 - cosine**2) / 2), rel=2e-6, abs=1e-6 * force / A**2)


@pytest.mark.parametrize(("exponent", "poisson"), [(0.3, 0.3), (0.8, 0.2), (1.0, 0.5)])
def test_surface_follows_the_tip(exponent, poisson):
    medium, r = body(exponent, poisson), np.array([0.0, 0.3, 0.8, 1.5]) * A
    found = fp.fields(medium, TIP, r, 0.0, 0.0, radius=A)
    depth = float(fp.indent(medium, TIP, radius=A).depth[0])
    np.testing.assert_allclose(found.displacement.values[2, :3], depth - r[:3] ** 2 / 20e-6, rtol=1e-9)
    pressure = fp.pressure(medium, TIP, r, 0.0, radius=A)
    np.testing.assert_allclose(-found.stress.values[2], pressure, atol=1e-7 * pressure.max())
    # the modulus vanishes there, so that nothing is carried along the surface
    np.testing.assert_allclose(
        found.stress.values[0], poisson / (1 - poisson) * found.stress.values[2], rtol=1e-9, atol=1e-15 * pressure.max()
    )


@pytest.mark.parametrize("exponent", [0.3, -0.3])
def test_equilibrium_and_hooke(exponent):
    """By central differences, whose error is (step/length)^2 = 1e-6."""
    medium, step = body(exponent), 1e-9
    point = np.array([0.7e-6, 0.3e-6, 0.5e-6])
    offsets = step * np.concatenate([np.eye(3), -np.eye(3), np.zeros((1, 3))])
    found = fp.fields(medium, TIP, *(point + offsets).T, radius=A, friction=0.3)
    stress, u = found.stress.values, found.displacement.values
    slope = (stress[:, :3] - stress[:, 3:6]) / (2 * step)
    xx, yy, zz, yz, xz, xy = slope
    for balance in (xx[0] + xy[1] + xz[2], xy[0] + yy[1] + yz[2], xz[0] + yz[1] + zz[2]):
        assert abs(balance) < 1e-5 * np.abs(slope).max()
    gradient = (u[:, :3] - u[:, 3:6]) / (2 * step)
    strain = (gradient + gradient.T) / 2
    mu = 1e9 * 0.5**exponent / 2.6
    expected = 2 * mu * (strain + 0.3 / 0.4 * np.trace(strain) * np.eye(3))
    xx, yy, zz, yz, xz, xy = stress[:, 6]
    np.testing.assert_allclose([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.long
def test_contact_on_cells():
    """Boundary elements against the exact round contact: 0.5 % of the largest stress."""
    rng = np.random.default_rng(3)
    medium = body(0.3)
    x, y = rng.uniform(-2e-6, 2e-6, (2, 60))
    force = float(fp.indent(medium, TIP, radius=A).force[0])
    for z in (0.02e-6, 0.4e-6):
        exact = fp.fields(medium, TIP, x, y, z, force=force, friction=0.2)
        cells = fp.fields(medium, TIP, x, y, z, force=force, friction=0.2, method="bem")
        off = np.abs(cells.stress - exact.stress).values.max(axis=0) / float(np.abs(exact.stress).max())
        assert off.max() < cells.attrs["stress_error"]
        assert off[np.abs(np.hypot(x, y) - A) > 0.1 * A].max() < 0.005


@pytest.mark.long
def test_flat_ends_adhesion_and_two_bodies():
    medium = body(0.4)
    below = fp.fields(medium, fp.Cylinder(A), 0.0, 0.0, [0.0, 20e-6], force=1e-4)
    # the singular pressure at the rim is cut off 1e-3 of the radius before it
    assert below.stress.values[2, 0] == pytest.approx(-(1 - 0.3) * 1e-4 / (np.pi * A**2), rel=2e-5)
    work = {"radius": A, "work_of_adhesion": 1.0}
    depth = float(fp.indent(medium, TIP, **work).depth[0])
    stuck = fp.fields(medium, TIP, [0.2e-6, 0.7e-6], 0.0, 0.0, **work)
    np.testing.assert_allclose(
        stuck.displacement.values[2], depth - np.array([0.04, 0.49]) * 1e-12 / 20e-6, atol=1e-6 * abs(depth)
    )
    pair = fp.TwoBodies(medium, body(0.4, 0.2))
    sides = [fp.fields(pair, TIP, 0.3e-6, 0.0, 0.0, radius=A, side=side) for side in ("above", "below")]
    depth = float(fp.indent(pair, TIP, radius=A).depth[0])
    moved = [float(side.displacement[2]) for side in sides]
    assert moved[1] - moved[0] == pytest.approx(depth - 0.09e-12 / 20e-6, rel=1e-8)


def test_bad_input():
    with pytest.raises(ValueError, match="infinite"):
        fp.fields(body(-0.3), TIP, 0.0, 0.0, 0.0, radius=A)
    with pytest.raises(ValueError, match="residual_stress"):
        fp.fields(body(0.3), TIP, 0.0, 0.0, 0.0, radius=A, residual_stress=[1.0])


@pytest.mark.parametrize("exponent", [0.01, 0.3, 0.9])
def test_energy_with_an_infinite_pressure_at_the_edge_is_the_work_done(exponent):
    """Waves of any length count there: 1e-3 of the energy was missing."""
    medium, tip = fp.PowerLawHalfSpace(1.0, 1.0, exponent, 0.3), fp.Paraboloid(2.0)
    flat = fp.indent(medium, fp.Cylinder(1.0), depth=0.01)
    total = fp.energy_by_depth(medium, fp.Cylinder(1.0), depth=0.01).attrs["total"]
    assert total == pytest.approx(float(flat.force[0]) * 0.01 / 2, rel=1e-12)
    plain, pulled = (fp.indent(medium, tip, radius=0.5, **more) for more in ({}, {"work_of_adhesion": 0.01}))
    back = float(pulled.depth[0] - plain.depth[0])
    work = float(plain.force[0]) * back + float(plain.stiffness[0]) * back**2 / 2
    first, second = (
        fp.energy_by_depth(medium, tip, radius=0.5, **more).attrs["total"] for more in ({}, {"work_of_adhesion": 0.01})
    )
    assert second - first == pytest.approx(work, rel=1e-6)
