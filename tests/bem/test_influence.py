"""Influence coefficients against closed forms and against quadrature over the plane of wavenumbers."""

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.special import ellipe, ellipk, j0, j1

from flatpunch import media
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator.convolution import build_operator
from flatpunch.bem.operator.influence import influence_coefficients, love_coefficients, near_averages, near_rule
from flatpunch.bem.operator.radial import remainder_table
from flatpunch.compliances import Kernel, compliance

RIGID = media.RigidBase()


def image_kernel() -> Kernel:
    """L - 1 = -exp(-2 kappa): G = 1/r - 1/sqrt(r^2 + 4), with E* = 1/pi."""
    return Kernel(modulus=1 / np.pi, length=1.0, response=lambda kappa: 1 - np.exp(-2 * kappa))


def buried_coefficients(spacing: float, shape: tuple[int, int], z: float) -> np.ndarray:
    """int 1/sqrt(r^2 + z^2) over the cells: the potential of a charged rectangle."""
    y = (np.arange(-1, shape[0])[:, None] + 0.5) * spacing
    x = (np.arange(-1, shape[1])[None, :] + 0.5) * spacing
    r = np.sqrt(x**2 + y**2 + z**2)
    corner = x * np.arcsinh(y / np.hypot(x, z)) + y * np.arcsinh(x / np.hypot(y, z)) - z * np.arctan(x * y / (z * r))
    return corner[1:, 1:] - corner[:-1, 1:] - corner[1:, :-1] + corner[:-1, :-1]


def test_love_is_the_integral_of_one_over_r():
    g = love_coefficients((4, 5))
    assert g[0, 0] == pytest.approx(4 * np.arcsinh(1.0), rel=1e-15)
    for i, j in ((0, 1), (2, 0), (3, 4)):
        exact = dblquad(lambda y, x: 1 / np.hypot(x, y), j - 0.5, j + 0.5, i - 0.5, i + 0.5, epsabs=1e-13)[0]
        # differences of four corners of order 10: rounding
        assert g[i, j] == pytest.approx(exact, abs=1e-13)


def test_quadrature_over_cells_near_the_origin():
    rule = near_rule()
    # every cell is covered once
    np.testing.assert_allclose(np.bincount(rule.owner, rule.weight), 1.0, rtol=1e-12)
    inverse = near_averages(lambda r: 1 / r, 1.0)
    love, close = love_coefficients(inverse.shape), inverse > 0
    assert close.sum() > 0.7 * close.size
    # the smallest piece of the central cell is 1e-5 wide
    np.testing.assert_allclose(inverse[close], love[close], rtol=3e-6)
    np.testing.assert_allclose(inverse[close][1:], love[close][1:], rtol=1e-9)
    np.testing.assert_allclose(near_averages(lambda r: r**2, 0.5)[3, 4], 0.25 * (25 + 1 / 6), rtol=1e-13)


@pytest.mark.parametrize("spacing", [0.05, 1.0])
def test_whole_coefficients_are_those_of_an_image_charge(spacing):
    shape = (40, 30)
    g = influence_coefficients(image_kernel(), spacing, shape)
    exact = buried_coefficients(spacing, shape, 1e-12) - buried_coefficients(spacing, shape, 2.0)
    assert g.shape == shape
    assert np.abs(g - exact).max() < 1e-8 * exact[0, 0]


# from a thousandth of the layer to thirty times its thickness
@pytest.mark.parametrize("spacing", [1e-3, 0.05, 0.08, 0.09, 0.3, 1.0, 3.0, 10.0, 30.0])
def test_image_of_a_point_force(spacing):
    shape = (70, 200)
    g = influence_coefficients(image_kernel(), spacing, shape)
    exact = spacing * love_coefficients(shape) - buried_coefficients(spacing, shape, 2.0)
    # promised: 1e-8 of the diagonal of the medium itself, which is small when cells are wide
    assert np.abs(g - exact).max() < 1e-8 * exact[0, 0]


def test_logarithm_of_a_graded_surface():
    """L - 1 = (1 - exp(-kappa))/kappa has R(r) = asinh(1/r), a logarithm at r = 0."""
    kernel = Kernel(1 / np.pi, 1.0, lambda kappa: 1 - np.expm1(-kappa) / kappa, tail=1.0, cutoff=40.0)
    spacing = 0.3
    g = influence_coefficients(kernel, spacing, (40, 40)) - spacing * love_coefficients((40, 40))
    for i, j in ((0, 0), (0, 1), (1, 1), (7, 3), (17, 17), (30, 30)):
        # the central cell by a quarter, its singular corner where quadrature expects it
        i0, i1, j0_, j1_, share = (0, 0.5, 0, 0.5, 4) if i == j == 0 else (i - 0.5, i + 0.5, j - 0.5, j + 0.5, 1)
        exact = dblquad(
            lambda y, x: np.arcsinh(1 / np.hypot(x, y)),
            j0_ * spacing,
            j1_ * spacing,
            i0 * spacing,
            i1 * spacing,
            epsabs=1e-12,
        )[0]
        assert g[i, j] == pytest.approx(share * exact, abs=1e-8 * 4 * spacing)


def test_radial_table_over_seven_decades():
    table = remainder_table(image_kernel(), 1e-3, 1e4)
    r = np.geomspace(1e-3, 1e4, 5000)
    # interpolation through six neighbours leaves 1e-13 of r dR/dr; the rest is the window of the quadrature
    np.testing.assert_allclose(table(r), -1 / np.sqrt(r**2 + 4), rtol=2e-12)


