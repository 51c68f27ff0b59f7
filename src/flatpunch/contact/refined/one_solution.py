"""One boundary element solution as a row of numbers: what corrections keep, and what helping processes make of a depth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flatpunch import bem
from flatpunch._support.checks import Array
from flatpunch.bem.grid import Grid
from flatpunch.compliance import Kernel
from flatpunch.contact.boundary_elements.expected_box import traced_whole
from flatpunch.contact.boundary_elements.outlines import Trace
from flatpunch.indenters.profile import Indenter

_TOLERANCE, _STIFFNESS_TOLERANCE = 1e-6, 3e-3
"""Gap error of the solutions, and of the punches that tell dF/dd: it leaves 4e-4 of that, less than what the cells do."""

_COARSE = 0.06
"""Cells over the mean radius from which on stars deserve smaller ones: there these are off by several per cent."""
_LONG = 4
"""Sides of the grid over each other from which on contacts in several parts do too: radii were off by half with 256 a side."""

FORCE, GROWTH, CHANGE, RADIUS, AREA, OUTLINE = 0, 1, 2, 3, 4, 5
"""Columns of a solution: ln F/E* [m^2], dln F/dln d, what extrapolation to vanishing cells has added to ln F, ln a0 [m],
ln sqrt(A/pi) [m], and from OUTLINE on ln a(phi) [m]."""


@dataclass(frozen=True, slots=True)
class Case:
    """Medium, indenter, polar angles of the outline and cells per side of the grid."""

    kernel: Kernel
    indenter: Indenter
    angles: int
    cells: int


Place = tuple[float, Array, Array, bool, bool]
"""Depth [m], expected half-widths and centre of the contact [m], whether they are well known, and whether this is no curve."""


def solved_row(case: Case, place: Place) -> tuple[Array, tuple[str, ...]]:
    """Row of the solution at a place, and what a user should know if it did not converge.

    Contacts in several parts along a line are solved anew on twice the cells a side; so are stars where this is no curve, which
    could not afford many.
    """
    solution, trace = _solved(case, place, case.cells)
    scattered = not np.isfinite(trace.contour[0]) and _aspect(solution.grid) > _LONG
    if scattered or (place[-1] and solution.grid.spacing > _COARSE * trace.radius):
        solution, trace = _solved(case, place, 2 * case.cells)
    lengths = np.array([trace.radius, np.sqrt(trace.area / np.pi), *trace.contour])
    force, growth = solution.extrapolated_force, solution.stiffness * solution.depth / solution.force
    row = np.array([np.log(force / case.kernel.modulus), growth, np.log(force / solution.force), *np.log(lengths)])
    return row, () if solution.converged else solution.notes


def _aspect(grid: Grid) -> float:
    """Longer over shorter side."""
    return max(grid.nx / grid.ny, grid.ny / grid.nx)


def _solved(case: Case, place: Place, cells: int) -> tuple[bem.Solution, Trace]:
    """Solution and outline on a grid of so many cells a side."""
    depth, half_widths, center, sure, _ = place
    options: dict[str, Any] = {
        "grid": cells,
        "tolerance": _TOLERANCE,
        "stiffness": _STIFFNESS_TOLERANCE,
        "angles": case.angles,
    }

    def solved(**box: Any) -> bem.Solution:
        (solution,) = bem.solve(case.kernel, case.indenter, depths=depth, **box, **options)
        return solution

    try:
        solution = solved(half_widths=half_widths, centers=center, search=not sure)
    except bem.ContactTouchesEdge:
        # under stiff films the series may expect outlines far off: then the contact is looked for by itself
        solution = solved()
    return traced_whole(case.kernel, case.indenter, solution, case.angles, solved)
