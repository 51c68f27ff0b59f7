"""Grids: their own checks, the automatic choice, and the error of a contact that does not fit."""

import re

import numpy as np
import pytest

from flatpunch import indenters, media
from flatpunch.bem import ContactTouchesEdge, Grid, required_bytes, solve
from flatpunch.bem.bounding_box import Extent, _settled, find_extent
from flatpunch.bem.grid import IndenterHeight
from flatpunch.compliances import compliance

HALF_SPACE = compliance(media.HalfSpace(1e9, 0.3))
SOFT_THIN = compliance(media.Medium([media.Layer(1e6, 0.5, 1e-7)], media.RigidBase()))


def test_grid_coordinates():
    grid = Grid(8, 10, 0.5, center=(1.0, -1.0))
    assert grid.shape == (10, 8)
    assert grid.x[0] == pytest.approx(1.0 - 3.5 * 0.5)
    assert grid.y.mean() == pytest.approx(-1.0)
    r, phi = grid.polar
    np.testing.assert_allclose(r * np.cos(phi), np.broadcast_to(grid.x, (10, 8)), atol=1e-14)
    assert phi.min() >= 0
    assert phi.max() < 2 * np.pi


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((4, 8, 1.0), r"Grid.nx = 4 must be a whole number of at least 8"),
        ((8, 8.5, 1.0), r"Grid.ny = 8.5"),
        ((float("nan"), 8, 1.0), r"Grid.nx = nan must be a whole number of at least 8"),
        ((8, 8, -1.0), r"Grid.spacing = -1.0 must be finite and > 0"),
    ],
)
def test_grid_checks(arguments, message):
    with pytest.raises(ValueError, match=message):
        Grid(*arguments)


def test_grid_around_an_elongated_contact():
    grid = Grid.around((4.0, 1.0), 128)
    assert grid.nx * grid.spacing >= 2 * 4.0 * 1.2
    assert grid.ny * grid.spacing >= 2 * 1.0 * 1.2
    assert 0.9 * 128**2 < grid.nx * grid.ny < 1.15 * 128**2


def test_memory_is_announced(caplog):
    with caplog.at_level("INFO", logger="flatpunch.bem"):
        solve(HALF_SPACE, indenters.Paraboloid(1.0), depths=1e-3, grid=Grid(64, 64, 1.5e-3))
    assert "64 x 64 cells" in caplog.text
    assert required_bytes(Grid(64, 64, 1.0)) == 200 * 64**2
    assert required_bytes(Grid(64, 64, 1.0), single=True) == 100 * 64**2


@pytest.mark.parametrize("kernel", [HALF_SPACE, SOFT_THIN], ids=["half-space", "thin layer"])
@pytest.mark.parametrize(
    "indenter", [indenters.Paraboloid(1e-6), indenters.Pyramid(3, 0.3), indenters.EllipticParaboloid(1e6, 3e7)]
)
@pytest.mark.parametrize("prescribed", [{"depths": 3e-9}, {"forces": 1e-8}], ids=["depth", "force"])
def test_fitted_grid_is_filled(kernel, indenter, prescribed):
    step = solve(kernel, indenter, grid=64, tolerance=1e-4, **prescribed)[0]
    assert step.converged
    rows, columns = np.flatnonzero(step.contact.any(axis=1)), np.flatnonzero(step.contact.any(axis=0))
    for used, cells in ((rows, step.grid.ny), (columns, step.grid.nx)):
        assert used[0] >= 2
        assert used[-1] <= cells - 3
        # the grid is centred on the tip, which is not the middle of a three-sided contact
        assert used.size > 0.4 * cells


def test_wrong_hint_costs_nothing_but_time():
    fitted = solve(HALF_SPACE, indenters.Paraboloid(1.0), depths=1e-3, grid=64)[0]
    for width in (1e-4, 10.0):
        step = solve(HALF_SPACE, indenters.Paraboloid(1.0), depths=1e-3, grid=64, half_widths=[(width, width)])[0]
        # grids differ a little: Hertz at 64 cells is good to 1e-4
        assert step.force == pytest.approx(fitted.force, rel=2e-4)


def test_contact_off_the_grid_says_how_large_it_must_be():
    grid = Grid(40, 40, 1e-3)
    with pytest.raises(ContactTouchesEdge, match="touches the edge of the grid") as failure:
        solve(HALF_SPACE, indenters.Paraboloid(1.0), depths=2e-3, grid=grid)
    nx, ny = (int(n) for n in re.search(r"(\d+) x (\d+) cells of this size", str(failure.value)).groups())
    assert nx * grid.spacing > 2 * np.sqrt(2e-3)
    step = solve(HALF_SPACE, indenters.Paraboloid(1.0), depths=2e-3, grid=Grid(nx, ny, grid.spacing))[0]
    assert step.converged


@pytest.mark.long
@pytest.mark.parametrize("depth", [1e-7, 1e-6, 5e-6])
def test_narrow_lobe_of_a_contact_gets_a_grid(depth):
    """A Knoop tip on a film 50 times stiffer than its base: at depth 1e-6 the contact is 21 um long and 0.1 um wide."""
    kernel = compliance(media.Medium([media.Layer(50e9, 0.3, 1e-6)], media.HalfSpace(1e9, 0.3)))
    step = solve(kernel, indenters.Knoop(), depths=depth, grid=96, tolerance=1e-5)[0]
    assert step.converged
    along, across = step.contact.any(axis=0).sum(), step.contact.any(axis=1).sum()
    assert along > 10 * across
    assert along > 0.5 * step.grid.nx
    assert across <= step.grid.ny - 2


