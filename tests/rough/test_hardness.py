"""Rough contact whose pressure ends at a hardness: bounded least squares, limits, and what is refused."""

import numpy as np
import pytest
import scipy.optimize

import flatpunch as fp

HALF_SPACE = fp.HalfSpace(1.0, 0.3)
COATED = fp.Medium([fp.Layer(20.0, 0.25, 1.0)], base=HALF_SPACE)
ROUGH = fp.self_affine(16, 1.0, rms_slope=0.3, cut_off=4.0)


def operator_of(body, surface):
    """Displacement of every cell from the pressure of every other one; the mean is free at given force."""
    n = surface.shape[0]
    q = 2 * np.pi * np.fft.fftfreq(n, surface.spacing)
    k = np.hypot(q[:, None], q)
    spectrum = np.zeros((n, n))
    spectrum[k > 0] = fp.compliance(body)(k[k > 0])
    spectrum[0, 0] = spectrum.max()
    kernel = np.fft.ifft2(spectrum).real
    rows = [np.roll(kernel, (i, j), (0, 1)).ravel() for i in range(n) for j in range(n)]
    return np.array(rows)


@pytest.mark.parametrize("body", [HALF_SPACE, COATED], ids=["half-space", "coated"])
@pytest.mark.parametrize("share", [pytest.param(0.05, marks=pytest.mark.long), 0.6])
def test_pressures_are_those_of_bounded_least_squares(body, share):
    """The least of p (u/2 + f - d) under 0 <= p <= H, for the depth that carries the force."""
    hardness = 0.25 * float(fp.rough_contact(body, ROUGH, pressure=0.05).max_pressure[0])
    found = fp.rough_contact(body, ROUGH, pressure=share * hardness, hardness=hardness, fields=True, tolerance=1e-9)
    assert found.valid.all()
    assert 0 < found.plastic_fraction.values[0] <= found.area_fraction.values[0]
    matrix = operator_of(body, ROUGH)
    root, height = np.linalg.cholesky(matrix).T, (ROUGH.heights.max() - ROUGH.heights).ravel()

    def pressure(depth):
        wanted = np.linalg.solve(root.T, depth - height)
        return scipy.optimize.lsq_linear(root, wanted, (0.0, hardness), method="bvls", tol=1e-15).x

    depth = scipy.optimize.brentq(lambda d: pressure(d).mean() / (share * hardness) - 1, 0.0, 40.0, xtol=1e-12)
    assert np.abs(found.pressure.values[0].ravel() - pressure(depth)).max() < 1e-6 * hardness


def test_a_hardness_that_is_not_reached_changes_nothing():
    elastic, hard = (fp.rough_contact(COATED, ROUGH, pressure=[0.0, 0.02], hardness=each) for each in (None, 1e3))
    assert all(np.array_equal(elastic[name], hard[name], equal_nan=True) for name in elastic)


def test_a_small_hardness_carries_the_load_alone():
    """Force over area tends to the hardness."""
    found = fp.rough_contact(HALF_SPACE, fp.self_affine(64, 1.0, rms_slope=0.3), pressure=[2e-6, 9e-6], hardness=1e-5)
    assert found.area_fraction.values == pytest.approx([0.2, 0.9], rel=0.01)
    assert found.plastic_fraction.values == pytest.approx([0.2, 0.9], rel=0.01)
    assert found.max_pressure.values == pytest.approx([1e-5, 1e-5])
    assert found.valid.all()


def test_stiffness_is_that_of_further_loading():
    body = fp.Medium([fp.Layer(1.0, 0.3, 2.0)], base=fp.RigidBase())
    depth = np.array([0.99999, 1.0, 1.00001])
    free = fp.Topography(ROUGH.heights, 1.0)
    elastic = fp.rough_contact(body, free, depth=depth)
    found = fp.rough_contact(body, free, depth=depth, hardness=0.3 * float(elastic.max_pressure[0]), tolerance=1e-9)
    assert found.plastic_fraction.values[1] > 0
    assert found.plastic_fraction.values[0] == found.plastic_fraction.values[2]
    slope = float(np.diff(found.force.values[::2])[0]) / 2e-5
    assert found.stiffness.values[1] == pytest.approx(slope, rel=1e-3)
    closing = -float(np.diff(found.mean_gap.values[::2])[0]) / 2e-5
    assert found.gap_stiffness.values[1] == pytest.approx(slope / closing, rel=1e-3)
    assert found.stiffness.values[1] < elastic.stiffness.values[1]


@pytest.mark.parametrize(
    ("hardness", "given", "says"),
    [
        (0.0, {"pressure": 0.1}, "hardness = 0"),
        (np.nan, {"pressure": 0.1}, "hardness = nan"),
        ("soft", {"pressure": 0.1}, "hardness"),
        (0.1, {"pressure": [0.05, 0.1]}, "hardness = 100 mPa must be above the mean pressure, 100 mPa"),
        (0.1, {"force": 1e3}, "hardness"),
    ],
)
def test_bad_hardnesses_are_refused(hardness, given, says):
    with pytest.raises((ValueError, TypeError), match=says):
        fp.rough_contact(HALF_SPACE, ROUGH, hardness=hardness, **given)
