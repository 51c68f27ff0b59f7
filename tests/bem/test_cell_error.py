"""Errors of the force that cells cause, against exact forces and finer cells, where one length of the problem is short."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliances import compliance
from flatpunch.contact.boundary_elements.error import extrapolated, own_error

THIN = fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase())
NEARLY_ROUND = fp.EllipticParaboloid(0.98, 1.02)
"""Second order is exact to the fourth power of its asymmetry, 4e-7."""


def _covered(solution: bem.Solution, force: float) -> None:
    """Assert that both estimates cover the error of their force."""
    assert abs(solution.force / force - 1) <= own_error(solution)
    best, error = extrapolated(solution)
    assert abs(best / force - 1) <= error


@cache
def _limit(radius: float) -> tuple[float, float]:
    """Depth and exact force of the nearly round contact on the thin layer."""
    exact = fp.indent(THIN, NEARLY_ROUND, radius=radius, method="second-order")
    return float(exact.depth[0]), float(exact.force[0])


@pytest.mark.long
@pytest.mark.parametrize(
    ("radius", "least"),
    [(3.0, 0.0), (30.0, 5e-4), (60.0, 2e-3), (100.0, 5e-3), pytest.param(200.0, 0.1, marks=pytest.mark.slow)],
)
def test_contacts_far_wider_than_an_incompressible_layer(radius: float, least: float) -> None:
    """Up to two thicknesses to a cell, where forces are ten per cent low."""
    depth, force = _limit(radius)
    (solution,) = bem.solve(compliance(THIN), NEARLY_ROUND, depths=depth, grid=256, tolerance=1e-6)
    _covered(solution, force)
    assert own_error(solution) >= least


@pytest.mark.parametrize("radius", [30.0, 60.0, pytest.param(100.0, marks=pytest.mark.long)])
def test_curves_on_a_thin_incompressible_layer(radius: float) -> None:
    """The estimate of `refined` was 9e-6 where the force was off by 7e-4, 5e-3 and 8e-3."""
    depth, force = _limit(radius)
    single = fp.indent(THIN, NEARLY_ROUND, depth=depth, method=fp.Refined(rtol=4.99e-4))
    assert abs(single.force.item() / force - 1) <= single.force_error.item()
    # finer cells were taken
    assert abs(single.force.item() / force - 1) < 1e-4 * (radius / 30) ** 4


def hertz(ratio: float) -> tuple[float, float]:
    """Force and aspect ratio of the Hertz contact of f = x^2 + ratio y^2 at depth 1 with E* = 1 (Johnson 1985, 4.2)."""

    def curvatures(m: float) -> float:
        return float((ellipe(m) / (1 - m) - ellipk(m)) / (ellipk(m) - ellipe(m)))

    m = brentq(lambda m: curvatures(m) - ratio, 1e-9, 1 - 1e-12, xtol=1e-15)
    long = np.sqrt((ellipk(m) - ellipe(m)) / (m * ellipk(m)))
    # d = p0 b K, p0 the largest pressure and b the short half-axis
    return float(2 / 3 * np.pi * long / ellipk(m)), float(1 / np.sqrt(1 - m))


@pytest.mark.parametrize(
    ("ratio", "aspect"), [(1.5, 1.3), (100.0, 18.2), (300.0, 34.5), (1000.0, 67.9), (5000.0, 165.8)]
)
def test_slender_ellipses(ratio: float, aspect: float) -> None:
    """Of aspect 166 a contact is 21 cells wide, and no wider cells can be solved."""
    force, found = hertz(ratio)
    assert found == pytest.approx(aspect, rel=0.01)
    tip = fp.EllipticParaboloid(1.0, ratio)
    (solution,) = bem.solve(compliance(fp.HalfSpace(1.0, 0.0)), tip, depths=1.0, grid=256, tolerance=1e-6)
    _covered(solution, force)


def drawn(rng: np.random.Generator) -> tuple[fp.HalfSpace | fp.Medium, float, float]:
    """A body, the slope of a tip beside a flat end of about unit radius, and a depth from first touch to a ring of that size."""
    young, thickness, poisson = (
        10 ** rng.uniform(-2, 2),
        10 ** rng.uniform(-0.7, 0.7),
        float(rng.choice([0.3, 0.45, 0.5])),
    )
    layer, slope = fp.Layer(young, poisson, thickness), 10 ** rng.uniform(-1.3, -0.15)
    body = [fp.HalfSpace(1.0, 0.3), fp.Medium([layer], fp.RigidBase()), fp.Medium([layer], fp.HalfSpace(1.0, 0.3))]
    return body[rng.integers(3)], slope, slope * 10 ** rng.uniform(-5, 0)


@pytest.mark.long
@pytest.mark.parametrize("count", [20, pytest.param(100, marks=pytest.mark.slow)])
def test_flat_ends_of_cones_against_exact_forces(count: int) -> None:
    """Three widths alone cover six in ten of these: none of them knows where the edge is among the cells."""
    rng, stated, best = np.random.default_rng(7), [], []
    for body, slope, depth in (drawn(rng) for _ in range(count)):
        tip = fp.Truncated(fp.Cone(float(np.arctan(slope))), height_removed=slope)
        exact = fp.indent(body, tip, depth=depth, method="first-order")
        if not exact.valid.item():
            continue
        for cells in (int(rng.integers(32, 50)) * 2, int(rng.integers(50, 82)) * 2):
            (solution,) = bem.solve(compliance(body), tip, depths=depth, grid=cells, tolerance=1e-6)
            force, error = extrapolated(solution)
            stated.append(own_error(solution) / abs(solution.force / exact.force.item() - 1))
            best.append(error / abs(force / exact.force.item() - 1))
    assert len(stated) > count
    assert np.mean(np.array(stated) > 1) >= 0.95
    assert np.mean(np.array(best) > 1) >= 0.95
    # no idle fears
    assert np.median(stated) < 5
    assert np.median(best) < 5


def test_straight_edges_along_the_cells() -> None:
    """Whether a column of cells touches is decided at once along a whole side of a square flat end."""
    kernel, tip, depth = compliance(fp.HalfSpace(1.0, 0.3)), fp.Truncated(fp.Pyramid(4, 0.3), height_removed=0.3), 1e-4
    # cells aligned with the edges; their error falls with the width, as that of the edges of a flat does
    wide, fine = (
        bem.solve(kernel, tip, depths=depth, grid=bem.Grid(int(2.5 * n), int(2.5 * n), 0.3 / np.tan(0.3) / n))[0].force
        for n in (64, 128)
    )
    missed = []
    for cells in range(80, 120, 4):
        (solution,) = bem.solve(kernel, tip, depths=depth, grid=cells, tolerance=1e-6)
        missed.append(abs(solution.force / (2 * fine - wide) - 1) / own_error(solution))
    assert max(missed) < 1
    # such edges do move forces by as much as the estimate says
    assert max(missed) > 0.3


@pytest.mark.long
@pytest.mark.parametrize("sides", [3, 5, 6])
def test_edges_of_pyramids_among_the_cells(sides: int) -> None:
    """Differences to wider cells alone left up to ten times the estimate, by chance."""
    kernel, tip, rng = compliance(fp.HalfSpace(1.0, 0.3)), fp.Pyramid(sides, 0.35), np.random.default_rng(sides)

    def solved(cells: int, shift: np.ndarray) -> bem.Solution:
        # the contact of three sides reaches out to 1.31
        spacing = 3.0 / cells
        grid = bem.Grid(cells, cells, spacing, tuple(spacing * shift))
        return bem.solve(kernel, tip, depths=0.3, grid=grid, tolerance=1e-6, stiffness=1e-2)[0]

    (fine,) = bem.solve(kernel, tip, depths=0.3, grid=768, tolerance=1e-6, stiffness=1e-2)
    force, rest = extrapolated(fine, tip)
    for _ in range(5):
        solution = solved(256, rng.uniform(0, 1, 2))
        best, error = extrapolated(solution, tip)
        assert abs(best / force - 1) < 1.2 * error + rest
        assert abs(solution.force / force - 1) < 1.2 * own_error(solution, tip) + rest


def test_the_estimate_is_no_idle_fear() -> None:
    (solution,) = bem.solve(compliance(fp.HalfSpace(1.0, 0.0)), fp.EllipticParaboloid(1.0, 2.0), depths=1.0, grid=256)
    assert own_error(solution) < 3e-5
    assert extrapolated(solution)[1] < 2e-5


@pytest.mark.long
@pytest.mark.parametrize("width", [60.0, 250.0, 300.0])
def test_cells_wider_than_a_thin_incompressible_layer(width):
    """A nearly round ellipse against the exact round contact: at 250 layers 13 % low, where 5 % was stated."""
    layer = fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase())
    exact = fp.indent(layer, fp.Paraboloid(1e6), radius=width)
    tip = fp.EllipticParaboloid(0.4995e-6, 0.5005e-6)
    for method in ("bem", "refined"):
        found = fp.indent(layer, tip, depth=float(exact.depth[0]), method=method, angles=8)
        assert abs(float(found.force[0]) / float(exact.force[0]) - 1) < float(found.force_error[0])