def test_a_chosen_grid_grows_where_the_contact_needs_it(monkeypatch):
    """The box is found on coarse cells; were it too small along one axis, the grid grows along that one alone."""
    from flatpunch.bem import curves
    from flatpunch.bem.bounding_box import Extent

    tip, small = indenters.EllipticParaboloid(0.5, 2.0), Extent((1.2e-2, 2.2e-2), (0.0, 0.0))
    right = solve(HALF_SPACE, tip, depths=1e-3, grid=96)[0]
    monkeypatch.setattr(curves, "find_extent", lambda *_, **__: small)
    step = solve(HALF_SPACE, tip, depths=1e-3, grid=64)[0]
    assert step.converged
    assert not step.contact[:, [0, -1]].any()
    assert step.grid.nx > 1.5 * small.grid(64).nx
    assert step.grid.ny == small.grid(64).ny
    # 64 cells on a narrow ellipse: 2e-4
    assert step.force == pytest.approx(right.force, rel=5e-4)


@pytest.mark.long
@pytest.mark.parametrize(
    ("ratio", "depth", "force"), [(60.0, 1.430679, 17.0399), (100.0, 1.23353, 14.152), (100.0, 0.9, 8.464)]
)
def test_box_of_a_lobe_one_cell_wide_is_found(ratio, depth, force):
    """Its width jumps between one and two cells, however close the grid comes; forces of 512 cells, extrapolated."""
    kernel = compliance(media.Medium([media.Layer(ratio, 0.3, 1.0)], media.HalfSpace(1.0, 0.3)))
    step = solve(kernel, indenters.Knoop(), depths=depth, grid=128, tolerance=1e-5)[0]
    assert step.converged
    assert step.force == pytest.approx(force, rel=2e-3)


def test_a_known_box_is_taken_as_it_is(monkeypatch):
    from flatpunch.bem import curves

    tip = indenters.Pyramid(3, 0.3)
    found = solve(HALF_SPACE, tip, depths=1e-6, grid=96)[0]
    x, y = (places[found.contact.any(axis=axis)] for places, axis in ((found.grid.x, 0), (found.grid.y, 1)))
    box = {"half_widths": (np.ptp(x) / 2, np.ptp(y) / 2), "centers": ((x[0] + x[-1]) / 2, 0.0)}

    def refuse(*_, **__):
        raise AssertionError("the box was looked for")

    with monkeypatch.context() as refusing:
        refusing.setattr(curves, "find_extent", refuse)
        step = solve(HALF_SPACE, tip, depths=1e-6, grid=96, search=False, **box)[0]
    assert step.force == pytest.approx(found.force, rel=1e-3)
    # a contact of three points reaches farther to one side
    assert step.grid.center[0] < -0.2 * step.radius
    # where it is too small, the contact is looked for: a grid that grew would have cells as fine, and many
    for share in (0.7, 0.2):
        small = (share * box["half_widths"][0], box["half_widths"][1])
        wider = solve(HALF_SPACE, tip, depths=1e-6, grid=96, search=False, **box | {"half_widths": small})[0]
        assert not wider.contact[:, [0, -1]].any()
        assert wider.force == pytest.approx(found.force, rel=1e-3)
        assert wider.grid.nx * wider.grid.ny < 1.2 * 96**2


@pytest.mark.parametrize("sides", [3, 4])
def test_the_contact_that_told_the_box_takes_the_place_of_the_coarsest_level(sides):
    """It has more cells than that level; the finest one still has its next coarser one, from which its error is estimated."""
    tip, options = indenters.Pyramid(sides, 0.3), {"depths": 1e-7, "grid": 256, "tolerance": 1e-8}
    [searched] = solve(HALF_SPACE, tip, **options)
    extent = find_extent(HALF_SPACE, IndenterHeight(tip), Extent((1e-6, 1e-6), (0.0, 0.0)), depth=1e-7)
    [told] = solve(HALF_SPACE, tip, half_widths=extent.half_widths, centers=extent.center, search=False, **options)
    assert len(searched.iterations) == len(told.iterations) - 1 == 3
    # both have a gap error of 1e-8; boxes from other first looks are as wide to a twentieth, and so are their cells
    assert searched.force == pytest.approx(told.force, rel=5e-5)
    assert searched.coarser_force == pytest.approx(told.coarser_force, rel=2e-4)
    [small] = solve(HALF_SPACE, tip, depths=1e-7, grid=64, tolerance=1e-8)
    assert np.isfinite(small.coarser_force)


def test_boxes_are_accepted_once_finer_grids_change_them_by_less_than_a_cell_or_a_tenth():
    before = Extent((1.0, 0.01), (0.0, 0.0))
    assert _settled(before, Extent((1.09, 0.015), (0.0, 0.0)), spacing=0.01)
    assert not _settled(before, Extent((1.2, 0.015), (0.0, 0.0)), spacing=0.01)
    assert not _settled(before, Extent((1.0, 0.03), (0.0, 0.0)), spacing=0.01)
