"""Files of a running command: none of its outputs replaces a file that it reads, or another of its outputs.

Inputs are noted where they are read (`reading`), outputs where they are announced (`whole_file.check_target`), in either order.
Files are compared by device and inode, so that symbolic and hard links are seen through. Outside of commands nothing is noted: a
call from Python writes where its caller says.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

_Key = tuple[int, int] | str
_files: ContextVar[tuple[set[_Key], dict[_Key, str]] | None] = ContextVar("files of the command", default=None)
"""Inputs, and outputs with their names, of the command that runs."""


class Conflict(BaseException):
    """An output that is an input or another output; no `Exception`, so that no reader takes it for a damaged file."""


@contextmanager
def command_files() -> Iterator[None]:
    """Note the files of one command."""
    token = _files.set((set(), {}))
    try:
        yield
    finally:
        _files.reset(token)


def note_input(path: Path) -> None:
    """Note a file that is read; `Conflict` if it is announced as an output."""
    _noted(path, None)


def note_output(name: str, path: Path) -> None:
    """Note a file that will be written, "--output gel.nc"; `Conflict` if it is an input, or another output."""
    _noted(path, name)


def _noted(path: Path, output: str | None) -> None:
    if (files := _files.get()) is None or (key := _key(path)) is None:
        return
    inputs, outputs = files
    if output is None:
        inputs.add(key)
    elif outputs.setdefault(key, output) is not output:
        raise Conflict(f"{output}: the same file as {outputs[key]}. Give each output a name of its own.")
    if key in inputs and key in outputs:
        raise Conflict(f"{outputs[key]}: an input of the command, which would be replaced. Name another file.")


def _key(path: Path) -> _Key | None:
    """What identifies a file, or the place of one to be; None for names that no file can have."""
    with suppress(OSError, ValueError):
        # of the real path, which is what will be written: "none/../curve.csv" is a file, though there is no folder "none"
        real = os.path.realpath(path)
        with suppress(FileNotFoundError):
            found = os.stat(real)
            return found.st_dev, found.st_ino
        return os.path.normcase(real)
    return None
