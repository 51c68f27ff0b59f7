"""Files that were dropped on the page: kept in memory by their content, and written to a folder only while they are read."""

from __future__ import annotations

import hashlib
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from flatpunch.app.form import FormError
from flatpunch.app.limits import LIMITS
from flatpunch.app.store import Store
from flatpunch.files import shipped_cases

_SHIPPED = "shipped/"
_IN_MEMORY = Path("/dev/shm")
"""A folder that is memory, where the system has it."""


@dataclass(frozen=True)
class Upload:
    """A file: its name without a folder, and its content."""

    name: str
    content: bytes

    @contextmanager
    def written(self) -> Iterator[Path]:
        """Give a path to the file that ends with the block."""
        where = _IN_MEMORY if _IN_MEMORY.is_dir() else None
        with tempfile.TemporaryDirectory(prefix="flatpunch-", dir=where) as folder:
            path = Path(folder) / self.name
            path.write_bytes(self.content)
            yield path


class Uploads:
    """Files by the text of the field `upload`: a digest of the content and the name, so that nobody can ask for another's."""

    def __init__(self) -> None:
        self._kept: Store[Upload] = Store(LIMITS.uploads, lambda upload: len(upload.content))

    def put(self, name: str, content: bytes) -> str:
        """Keep a file; return the text of the field."""
        clean = re.sub(r"[^\w.() +-]", "_", Path(name.replace("\\", "/")).name)[-100:].lstrip(". ") or "curve"
        key = f"{hashlib.sha256(content).hexdigest()}/{clean}"
        self._kept.put(key, Upload(clean, content))
        return key

    def get(self, key: str) -> Upload:
        """Return a file; FormError if none was given, or it is no longer kept."""
        if key.startswith(_SHIPPED):
            path = shipped_cases()[0].parent / "fit" / Path(key).name
            if path.suffix == ".csv" and path.is_file():
                return Upload(path.name, path.read_bytes())
        if not key:
            raise FormError("drop the file of a measured curve here, or choose one.", "upload")
        found = self._kept.get(key)
        if found is None:
            raise FormError(f"{Path(key).name} is no longer in memory; drop it here again.", "upload")
        return found


def shipped_fits() -> list[Path]:
    """Case files of fits that come with the package, each with its curve beside it."""
    return sorted((shipped_cases()[0].parent / "fit").glob("*.toml"))
