"""Contacts that are their own mirror images: solved on half of the grid or a quarter, with the same result."""

import numpy as np
import pytest

from flatpunch import bem, indenters, media
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator.convolution import build_operator
from flatpunch.bem.solver import levels
from flatpunch.bem.solver.levels import Levels
from flatpunch.bem.solver.nested import solve_depth, solve_force, solve_stiffness
from flatpunch.compliances import compliance

FILM = compliance(media.Medium([media.Layer(50.0, 0.3, 1.0)], media.HalfSpace(1.0, 0.3)))
POWER_LAW = compliance(media.PowerLawHalfSpace(1.0, 1.0, 0.3, 0.3))
BOTH, ALONG_X, ALONG_Y = (True, True), (True, False), (False, True)


def whole(half, mirrored):
    if mirrored[0]:
        half = np.concatenate([half[..., ::-1], half], axis=-1)
    return np.concatenate([half[..., ::-1, :], half], axis=-2) if mirrored[1] else half


def kept(values, mirrored):
    ny, nx = values.shape
    return values[ny // 2 if mirrored[1] else 0 :, nx // 2 if mirrored[0] else 0 :]


@pytest.mark.parametrize("mirrored", [BOTH, ALONG_X, ALONG_Y])
@pytest.mark.parametrize("shape", [(64, 90), (46, 150)])
def test_folded_convolution_is_that_of_the_whole_grid(shape, mirrored):
    grid = Grid(*shape, 0.03)
    part = grid.folded(mirrored)
    usual, folded = build_operator(FILM, grid), build_operator(FILM, part)
    p = np.random.default_rng(1).random(part.shape)
    u = kept(usual.apply(whole(p, mirrored)), mirrored)
    np.testing.assert_allclose(folded.apply(p), u, rtol=0, atol=1e-14 * u.max())
    np.testing.assert_allclose(folded.apply(np.stack([p, 2 * p]))[1], 2 * u, rtol=0, atol=1e-14 * 2 * u.max())
    single = folded.single().apply(p.astype(np.float32))
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, u, rtol=0, atol=1e-6 * u.max())


@pytest.mark.parametrize("mirrored", [BOTH, ALONG_X, ALONG_Y])
def test_folded_approximate_inverse_is_that_of_the_whole_grid(mirrored):
    # 64 and 96 are fast lengths, so that both work on the same periodic grid
    grid = Grid(64, 96, 0.03)
    part = grid.folded(mirrored)
    gap = np.random.default_rng(2).standard_normal(part.shape)
    usual, folded = build_operator(FILM, grid), build_operator(FILM, part)
    assert usual.periodic == folded.periodic
    p = kept(usual.precondition(whole(gap, mirrored)), mirrored)
    np.testing.assert_allclose(folded.precondition(gap), p, rtol=0, atol=1e-14 * np.abs(p).max())


def test_folded_grids_know_the_whole():
    grid = Grid(20, 14, 0.5, (0.0, 3.0))
    part = grid.folded(ALONG_X)
    assert part.shape == (14, 10)
    assert part.copies == 2
    assert part.unfolded == grid
    np.testing.assert_array_equal(part.x, grid.x[10:])
    np.testing.assert_array_equal(part.y, grid.y)
    some = part.part(slice(2, 12), slice(0, 7))
    np.testing.assert_allclose(some.x, part.x[:7])
    np.testing.assert_allclose(some.y, part.y[2:12])
    coarse = Grid(90, 64, 0.5).folded(BOTH).coarser()
    assert coarse.unfolded == Grid(90, 64, 0.5).coarser()


TIPS = {
    "ellipse": (indenters.EllipticParaboloid(0.3, 1.0), BOTH),
    "square pyramid": (indenters.Pyramid(4, 0.35), BOTH),
    "three-sided pyramid": (indenters.Pyramid(3, 0.35), ALONG_Y),
    # turned so that neither axis is a mirror
    "turned pyramid": (indenters.PowerLaw(1.0, lambda phi: 1 + 0.1 * np.cos(3 * phi - 0.4)), (False, False)),
}


@pytest.mark.parametrize("name", TIPS)
@pytest.mark.parametrize("kernel", [FILM, POWER_LAW], ids=["film", "power law"])
def test_solutions_are_those_of_the_whole_grid(name, kernel, monkeypatch):
    tip, mirrored = TIPS[name]
    grid = bem.solve(kernel, tip, depths=0.4, grid=72)[0].grid
    height = bem.grid.IndenterHeight(tip)
    setting = Levels(kernel, grid)
    assert setting.folded_to(height)[0].grid.mirrored == mirrored
    found, _ = solve_depth(setting, height, 0.4, 1e-9, 500)
    by_force, _ = solve_force(setting, height, found.force * kernel.modulus * grid.spacing**2, 0.3, 1e-9, 500)
    stiffness = solve_stiffness(setting, found.contact, 1e-9)
    monkeypatch.setattr(levels, "mirror_axes", lambda *_: (False, False))
    usual, _ = solve_depth(setting, height, 0.4, 1e-9, 500)
    assert found.converged
    assert usual.converged
    assert found.pressure.shape == grid.shape
    # gap errors of 1e-9 of the depth
    assert found.force == pytest.approx(usual.force, rel=1e-8)
    assert by_force.depth == pytest.approx(usual.depth, rel=1e-8)
    np.testing.assert_array_equal(found.contact, usual.contact)
    np.testing.assert_allclose(found.pressure, usual.pressure, rtol=0, atol=1e-6 * usual.pressure.max())
    np.testing.assert_allclose(found.displacement, usual.displacement, rtol=0, atol=1e-7 * usual.displacement.max())
    assert stiffness == pytest.approx(solve_stiffness(setting, found.contact, 1e-9), rel=1e-8)


def test_what_is_no_mirror_image_of_itself_is_not_folded():
    tip = bem.grid.IndenterHeight(indenters.Pyramid(4, 0.35))

    def mirrored(grid, height=tip):
        folded, cells = Levels(FILM, grid).folded_to(height)
        np.testing.assert_allclose(folded.grid.unfold(cells), height(grid) / grid.spacing, rtol=1e-12)
        return folded.grid.mirrored

    assert mirrored(Grid(40, 40, 0.1)) == BOTH
    # cells off the centre, odd numbers of cells
    assert mirrored(Grid(40, 40, 0.1, (0.02, 0.0))) == ALONG_Y
    assert mirrored(Grid(40, 41, 0.1)) == ALONG_X
    assert mirrored(Grid(40, 40, 0.1), lambda grid: tip(grid) + 1e-6 * grid.x) == ALONG_Y


def test_windows_of_folded_grids_begin_at_the_mirror():
    tip = bem.grid.IndenterHeight(indenters.EllipticParaboloid(0.1, 1.0))
    setting = Levels(FILM, Grid(128, 128, 0.05)).folded(BOTH)
    height = setting.cells(tip)
    window = setting.window((height < 20.0).astype(float))
    assert window is not None
    assert (window.rows.start, window.columns.start) == (0, 0)
    np.testing.assert_array_equal(window.levels.cells(tip), window.cut(height))
