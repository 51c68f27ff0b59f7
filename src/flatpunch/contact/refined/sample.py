"""One boundary element solution of a curve, as the numbers that are kept of it.

Solutions are kept on disk, one file for each medium, tip and grid. The key is made of what the numbers depend on: samples of
the medium's response, its length and the tip's heights, beside its record. The modulus is not among them, forces are kept over
it.
"""

from __future__ import annotations

import hashlib
import io
import json
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch import bem
from flatpunch._support.checks import Array, FlatpunchWarning
from flatpunch._support.paths import Plain
from flatpunch._support.readable import record
from flatpunch._support.reading import Unreadable, archived_arrays, content
from flatpunch._support.whole_file import BrokenSeal, sealed, unsealed, write_whole
from flatpunch.compliances import Kernel
from flatpunch.contact.boundary_elements import error
from flatpunch.contact.boundary_elements.expected_box import traced_whole
from flatpunch.contact.boundary_elements.method import TOLERANCE
from flatpunch.indenters._common import SCATTERED
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


class SampleCache:
    """Solutions of one medium and tip in one file of a folder, which is made when first needed."""

    def __init__(self, folder: Path, kernel: Kernel, indenter: Indenter, angles: int, cells: int) -> None:
        self.path = Path(folder) / f"refined-{_key(kernel, indenter, angles, cells)}.npz"

    def load(self) -> tuple[dict[float, Sample], list[Any]]:
        """Solutions by position ln d, and rows of the gaps between them; none if the file is missing or damaged."""
        if not self.path.exists():
            return {}, []
        try:
            # largest file of solutions that is read [bytes]
            body, has_seal = unsealed(content(self.path, 1_000_000_000))
            if not has_seal:
                raise BrokenSeal("it has no seal")
            found = archived_arrays(body)
            samples = {
                x: Sample(force, growth, shape, *errors)
                for (x, force, growth, *errors), shape in zip(found["numbers"].tolist(), found["shapes"], strict=True)
            }
            return samples, found["gaps"].tolist()
        except (ValueError, KeyError) as error:
            reason = str(error) if isinstance(error, (BrokenSeal, Unreadable)) else type(error).__name__
            with suppress(OSError):
                self.path.replace(self.path.with_name(f"{self.path.name}.damaged"))
            _warn(
                f"{self.path}: damaged or changed after it was written ({reason}). It is set aside, and solved again."
            )
            return {}, []

    def save(self, samples: dict[float, Sample], gaps: Sequence[Any]) -> None:
        """Write all, whole or not at all; a full or read-only disk costs the file, not the result."""
        numbers = [(x, s.force, s.growth, s.force_error, s.shape_error) for x, s in samples.items()]
        shapes = np.array([sample.shape for sample in samples.values()])
        buffer = io.BytesIO()
        np.savez_compressed(buffer, numbers=numbers, shapes=shapes, gaps=np.array(gaps))
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(self.path, sealed(buffer.getvalue()))
        except OSError as error:
            _warn(f"{self.path}: solutions cannot be kept ({error.strerror or error}); the result does not need them.")


def _warn(message: str) -> None:
    warnings.warn(message, FlatpunchWarning, stacklevel=4)


def _key(kernel: Kernel, indenter: Indenter, angles: int, cells: int) -> str:
    response = kernel.response(np.geomspace(1e-4, 100.0, 100))
    scale = indenter.reach if np.isfinite(indenter.reach) else 1.0
    r, phi = scale * np.geomspace(1e-6, 1.0, 100)[:, None], SCATTERED[::10]
    heights = np.asarray(indenter.height(r, phi))
    # the first is the number of the format; media and tips that agree to eleven digits share a file
    parts = [10, angles, cells, f"{kernel.length:.11g}", kernel.exponent, record(indenter)]
    digest = hashlib.sha256(json.dumps(parts, sort_keys=True).encode())
    for samples in (response, heights):
        digest.update(" ".join(f"{value:.11g}" for value in samples.ravel()).encode())
    return digest.hexdigest()[:32]
