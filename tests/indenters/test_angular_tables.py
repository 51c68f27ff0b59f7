"""Means and harmonics over the polar angle, of tips with kinks that circles about the apex cross."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.indenters import Rounded, Truncated
from flatpunch.indenters.geometry.angles import AngularHarmonics, AngularRule, GeometricMean, angular_mean
from flatpunch.indenters.geometry.features import different_rays

CROSSED = {
    "rounded": Rounded(fp.Pyramid(3, 0.5), 0.2, true_sphere=False),
    "rounded by a sphere": Rounded(fp.Pyramid(4, 0.5), 0.2, true_sphere=True),
    "rounded, irregular": fp.AfmPyramid(0.3, 0.4, 0.35, tip_radius=0.1),
    "truncated": Truncated(fp.Pyramid(3, 0.35), 0.03),
    "truncated, seven sides": Truncated(fp.Pyramid(7, 0.35), 0.03),
    "truncated ellipse": Truncated(fp.EllipticParaboloid(0.2, 1.0), 0.02),
    "truncated superellipse": Truncated(fp.Superellipse(1.0, 0.8, 0.3, 4.0, 2.0), 0.02),
    "truncated rounded": Truncated(Rounded(fp.Pyramid(4, 0.5), 0.2, true_sphere=False), 0.06),
}
crossed = pytest.mark.parametrize("tip", CROSSED.values(), ids=CROSSED)
MANY = 2 * np.pi * (np.arange(200_000) + 0.5) / 200_000


def radii(tip):
    """Below, between and beyond the rings, and close by."""
    first, last = tip.rings[0], tip.rings[-1]
    between = first + (last - first) * np.array([1e-6, 0.01, 0.3, 0.7, 0.99])
    return np.array([0.6 * first, *between, 1.01 * last, 3 * last, 30 * last])


@crossed
def test_crossings_are_kinks(tip):
    r = np.linspace(tip.rings[0], 1.5 * tip.rings[-1], 41)[1:]
    found = tip.crossings(r)
    assert np.isfinite(found).any()
    rows, columns = np.nonzero(np.isfinite(found))
    r, phi, step = r[rows], found[rows, columns], 1e-6 * np.arange(-3, 4)[:, None]
    f = tip.height(r, phi + step)
    first, second = np.diff(f, axis=0) / 1e-6, np.diff(f, 2, axis=0) / 1e-12
    jumps = np.abs(first[3] - first[2]) > 1e-4 * np.abs(first).max(axis=0)
    bends = np.abs(second[4] - second[0]) > 1e-2 * np.abs(second).max(axis=0)
    # lines that are no border here, because others lie above them, cost nothing
    assert np.mean(jumps | bends) > (0.9 if isinstance(tip, Truncated) else 0.3)


@crossed
def test_means_are_exact_where_kinks_are_crossed(tip):
    r = radii(tip)
    phi, weights = zip(*(AngularRule(tip).at(r[[i]]) for i in range(r.size)), strict=True)
    height, slope = (
        np.array([float(np.sum(of(r[[i]][:, None], phi[i]) * weights[i])) for i in range(r.size)])
        for of in (tip.height, tip.slope)
    )
    dense = tip.height(r[:, None], MANY).mean(axis=1), tip.slope(r[:, None], MANY).mean(axis=1)
    np.testing.assert_allclose(height, dense[0], rtol=1e-9, atol=1e-12)
    # which counts whole angles on either side of the border of a flat
    np.testing.assert_allclose(slope, dense[1], atol=1e-4 * dense[1].max())
    np.testing.assert_allclose(angular_mean(tip).height(r), height, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(angular_mean(tip).slope(r), slope, rtol=1e-7, atol=1e-9)


@crossed
def test_mean_slopes_are_the_slopes_of_mean_heights(tip):
    mean, r = angular_mean(tip), np.linspace(0.9 * tip.rings[0], 2 * tip.rings[-1], 57)
    step = 1e-5 * r
    numerical = (mean.height(r + step) - mean.height(r - step)) / (2 * step)
    np.testing.assert_allclose(mean.slope(r), numerical, atol=1e-6 * mean.slope(r).max())


def test_geometric_mean():
    tip = CROSSED["rounded"]
    mean, r = GeometricMean(tip), radii(tip)
    f, slope = tip.height(r[:, None], MANY), tip.slope(r[:, None], MANY)
    direct = np.exp(np.log(f).mean(axis=1))
    np.testing.assert_allclose(mean.height(r), direct, rtol=1e-9)
    np.testing.assert_allclose(mean.slope(r), direct * (slope / f).mean(axis=1), rtol=1e-7)


SMOOTH = {"smooth": fp.Ellipsoid(1.3, 1.6, 2.0)}
# within the border of a flat f is zero and has no logarithm
WITH_LOGARITHM = {name: tip for name, tip in (CROSSED | SMOOTH).items() if not isinstance(tip, Truncated)}
HARMONICS = {name: (tip, False) for name, tip in (CROSSED | SMOOTH).items()}
HARMONICS |= {f"logarithm, {name}": (tip, True) for name, tip in WITH_LOGARITHM.items()}


@pytest.mark.long
@pytest.mark.parametrize(("tip", "logarithmic"), HARMONICS.values(), ids=HARMONICS)
def test_harmonics(tip, logarithmic):
    table = AngularHarmonics(tip, 24, logarithmic=logarithmic)
    r = radii(tip) if tip.rings else np.array([0.01, 0.3, 1.0])
    f, slope = tip.height(r[:, None], table.start + MANY), tip.slope(r[:, None], table.start + MANY)
    if logarithmic:
        f, slope = np.log(f), slope / f
    alone = [table.harmonics(r[[i]]) for i in range(r.size)]
    # from here on from polynomials over the radius
    table.at(np.geomspace(r[0], r[-1], 2000))
    # high orders turn many times between two rings, and slopes jump across the border of a flat, which counts whole angles
    for which, field, exactly, allowed in ((0, f, 5e-11, 1e-7), (1, slope, 2e-5, 2e-5)):
        expected = 2 * field @ np.exp(-1j * np.outer(MANY, table.orders)) / MANY.size
        scale = np.abs(field[-3:]).max()
        by_themselves = np.vstack([both[which] for both in alone]).view(complex)
        assert np.abs(by_themselves - expected).max() < exactly * scale
        assert np.abs(table.harmonics(r)[which].view(complex) - expected).max() < allowed * scale


def test_rays_that_symmetry_carries_into_each_other():
    tip, phi = fp.Pyramid(3, 0.4), np.linspace(0, 2 * np.pi, 360, endpoint=False)
    rays, which = different_rays(tip, phi)
    assert rays.size == 61
    np.testing.assert_allclose(tip.height(np.ones(1), rays[which]), tip.height(np.ones(1), phi), rtol=1e-12)
    lopsided = fp.AfmPyramid(0.3, 0.4, 0.35)
    rays, which = different_rays(lopsided, phi)
    np.testing.assert_allclose(lopsided.height(np.ones(1), rays[which]), lopsided.height(np.ones(1), phi), rtol=1e-12)
