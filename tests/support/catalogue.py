"""Make the tables of the honesty catalogue, tests/catalogue/*.csv; run from the folder tests.

    python -m support.catalogue truth     # truth.csv: boundary elements on all cores, ten to twenty minutes
    python -m support.catalogue truth 3 17          # of these cases alone
    python -m support.catalogue judge     # catalogue.csv: errors and estimates of every method against truth.csv
    python -m support.catalogue judge refined    # the same of one method alone, the others as they are

truth.csv holds the force on two grids, so that the grid's own error is known, and the outline at equal angles.
"""

from __future__ import annotations

import csv
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliances import compliance
from flatpunch.contact.boundary_elements.expected_box import outgrown
from flatpunch.contact.boundary_elements.outlines import traced
from flatpunch.contact.refined.refinement import refinement
from support.catalogue_cases import Case, cases

HERE = Path(__file__).parents[1] / "catalogue"
ANGLES = 72
GRIDS = (512, 1024)
METHODS = ("first-order", "second-order", "fourth-order", "refined", "refined-single", "bem")
"""`refined` is judged within a range, between its solutions; `refined-single` at the one depth that was asked for; `bem` with as
many cells."""
NO_TABLE = 4.99e-4
"""Tolerance for which the solutions that come with the package, which are tested by themselves, are not used."""
_STEPS = 40
"""More than would be solved one by one."""
HEAD = ["number", "tip", "medium", "size"]


@dataclass(frozen=True)
class Truth:
    """Boundary element solution of one case; `outline` is empty where the contact has none."""

    case: Case
    depth: float
    coarse: float
    force: float
    radius: float
    area: float
    outline: np.ndarray
    converged: bool

    @property
    def grid_error(self) -> float:
        """Relative difference of the forces on the two grids, several times the error that `limit` leaves."""
        return abs(self.coarse / self.force - 1)

    @property
    def limit(self) -> float:
        """Force on vanishing cells: the error falls with the square of their width."""
        return self.force + (self.force - self.coarse) / 3


def solve(case: Case, grids: tuple[int, int] = GRIDS) -> Truth:
    """Boundary elements on a coarse and a fine grid."""
    medium, tip = case.build()
    depth = case.depth()
    kernel = compliance(medium)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fp.FlatpunchWarning)

        def solved(**box: object) -> list[bem.Solution]:
            return [bem.solve(kernel, tip, depths=depth, grid=grid, tolerance=1e-6, **box)[0] for grid in grids]

        coarse, fine = solved()
        # at edges the outline is followed along them; 360 angles so that every symmetry divides them
        trace = traced(kernel, tip, fine, 360)
        larger = outgrown(fine.grid, trace.contour)
        if larger is not None:
            print(case, "on a larger grid", flush=True)
            coarse, fine = solved(**larger)
            trace = traced(kernel, tip, fine, 360)
    outline = trace.contour[:: 360 // ANGLES]
    return Truth(
        case,
        depth,
        coarse.force,
        fine.force,
        trace.radius,
        trace.area,
        outline if np.all(np.isfinite(outline)) else np.empty(0),
        fine.converged and coarse.converged,
    )


def judge(truth: Truth, method: str) -> tuple[float, float, float, float]:
    """True error and estimate of the force (relative), and of the outline (over the mean radius).

    An outline that neither side has is no error; one that only boundary elements have counts as infinitely wrong.
    """
    medium, tip = truth.case.build()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fp.FlatpunchWarning)
        if method == "refined":
            result = _refined_within_a_range(medium, tip, truth.depth)
        elif method == "refined-single":
            # no solutions of the curve before
            refinement.cache_clear()
            single = fp.indent(medium, tip, depth=truth.depth, method=fp.Refined(rtol=NO_TABLE), angles=ANGLES)
            result = single.isel(step=0)
        else:
            result = fp.indent(medium, tip, depth=truth.depth, method=method, angles=ANGLES).isel(step=-1)
    force = abs(float(result.force) / truth.limit - 1)
    outline = float("nan")
    if truth.outline.size:
        # a result without any outline has no contour
        given = result.contour.values if "contour" in result else np.nan
        outline = float(np.max(np.abs(given - truth.outline)) / truth.radius)
        outline = outline if np.isfinite(outline) else float("inf")
    return force, float(result.force_error), outline, float(result.contour_error)