MEDIA = {
    "bonded incompressible": media.Medium([media.Layer(1.0, 0.5, 1.0)], RIGID),
    "sliding on rigid": media.Medium([media.Layer(1.0, 0.3, 1.0, bonded=False)], RIGID),
    "stiff film": media.Medium([media.Layer(1.0, 0.3, 1.0)], media.HalfSpace(0.01, 0.4)),
    "three layers": media.Medium(
        [media.Layer(1.0, 0.3, 1.0), media.Layer(20.0, 0.2, 0.5), media.Layer(0.3, 0.45, 3.0)],
        media.HalfSpace(5.0, 0.3),
    ),
}


def displacement_of_a_cell(kernel: Kernel, spacing: float, x: float, y: float) -> float:
    """Part of u under a unit pressure on one cell that L - 1 brings, by quadrature over the plane of wavenumbers."""
    edges = np.concatenate([[0.0], np.geomspace(1e-7, 1.0, 25), np.arange(1.2, kernel.cutoff + 1, 0.2)])
    t, v = np.polynomial.legendre.leggauss(12)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    k, w = (middle + half * t).ravel(), (half * v).ravel()
    angle = (np.arange(512) + 0.5) * (np.pi / 2 / 512)
    kx, ky = k[:, None] * np.cos(angle), k[:, None] * np.sin(angle)
    c = 2 * kernel.remainder(k) / (kernel.modulus * k)
    wave = np.sinc(kx * spacing / (2 * np.pi)) * np.sinc(ky * spacing / (2 * np.pi)) * np.cos(kx * x) * np.cos(ky * y)
    return float(np.sum(w * k * c * wave.mean(axis=1)) * spacing**2 / (2 * np.pi))


@pytest.mark.parametrize("name", MEDIA)
@pytest.mark.parametrize("spacing", [0.05, 0.7, 4.0])
def test_layers_under_a_loaded_cell(name, spacing):
    kernel = compliance(MEDIA[name])
    g = influence_coefficients(kernel, spacing, (30, 30))
    half_space = love_coefficients((30, 30)) * spacing / (np.pi * kernel.modulus)
    # the quadrature of this test resolves waves of k x up to about 500
    for i, j in ((0, 0), (0, 1), (2, 2), (5, 3) if spacing < 1 else (1, 2)):
        exact = half_space[i, j] + displacement_of_a_cell(kernel, spacing, j * spacing, i * spacing)
        assert g[i, j] == pytest.approx(exact, abs=1e-8 * half_space[0, 0])


def test_uniformly_loaded_disc():
    """Displacement inside and outside a disc of cells against int C(k) a J1(ka) J0(kr) dk."""
    kernel = compliance(MEDIA["stiff film"])
    a, n = 2.0, 160
    grid = Grid(n, n, 3 * a / n)
    fine = Grid(8 * n, 8 * n, grid.spacing / 8)
    share = (np.hypot(fine.x, fine.y[:, None]) < a).reshape(n, 8, n, 8).mean(axis=(1, 3))
    share *= np.pi * a**2 / (share.sum() * grid.cell_area)
    u = build_operator(kernel, grid).apply(share) * grid.spacing / kernel.modulus
    edges = np.concatenate([[0.0], np.geomspace(1e-7, 1.0, 25), np.arange(1.5, kernel.cutoff + 1, 0.5)])
    t, v = np.polynomial.legendre.leggauss(16)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    k, w = (middle + half * t).ravel(), (half * v).ravel()
    for column in (n // 2, n // 2 + 20, n - 5):
        r = float(np.hypot(grid.x[column], grid.y[n // 2]))
        rest = float(np.sum(w * 2 * kernel.remainder(k) / (kernel.modulus * k) * a * j1(k * a) * j0(k * r)))
        exact = rest + half_space_disc(r, a) / kernel.modulus
        # the rim's load is smeared over its cells, which shifts its second moment by (h/a)^2/12 = 3e-5
        assert u[n // 2, column] == pytest.approx(exact, rel=4e-5)


def half_space_disc(r: float, a: float) -> float:
    """u E* under a unit pressure on a disc of a half-space (Johnson 1985, 3.29)."""
    if r <= a:
        return 4 * a / np.pi * ellipe((r / a) ** 2)
    m = (a / r) ** 2
    return 4 * r / np.pi * (ellipe(m) - (1 - m) * ellipk(m))


@pytest.mark.parametrize("thickness", [1e-6, 1e-8, 1e-12, 1e-30])
def test_what_is_far_thinner_than_the_cells_leaves_what_is_below(thickness):
    """Of thin films and tense surfaces: 3e-7, beside the first cell."""
    base = media.HalfSpace(1.0, 0.5)
    alone = influence_coefficients(compliance(base), 1.0, (40, 40))
    for body in (
        media.Medium([media.Layer(0.1, 0.5, thickness)], base),
        media.Medium([media.Layer(10.0, 0.5, thickness)], base),
        media.Medium([], base, media.Membrane(tension=thickness)),
    ):
        found = influence_coefficients(compliance(body, membrane=True), 1.0, (40, 40)) / alone
        assert found[0, 1:] == pytest.approx(1.0, abs=1e-6)
        # the table ends at 1e-5 cells from the centre
        assert found[0, 0] == pytest.approx(1.0, abs=1e-4)
