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
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.checks import FlatpunchWarning
from flatpunch._support.readable import record
from flatpunch._support.reading import Unreadable, content
from flatpunch._support.whole_file import BrokenSeal, sealed, unsealed, write_whole
from flatpunch.compliances import Kernel
from flatpunch.contact.refined.sample import Sample
from flatpunch.indenters._common import SCATTERED
from flatpunch.indenters.profile import Indenter


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
            with np.load(io.BytesIO(body), allow_pickle=False) as file:
                numbers, shapes = file["numbers"], file["shapes"]
                samples = {
                    x: Sample(force, growth, shape, *errors)
                    for (x, force, growth, *errors), shape in zip(numbers.tolist(), shapes, strict=True)
                }
                return samples, file["gaps"].tolist()
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
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
        np.savez_compressed(buffer, numbers=numbers, shapes=shapes, gaps=np.reshape(gaps, (-1, 5)))
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
