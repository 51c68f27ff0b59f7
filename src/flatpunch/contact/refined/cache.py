"""Boundary element solutions kept on disk, one file for each medium, tip and grid.

The key is made of what the numbers depend on: samples of the medium's response, its length and the tip's heights, beside its
record. The modulus is not among them, forces are kept over it.
"""

from __future__ import annotations

import hashlib
import io
import json
import warnings
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np

from flatpunch._support.checks import Array, FlatpunchWarning
from flatpunch._support.reading import Unreadable, content
from flatpunch._support.record import record
from flatpunch._support.sealed import BrokenSeal, sealed, unsealed
from flatpunch._support.whole_file import write_whole
from flatpunch.compliance import Kernel
from flatpunch.indenters.profile import Indenter

_FORMAT = 9
_LARGEST = 1_000_000_000
"""Largest file of solutions that is read [bytes]."""
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
        """Rows of solutions by position ln d; empty if there are none yet, or the file is damaged, which is said."""
        if not self.path.exists():
            return {}
        try:
            body, has_seal = unsealed(content(self.path, _LARGEST))
            if not has_seal:
                raise BrokenSeal("it has no seal")
            with np.load(io.BytesIO(body), allow_pickle=False) as file:
                return _rows(file["positions"], file["rows"])
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            reason = str(error) if isinstance(error, (BrokenSeal, Unreadable)) else type(error).__name__
            with suppress(OSError):
                self.path.replace(self.path.with_name(f"{self.path.name}.damaged"))
            _warn(
                f"{self.path}: damaged or changed after it was written ({reason}). It is set aside, and solved again."
            )
            return {}

    def save(self, known: dict[float, Array]) -> None:
        """Write all rows, whole or not at all; a full or read-only disk costs the file, not the result."""
        buffer = io.BytesIO()
        np.savez_compressed(buffer, positions=np.array(list(known)), rows=np.array(list(known.values())))
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(self.path, sealed(buffer.getvalue()))
        except OSError as error:
            _warn(f"{self.path}: solutions cannot be kept ({error.strerror or error}); the result does not need them.")


def _rows(positions: Array, rows: Array) -> dict[float, Array]:
    """Rows by position, if they have the form of such."""
    good = positions.dtype == rows.dtype == np.float64 and positions.ndim == 1 and rows.ndim == 2
    if not good or len(positions) != len(rows) or not np.isfinite(positions).all():
        raise BrokenSeal("it holds no rows of solutions")
    return dict(zip(positions.tolist(), rows, strict=True))


def _warn(message: str) -> None:
    warnings.warn(message, FlatpunchWarning, stacklevel=4)


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
