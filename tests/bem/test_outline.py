"""Outline of known pressures, to a fraction of a cell."""

import numpy as np
import pytest

from flatpunch import indenters, media
from flatpunch.bem import Grid, solve, trace_outline
from flatpunch.bem.outline import EXCESS, covered, ray_lengths, rim_along
from flatpunch.compliances import compliance

HALF_SPACE = compliance(media.HalfSpace(1e9, 0.3))


def hertzian(grid: Grid, a: float, b: float, turn: float = 0.0) -> np.ndarray:
    x = grid.x * np.cos(turn) + grid.y[:, None] * np.sin(turn)
    y = -grid.x * np.sin(turn) + grid.y[:, None] * np.cos(turn)
    return np.sqrt(np.maximum(1 - (x / a) ** 2 - (y / b) ** 2, 0.0))


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.2])
def test_ellipse_of_exact_pressure(turn):
    grid = Grid(200, 200, 0.015)
    outline = trace_outline(grid, hertzian(grid, 1.2, 0.8, turn), angles=180)
    angle = outline.phi - turn
    exact = 1 / np.sqrt((np.cos(angle) / 1.2) ** 2 + (np.sin(angle) / 0.8) ** 2)
    # p^2 is a parabola here; what is left is its linear interpolation between cells, worst where one of them lies outside
    assert np.abs(outline.contour - exact).max() < 0.07 * grid.spacing
    assert outline.half_axes == pytest.approx((1.2, 0.8), rel=1e-4)
    assert outline.area == pytest.approx(np.pi * 1.2 * 0.8, rel=2e-4)
    assert outline.eccentricity == pytest.approx(np.sqrt(1 - (0.8 / 1.2) ** 2), abs=1e-4)
    assert outline.note == ""


@pytest.mark.parametrize("half_width", [12.0, 16.0])
def test_rays_that_graze_the_rim(half_width):
    """Seen from a point near one end of a long ellipse, most rays do; of the staircase of cells 0.3 cells are left."""
    grid, turn, ahead = Grid(288, 288, 1.0), 0.3, 48.0
    x, y = grid.x + ahead * np.cos(turn), grid.y[:, None] + ahead * np.sin(turn)
    along, across = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    pressure = np.sqrt(np.maximum(1 - (along / 60) ** 2 - (across / half_width) ** 2, 0.0))
    outline = trace_outline(grid, pressure, angles=360)
    c, s = np.cos(outline.phi - turn), np.sin(outline.phi - turn)
    square, linear = (c / 60) ** 2 + (s / half_width) ** 2, ahead * c / 60**2
    exact = (np.sqrt(linear**2 + square * (1 - (ahead / 60) ** 2)) - linear) / square
    assert np.abs(outline.contour - exact).max() < 0.3
    assert np.abs(outline.contour - exact).max() < outline.error


def test_rays_that_leave_the_contact_and_meet_it_again():
    """A disc and a sector of a ring, joined by a bridge along its middle."""
    grid = Grid(500, 500, 0.014)
    r, phi = np.hypot(grid.x, grid.y[:, None]), np.arctan2(grid.y[:, None], grid.x)
    disc, sector = r < 1, (r > 2) & (r < 3) & (np.abs(phi) < 0.8)
    bridge = (grid.x > 0) & (grid.x < 2.1) & (np.abs(grid.y[:, None]) < 0.1)
    outline = trace_outline(grid, (disc | sector | bridge).astype(float), angles=720, sharp=True)
    across = np.arctan(0.1 / 1.5)
    assert outline.note == ""
    assert outline.contour[[0, 60, 360]] == pytest.approx([3.0, 3.0, 1.0], abs=0.02)
    assert outline.radius == pytest.approx(1 + (1.6 + 2 * across) / (2 * np.pi), rel=5e-3)
    parabola = trace_outline(grid, disc + sector + bridge.astype(float), angles=720)
    assert parabola.area == pytest.approx(np.pi + 0.8 * 5 + 0.2, rel=0.02)


