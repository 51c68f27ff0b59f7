"""What the page keeps in memory, the oldest first to go: results of cases by their form, and files that were dropped on it.

Files are kept by their content, and written to a folder only while they are read.
"""

from __future__ import annotations

import hashlib
import re
import tempfile
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from flatpunch.app.form import FormError
from flatpunch.app.limits import LIMITS
from flatpunch.files import shipped_cases

Kept = TypeVar("Kept")


class Store(Generic[Kept]):
    """Things by name, up to so many bytes together; `size` gives the bytes of one."""

    def __init__(self, most: int, size: Callable[[Kept], int]) -> None:
        self._most, self._size = most, size
        self._things: OrderedDict[str, Kept] = OrderedDict()
        self._total = 0
        self._lock = threading.Lock()

    def put(self, name: str, thing: Kept) -> None:
        """Keep a thing; one of the same name is replaced."""
        with self._lock:
            self._drop(name)
            self._things[name] = thing
            self._total += self._size(thing)
            while self._total > self._most and len(self._things) > 1:
                self._drop(next(iter(self._things)))

    def get(self, name: str) -> Kept | None:
        """Return a thing, which becomes the youngest; None if it is not here, or no longer."""
        with self._lock:
            if name in self._things:
                self._things.move_to_end(name)
            return self._things.get(name)

    def _drop(self, name: str) -> None:
        thing = self._things.pop(name, None)
        self._total -= 0 if thing is None else self._size(thing)


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
        self._kept: Store[Upload] = Store(LIMITS.kept, lambda upload: len(upload.content))

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
