"""Files of an archive (.zip), unpacked into a folder of their own while they are read."""

from __future__ import annotations

import re
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path

from flatpunch.fit.measured.curve import CurveError


def unpacked(path: Path) -> Iterator[Path]:
    """The files of an archive one after the other, in the order of their names.

    Raises
    ------
    CurveError
        If the archive is damaged or has a password.
    """
    try:
        with zipfile.ZipFile(path) as archive, tempfile.TemporaryDirectory() as folder:
            for name in sorted((name for name in archive.namelist() if not name.endswith("/")), key=by_number):
                # members of the same name in two folders are read before the next one takes their place
                inner = Path(folder) / Path(name).name
                inner.write_bytes(archive.read(name))
                yield inner
    # what `zipfile` and `zlib` raise on a damaged directory or member: an encrypted member is a RuntimeError, a name that is no
    # text a ValueError
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError, ValueError):
        raise CurveError(
            f"{path.name}: its files cannot be unpacked. It is damaged, or has a password; give it as it was made, or unpack it."
        ) from None


def by_number(name: str) -> list[tuple[int, str]]:
    """Key that sorts names as people count: curve2 before curve10."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", name)]
