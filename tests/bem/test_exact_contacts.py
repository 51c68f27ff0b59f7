"""Boundary elements against exact contacts: half-spaces, layers, gradings; and the order in which they converge."""

import numpy as np
import pytest
from scipy.optimize import brentq

from flatpunch import indenters, media
from flatpunch.bem import Grid, solve
from flatpunch.compliances import compliance
from flatpunch.reference import elliptic, half_space, power_law
from support import exact_contacts as exact

MODULUS = 1e9 / (1 - 0.3**2)
HALF_SPACE = compliance(media.HalfSpace(1e9, 0.3))
RIGID = media.RigidBase()

# Outline: a root-like rim is found to 0.05 cells on average, the rim of the cells themselves to 0.2 (test_outline.py).
RIM = 0.05


def test_hertz():
    radius = 1e-6
    for step in solve(HALF_SPACE, indenters.Paraboloid(radius), depths=[1e-9, 2e-8], grid=128, stiffness=True):
        a = np.sqrt(radius * step.depth)
        contact = half_space.paraboloid(a, radius, MODULUS)
        assert step.converged
        # second order, 0.07 (h/a)^2 (test_convergence_order)
        assert step.force == pytest.approx(contact.force, rel=0.1 * (step.grid.spacing / a) ** 2)
        assert step.radius == pytest.approx(a, abs=RIM * step.grid.spacing)
        # the stiffness is that of a punch of these cells, first order
        assert step.stiffness == pytest.approx(2 * MODULUS * a, rel=0.1 * step.grid.spacing / a)
        middle = step.grid.polar[0] < 0.9 * a
        p = half_space.paraboloid_pressure(step.grid.polar[0][middle], a, radius, MODULUS)
        # the staircase of the rim is felt a few cells deep
        assert np.abs(step.pressure[middle] - p).max() < 1e-3 * p.max()


@pytest.mark.parametrize("eccentricity", [0.5, 0.8, 0.95])
def test_hertz_elliptic(eccentricity):
    A, B = curvatures(np.sqrt(1 - eccentricity**2))
    reference = elliptic.elliptic_paraboloid(A, B, MODULUS, depth=1e-8)
    step = solve(HALF_SPACE, indenters.EllipticParaboloid(A, B), depths=1e-8, grid=160)[0]
    b = min(reference.half_axis_x, reference.half_axis_y)
    assert step.force == pytest.approx(reference.force, rel=0.1 * (step.grid.spacing / b) ** 2)
    assert step.outline.half_axes[1] == pytest.approx(b, abs=RIM * step.grid.spacing)
    assert step.area == pytest.approx(reference.area, rel=4 * RIM * step.grid.spacing / b)
    # both axes are off by about the same share of a cell
    assert step.outline.eccentricity == pytest.approx(eccentricity, abs=5e-4)


def curvatures(ratio: float) -> tuple[float, float]:
    """A, B of an elliptic paraboloid whose Hertzian contact has this ratio of half-axes."""
    B = brentq(lambda B: elliptic.half_axes_ratio(1.0, B) - ratio, 1.0, 1e4, xtol=1e-13)
    return 5e5, 5e5 * B


def test_cone():
    step = solve(HALF_SPACE, indenters.Cone(0.2), depths=1e-8, grid=192)[0]
    a = 2 / np.pi * step.depth / np.tan(0.2)
    contact = half_space.cone(a, 0.2, MODULUS)
    # the tip's logarithm: h^2 log h
    assert step.force == pytest.approx(contact.force, rel=0.5 * (step.grid.spacing / a) ** 2)
    assert step.radius == pytest.approx(a, abs=RIM * step.grid.spacing)


