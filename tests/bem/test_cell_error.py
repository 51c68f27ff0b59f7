"""Errors of the force that cells cause, against exact forces and finer cells, where one length of the problem is short."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliance import compliance
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


@pytest.mark.parametrize("radius", [30.0, 60.0, 100.0])
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


def test_flat_ends_near_first_touch() -> None:
    """Forces scatter by half a per cent with where the edges are among the cells, and differences of three with them."""
    missed = []
    for sides in (3, 4, 6):
        tip = fp.Truncated.across(fp.Pyramid(sides, 0.35), 0.5)
        for depth in (1e-4, 1e-2, 5e-2):
            kernel = compliance(fp.HalfSpace(1.0, 0.3))
            *coarse, fine, finest = (
                bem.solve(kernel, tip, depths=depth, grid=grid, tolerance=1e-6)[0]
                for grid in (224, 256, 320, 512, 1024)
            )
            # the error falls with the width of the cells beside the edges of a flat
            force = 2 * finest.force - fine.force
            for solution in coarse:
                best, error = extrapolated(solution)
                missed += [abs(solution.force / force - 1) / own_error(solution), abs(best / force - 1) / error]
    # measured over seven grids: 88 % hold, 98 % within a factor of two
    assert np.mean(np.array(missed) < 1) > 0.8
    assert np.mean(np.array(missed) < 2) > 0.95


def test_the_estimate_is_no_idle_fear() -> None:
    (solution,) = bem.solve(compliance(fp.HalfSpace(1.0, 0.0)), fp.EllipticParaboloid(1.0, 2.0), depths=1.0, grid=256)
    assert own_error(solution) < 3e-5
    assert extrapolated(solution)[1] < 2e-5
