"""Fields under prescribed loads: closed forms and published tables of road design."""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

import flatpunch as fp

DATA = Path(__file__).resolve().parents[1] / "data"
NU = 0.3
BODY = fp.HalfSpace(1e9, NU)


def component(result, name):
    return result.stress.sel(component=name).values


def test_disc_load_closed_forms():
    """Centre of a uniform disc (Love), and the deflection at its rim and centre: 2 p a (1 - nu^2)/E at the centre."""
    z = np.array([0.0, 0.5, 2.0])
    found = fp.fields(BODY, fp.DiscLoad(1e6, 1.0), 0, 0, z)
    np.testing.assert_allclose(component(found, "zz"), -1e6 * (1 - z**3 / (1 + z**2) ** 1.5), rtol=1e-12)
    assert found.displacement.values[2, 0] == pytest.approx(2e6 * (1 - NU**2) / 1e9, rel=1e-12)
    rim = fp.fields(BODY, fp.DiscLoad(1e6, 1.0), [0.5, 2.0], 0, 0).displacement.values[2]
    p = 4e6 * (1 - NU**2) / (np.pi * 1e9)
    inside = p * ellipe(0.25)
    outside = 2 * p * (ellipe(0.25) - 0.75 * ellipk(0.25))
    np.testing.assert_allclose(rim, [inside, outside], rtol=1e-12)


def test_cerruti_and_boussinesq_far_from_a_small_disc():
    """Point forces: a disc of a thousandth of the distance differs by its square, 1e-6."""
    rng = np.random.default_rng(5)
    x, y, z = rng.uniform(-1, 1, (3, 30))
    z = np.abs(z) + 0.2
    disc = 1e-3
    area, big = np.pi * disc**2, 1e9
    r2 = x**2 + y**2 + z**2
    r = np.sqrt(r2)
    normal = fp.fields(BODY, fp.DiscLoad(big, disc), x, y, z)
    np.testing.assert_allclose(component(normal, "zz"), -3 * big * area * z**3 / (2 * np.pi * r**5), rtol=2e-5)
    np.testing.assert_allclose(component(normal, "xz"), -3 * big * area * x * z**2 / (2 * np.pi * r**5), rtol=2e-5)
    sliding = fp.fields(BODY, fp.DiscLoad(0.0, disc, traction=big), x, y, z)
    for name, expected in (("zz", x * z**2), ("xz", x**2 * z), ("yz", x * y * z)):
        np.testing.assert_allclose(
            component(sliding, name), -3 * big * area * expected / (2 * np.pi * r**5), rtol=1e-4, atol=1e-6 * big * area
        )
    mu = 1e9 / (2 * (1 + NU))
    u_x = 1 / r + x**2 / r**3 + (1 - 2 * NU) * (1 / (r + z) - x**2 / (r * (r + z) ** 2))
    np.testing.assert_allclose(sliding.displacement.values[0], big * area / (4 * np.pi * mu) * u_x, rtol=2e-5)


def rows(name):
    with (DATA / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def test_kenpave():
    """Three layers under a wheel: stresses, strains and deflection to the digits of the recomputed table."""
    table = [row for row in rows("multilayer_kenpave.csv") if float(row["z_in"]) > 0]
    road = fp.Medium([fp.Layer(500e3, 0.35, 6.0), fp.Layer(40e3, 0.4, 10.0)], fp.HalfSpace(10e3, 0.45))
    z = np.array([float(row["z_in"]) for row in table])
    found = fp.fields(road, fp.DiscLoad(100.0, 5.99), 0, 0, z, side="above")
    # the row at z = 1 in is off by 4e-5; in 40 digits it is 95.827427
    np.testing.assert_allclose(-component(found, "zz"), [float(row["sz_exact"]) for row in table], rtol=5e-5)
    assert -component(found, "zz")[0] == pytest.approx(95.82742737, rel=1e-9)
    np.testing.assert_allclose(found.displacement.values[2], [float(row["w_exact"]) for row in table], rtol=1e-5)
    sides = [fp.fields(road, fp.DiscLoad(100.0, 5.99), 0, 0, 6.0, side=side) for side in ("above", "below")]
    np.testing.assert_allclose([float(s.stress[0]) for s in sides], [166.443, -0.486], atol=6e-4)


def test_ellea():
    """Deflection and vertical stress below one wheel on a road, to the digits of the recomputed table."""
    table = rows("multilayer_ellea1_depth.csv")
    road = fp.Medium([fp.Layer(3000.0, 0.30, 150.0), fp.Layer(200.0, 0.35, 600.0)], fp.HalfSpace(40.0, 0.40))
    z = np.array([float(row["z_mm"]) for row in table])
    found = fp.fields(road, fp.DiscLoad(1.1, 150.0), 0, 0, z)
    np.testing.assert_allclose(found.displacement.values[2], [float(row["uz_exact"]) for row in table], atol=1e-5)
    np.testing.assert_allclose(-component(found, "zz"), [float(row["sz_exact"]) for row in table], atol=1e-5)


def test_a_footprint_of_few_cells_is_as_good_as_one_of_many():
    """The pressure is constant in each cell, so that cutting it changes nothing."""
    road = fp.Medium([fp.Layer(3.0, 0.35, 0.5)], base=fp.HalfSpace(0.3, 0.45))
    tyre = np.array([[0.4, 0.9], [0.6, 0.2]])
    x, y, z = np.array([0.1, -0.3, 0.8]), np.array([0.2, 0.0, -0.4]), np.array([0.3, 0.5, 0.9])
    few = fp.fields(road, fp.PatchLoad(tyre, 0.4, traction=0.3 * tyre, center=(0.1, 0.0)), x, y, z)
    cut = np.kron(tyre, np.ones((96, 96)))
    many = fp.fields(road, fp.PatchLoad(cut, 0.4 / 96, traction=0.3 * cut, center=(0.1, 0.0)), x, y, z)
    np.testing.assert_allclose(few.stress, many.stress, atol=1e-4)
    assert few.attrs["stress_error"] < 1e-3
