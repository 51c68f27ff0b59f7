"""Reading files from outside: regular files only, up to a size that is said, in one wording; and files of a running command.

A pipe without a writer would never end, a device never stop; a file that is far too large would fill the memory first and
be refused afterwards. The unpacked sizes of archives (.zip, .npz, .xlsx, force maps of JPK) are checked before anything is
unpacked, with one ceiling.

None of the outputs of a command replaces a file that it reads, or another of its outputs. Inputs are noted where they are read,
outputs where they are announced (`whole_file.check_target`), in either order. Files are compared by device and inode, so that
symbolic and hard links are seen through. Outside of commands nothing is noted: a call from Python writes where its caller says.
"""

from __future__ import annotations

import io
import lzma
import os
import stat
import zipfile
import zlib
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatpunch._support.checks import shown

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


RESULT = 4_000_000_000
"""Largest file of this package's own results, finished points and tables that is read [bytes]."""

UNPACKED = 250_000_000
"""Largest size that is unpacked at once [bytes]: all files of an archive, one file of a force map of JPK, one map of heights;
text takes 15 times as much memory."""

FILES = 200_000
"""Most files of an archive; force maps hold some for each curve."""


def shown_path(path: object) -> str:
    """Return a path as messages write it: on one line, and not endless."""
    text = "".join(c if c.isprintable() else "?" for c in str(path))
    return text if len(text) <= 300 else f"{text[:300]}..."


def as_path(name: str, value: object) -> Path:
    """Return what was given for a path as one, or refuse it by a TypeError."""
    if not isinstance(value, (str, os.PathLike)):
        raise TypeError(f"{name} = {shown(value)} must be a path: a text or a pathlib.Path.")
    return Path(value)


def is_file(path: Path) -> bool:
    """Whether there is a regular file to be read; a name that is too long or no name at all is none."""
    note_input(path)
    try:
        return path.is_file()
    except (OSError, ValueError):
        # ValueError: a null character
        return False


def is_folder(path: Path) -> bool:
    """Whether there is a folder; a name that is too long or no name at all is none."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        # ValueError: a null character
        return False


class Unreadable(ValueError):
    """A file that cannot be read; the message says why, without the path."""


def content(path: Path, most: int) -> bytes:
    """Return the bytes of a regular file; `Unreadable` if it is missing, no regular file, or larger than `most` [bytes]."""
    note_input(path)
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):
            kind = "a folder" if stat.S_ISDIR(about.st_mode) else "a pipe or a device"
            raise Unreadable(f"not readable (it is {kind}, not a file)")
        with path.open("rb") as file:
            # what the system says of the size need not be true
            found = file.read(most + 1) if about.st_size <= most else b""
    except OSError as error:
        raise Unreadable(f"not readable ({error.strerror or error})") from None
    except Unreadable:
        raise
    except ValueError:
        # a null character in the name
        raise Unreadable("not readable (no name of a file)") from None
    if max(about.st_size, len(found)) > most:
        raise Unreadable(f"larger than {most / 1e6:g} MB, the most that is read")
    return found


def text_content(path: Path, most: int) -> str:
    """Return the text of a regular file in UTF-8, without the byte-order mark that spreadsheets and editors write before it."""
    try:
        return content(path, most).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise Unreadable("not a text file in UTF-8") from None


DAMAGED = (OSError, EOFError, ValueError, RuntimeError, zipfile.BadZipFile, zlib.error, lzma.LZMAError)
"""What `zipfile` raises on damaged archives: lists that are cut off, names that are no text, members that have a password or
another kind of compression (RuntimeError)."""


def check_archive(path: Path) -> None:
    """Refuse archives that unpack to more than can be read, with the sizes; what is no archive is left to its reader.

    Python unpacks no more than the sizes that an archive states, whatever it holds.
    """
    note_input(path)
    try:
        with path.open("rb") as file:
            if not zipfile.is_zipfile(file):
                return
            with zipfile.ZipFile(file) as archive:
                entries = archive.infolist()
    except DAMAGED:
        raise Unreadable("damaged: its list of files cannot be read") from None
    if len(entries) > FILES:
        raise Unreadable(f"an archive of {len(entries)} files; at most {FILES} are read")
    largest = max(entries, key=lambda entry: entry.file_size, default=None)
    # the curves of a force map are read one by one
    size = 0 if largest is None or not path.suffix.lower().startswith(".jpk") else largest.file_size
    total = size or sum(entry.file_size for entry in entries)
    if largest is not None and total > UNPACKED:
        raise Unreadable(
            f"an archive that unpacks to {total / 1e6:.4g} MB, its file {shown_path(largest.filename)} alone to "
            f"{largest.file_size / 1e6:.4g} MB; at most {UNPACKED / 1e6:g} MB are read"
        )


def archived_arrays(body: bytes, names: Collection[str] | None = None) -> dict[str, NDArray[Any]]:
    """Arrays in the bytes of a .npz file, all or those of some names; `Unreadable` where it is damaged."""
    try:
        with zipfile.ZipFile(io.BytesIO(body)) as archive:
            members = {name.removesuffix(".npy"): name for name in archive.namelist() if name.endswith(".npy")}
            # a member is read whole: its checksum is compared at its end
            return {
                name: stored_array(archive.read(member))
                for name, member in members.items()
                if names is None or name in names
            }
    except Unreadable:
        raise
    except (*DAMAGED, LookupError):
        raise Unreadable("damaged, or no NumPy archive") from None


def stored_array(body: bytes) -> NDArray[Any]:
    """Array in the bytes of a .npy file; `Unreadable` where it is damaged. Only the length of the data is checked."""
    stream = io.BytesIO(body)
    try:
        found = np.lib.format.read_array(stream, allow_pickle=False)
    # NumPy parses the head as Python, and makes room for the shape that stands there
    except (EOFError, ValueError, TypeError, SyntaxError, LookupError, ArithmeticError, MemoryError, TokenError):
        raise Unreadable("damaged, or no array of NumPy") from None
    if stream.read(1):
        raise Unreadable("damaged: longer than its array")
    return np.asarray(found)
