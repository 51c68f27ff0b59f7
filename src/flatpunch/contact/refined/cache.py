"""Boundary element solutions kept on disk, one file for each medium, tip and grid.

The key is made of what the numbers depend on: samples of the medium's response, its length and the tip's heights, beside its
record. The modulus is not among them, forces are kept over it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.record import record
from flatpunch._support.whole_file import whole_file
from flatpunch.compliance import Kernel
from flatpunch.contact.refined.sample import Sample
from flatpunch.indenters.profile import Indenter

_FORMAT = 10
"""Number of the format of the files; those of other numbers are not found."""

_DIGITS = 11
"""Digits to which media and tips must agree to share a file."""


class SampleCache:
    """Solutions of one medium and tip in one file of a folder.

    Parameters
    ----------
    folder : Path
        Where files are kept; made when first needed.
    kernel, indenter
        Medium and indenter.
    angles, cells : int
        Polar angles of the outline and cells per side of the grids.
    """

    def __init__(self, folder: Path, kernel: Kernel, indenter: Indenter, angles: int, cells: int) -> None:
        self.path = Path(folder) / f"refined-{_key(kernel, indenter, angles, cells)}.npz"

    def load(self) -> tuple[dict[float, Sample], list[Any]]:
        """Solutions by position ln d, and rows of the gaps between them; nothing if the file is missing or damaged."""
        try:
            with np.load(self.path) as file:
                numbers, shapes = file["numbers"], file["shapes"]
                samples = {
                    x: Sample(force, growth, shape, *errors)
                    for (x, force, growth, *errors), shape in zip(numbers.tolist(), shapes, strict=True)
                }
                return samples, file["gaps"].tolist()
        except (OSError, ValueError, KeyError):
            return {}, []

    def save(self, samples: dict[float, Sample], gaps: Sequence[Any]) -> None:
        """Write all; the file appears whole or not at all."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        numbers = [(x, s.force, s.growth, s.force_error, s.shape_error) for x, s in samples.items()]
        shapes = np.array([sample.shape for sample in samples.values()])
        with whole_file(self.path) as temporary:
            np.savez_compressed(temporary, numbers=numbers, shapes=shapes, gaps=np.reshape(gaps, (-1, 5)))


def _key(kernel: Kernel, indenter: Indenter, angles: int, cells: int) -> str:
    response = kernel.response(np.geomspace(1e-4, 30.0, 60))
    scale = indenter.reach if np.isfinite(indenter.reach) else 1.0
    r, phi = scale * np.geomspace(1e-6, 1.0, 25)[:, None], 2 * np.pi * np.arange(97) / 97
    heights = np.asarray(indenter.height(r, phi))
    parts = [_FORMAT, angles, cells, f"{kernel.length:.{_DIGITS}g}", kernel.exponent, record(indenter)]
    digest = hashlib.sha256(json.dumps(parts, sort_keys=True).encode())
    for samples in (response, heights):
        digest.update(" ".join(f"{value:.{_DIGITS}g}" for value in samples.ravel()).encode())
    return digest.hexdigest()[:32]
