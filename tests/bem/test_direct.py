"""Star-shaped contacts under stiff films: solved directly or iteratively, they converge to the same solution."""

import numpy as np
import pytest

from flatpunch import indenters, media
from flatpunch._support.checks import FlatpunchWarning
from flatpunch.bem import Grid, solve
from flatpunch.bem.operator.convolution import build_operator
from flatpunch.bem.solver import active_set as solver
from flatpunch.bem.solver import direct
from flatpunch.bem.solver import gap_removal as removal
from flatpunch.bem.solver.direct import affordable, influence, offsets
from flatpunch.compliance import compliance

FILM = compliance(media.Medium([media.Layer(50.0, 0.3, 1.0)], media.HalfSpace(1.0, 0.3)))
PYRAMID = indenters.Pyramid(3, 0.35)

FOLDINGS = [(False, False), (True, False), (False, True), (True, True)]


@pytest.mark.parametrize("mirrored", FOLDINGS)
def test_matrix_is_the_operator(mirrored):
    grid = Grid(44, 36, 0.1).folded(mirrored)
    operator = build_operator(FILM, grid)
    rng = np.random.default_rng(7)
    contact = rng.random(grid.shape) < 0.3
    pressure = rng.standard_normal(grid.shape) * contact
    displacement = operator.apply(pressure)
    held = influence(operator, contact, offsets(operator))
    assert held.covers(contact)
    # both are sums of some hundred numbers of order one
    whole = np.triu(held.matrix) + np.triu(held.matrix, 1).T
    np.testing.assert_allclose(whole @ pressure[contact], displacement[contact], atol=1e-12)
    removed = held.remove_gap(contact, displacement * contact)
    # condition of the matrix times rounding
    np.testing.assert_allclose(removed, -pressure, atol=1e-10)


def test_matrix_serves_smaller_contacts():
    grid = Grid(40, 40, 0.1)
    operator = build_operator(FILM, grid)
    held = influence(operator, grid.polar[0] < 1.2, offsets(operator))
    smaller, larger = grid.polar[0] < 0.9, grid.polar[0] < 1.5
    assert held.covers(smaller)
    assert not held.covers(larger)
    gap = np.where(smaller, grid.x, 0.0)
    np.testing.assert_allclose(
        held.remove_gap(smaller, gap),
        influence(operator, smaller, offsets(operator)).remove_gap(smaller, gap),
        atol=1e-12,
    )


def test_rounding_is_told():
    """A matrix that is not positive is left to the iterations."""
    grid = Grid(8, 8, 0.1)
    place = np.arange(grid.nx * grid.ny)
    held = direct.Influence(place, -np.eye(place.size))
    assert held.remove_gap(np.ones(grid.shape, dtype=bool), np.ones(grid.shape)) is None


@pytest.mark.parametrize(
    ("condition", "precisions", "left"), [(1e4, ["float32"], 1e-8), (1e10, ["float32", "float64"], 1e-5)]
)
def test_systems_are_solved_in_single_precision_where_that_suffices(condition, precisions, left, monkeypatch):
    rng, size, used = np.random.default_rng(3), 60, []
    turned = np.linalg.qr(rng.standard_normal((size, size)))[0]
    matrix = (turned * np.geomspace(1, 1 / condition, size)) @ turned.T
    factored = direct.cho_factor
    monkeypatch.setattr(direct, "cho_factor", lambda a, **k: (used.append(str(a.dtype)), factored(a, **k))[1])
    right = rng.standard_normal(size)
    solution = direct._solved(np.triu(matrix), right)
    assert used == precisions
    assert np.abs(matrix @ solution - right).max() < left * np.abs(right).max()


def test_nothing_in_contact_is_no_system():
    assert direct._solved(np.empty((0, 0)), np.empty(0)).size == 0


