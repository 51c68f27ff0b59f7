"""Star-shaped contacts under stiff films, where other preconditioners and full steps fail."""

import numpy as np
import pytest

from flatpunch import indenters, media
from flatpunch._support.checks import FlatpunchWarning
from flatpunch.bem import Grid, solve
from flatpunch.bem.operator.convolution import build_operator
from flatpunch.bem.solver import active_set as solver
from flatpunch.bem.solver.conjugate import remove_gap
from flatpunch.compliances import compliance

FILM = compliance(media.Medium([media.Layer(50.0, 0.3, 1.0)], media.HalfSpace(1.0, 0.3)))
PYRAMID = indenters.Pyramid(3, 0.35)


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
    monkeypatch.setattr(solver, "PATIENCE", 0)
    careful = solve(FILM, PYRAMID, depths=depth, grid=usual.grid, tolerance=1e-6)[0]
    assert careful.converged
    # errors of 1e-6 of the depth
    assert careful.force == pytest.approx(usual.force, rel=1e-4)


@pytest.mark.parametrize("ceiling", [float("inf"), 1.5, 1.0])
def test_a_step_that_lowers_the_energy_is_found_whatever_is_proposed(ceiling):
    grid = Grid(32, 32, 0.1)
    operator = build_operator(FILM, grid)
    height, depth = grid.polar[0] * 2, 10.0
    for start in (np.zeros(grid.shape), np.where(grid.polar[0] < 1.0, 1.0, 0.0)):
        problem = solver._Problem(operator, height, ceiling)
        now = solver._trial(problem, depth, start)
        # upwards in energy: the gap with the wrong sign
        change = np.where(start > 0, now.gap, 0.0) if start.any() else np.zeros(grid.shape)
        if start.any():
            change = remove_gap(operator, start > 0, np.where(start > 0, now.gap, 0.0), 1e-6, 400)[0]
        later = solver._descended(problem, depth, now, change)
        assert solver._energy(np, later) < solver._energy(np, now)


@pytest.mark.filterwarnings("ignore:the contact has several parts")
def test_film_that_does_not_converge_warns():
    with pytest.warns(FlatpunchWarning, match="not converged after"):
        step = solve(FILM, PYRAMID, depths=np.exp(2.016), grid=Grid(64, 64, 1.6), tolerance=1e-8, limit=2)[0]
    assert not step.converged
    assert max(step.gap_error, step.penetration) > 1e-8


@pytest.mark.parametrize("modulus", [20.0, 300.0, 1000.0])
def test_narrow_lobes_converge(modulus):
    film = compliance(media.Medium([media.Layer(modulus, 0.3, 1.0)], media.HalfSpace(1.0, 0.3)))
    for depth in (2.0, 8.0):
        step = solve(film, PYRAMID, depths=depth, grid=96, tolerance=1e-6)[0]
        assert step.converged
        # measured over depths from 1.3 to 33 film thicknesses: 236 at most
        assert max(step.iterations) < 300


def test_iterations_on_a_concave_contact_of_many_cells():
    film = compliance(media.Medium([media.Layer(4.0, 0.3, 1.0)], media.HalfSpace(1.0, 0.3)))
    step = solve(film, PYRAMID, depths=np.exp(0.2), grid=256, tolerance=1e-6)[0]
    assert step.converged
    # 153 with a smooth part of the approximate inverse that did not suit
    assert step.iterations[-1] < 60