def _refined_within_a_range(medium: fp.Medium, tip: object, depth: float) -> object:
    """The refined method's answer at a depth on a curve, so that none of its solutions lies there.

    The corrections that come with the package are tested by themselves.
    """
    for beyond in (1.5, 1.05):
        depths = depth * np.unique([*np.geomspace(1 / 8, beyond, _STEPS), 1.0])
        try:
            curve = fp.indent(medium, tip, depth=depths, method=fp.Refined(rtol=NO_TABLE), angles=ANGLES)
            return curve.isel(step=int(np.searchsorted(depths, depth)))
        except ValueError:
            # the tip's shape ends there
            continue
    raise ValueError(f"depth = {depth:g} is too close to the end of the tip")


def read_truth() -> list[Truth]:
    """Rows of truth.csv."""
    with (HERE / "truth.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return [
        Truth(
            Case(int(row["number"]), row["tip"], row["medium"], float(row["size"])),
            *(float(row[name]) for name in ("depth", "coarse", "force", "radius", "area")),
            float(row["radius"]) * np.array([float(value) for value in row["outline"].split()]),
            row["converged"] == "True",
        )
        for row in rows
    ]


def make_truth(numbers: set[int] | None = None) -> None:
    """Solve all cases, or those of the given numbers while the others stay as they are."""
    lines = [
        "# Boundary elements at 1024 x 1024 cells (column coarse: force at 512 x 512); made by make.py. Lengths in layer",
        "# thicknesses. outline: a(phi)/radius at 72 equal angles from 0, empty where the contact has none.",
        ",".join([*HEAD, "depth", "coarse", "force", "radius", "area", "converged", "outline"]),
    ]
    before = {truth.case.number: truth for truth in read_truth()} if numbers is not None else {}
    wanted = [case for case in cases() if numbers is None or case.number in numbers | before.keys()]
    # those without depth lie within the flat end of the tip
    wanted = [case for case in wanted if case.depth() > 0]
    with ProcessPoolExecutor() as pool:
        new = pool.map(solve, [case for case in wanted if numbers is None or case.number in numbers])
        truths = [next(new) if numbers is None or case.number in numbers else before[case.number] for case in wanted]
    for truth in truths:
        case = truth.case
        figures = (truth.depth, truth.coarse, truth.force, truth.radius, truth.area)
        outline = " ".join(f"{value:.5f}" for value in truth.outline / truth.radius)
        head = [str(case.number), case.tip, case.medium, f"{case.size:g}"]
        lines.append(",".join([*head, *(f"{value:.9g}" for value in figures), str(truth.converged), outline]))
    (HERE / "truth.csv").write_text("\n".join(lines) + "\n")


def make_catalogue(methods: tuple[str, ...]) -> None:
    """Errors and estimates of methods against truth.csv, on all cores; other methods keep what the file says."""
    lines = [
        "# True error and estimate of every method against truth.csv; made by make.py. Forces relative, outlines over the mean",
        "# radius (nan where the contact has no outline). Blank: the method does not take this tip.",
    ]
    before = read_catalogue() if set(methods) != set(METHODS) else {}
    truths = read_truth()
    columns = [
        f"{method} {what}" for method in METHODS for what in ("force", "estimate", "outline", "outline_estimate")
    ]
    rows = [before.get(truth.case.number, {}) for truth in truths]
    with ProcessPoolExecutor() as pool:
        for row, new in zip(rows, pool.map(_entries, truths, [methods] * len(truths), chunksize=4), strict=True):
            row.update(new)
    head = [*HEAD, "grid_error", "outlined", *columns]
    lines += [",".join(head), *(",".join(row[name] for name in head) for row in rows)]
    (HERE / "catalogue.csv").write_text("\n".join(lines) + "\n")


def read_catalogue() -> dict[int, dict[str, str]]:
    """Rows of catalogue.csv by number."""
    with (HERE / "catalogue.csv").open() as file:
        return {int(row["number"]): row for row in csv.DictReader(line for line in file if not line.startswith("#"))}


def _entries(truth: Truth, methods: tuple[str, ...]) -> dict[str, str]:
    """Entries of one row of catalogue.csv."""
    case = truth.case
    row = dict(zip(HEAD, (str(case.number), case.tip, case.medium, f"{case.size:g}"), strict=True))
    row |= {"grid_error": f"{truth.grid_error:.3g}", "outlined": str(truth.outline.size)}
    for method in methods:
        entries = [""] * 4
        try:
            entries = [f"{value:.4g}" for value in judge(truth, method)]
        except ValueError as error:
            print(case, method, error, flush=True)
        names = (f"{method} {what}" for what in ("force", "estimate", "outline", "outline_estimate"))
        row |= dict(zip(names, entries, strict=True))
    print(case, flush=True)
    return row


if __name__ == "__main__":
    if sys.argv[1] == "truth":
        make_truth({int(number) for number in sys.argv[2:]} or None)
    else:
        make_catalogue(tuple(sys.argv[2:]) or METHODS)
