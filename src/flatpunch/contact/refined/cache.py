"""Boundary element solutions kept on disk, one file for each medium, tip and grid.

The key is made of what the numbers depend on: samples of the medium's response, its length and the tip's heights, beside its
record. The modulus is not among them, forces are kept over it.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.record import record
from flatpunch._support.whole_file import whole_file
from flatpunch.compliance import Kernel
from flatpunch.indenters.profile import Indenter

_FORMAT = 9
_DIGITS = 11


class CorrectionCache:
    """Nodes of one correction in one file of a folder.

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
        self.path = Path(folder) / f"correction-{_key(kernel, indenter, angles, cells)}.npz"

    def load(self) -> dict[float, Array]:
        """Rows of solutions by position ln d; empty if there are none yet or the file cannot be read."""
        try:
            with np.load(self.path) as file:
                return dict(zip(file["positions"].tolist(), file["rows"], strict=True))
        except (OSError, ValueError, KeyError):
            return {}

    def save(self, known: dict[float, Array]) -> None:
        """Write all rows; the file appears whole or not at all."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(self.path) as temporary:
            np.savez_compressed(temporary, positions=np.array(list(known)), rows=np.array(list(known.values())))


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