def test_few_cells_are_affordable():
    operator = build_operator(FILM, Grid(128, 128, 0.1))
    assert affordable(operator, 500, slow=False, once=False)
    assert not affordable(operator, 1200, slow=False, once=False)
    assert not affordable(operator, 600, slow=False, once=True)
    assert affordable(operator, 1200, slow=True, once=False)
    assert not affordable(operator, 5000, slow=True, once=True)


@pytest.mark.parametrize("depth", [2.0, 5.0, np.exp(2.016)])
def test_both_ways_agree(depth, monkeypatch):
    directly = solve(FILM, PYRAMID, depths=depth, grid=96, tolerance=1e-8)[0]
    monkeypatch.setattr(removal, "affordable", lambda *_, **__: False)
    iteratively = solve(FILM, PYRAMID, depths=depth, grid=directly.grid, tolerance=1e-8)[0]
    assert directly.converged
    assert iteratively.converged
    # errors of 1e-8 of the depth, which the stiffness of the film turns into more pressure at the edges
    assert iteratively.force == pytest.approx(directly.force, rel=1e-6)
    assert sum(directly.iterations) < sum(iteratively.iterations)


def test_contact_that_stalled():
    """Iterations were left to rounding once, 1000 of them, and the force came out twice too large."""
    step = solve(FILM, PYRAMID, depths=np.exp(2.016), grid=256, tolerance=1e-6)[0]
    assert step.converged
    # measured 59, 30 and 90 .. 115
    assert max(step.iterations) < 250
    # between those of neighbouring depths, which always converged; coarser cells give 5.1338
    assert np.log(step.force) == pytest.approx(5.1355, abs=1e-3)


@pytest.mark.parametrize("depth", [3.0, np.exp(2.016)])
def test_steps_that_lower_the_energy_suffice(depth, monkeypatch):
    usual = solve(FILM, PYRAMID, depths=depth, grid=64, tolerance=1e-6)[0]
    monkeypatch.setattr(solver, "_PATIENCE", 0)
    careful = solve(FILM, PYRAMID, depths=depth, grid=usual.grid, tolerance=1e-6)[0]
    assert careful.converged
    # errors of 1e-6 of the depth
    assert careful.force == pytest.approx(usual.force, rel=1e-4)


def test_a_step_that_lowers_the_energy_is_found_whatever_is_proposed():
    grid = Grid(32, 32, 0.1)
    operator = build_operator(FILM, grid)
    height, depth = grid.polar[0] * 2, 10.0
    for start in (np.zeros(grid.shape), np.where(grid.polar[0] < 1.0, 1.0, 0.0)):
        now = solver._trial(operator, height, depth, start)
        # upwards in energy: the gap with the wrong sign
        change = np.where(start > 0, now.gap, 0.0) if start.any() else np.zeros(grid.shape)
        if start.any():
            held = influence(operator, start > 0, offsets(operator))
            change = held.remove_gap(start > 0, np.where(start > 0, now.gap, 0.0))
        later = solver._descended(operator, height, depth, now, change)
        assert solver._energy(np, later) < solver._energy(np, now)


@pytest.mark.filterwarnings("ignore:the contact has several parts")
def test_film_that_does_not_converge_warns():
    with pytest.warns(FlatpunchWarning, match="not converged after"):
        step = solve(FILM, PYRAMID, depths=np.exp(2.016), grid=Grid(64, 64, 1.6), tolerance=1e-8, limit=2)[0]
    assert not step.converged
    assert max(step.gap_error, step.penetration) > 1e-8


def test_iterations_on_a_concave_contact_of_many_cells():
    """Too many for the direct way."""
    film = compliance(media.Medium([media.Layer(4.0, 0.3, 1.0)], media.HalfSpace(1.0, 0.3)))
    step = solve(film, PYRAMID, depths=np.exp(0.2), grid=256, tolerance=1e-6)[0]
    assert step.converged
    # 153 with a smooth part of the approximate inverse that did not suit
    assert step.iterations[-1] < 60