@pytest.mark.parametrize("shape", ["paraboloid", "elliptic", "slender", "cone"])
def test_force_extrapolated_to_vanishing_cells(shape):
    """Its error is a third of that of the cells themselves at most."""
    if shape == "paraboloid":
        tip, exactly = indenters.Paraboloid(1e-6), half_space.paraboloid(1e-7, 1e-6, MODULUS).force
    elif shape == "cone":
        tip, exactly = indenters.Cone(0.2), half_space.cone(2e-8 / np.pi / np.tan(0.2), 0.2, MODULUS).force
    else:
        tip = indenters.EllipticParaboloid(5e5, 7.5e5 if shape == "elliptic" else 2.5e6)
        exactly = elliptic.elliptic_paraboloid(tip.A, tip.B, MODULUS, depth=1e-8).force
    step = solve(HALF_SPACE, tip, depths=1e-8, grid=256)[0]
    # 1.0e-6 and less found
    assert step.extrapolated_force == pytest.approx(exactly, rel=2e-6)
    assert abs(step.extrapolated_force / exactly - 1) < abs(step.force / exactly - 1) / 3


def test_extrapolated_force_of_a_pyramid():
    """With twice the cells it is the same to 1e-5; that of the cells themselves differs by more than three times as much."""
    soft, tip = compliance(media.HalfSpace(1.0, 0.0)), indenters.Pyramid(4, 0.1)
    rough, fine = (solve(soft, tip, depths=1.0, grid=grid)[0] for grid in (256, 512))
    assert rough.extrapolated_force == pytest.approx(fine.extrapolated_force, rel=1e-5)
    assert abs(rough.extrapolated_force - fine.extrapolated_force) < abs(rough.force - fine.extrapolated_force) / 3


def test_coarser_force_is_that_of_cells_twice_as_wide():
    soft, tip = compliance(media.HalfSpace(1.0, 0.0)), indenters.Pyramid(4, 0.1)
    fine, rough = (solve(soft, tip, depths=1.0, grid=grid, tolerance=1e-6)[0] for grid in (128, 64))
    assert fine.grid.spacing == pytest.approx(rough.grid.spacing / 2, rel=1e-12)
    # ten times the tolerance
    assert fine.coarser_force == pytest.approx(rough.force, rel=1e-5)
    # the force of coarser cells at this depth, though they have had another for it
    by_force = solve(soft, tip, forces=fine.force, grid=128, tolerance=1e-6)[0]
    assert by_force.coarser_force == pytest.approx(fine.coarser_force, rel=1e-4)
    # steps close together begin with the one before; the smallest grids have no coarser ones
    _, close = solve(soft, tip, depths=[1.0, 1.001], grid=64)
    (smallest,) = solve(soft, tip, depths=1.0, grid=24)
    for step in (close, smallest):
        assert np.isnan(step.coarser_force)
        assert step.extrapolated_force == step.force


LAYERS = {
    "bonded incompressible": ([media.Layer(1e6, 0.5, 1.0)], RIGID),
    "bonded compressible": ([media.Layer(1e6, 0.3, 1.0)], RIGID),
    "sliding incompressible": ([media.Layer(1e6, 0.5, 1.0, bonded=False)], RIGID),
    "film 10 times stiffer": ([media.Layer(1e9, 0.3, 1.0)], media.HalfSpace(1e8, 0.3)),
    "film 10 times softer": ([media.Layer(1e8, 0.4, 1.0)], media.HalfSpace(1e9, 0.2)),
}


@pytest.mark.parametrize("name", LAYERS)
@pytest.mark.parametrize("beta", [0.1, 1.0, 3.0, 10.0])
def test_paraboloid_on_layers(name, beta):
    layers, base = LAYERS[name]
    kernel = compliance(media.Medium(layers, base))
    depth, force = exact.power_law_on_layer(kernel, beta, 2.0, 1e-3)
    steps = [solve(kernel, indenters.Paraboloid(500.0), depths=depth, grid=cells)[0] for cells in (124, 128, 132)]
    step, h = steps[1], steps[1].grid.spacing
    assert step.converged
    # second order; thin incompressible layers weigh the rim like (a/layer)^2 more than a half-space
    assert step.force == pytest.approx(force, rel=(0.1 + 0.1 * min(beta, 3.0)) * (h / beta) ** 2 + 1e-8)
    # on average; one grid may have the rim 0.08 cells off
    assert np.mean([step.radius for step in steps]) == pytest.approx(beta, abs=RIM * h)


