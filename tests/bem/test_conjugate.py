"""The preconditioner of the inner iterations: an energy, which is least where displacements are extended as the surface does."""

import numpy as np
import pytest

from flatpunch import indenters, media
from flatpunch.bem import solve
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator.convolution import build_operator
from flatpunch.bem.solver import active_set
from flatpunch.bem.solver.conjugate import preconditioner, remove_gap
from flatpunch.compliances import compliance

HALF_SPACE = compliance(media.HalfSpace(1e9, 0.3))
DRAINED = compliance(media.Medium([media.Layer(1e6, 0.5, 1 / 3)], media.RigidBase()))
GRID = Grid(40, 40, 0.065)
X, Y = np.meshgrid(GRID.x, GRID.y)
DISC = np.hypot(X, Y) < 1
STAR = (np.hypot(X, Y) < 0.35) | ((np.minimum(abs(X), abs(Y)) < 0.08) & (np.maximum(abs(X), abs(Y)) < 1.1))


def film(beta):
    return compliance(media.Medium([media.Layer(1e9, 0.3, 1 / beta)], media.HalfSpace(1e7, 0.3)))


def matrix(function, contact):
    """What a linear function does to pressures or gaps on a contact, column by column."""
    places = np.flatnonzero(contact)
    columns = [function(np.eye(1, contact.size, place).reshape(contact.shape)).ravel()[places] for place in places]
    return np.array(columns).T


def eigenvalues(kernel, contact, *, extended):
    """Of the preconditioner over the exact inverse, which are real and positive."""
    operator = build_operator(kernel, GRID)
    inverse = matrix(preconditioner(operator, contact.astype(float), extended=extended), contact)
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-13 * abs(inverse).max())
    return np.sort(np.linalg.eigvals(inverse @ matrix(operator.apply, contact)).real)


@pytest.mark.long
@pytest.mark.parametrize("contact", [DISC, STAR], ids=["disc", "star"])
@pytest.mark.parametrize(
    ("kernel", "zero", "mean"),
    [(HALF_SPACE, 3.6, 2.1), (film(1), 64, 13), (film(10), 125, 5)],
    ids=["half-space", "film, beta 1", "film, beta 10"],
)
def test_least_energy(kernel, zero, mean, contact):
    """No continuation stores less than the surface's own, but for what the symbol without padding leaves out: a twelfth."""
    most = []
    for extended, bound in ((False, zero), (True, mean)):
        values = eigenvalues(kernel, contact, extended=extended)
        assert values[0] > 1 - 1 / 12
        assert values[-1] < bound
        most.append(values[-1])
    assert most[1] < 0.7 * most[0]


def test_layers_that_drain_want_zero():
    """Smooth displacements are what costs most there, so that those beyond the contact are better none."""
    assert eigenvalues(DRAINED, STAR, extended=False)[-1] < 1.4
    assert eigenvalues(DRAINED, STAR, extended=True)[-1] > 5


@pytest.mark.parametrize("mirrored", [(False, False), (True, False), (False, True), (True, True)])
def test_same_pressure_in_fewer_steps(mirrored):
    """On folded grids too: a flat punch under a star."""
    grid = GRID.folded(mirrored)
    operator, contact = build_operator(film(10), grid), STAR[-grid.ny :, -grid.nx :]
    gap = -contact.astype(float)
    (zero, many), (mean, few) = (
        remove_gap(operator, contact, gap, 1e-10, 500, extended=extended) for extended in (False, True)
    )
    assert few < 0.7 * many
    # residuals of 1e-10, and a condition number of about 100
    np.testing.assert_allclose(mean, zero, atol=1e-7 * abs(zero).max())


def test_pyramids_deep_in_stiff_films_take_half_of_the_iterations(monkeypatch):
    tip, options = indenters.Pyramid(3, 0.3), {"depths": 10.0, "grid": 256, "tolerance": 1e-8}
    [now] = solve(film(1), tip, **options)
    monkeypatch.setattr(active_set, "_MANY", 1000)
    [before] = solve(film(1), tip, **options)
    assert now.converged
    assert before.converged
    assert now.force == pytest.approx(before.force, rel=1e-7)
    assert now.iterations[-1] < before.iterations[-1] / 2
