"""Outlines between the solutions of a curve where they change fastest: to a per cent of the mean radius."""

from __future__ import annotations

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliance import compliance
from flatpunch.contact.boundary_elements.outlines.needle import traced
from flatpunch.contact.refined.solutions import correction
from support.catalogue_cases import cases
from support.known_outlines import distance

RAYS = 2520
"""On which all edges of tips of up to ten sides lie."""
KNOWN = {case.number: case for case in cases()}


def test_distance_of_outlines() -> None:
    phi = 2 * np.pi * np.arange(360) / 360
    circle, moved = np.ones(720), 0.1 * np.cos(phi) + np.sqrt(1 - (0.1 * np.sin(phi)) ** 2)
    assert distance(moved, circle) == pytest.approx(0.1, rel=1e-3)
    # radii change by a half on the flank of this needle, which is a hundredth thicker
    needle, thicker = (1 + 9 * np.maximum(1 - np.abs(np.sin(phi / 2)) / width, 0) for width in (0.1, 0.101))
    assert np.abs(needle - thicker).max() > 5 * distance(thicker, needle)


@pytest.mark.parametrize(
    ("number", "grid"),
    [
        (42, 1024),  # ellipse, film 30
        (75, 1024),  # five sides on a layer that softens with depth, ten times as wide as it is thick
        (84, 1024),  # six sides, film 10: the contact falls apart at a little more depth
        (96, 1024),  # eight sides, film 30: eight needles
        # rounded edges, film 100: needles six mean radii long, of which nothing is to be seen at half the depth
        (212, 2048),
        (268, 1024),  # three sides, film 7
        (271, 1024),  # four sides, film 50: needles have just begun to grow
        (278, 1024),  # seven sides, film 50: needles of six mean radii, whose ends ask for looks that converge
        (
            283,
            2048,
        ),  # seven sides, film 50: from 1024 cells its needles are too short by a hundredth of the mean radius
    ],
)
def test_outline_between_solutions(number: int, grid: int) -> None:
    case = KNOWN[number]
    (medium, tip), depth = case.build(), case.depth()
    # by itself: of two contacts on one film and tip the second would lie between the solutions of the first
    correction.cache_clear()
    depths = depth * np.unique([*np.geomspace(1 / 8, 1.5, 40), 1.0])
    curve = fp.indent(medium, tip, depth=depths, method="refined", tables=False)
    found = curve.isel(step=int(np.searchsorted(depths, depth)))
    kernel = compliance(medium)
    (solution,) = bem.solve(kernel, tip, depths=depth, grid=grid, tolerance=1e-6, angles=RAYS)
    truth = traced(kernel, tip, solution, RAYS)
    assert distance(found.contour.values, truth.contour) < 0.01 * truth.radius
    assert float(found.force) == pytest.approx(solution.force, rel=1e-3)
    assert float(found.radius) == pytest.approx(truth.radius, rel=0.01)


def test_outline_between_solutions_of_another_range() -> None:
    """Needles of seven sides on film 50 grow by a half between two of them."""
    correction.cache_clear()
    for number in (278, 283):
        case = KNOWN[number]
        (medium, tip), depth = case.build(), case.depth()
        depths = depth * np.unique([*np.geomspace(1 / 8, 1.5, 40), 1.0])
        curve = fp.indent(medium, tip, depth=depths, method="refined", tables=False)
    found = curve.isel(step=int(np.searchsorted(depths, depth)))
    kernel = compliance(medium)
    (solution,) = bem.solve(kernel, tip, depths=depth, grid=1024, tolerance=1e-6, angles=RAYS)
    truth = traced(kernel, tip, solution, RAYS)
    assert distance(found.contour.values, truth.contour) < 0.01 * truth.radius
    assert float(found.contour_error) > 0.01
    assert float(found.force) == pytest.approx(solution.force, rel=1e-3)
    assert float(found.radius) == pytest.approx(truth.radius, rel=0.01)


@pytest.mark.parametrize(
    ("ratio", "sides", "inclination", "flat", "depth"),
    [
        (100, 3, 0.35, 0.2, 1.4),  # needles that begin on the flat and are up to a tenth as wide
        (100, 3, 0.35, 0.2, 2.7),
        (100, 4, 0.349, 0.044, 0.0233),  # hardly more than the flat
        (20, 4, 0.35, 0.156, 0.074),
        (2, 3, 0.7, 0.874, 0.142),
        (50, 6, 0.52, 0.25, 2.6),
        (50, 8, 0.175, 0.516, 0.253),  # corners too wide for their load to tell how wide
    ],
)
def test_outline_of_a_tip_that_is_cut_off(
    ratio: float, sides: int, inclination: float, flat: float, depth: float
) -> None:
    tip = fp.Truncated.across(fp.Pyramid(sides, inclination), flat)
    kernel = compliance(fp.Medium([fp.Layer(ratio, 0.3, thickness=1.0)], base=fp.HalfSpace(1.0, 0.3)))
    coarse, fine = (
        traced(kernel, tip, bem.solve(kernel, tip, depths=depth, grid=grid, tolerance=1e-6, angles=RAYS)[0], RAYS)
        for grid in (256, 1024)
    )
    assert distance(coarse.contour, fine.contour) < 0.01 * fine.radius
    assert coarse.radius == pytest.approx(fine.radius, rel=3e-3)
    assert coarse.area == pytest.approx(fine.area, rel=6e-3)