def test_rim_of_solved_contacts_is_not_biased():
    offsets, scatter = [], []
    for a in np.linspace(0.9, 1.0, 5):
        step = solve(HALF_SPACE, indenters.Paraboloid(1.0), depths=a**2 * 1e-4, grid=Grid(96, 96, 2.6e-2 / 96))[0]
        error = (step.outline.contour - a * 1e-2) / step.grid.spacing
        offsets.append(error.mean())
        scatter.append(error.std())
    # cells: measured 0.00 +- 0.01 and 0.04
    assert abs(np.mean(offsets)) < 0.02
    assert max(scatter) < 0.06


def test_a_cell_wide_contact_is_flagged():
    grid = Grid(32, 32, 1.0)
    outline = trace_outline(grid, hertzian(grid, 3.0, 3.0))
    assert "Use more cells" in outline.note
    # and good to a cell all the same
    assert outline.radius == pytest.approx(3.0, abs=1.0)


def test_contact_away_from_the_first_touch():
    grid = Grid(32, 32, 1.0)
    pressure = np.zeros(grid.shape)
    pressure[4:9, 4:9] = 1.0
    outline = trace_outline(grid, pressure)
    assert "not in contact" in outline.note
    assert np.isnan(outline.contour).all()
    assert outline.area == 25.0
    assert "no contact" in trace_outline(grid, 0 * pressure).note


def test_first_touch_in_the_outermost_cell_in_contact():
    """It lies 0.002 cells beyond the centre of that cell: what lies next counts as little as that."""
    grid = Grid(33, 33, 1.0, center=(-0.002, 0.0))
    x, y = grid.x[None, :], grid.y[:, None]
    pressure = np.where(np.hypot(x + 4, y) < 4.3, 1.0, 0.0)
    assert pressure[16, 16] == 1
    assert pressure[16, 17] == 0
    outline = trace_outline(grid, pressure)
    assert np.isfinite(outline.contour).all()
    # four and a half cells the other way, and half a cell this way
    assert outline.contour[180] == pytest.approx(8.5, abs=0.5)
    assert outline.contour[0] == pytest.approx(0.5, abs=0.3)


@pytest.mark.parametrize("depth", [10.0, 30.0])
def test_rim_under_a_layer_few_cells_thick(depth):
    """Six cells in the thickness will do where the pressure still is root-like over four of them."""
    kernel = compliance(media.Medium([media.Layer(1.0, 0.3, 1.0, bonded=False)], base=media.RigidBase()))
    tip = indenters.EllipticParaboloid(0.2, 1.0)
    coarse, fine = (solve(kernel, tip, depths=depth, grid=grid, tolerance=1e-6)[0] for grid in (192, 768))
    h = coarse.grid.spacing
    assert 6 < 1 / h < 20
    off = (coarse.outline.contour - fine.outline.contour) / h
    assert np.abs(off).max() < 0.2
    assert abs(off.mean()) < 0.06


def test_a_line_as_thin_as_two_cells_between_wide_parts():
    """Along it the cells themselves determine where it ends."""
    grid = Grid(120, 120, 1.0)
    x, y = np.abs(grid.x), np.abs(grid.y[:, None])
    contact = ((y < 1) | ((y > 4) & (y < 12))) & (x < 45)
    contour, error = rim_along(grid, contact.astype(float), 2 * np.pi * np.arange(360) / 360, 0.5)
    assert np.all(np.isfinite(contour))
    # less the cells by which they reach too far
    assert contour[[0, 90]] == pytest.approx([45, 12], abs=0.2)
    assert (error > 0.1).all()


def test_share_of_cells_in_contact_is_that_of_the_area_inside_the_rim():
    """Of rings, whose rims reach as far as those of solved contacts: on average over rings neither length nor area is off."""
    grid = Grid(64, 64, 2.5 / 64)
    r, found = grid.polar[0], []
    for outer in np.linspace(0.9, 1.1, 101):
        share = covered((r < outer + EXCESS * grid.spacing) & (r > outer / 2 - EXCESS * grid.spacing))
        area, ray = share.sum() * grid.cell_area, np.sum(share * ray_lengths(grid))
        found.append((ray / (outer / 2), area / (0.75 * np.pi * outer**2)))
    np.testing.assert_allclose(np.mean(found, axis=0), 1.0, atol=1.5e-3)
