"""Expected boxes of contacts, and narrow lobes that outgrow them."""

from __future__ import annotations

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliances import compliance
from flatpunch.contact.boundary_elements.expected_box import boxes_around, boxes_between, level_line, outgrown
from flatpunch.contact.boundary_elements.outlines import traced
from flatpunch.contact.refined.interpolation import RoundReference
from flatpunch.contact.refined.sample import Case, solved
from flatpunch.indenters import Rounded
from flatpunch.indenters.profile import Indenter

PHI = 2 * np.pi * np.arange(360) / 360


def _film(ratio: float) -> fp.Medium:
    return fp.Medium([fp.Layer(ratio, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))


@pytest.mark.parametrize(
    "medium", [fp.HalfSpace(1.0, 0.3), _film(0.1), _film(4.0)], ids=["half-space", "soft", "stiff"]
)
@pytest.mark.parametrize(
    "tip", [fp.Pyramid(3, 0.3), fp.Pyramid(4, 0.3), fp.EllipticParaboloid(1.0, 0.1), fp.EllipticParaboloid(0.1, 1.0)]
)
def test_first_boxes_hold_the_contact_and_not_much_more(medium: fp.Medium, tip: Indenter) -> None:
    """A coarse grid around the box has a rim of a quarter; a contact that fills less than half of it is looked for anew."""
    kernel, depth = compliance(medium), 0.1
    radius = np.exp(RoundReference(kernel, tip).at(np.log([depth]))[2])
    (half_widths,), (center,), (sure,) = boxes_between(np.log([depth]), {}, radius, level_line(tip, PHI), PHI)
    (solution,) = bem.solve(kernel, tip, depths=depth, grid=128)
    (true,), (middle,) = boxes_around(solution.outline.contour[None], PHI)
    assert not sure
    assert (np.abs(middle - center) + true < 1.2 * half_widths).all()
    assert (true > 0.6 * half_widths).all()


def test_boxes_between_solutions_are_those_of_the_outlines() -> None:
    phi, positions = PHI, np.array([0.5])
    known = {0.0: np.zeros(360), 1.0: np.full(360, 0.8), 2.0: np.full(360, np.nan)}
    half_widths, center, sure = boxes_between(positions, known, np.array([9.0]), np.zeros(360), phi)
    assert half_widths[0] == pytest.approx(np.exp(0.4))
    assert (center == 0).all()
    assert sure.all()
    # next to a contact without outline only the round contact is known
    half_widths, _, sure = boxes_between(positions + 1, known, np.array([9.0]), np.zeros(360), phi)
    assert half_widths[0] == pytest.approx(9.0)
    assert not sure.any()


def test_level_lines() -> None:
    line = level_line(fp.Pyramid(4, 0.3), PHI)
    assert np.ptp(line) == pytest.approx(np.log(np.sqrt(2)), rel=1e-12)
    assert line.mean() == pytest.approx(0.0, abs=1e-12)
    # which change their shape with the height
    assert (level_line(Rounded(fp.Pyramid(4, 0.3), 0.1, true_sphere=False), PHI) == 0).all()


@pytest.mark.long
def test_a_narrow_lobe_that_outgrows_its_box() -> None:
    """256 cells lose the last hundredths of it, so that the contact of the cells does not touch the edge."""
    tip, depth = fp.Pyramid(3, 0.4), 1.0
    case = Case(compliance(_film(50.0)), tip, 360, 256)
    # the lobe along negative x leaves the first of these by a hundredth
    narrow = (depth, np.array([0.78, 0.95]), np.array([1.25 * 0.78 - 1.19, 0.0]), True)
    wide = (depth, np.array([1.0, 1.0]), np.array([-0.3, 0.0]), True)
    (cut,) = bem.solve(
        case.kernel, tip, depths=depth, half_widths=narrow[1], centers=narrow[2], search=False, grid=256, tolerance=1e-6
    )
    whole = np.exp(solved(case, wide).shape[2:])
    edge = cut.grid.x[0] - cut.grid.spacing / 2
    assert edge == pytest.approx(-1.19, abs=cut.grid.spacing)
    assert whole.max() > -edge
    again = np.exp(solved(case, narrow).shape[2:])
    assert again.max() == pytest.approx(whole.max(), rel=1e-3)
    # farthest point from 4096 cells
    assert again.max() == pytest.approx(1.2087, abs=0.03 * 0.364)


@pytest.mark.long
def test_boundary_elements_solve_what_outgrows_its_grid_on_a_larger_one() -> None:
    """At this depth the lobes of the first solution end 0.14 mean radii too early, at the edge of its grid."""
    tip, kernel = fp.Pyramid(3, 0.4), compliance(_film(50.0))
    (cut,) = bem.solve(kernel, tip, depths=1.4374, grid=128, tolerance=1e-11)
    contour = traced(kernel, tip, cut, 360).contour
    larger = outgrown(cut.grid, contour)
    assert larger is not None
    curve = fp.indent(_film(50.0), tip, depth=[0.3, 1.4374], method=fp.BoundaryElements(grid=128))
    fine = fp.indent(_film(50.0), tip, depth=1.4374, method=fp.BoundaryElements(grid=512))
    radius = float(fine.radius[0])
    assert contour.max() < float(fine.contour.max()) - 0.05 * radius
    off = abs(float(curve.contour[1].max()) - float(fine.contour.max())) / radius
    assert off < float(curve.contour_error[1] + fine.contour_error[0])
    # a grid that was asked for stays
    same = fp.indent(_film(50.0), tip, depth=1.4374, method=fp.BoundaryElements(grid=cut.grid, tolerance=1e-11))
    # two starts, each solved to 1e-11 of the depth
    assert float(same.contour.max()) == pytest.approx(contour.max(), rel=2e-6)
