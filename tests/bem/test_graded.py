"""Boundary elements on media graded in depth: a stiff coating that softens into its base, and power laws."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j1

from flatpunch import indenters, media
from flatpunch.bem import solve
from flatpunch.bem.operator.influence import influence_coefficients, love_coefficients
from flatpunch.bem.operator.radial import remainder_table, short_wave_remainder
from flatpunch.compliances import compliance
from flatpunch.contact import indent
from flatpunch.reference import elliptic, power_law
from support import exact_contacts as exact

BASE = media.HalfSpace(1e9, 0.3)
GRADED = {
    "coating that softens": media.Medium([media.GradedLayer(lambda z: 4e9 - 3e9 * z, 0.3, 1.0)], BASE),
    "coating that stiffens": media.Medium([media.GradedLayer(lambda z: 3e8 * np.exp(1.2 * z), 0.3, 1.0)], BASE),
    "soft layer on a rigid base": media.Medium(
        [media.GradedLayer(lambda z: 1e6 * (1 + z), 0.45, 1.0)], media.RigidBase()
    ),
}


@pytest.mark.parametrize("name", GRADED)
@pytest.mark.parametrize("beta", [0.3, 2.0])
def test_round_contact_on_a_graded_layer(name, beta):
    kernel = compliance(GRADED[name])
    assert kernel.tail != 0
    depth, force = exact.power_law_on_layer(kernel, beta, 2.0, 1e-3)
    step = solve(kernel, indenters.Paraboloid(500.0), depths=depth, grid=128)[0]
    h = step.grid.spacing
    assert step.converged
    # cells: second order as on constant layers; the punch matrix of graded surfaces leaves N^-2 of the edge, some 1e-4 of a
    assert step.force == pytest.approx(force, rel=0.3 * (h / beta) ** 2 + 2e-4)
    assert step.radius == pytest.approx(beta, abs=0.05 * h + 5e-4 * beta)


@pytest.mark.parametrize("ratio", [0.03, 0.2, 5.0, 30.0, 300.0])
@pytest.mark.parametrize("cells", [64, 192])
def test_rim_under_steep_gradings(ratio, cells):
    """The root law of the surface's own modulus ends where that has changed, above the base: up to 0.45 cells were lost."""
    layer = media.GradedLayer(media.LinearModulus(1e6, ratio * 1e6, 2.0), 0.3, 2.0)
    medium, tip = media.Medium([layer], media.HalfSpace(1e6 * ratio, 0.3)), indenters.Paraboloid(50.0)
    contact = indent(medium, tip, radius=1.5)
    step = solve(compliance(medium), tip, depths=contact.depth.values, grid=cells)[0]
    assert step.radius == pytest.approx(1.5, abs=0.12 * step.grid.spacing)
    assert np.abs(step.outline.contour - 1.5).max() < 0.5 * step.grid.spacing
    assert step.outline.error > np.abs(step.outline.contour - 1.5).max()


@pytest.mark.parametrize("name", GRADED)
@pytest.mark.parametrize("spacing", [0.08, 0.7, 3.0])
def test_cell_on_a_graded_layer(name, spacing):
    """Against quadrature over the cell of the Green's function, which the test below judges."""
    kernel = compliance(GRADED[name])
    g = influence_coefficients(kernel, spacing, (6, 6)) * np.pi * kernel.modulus
    half_space = love_coefficients((6, 6)) * spacing
    table = remainder_table(kernel, 1e-7 * spacing, 10 * spacing)
    for i, j in ((0, 0), (0, 1), (2, 1)):
        rest = cell_integral(table, spacing, i, j)
        assert g[i, j] == pytest.approx(half_space[i, j] + rest, abs=1e-8 * half_space[0, 0])


def cell_integral(radial, spacing: float, i: int, j: int) -> float:
    """Integral of a function of r over a cell; the central one in polar coordinates, with r = rim t^3 for its logarithm."""
    t, v = np.polynomial.legendre.leggauss(64)
    t, v = (t + 1) / 2, v / 2
    if i == j == 0:
        angle, weight = np.pi / 4 * t, np.pi / 4 * v
        rim = spacing / 2 / np.cos(angle)[:, None]
        return 8 * float(weight @ (radial(rim * t**3) * 3 * rim**2 * t**5) @ v)
    x, y = (j - 0.5 + t) * spacing, (i - 0.5 + t)[:, None] * spacing
    return spacing**2 * float(v @ radial(np.hypot(x, y)) @ v)


KERNELS = {
    **GRADED,
    "bonded incompressible": media.Medium([media.Layer(1.0, 0.5, 1.0)], media.RigidBase()),
    "stiff film": media.Medium([media.Layer(1.0, 0.3, 1.0)], media.HalfSpace(0.01, 0.4)),
}


@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("a", [0.1, 1.0, 20.0])
def test_uniformly_loaded_disc_against_hankel_quadrature(name, a):
    """Middle of a disc: int R 2 pi r dr from the table of the coefficients, against int 2 pi a (L - 1)/k J1(ka) dk."""
    kernel = compliance(KERNELS[name])
    table = remainder_table(kernel, 1e-7 * a, 2 * a)
    found = 2 * np.pi * quad(lambda r: float(table(np.array([r]))[0]) * r, 0, a, epsabs=0, epsrel=1e-11, limit=200)[0]
    # beyond 2000 what is left of L - 1 without its logarithm, O(kappa^-2), weighs below 1e-10
    edges = np.concatenate([[0.0], np.geomspace(1e-7, 1.0, 25), np.arange(1.4, 2000.0, 0.4)])
    t, v = np.polynomial.legendre.leggauss(12)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    k, w = (middle + half * t).ravel(), (half * v).ravel()
    # the logarithm: tail (1 - exp(-kappa))/kappa belongs to R(r) = tail asinh(1/r)
    without = short_wave_remainder(kernel, k) + kernel.tail * np.expm1(-k) / k
    rest = 2 * np.pi * a * float(np.sum(w * without / k * j1(k * a)))
    logarithm = 2 * np.pi * kernel.tail * quad(lambda r: np.arcsinh(1 / r) * r, 0, a, epsrel=1e-12)[0]
    # 2 pi a: the same disc on a half-space
    assert found == pytest.approx(rest + logarithm, abs=1e-8 * 2 * np.pi * a)


@pytest.mark.parametrize("exponent", [-0.3, 0.4])
@pytest.mark.parametrize("ratio", [3.0, 10.0])
def test_elongated_ellipse_on_a_power_law_half_space(exponent, ratio):
    medium = media.PowerLawHalfSpace(modulus=1e9, depth=1e-6, exponent=exponent, poisson=0.3)
    constant = power_law.stiffness_constant(1e9, 1e-6, exponent, 0.3)
    reference = elliptic.elliptic_paraboloid(5e5, 5e5 * ratio, constant, depth=1e-8, exponent=exponent)
    step = solve(compliance(medium), indenters.EllipticParaboloid(5e5, 5e5 * ratio), depths=1e-8, grid=128)[0]
    b = min(reference.half_axis_x, reference.half_axis_y)
    # second order in the cells across
    assert step.force == pytest.approx(reference.force, rel=0.2 * (step.grid.spacing / b) ** 2)
    axes = sorted((reference.half_axis_x, reference.half_axis_y), reverse=True)
    assert step.outline.half_axes == pytest.approx(axes, abs=(0.4 if exponent < 0 else 0.1) * step.grid.spacing)
