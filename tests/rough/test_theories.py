"""Full contact from a spectrum against the numerical one, Persson and Greenwood-Williamson where they are good; summits."""

import numpy as np
import pytest

import flatpunch as fp

ROUGH = fp.self_affine(128, 10e-9, rms_slope=0.1, roll_off=0.3e-6, cut_off=80e-9, seed=4)
STEEL = fp.HalfSpace(210e9, 0.3)
COATED = fp.Medium([fp.Layer(400e9, 0.2, 100e-9)], base=STEEL)
SOFT = fp.Medium([fp.Layer(5e3, 0.45, 2e-6)], base=fp.RigidBase())


@pytest.mark.parametrize("medium", [STEEL, COATED, SOFT], ids=["half-space", "coating", "layer"])
def test_full_contact_of_a_surface_is_the_numerical_one(medium):
    full = fp.full_contact(medium, ROUGH)
    pressed = fp.rough_contact(medium, ROUGH, pressure=10 * full.rms_pressure, fields=True)
    assert float(pressed.area_fraction[0]) == 1
    assert full.rms_pressure == pytest.approx(float(pressed.pressure.std()), rel=1e-6)
    mean = float(pressed.mean_pressure[0])
    uniform = 0.5 * mean**2 * 2e-6 * 1.45 * 0.1 / (0.55 * 5e3) if medium is SOFT else 0.0
    assert full.energy == pytest.approx(float(pressed.energy[0]) / ROUGH.area - uniform, rel=1e-5)
    assert full.rms_height == pytest.approx(ROUGH.rms_height, rel=1e-9)
    assert full.rms_slope == pytest.approx(ROUGH.rms_slope, rel=0.01)


def test_half_space_of_a_spectrum():
    """Rms pressure E* rms slope/2, and (E*/4) <|q| h^2> of energy; power laws between the points are integrated exactly."""
    q = np.geomspace(1e5, 1e8, 30)
    full = fp.full_contact(STEEL, (q, 1e-29 * (q / 1e6) ** -3.6))
    star = 210e9 / 0.91
    assert full.rms_pressure == pytest.approx(star * full.rms_slope / 2, rel=1e-12)
    energy = 1e-29 * 1e6**3.6 / (2 * np.pi) * (1e8**-0.6 - 1e5**-0.6) / -0.6
    assert full.energy == pytest.approx(star / 4 * energy, rel=1e-10)
    assert full.rms_height**2 == pytest.approx(
        1e-29 * 1e6**3.6 / (2 * np.pi) * (1e8**-1.6 - 1e5**-1.6) / -1.6, rel=1e-10
    )


@pytest.mark.parametrize("medium", [STEEL, COATED], ids=["half-space", "coating"])
def test_where_theories_are_good(medium):
    """Persson: low at small loads, exact at full contact. Greenwood-Williamson: good at small loads only."""
    full = fp.full_contact(medium, ROUGH)
    contact = fp.rough_contact(medium, ROUGH, pressure=full.rms_pressure * np.array([0.004, 0.02, 0.1, 1.0, 2.5]))
    theories = fp.rough_theories(contact, medium, ROUGH)
    numerical = theories.area_fraction.values
    persson = theories.persson.values / numerical
    assert (np.diff(persson) > 0).all()
    assert 0.5 < persson[0] < 0.7
    assert persson[-1] == pytest.approx(1, abs=0.01)
    assert theories.greenwood_williamson.values[:2] == pytest.approx(numerical[:2], rel=0.03)
    assert theories.greenwood_williamson_gap.values[0] == pytest.approx(contact.mean_gap.values[0], rel=0.02)
    assert (theories.bearing_area.values[:3] > numerical[:3]).all()


def test_summits_of_known_bumps():
    """Paraboloids of known place, height and curvatures, off the cells; one at the border of a surface that repeats."""
    n, h = 64, 1e-8
    x = (np.arange(n) - (n - 1) / 2) * h
    bumps = [
        (-1.03e-7, 0.52e-7, 3e-9, 1e6, 2e6),
        (1.62e-7, -1.23e-7, 5e-9, 1.5e6, 1.5e6),
        (0.0, 3.15e-7, 4e-9, 1e6, 1e6),
    ]
    heights = np.full((n, n), -20e-9)
    for cx, cy, z, kx, ky in bumps:
        dy = (x[:, None] - cy + n * h / 2) % (n * h) - n * h / 2
        heights = np.maximum(heights, z - kx * (x - cx) ** 2 / 2 - ky * dy**2 / 2)
    found = fp.Topography(heights, h).summits()
    assert found.heights.size == 3
    for (cx, cy, z, kx, ky), i in zip(
        bumps, [np.argmin(np.abs(found.positions[:, 0] - bump[0])) for bump in bumps], strict=True
    ):
        assert found.positions[i] == pytest.approx((cx, cy), abs=1e-12)
        assert found.heights[i] + heights.mean() == pytest.approx(z, abs=1e-14)
        assert found.curvatures[i] == pytest.approx(sorted((kx, ky)), rel=1e-6)
    assert fp.Topography(heights, h, periodic=(True, False)).summits().heights.size == 2
    assert fp.Topography(np.zeros((8, 8)), h).summits().heights.size == 0


@pytest.mark.parametrize(
    ("spectrum", "error", "words"),
    [
        (fp.Topography(ROUGH.heights, 1e-8, periodic=False), ValueError, "ends"),
        (np.ones(3), TypeError, "pair"),
        ((np.array([1.0, 2.0]), np.ones(3)), ValueError, "2 wavenumbers and 3 densities"),
        ((np.array([2.0, 1.0]), np.ones(2)), ValueError, "ascending"),
        ((np.array([1.0, 2.0]), np.array([1.0, np.nan])), ValueError, "density"),
    ],
)
def test_refusals(spectrum, error, words):
    with pytest.raises(error, match=words):
        fp.full_contact(STEEL, spectrum)


def test_flat_surface_touches_as_a_whole():
    flat, body = fp.Topography(np.full((8, 8), 1e-9), 1e-8), fp.HalfSpace(1e9, 0.3)
    full = fp.full_contact(body, flat)
    assert full.area_fraction([0.0, 1.0]).tolist() == [0.0, 1.0]
    theories = fp.rough_theories(fp.rough_contact(body, flat, pressure=[0.0, 1e6]), body, flat)
    assert theories.persson.values.tolist() == [0.0, 1.0]
    for other in (None, fp.indent(body, fp.Sphere(1e-6), depth=1e-8)):
        with pytest.raises(TypeError, match="must be a result of rough_contact"):
            fp.rough_theories(other, body, flat)
    with pytest.raises(ValueError, match=r"pressure\[1\] = -1.0 must be finite and >= 0"):
        full.area_fraction([0.0, -1.0])
