"""One boundary element solution of a curve, as the numbers that are kept of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flatpunch import bem
from flatpunch._support.checks import Array
from flatpunch._support.paths import Plain
from flatpunch.compliances import Kernel
from flatpunch.contact.boundary_elements import error
from flatpunch.contact.boundary_elements.expected_box import traced_whole
from flatpunch.contact.boundary_elements.method import TOLERANCE
from flatpunch.indenters.profile import Indenter

STIFFNESS_ERROR = 3e-3
"""Error of dln F/dln d, and deviation of the displacement under the punch that it comes from, which leaves less than the cells
do; with half of it slopes correct forces that are more accurate, and the punches take longer."""


@dataclass(frozen=True, slots=True)
class Case:
    """Medium, indenter, number of polar angles of the outline, cells per side of the grid."""

    kernel: Kernel
    indenter: Indenter
    angles: int
    cells: int


@dataclass(frozen=True, slots=True)
class Sample:
    """What is kept of one solution.

    Attributes
    ----------
    force, growth : float
        ln F/E* [m^2], extrapolated to vanishing cells, and dln F/dln d.
    shape : ndarray, shape (2 + angles,)
        ln of mean radius, of sqrt(area/pi) and of the outline a(phi) [m]; NaN where the contact has no outline.
    force_error, shape_error : float
        Estimated errors: relative of the force, and of the outline over the mean radius; infinite if it did not converge.
    notes : tuple of str
        What a user should know of the solution.
    """

    force: float
    growth: float
    shape: Array
    force_error: float
    shape_error: float
    notes: tuple[str, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether the solution converged."""
        return bool(np.isfinite(self.force_error))

    @property
    def outlined(self) -> bool:
        """Whether the contact has an outline."""
        return bool(np.isfinite(self.shape[2:]).all())


def solved(case: Case, place: tuple[float, Array, Array, bool]) -> Sample:
    """Solve at a place: depth [m], expected half-widths and centre of the contact [m], and whether these are well known."""
    sample = _solved_on(case, place, case.cells)
    # estimated error of the force above which a contact is solved again on half as wide cells, at five times the cost
    unresolved = sample.converged and sample.force_error > 2e-3
    return _solved_on(case, place, 2 * case.cells) if unresolved else sample


def _solved_on(case: Case, place: tuple[float, Array, Array, bool], cells: int) -> Sample:
    """Solution on so many cells a side."""
    depth, half_widths, center, sure = place
    options: Plain = {
        "depths": depth,
        "grid": cells,
        "tolerance": TOLERANCE,
        "stiffness": STIFFNESS_ERROR,
        "angles": case.angles,
    }

    def solve(**box: Any) -> bem.Solution:
        return bem.solve(case.kernel, case.indenter, **box, **options)[0]

    try:
        solution = solve(half_widths=half_widths, centers=center, search=not sure)
    except bem.ContactTouchesEdge:
        # the expected box may be far off under stiff films
        solution = solve()
    solution, trace = traced_whole(case.kernel, case.indenter, solution, case.angles, solve)
    force, force_error = error.extrapolated(solution, case.indenter)
    return Sample(
        force=float(np.log(force / case.kernel.modulus)),
        growth=solution.stiffness * depth / solution.force,
        shape=np.log([trace.radius, np.sqrt(trace.area / np.pi), *trace.contour]),
        force_error=force_error if solution.converged else float("inf"),
        shape_error=trace.error if solution.converged else float("inf"),
        notes=() if solution.converged else solution.notes,
    )
