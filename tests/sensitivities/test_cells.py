"""Derivatives of contacts that are solved on cells, against differences and scaling laws."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.media.paths import with_values
from flatpunch.sensitivities.parameters import parameters

FILM = fp.Medium([fp.Layer(2.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.25))
PAIR = fp.TwoBodies(FILM, fp.Medium([fp.Layer(1.0, 0.2, 0.8)], base=fp.HalfSpace(8.0, 0.1)))

GRID = fp.bem.Grid.around((1.3, 1.3), 96)


@pytest.mark.long
@pytest.mark.parametrize(
    ("medium", "tip"), [(FILM, fp.Pyramid(4, 0.3)), (FILM, fp.EllipticParaboloid(0.2, 0.3)), (PAIR, fp.Paraboloid(2.0))]
)
def test_cells_against_differences_on_the_same_cells(medium, tip):
    method = fp.BoundaryElements(grid=GRID, tolerance=1e-8)
    found = fp.sensitivity(medium, tip, depth=0.3, method=method)
    for parameter in parameters(medium, tip):

        def force(value, name=parameter.path):
            body, shape = with_values(medium, tip, {name: value})
            (solution,) = fp.bem.solve(fp.compliance(body), shape, depths=0.3, grid=GRID, tolerance=1e-9)
            return np.log(solution.force)

        step = 2e-3 if parameter.kind == "poisson" else 1e-2 * parameter.value
        # two-point: cells join and leave the contact between the steps
        wanted = parameter.value * (force(parameter.value + step) - force(parameter.value - step)) / (2 * step)
        # the punch's pressure is singular at the edge, where the change of the tip is largest: each cell that joins counts
        accuracy = 2e-3 if parameter.body < 0 else 2e-4
        assert float(found.force.sel(parameter=parameter.path)) == pytest.approx(wanted, abs=accuracy), parameter.path
    assert float(found.force.values[found.unit.values == "Pa"].sum()) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("sides", [3, 5])
def test_cells_know_that_pyramids_are_similar_at_all_sizes(sides):
    """F = c d^2 cot(beta) on a half-space: exactly known by the tip's angle, and at fixed force, though the punch is not."""
    found = fp.sensitivity(
        fp.HalfSpace(1.0, 0.3), fp.Pyramid(sides, 0.3), depth=0.3, method=fp.BoundaryElements(grid=64)
    )
    by_angle = found.sel(parameter="indenter.inclination")
    assert float(by_angle.force) == pytest.approx(-0.6 / np.sin(0.6), rel=1e-6)
    assert float(by_angle.depth) == pytest.approx(0.3 / np.sin(0.6), rel=1e-6)


def test_cells_beside_a_flat_end():
    """At first touch the force is that of the flat punch, whose side is height_removed/tan(inclination)."""
    tip = fp.Truncated(fp.Pyramid(4, 0.3), 0.1)
    found = fp.sensitivity(fp.HalfSpace(1.0, 0.3), tip, depth=1e-5, method=fp.BoundaryElements(grid=128))
    # what a rim among cells leaves
    assert float(found.force.sel(parameter="indenter.height_removed")) == pytest.approx(1.0, abs=0.03)
    assert float(found.force.sel(parameter="indenter.tip.inclination")) == pytest.approx(-0.6 / np.sin(0.6), abs=0.03)


@pytest.mark.long
def test_cells_of_a_contact_without_an_outline():
    """Under a stiff film the lobes of a three-sided pyramid come off its centre; depths are chosen by the size of the whole."""
    stiff = fp.Medium([fp.Layer(5.551, 0.0083, 1.164)], base=fp.HalfSpace(1.0, 0.3))
    found = fp.sensitivity(stiff, fp.Pyramid(3, 0.10048), depth=0.1597, method="bem")
    assert "no outline" in found.attrs["notes"]
    assert 0.3 < float(found.contact_radius) < 1.0
    assert float(found.force.values[found.unit.values == "Pa"].sum()) == pytest.approx(1.0, abs=1e-6)
    assert np.isfinite(found.depth_sensitivity).all()


def test_cells_agree_with_the_round_contact():
    exact = fp.sensitivity(FILM, fp.Paraboloid(2.0), depth=0.3)
    cells = fp.sensitivity(FILM, fp.Paraboloid(2.0), depth=0.3, method=fp.BoundaryElements(grid=96))
    # what cells of a fiftieth of the radius leave
    np.testing.assert_allclose(cells.force, exact.force, atol=5e-3)
    assert np.isnan(cells.radius.values).all()


@pytest.mark.long
@pytest.mark.parametrize(
    ("tip", "accuracy"),
    [
        # what rims among cells leave at sharp ends
        (fp.Roller(5.0, 4.0), 0.06),
        (fp.Roller(5.0, 4.0, crown=40.0), 0.02),
        (fp.RoundedPunch(1.0, 0.1), 2e-3),
    ],
)
@pytest.mark.parametrize("depth", [0.01, 0.1])
def test_cells_beside_edges_of_tips(tip, accuracy, depth):
    """On a half-space F/(E* d^2) depends on the ratios of the lengths alone."""
    found = fp.sensitivity(fp.HalfSpace(1.0, 0.3), tip, depth=depth)
    by_depth = float(found.contact_stiffness * found.contact_depth / found.contact_force)
    by_tip = found.force.values[found.unit.values == "m"]
    assert by_depth + float(by_tip.sum()) == pytest.approx(2.0, abs=accuracy)
