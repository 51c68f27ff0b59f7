"""Flat-ended punches of any planform: the flat-punch solution by a second road."""

import warnings

import numpy as np
import pytest

from flatpunch import indenters, media
from flatpunch._support.checks import FlatpunchWarning
from flatpunch.bem import Grid, solve, solve_punch
from flatpunch.compliances import compliance
from flatpunch.punch import flat_punch

BODY = media.HalfSpace(1e9, 0.3)
HALF_SPACE = compliance(BODY)
MODULUS = 1e9 / 0.91


def extrapolated(cells: tuple[int, int, int], stiffness) -> float:
    """Limit of a first-order sequence whose next term is of second order, at halved spacings."""
    k1, k2, k4 = (stiffness(n) for n in cells)
    first, second = 2 * k2 - k1, 2 * k4 - k2
    return second + (second - first) / 3


def shape_factor(step) -> float:
    """K/(2 E* sqrt(A/pi)), 1 for a circle."""
    return step.stiffness / (2 * MODULUS * np.sqrt(step.contact.sum() * step.grid.cell_area / np.pi))


def test_square():
    """1.0212: sqrt(pi) pi/2 times the capacitance of the unit square, 0.3667892; boundary elements gave 1.02120."""

    def factor(n):
        # the square ends where cells end
        return shape_factor(solve_punch(HALF_SPACE, np.ones((n, n), dtype=bool), Grid(n, n, 1e-6 / n)))

    exact = np.pi * 0.3667892 / (2 / np.sqrt(np.pi))
    # edges of pressure s^(-1/2) and corners leave a series of h, h^1.4, ..: 2e-5 after two extrapolations
    assert extrapolated((32, 64, 128), factor) == pytest.approx(exact, rel=2e-5)
    assert exact == pytest.approx(1.0212, abs=5e-5)


def test_triangle():
    """1.0614 for the equilateral triangle, by boundary elements; 1.062 in the literature (Woirgard)."""

    def planform(x, y):
        return (-y <= 1.0) & (y / 2 + np.sqrt(0.75) * np.abs(x) <= 1.0)

    factors = [shape_factor(solve_punch(HALF_SPACE, planform, Grid(n, n, 4.4 / n))) for n in (128, 256)]
    # first order; slanted edges are staircases, so that one extrapolation is all they allow
    assert 2 * factors[1] - factors[0] == pytest.approx(1.0614, rel=5e-4)


@pytest.mark.parametrize(
    "medium",
    [
        BODY,
        media.Medium([media.Layer(1e6, 0.5, 1.0)], media.RigidBase()),
        media.Medium([media.Layer(1e9, 0.3, 1.0)], media.HalfSpace(1e8, 0.3)),
    ],
    ids=["half-space", "incompressible layer", "stiff film"],
)
def test_round_punch_against_the_punch_matrix(medium):
    with warnings.catch_warnings():
        # under the stiff film a punch that sticks pulls in its middle; here both stick
        warnings.simplefilter("ignore", FlatpunchWarning)
        exact = flat_punch(medium, 1.5).stiffness
    kernel = compliance(medium)
    found = []
    for n in (80, 160, 320):
        step = solve_punch(kernel, lambda x, y: np.hypot(x, y) < 1.5, Grid(n, n, 3.2 / n), tolerance=1e-6)
        # a disc of cells has not quite the disc's area
        found.append(step.stiffness * np.sqrt(np.pi * 1.5**2 / (step.contact.sum() * step.grid.cell_area)))
    errors = np.abs(np.array(found) / exact - 1)
    # first order: edge pressures are singular; measured 0.1 h/a on a half-space, three times that on a thin soft layer
    assert errors[-1] < 0.5 * (3.2 / 320) / 1.5
    assert errors[-1] < 0.7 * errors[0]


def test_cylinder_is_a_punch():
    grid = Grid(96, 96, 2.2e-6 / 96)
    by_contact = solve(HALF_SPACE, indenters.Cylinder(1e-6), depths=1e-8, grid=grid)[0]
    by_mask = solve_punch(HALF_SPACE, by_contact.contact, grid, depth=1e-8)
    # the same linear problem, both to 1e-8
    assert by_contact.force == pytest.approx(by_mask.force, rel=1e-7)
    assert by_contact.outline.area == pytest.approx(by_mask.outline.area, rel=1e-12)


def test_punch_with_a_face_follows_it():
    """The face of a paraboloid on the disc of its own contact is the contact, whose pressure vanishes at the rim."""
    tip, depth = indenters.Paraboloid(1e-3), 1e-8
    grid = Grid(96, 96, 9e-6 / 96)
    contact = solve(HALF_SPACE, tip, depths=depth, grid=grid)[0]
    r, phi = grid.polar
    stuck = solve_punch(HALF_SPACE, contact.contact, grid, depth=depth, face=tip.height(r, phi))
    # both to 1e-8 of the depth
    np.testing.assert_allclose(stuck.pressure, contact.pressure, atol=1e-5 * contact.pressure.max())
    assert stuck.force == pytest.approx(contact.force, rel=1e-7)


def test_planform_is_checked():
    with pytest.raises(ValueError, match="planform has shape"):
        solve_punch(HALF_SPACE, np.ones((4, 4), dtype=bool), Grid(8, 8, 1.0))
    with pytest.raises(ValueError, match="holds no cell"):
        solve_punch(HALF_SPACE, lambda x, y: x > 1e3 + 0 * y, Grid(8, 8, 1.0))
