"""A closer look at a part of a contact."""

from __future__ import annotations

import numpy as np
import pytest
from flatpunch.contact.boundary_elements.outlines.zoom import Patch, look_closer

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliance import compliance

HALF_SPACE = compliance(fp.HalfSpace(1.0, 0.3))
FILM = compliance(fp.Medium([fp.Layer(20.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)))


def _whole(solution: bem.Solution) -> Patch:
    return Patch(solution.grid, 0.0, solution.pressure, solution.displacement)


@pytest.mark.parametrize("angle", [0.0, 0.7, 4.0])
def test_pressure_of_hertz_on_finer_cells_at_any_angle(angle: float) -> None:
    ball = fp.Paraboloid(1.0)
    solution = bem.solve(HALF_SPACE, ball, depths=1.0, grid=96)[0]
    window = bem.Grid(120, 80, solution.grid.spacing / 4, (0.85, 0.1))
    closer = look_closer(HALF_SPACE, ball, 1.0, _whole(solution), window, angle)
    exact = 2 / np.pi * HALF_SPACE.modulus * np.sqrt(np.maximum(1 - window.polar[0] ** 2, 0.0))
    # away from the border of the window, where the other cells stand still
    inner = (slice(20, -20), slice(20, -20))
    off = np.abs(closer.pressure - exact)[inner]
    assert off.max() < 0.03 * exact.max()
    assert np.mean(off) < 1e-3 * exact.max()
    # the rim is known to a quarter of the coarse cells
    assert np.mean((closer.pressure > 0) != (exact > 0)) < 0.02
    # and nothing is left of the gap
    gap = closer.displacement + ball.height(*window.polar) - 1.0
    assert np.abs(gap[closer.pressure > 0]).max() < 2e-4
    assert gap.min() > -2e-4


def test_the_same_cells_have_the_same_pressure() -> None:
    tip = fp.Pyramid(4, 0.3)
    solution = bem.solve(FILM, tip, depths=0.4, grid=64, tolerance=1e-8)[0]
    grid = solution.grid
    columns, rows = slice(38, 62), slice(34, 58)
    closer = look_closer(FILM, tip, 0.4, _whole(solution), grid.part(rows, columns), 0.0)
    np.testing.assert_allclose(closer.pressure, solution.pressure[rows, columns], atol=1e-3 * solution.pressure.max())
    np.testing.assert_allclose(closer.displacement, solution.displacement[rows, columns], atol=1e-4 * 0.4)


def test_mirror_images_are_solved_once() -> None:
    tip = fp.Pyramid(3, 0.3)
    solution = bem.solve(FILM, tip, depths=0.4, grid=96)[0]
    along = tip.corners[0]
    window = bem.Grid(80, 40, solution.grid.spacing / 2, (1.2 * solution.radius, 0.0))
    whole, half = (
        look_closer(FILM, tip, 0.4, _whole(solution), window, along, mirrored=(False, even)) for even in (False, True)
    )
    np.testing.assert_array_equal(half.pressure, half.pressure[::-1])
    # the coarse cells lie askew, so that the whole is even to their error only
    assert half.pressure.sum() == pytest.approx(whole.pressure.sum(), rel=1e-3)


def test_a_quarter_stands_for_what_is_even_along_both_axes() -> None:
    tip = fp.Pyramid(4, 0.3)
    solution = bem.solve(FILM, tip, depths=0.4, grid=96)[0]
    window = bem.Grid(60, 60, solution.grid.spacing / 2)
    whole, quarter = (
        look_closer(FILM, tip, 0.4, _whole(solution), window, 0.0, mirrored=(even, even)) for even in (False, True)
    )
    np.testing.assert_array_equal(quarter.pressure, quarter.pressure[:, ::-1])
    # to the tolerance of a look, in the outermost cells too
    np.testing.assert_allclose(quarter.pressure, whole.pressure, atol=2e-4 * whole.pressure.max())
    np.testing.assert_allclose(quarter.displacement, whole.displacement, atol=1e-5 * 0.4)


def test_load_along_a_tongue_is_that_of_a_fine_grid() -> None:
    tip = fp.Pyramid(4, 0.3)
    coarse, fine = (bem.solve(FILM, tip, depths=0.5, grid=cells, tolerance=1e-6)[0] for cells in (96, 384))
    corner, start, end = np.pi / 4, 1.3 * fine.radius, 1.35 * fine.radius
    step = coarse.grid.spacing / 4
    window = bem.Grid(160, 80, step, (start + 60 * step, 0.0))
    loads = [
        look_closer(FILM, tip, 0.5, _whole(solution), window, corner, mirrored=(False, True)).pressure.sum(axis=0)
        * step
        for solution in (coarse, fine)
    ]
    seen = (window.x > start) & (loads[1] > 0.03 * loads[1].max())
    assert end < window.x[seen][-1]
    # cells four times as wide; read as they are they are off by a fifth there
    np.testing.assert_allclose(loads[0][seen], loads[1][seen], rtol=0.05)
