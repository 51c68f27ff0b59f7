"""Contacts in several parts, or with slits beside their needles: mean radius and area, though there may be no outline."""

from __future__ import annotations

import numpy as np
import pytest
from flatpunch.contact.boundary_elements.outlines.needle import traced
from flatpunch.contact.boundary_elements.outlines.parts import EXCESS, ray_and_area, star_of

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliance import compliance

THREE, FOUR = fp.Pyramid(3, 0.35), fp.Pyramid(4, 0.35)


def film(ratio: float) -> fp.Medium:
    """So many times stiffer than its base."""
    return fp.Medium([fp.Layer(ratio, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))


def solved(ratio: float, tip: fp.Pyramid | fp.Rounded, depth: float, cells: int) -> bem.Solution:
    """On such a film."""
    return bem.solve(compliance(film(ratio)), tip, depths=depth, grid=cells, tolerance=1e-6)[0]


def looked_at(ratio: float, tip: fp.Pyramid | fp.Rounded, solution: bem.Solution) -> tuple[float, float, bool]:
    """Mean radius, area, and whether there is an outline."""
    trace = traced(compliance(film(ratio)), tip, solution, 360)
    return trace.radius, trace.area, bool(np.isfinite(trace.contour).all())


def test_cells_of_a_ring() -> None:
    """As contacts have them, whose rims reach a little too far: on average over rings neither length nor area is off."""
    grid = bem.Grid(64, 64, 2.5 / 64)
    r = np.hypot(grid.x[None, :], grid.y[:, None])
    found = []
    for outer in np.linspace(0.9, 1.1, 101):
        cells = (r < outer + EXCESS * grid.spacing) & (r > outer / 2 - EXCESS * grid.spacing)
        ray, area = ray_and_area(grid, cells)
        found.append((ray / (outer / 2), area / (0.75 * np.pi * outer**2)))
    # without what they are too many it would be 0.011 and 0.009
    np.testing.assert_allclose(np.mean(found, axis=0), 1.0, atol=1.5e-3)


@pytest.mark.parametrize(
    ("ratio", "tip", "depth", "counted", "true_radius", "true_area"),
    [
        # from 2048 cells a side, looked at in the same way: by then 1024 change them by up to 0.1 %
        (50.0, THREE, 6.0, 0.25, 1.0154, 20.790),  # needles half a cell wide; islands have just come down
        (50.0, THREE, 9.6, 0.05, 5.290, 284.32),
        (
            100.0,
            THREE,
            9.25,
            0.25,
            1.8778,
            85.466,
        ),  # needles that are looked at from beyond the point of first touch on
        (50.0, FOUR, 6.067, 0.05, 1.0997, 18.610),
        (50.0, fp.Rounded(FOUR, 1.0), 8.16, 0.015, 3.655, 145.58),
    ],
)
def test_needles_with_islands_beside_them(
    ratio: float, tip: fp.Pyramid | fp.Rounded, depth: float, counted: float, true_radius: float, true_area: float
) -> None:
    """By their cells they are too large by more than `counted`; looked at, 256 cells tell what 2048 do."""
    rough = solved(ratio, tip, depth, 256)
    radius, area, outlined = looked_at(ratio, tip, rough)
    assert not outlined
    assert radius == pytest.approx(true_radius, rel=5e-3)
    assert area == pytest.approx(true_area, rel=8e-3)
    assert rough.area > (1 + counted) * true_area


def test_slits_beside_needles_do_not_count() -> None:
    """Three sides, film 10: lobes on either side of each needle. Counted on 1024 cells both are right to a few thousandths."""
    rough, fine = (solved(10.0, THREE, 6.1256, cells) for cells in (256, 1024))
    radius, area, _ = looked_at(10.0, THREE, rough)
    true_radius, true_area = ray_and_area(fine.grid, fine.contact)
    assert radius == pytest.approx(true_radius, rel=6e-3)
    assert area == pytest.approx(true_area, rel=8e-3)


def test_islands_within_a_look_at_the_core_count_once() -> None:
    """Four sides, film 10: by the star they once counted too, the radius was 8 and the area 9 % too large."""
    rough, fine = (solved(10.0, FOUR, 3.044, cells) for cells in (256, 1024))
    radius, area, outlined = looked_at(10.0, FOUR, rough)
    true_radius, true_area = ray_and_area(fine.grid, fine.contact)
    assert not outlined
    assert radius == pytest.approx(true_radius, rel=8e-3)
    assert area == pytest.approx(true_area, rel=8e-3)


def test_islands_are_told_from_pieces_of_needles() -> None:
    solution = solved(50.0, THREE, 6.0, 256)
    outline, islands = star_of(compliance(film(50.0)), THREE, solution, 360)
    assert np.isfinite(outline.contour).all()
    rows, columns = np.nonzero(islands)
    x, y = solution.grid.x[columns], solution.grid.y[rows]
    # on the faces, in the middle between the edges at 60, 180 and 300 degrees, and far from the point of first touch
    off = np.abs(np.mod(np.arctan2(y, x) + np.pi / 3, 2 * np.pi / 3) - np.pi / 3)
    assert off.max() < np.pi / 6
    assert np.hypot(x, y).min() > 4.0


def test_parts_along_a_line_have_smaller_cells() -> None:
    """A needle of 340 thicknesses with islands: on 256 cells a side the radius was too large by half, the area by four times."""
    contact = fp.indent(film(100.0), fp.Knoop(), depth=13.6, method="refined")
    # from 2048 cells a side
    assert contact.force.item() == pytest.approx(958.30, rel=1e-3)
    assert contact.force.item() == pytest.approx(958.30, rel=contact.force_error.item())
    assert contact.radius.item() == pytest.approx(2.217, rel=0.03)
    assert contact.area.item() == pytest.approx(146.18, rel=0.05)


@pytest.mark.parametrize("share", [1 - 1e-6, 1.0001, 1.001])
def test_needles_of_hundreds_of_thicknesses_are_looked_at_to_the_end(share: float) -> None:
    """Looks along them need more than 400 iterations; given up, radii were too large by 40 %, areas by four times."""
    contact = fp.indent(film(100.0), fp.Knoop(), depth=13.6 * share, method="refined")
    assert contact.radius.item() == pytest.approx(2.217, rel=0.03)
    assert contact.area.item() == pytest.approx(146.18, rel=0.06)


def test_force_in_parts_has_an_estimate() -> None:
    """It once grew with outlines carried on from before the contact came apart, beyond all bounds."""
    contact = fp.indent(film(100.0), fp.Knoop(), depth=np.linspace(13.0, 14.5, 20), method="refined")
    assert np.isnan(contact.contour).all()
    assert contact.force_error.min() > 1e-4
    assert contact.force_error.max() < 4e-3


def test_islands_beside_the_point_of_first_touch() -> None:
    """Sixty thicknesses wide, of a star of few cells among them: the look at its core has nothing that is surely its own."""
    film, tip = fp.Medium([fp.Layer(400e9, 0.22, 0.5e-6)], base=fp.HalfSpace(8e9, 0.35)), fp.Pyramid(3, 0.431096)
    kernel, worn = compliance(film), fp.Rounded(tip, 80e-9)
    coarse, fine = (
        traced(kernel, worn, bem.solve(kernel, worn, depths=2.313232937e-5, grid=n, tolerance=1e-6)[0], 360)
        for n in (256, 384)
    )
    assert np.isnan(coarse.contour).all()
    assert coarse.radius == pytest.approx(fine.radius, rel=0.06)
    assert coarse.area == pytest.approx(fine.area, rel=0.04)
