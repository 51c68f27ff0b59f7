"""Files of a running command: none of its outputs replaces a file that it reads, or another of its outputs.

Inputs are noted where they are read (`reading`), outputs where they are announced (`whole_file.check_target`), in either order.
Files are compared by device and inode, so that symbolic and hard links are seen through. Outside of commands nothing is noted: a
call from Python writes where its caller says.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
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
    if (files := _files.get()) is not None and (key := _key(path)) is not None:
        files[0].add(key)
        _check(key)


def note_output(name: str, path: Path) -> None:
    """Note a file that will be written, "--output gel.nc"; `Conflict` if it is an input, or another output."""
    if (files := _files.get()) is not None and (key := _key(path)) is not None:
        if key in files[1]:
            raise Conflict(f"{name}: the same file as {files[1][key]}. Give each output a name of its own.")
        files[1][key] = name
        _check(key)


def _check(key: _Key) -> None:
    inputs, outputs = _files.get() or (set(), {})
    if key in inputs and key in outputs:
        raise Conflict(
            f"{outputs[key]}: this file is an input of the command and would be replaced. Name another file."
        )


def _key(path: Path) -> _Key | None:
    """What identifies a file, or the place of one to be; None for names that no file can have."""
    try:
        found = path.stat()
    except (OSError, ValueError):
        try:
            return os.path.normcase(os.path.realpath(path))
        except (OSError, ValueError):
            return None
    return found.st_dev, found.st_ino