def test_cone_on_a_layer_by_force():
    kernel = compliance(media.Medium(*LAYERS["bonded incompressible"]))
    depth, force = exact.power_law_on_layer(kernel, 2.0, 1.0, np.tan(0.01))
    step = solve(kernel, indenters.Cone(0.01), forces=force, grid=160)[0]
    assert step.force == pytest.approx(force, rel=1e-8)
    # the punch matrix leaves 1e-5 for the kink of a cone at these terms; cells 0.5 (h/a)^2
    assert step.depth == pytest.approx(depth, rel=0.5 * (step.grid.spacing / 2) ** 2 + 1e-5)


@pytest.mark.parametrize("exponent", [-0.3, 0.3, 0.8])
def test_ellipse_on_a_power_law_half_space(exponent):
    medium = media.PowerLawHalfSpace(modulus=1e9, depth=1e-6, exponent=exponent, poisson=0.3)
    constant = power_law.stiffness_constant(1e9, 1e-6, exponent, 0.3)
    reference = elliptic.elliptic_paraboloid(5e5, 1.5e6, constant, depth=1e-8, exponent=exponent)
    step = solve(compliance(medium), indenters.EllipticParaboloid(5e5, 1.5e6), depths=1e-8, grid=128)[0]
    # 128 cells: second order, measured 1.5e-5 .. 4.4e-5
    assert step.force == pytest.approx(reference.force, rel=8e-5)
    # where pressure rises steeply from the rim (k < 0) the fit is poorer: within half a cell, else 0.05
    b = min(reference.half_axis_x, reference.half_axis_y)
    assert step.area == pytest.approx(reference.area, rel=(0.4 if exponent < 0 else 0.1) * step.grid.spacing / b)


def test_convergence_order():
    """Force converges with the square of the spacing.

    Within the contact the collocated mean over a cell is off by h^2/24 times the curvature of the pressure; near the rim,
    in a strip of a few cells, pressure ~ sqrt(h) and its relative error is of order one, but what that strip carries is
    h^(3/2), and as the force minimises an energy the error of the contact enters squared. So h^2, up to the luck with which
    a circle falls on the cells; four grids and a mean over three radii smooth that.
    """
    cells = np.array([32, 64, 128, 256])
    errors = []
    for n in cells:
        grid = Grid(int(n), int(n), 2.6e-7 / n)
        scatter = []
        for a in (0.96e-7, 0.98e-7, 1.0e-7):
            step = solve(HALF_SPACE, indenters.Paraboloid(1e-6), depths=a**2 / 1e-6, grid=grid)[0]
            scatter.append(abs(step.force / half_space.paraboloid(a, 1e-6, MODULUS).force - 1))
        errors.append(np.mean(scatter))
    order = -np.polyfit(np.log(cells), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.25)
    assert errors[-1] < 1.5e-5


def test_square_pyramid():
    """F = C E* d^2/tan(inclination), C = 0.73762 (boundary elements of another author, good to 1e-5)."""
    cells = np.array([128, 256])
    constants = []
    for n in cells:
        step = solve(HALF_SPACE, indenters.Pyramid(4, 0.1), depths=1e-8, grid=int(n))[0]
        constants.append(step.force * np.tan(0.1) / (MODULUS * 1e-16))
    # second order: extrapolate once
    assert constants[1] + (constants[1] - constants[0]) / 3 == pytest.approx(0.73762, rel=2e-5)
    # its outline: a0 = 0.6754, area 1.4802 (d/tan)^2, at 1024 cells
    assert step.radius == pytest.approx(0.6754 * 1e-8 / np.tan(0.1), rel=3e-3)
    assert step.area == pytest.approx(1.4802 * (1e-8 / np.tan(0.1)) ** 2, rel=1e-2)
