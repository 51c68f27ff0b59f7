"""Files that appear whole or not at all: written under a temporary name in the same folder, then renamed.

Whether they can be written is asked before anything is solved.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

UNFINISHED = ".unfinished-"
"""How temporary names begin: what a killed process left behind is known by it."""


def check_target(option: str, path: Path | None, endings: tuple[str, ...]) -> None:
    """Refuse a file that could not be written in the end, before anything is solved; None is no file."""
    if path is None:
        return
    if path.suffix.lower() not in endings:
        raise ValueError(f"{option} {path}: the ending must be {' or '.join(endings)}.")
    if not path.parent.is_dir():
        raise ValueError(f"{option} {path}: the folder {path.parent} does not exist. Make it first.")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary file next to `path` that takes its place at the end, or vanishes if anything goes wrong.

    Parameters
    ----------
    path : Path
        Target; the temporary file has the same ending.

    Yields
    ------
    Path
        The temporary file, empty.
    """
    handle, name = tempfile.mkstemp(prefix=UNFINISHED, suffix=path.suffix, dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        _with_usual_rights(temporary)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it appears whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_bytes(content)


def _with_usual_rights(path: Path) -> None:
    """Temporary files are private; give the result the rights that any new file gets."""
    mask = os.umask(0)
    os.umask(mask)
    path.chmod(0o666 & ~mask)
