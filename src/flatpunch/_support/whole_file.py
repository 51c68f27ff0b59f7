"""Files that appear whole or not at all: written under a temporary name in the same folder, then renamed.

A file that is there is replaced, and keeps its rights and its owner, unless it is write-protected, a folder, a pipe or a device.
Commands announce their outputs before anything is solved (`check_target`); one that is an input is refused. What a killed
process left unfinished is removed by the next one that writes beside it: temporary names hold machine and process.

A seal is a last line that holds the SHA-256 of everything before it. HDF5 and zip ignore what follows their end, so that other
programs read sealed files as any other. A damaged file is found before a library sees its bytes: HDF5 may return other numbers
for damaged ones, fail deep inside, or never return.
"""

from __future__ import annotations

import errno
import hashlib
import os
import platform
import re
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path

from flatpunch._support.reading import note_output, shown_path

UNFINISHED = ".unfinished-"
"""How temporary names begin; machine, process and eight random letters follow."""

_TEMPORARY = re.compile(re.escape(UNFINISHED) + r"([0-9a-f]{8})-([0-9]{1,10})-[a-z0-9_]{8}(?:\..*)?", re.DOTALL)

REMEDY = "Choose a folder that exists, is yours and has space left."
"""What to do where a file cannot be written."""

_HOUR = 3600.0
"""Age above which unfinished files of other machines count as left behind [s]."""


_MARK = b"# flatpunch seal sha256 "
_SEAL = re.compile(rb"\n" + _MARK + rb"([0-9a-f]{64})\n")
_LENGTH = 1 + len(_MARK) + 2 * hashlib.sha256().digest_size + 1


def check_target(option: str, path: Path, endings: tuple[str, ...], *, chosen: bool = False) -> None:
    """Refuse a file that could not be written in the end or must not be, before anything is solved.

    Names that a command has `chosen` itself replace nothing.
    """
    if path.suffix.lower() not in endings:
        raise ValueError(f"{option} {shown_path(path)}: the ending must be {' or '.join(endings)}.")
    if (reason := unwritable(path)) is not None:
        raise ValueError(f"{option} {shown_path(path)}: {reason}")
    if chosen and _real(path).exists():
        raise ValueError(f"{shown_path(path)} exists and was not named. Move it away, or name a file with {option}.")
    note_output(f"{option} {shown_path(path)}", path)


def made_folder(option: str, folder: Path) -> None:
    """Make a folder, and refuse one in which no file can be made, before anything is solved."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        # a null character is a ValueError
        reason = getattr(error, "strerror", None) or "no name of a folder"
        raise ValueError(f"{option} {shown_path(folder)}: cannot be made ({reason}). {REMEDY}") from None
    if (reason := unwritable(folder / "file")) is not None:
        raise ValueError(f"{option} {shown_path(folder)}: {reason}")


def unwritable(path: Path) -> str | None:
    """Say why no file can be written there, in a sentence; None where it can."""
    try:
        target = _real(path)
        if (reason := _kept(target)) is not None:
            return f"{reason}. Name another file."
        if not target.parent.is_dir():
            return f"the folder {shown_path((target if path.is_symlink() else path).parent)} does not exist. Make it first."
        handle, name = _temporary(target)
        os.close(handle)
        os.unlink(name)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "no name of a file"
        return f"cannot be written ({reason}). {REMEDY}"
    return None


def _kept(target: Path) -> str | None:
    """Why what is there must not be replaced; None where nothing is, or a file that may be."""
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(mode):
        return "is a folder"
    if not stat.S_ISREG(mode):
        return "is a pipe or a device, not a file"
    # the system lets its administrator write to protected files
    return None if mode & 0o222 and os.access(target, os.W_OK) else "is write-protected"


class NotWritten(OSError):
    """A file could not be written; it has the path."""

    def __str__(self) -> str:
        return f"{self.filename}: cannot be written ({self.strerror}). {REMEDY}"


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give an empty temporary file next to `path`, of the same ending, that takes its place at the end, or vanishes.

    A link is followed: what it points to is replaced.
    """
    try:
        target = _real(path)
        if (reason := _kept(target)) is not None:
            raise PermissionError(errno.EACCES, f"it {reason}")
        _clean_once(target.parent)
        handle, name = _temporary(target)
        os.close(handle)
        temporary = Path(name)
        try:
            yield temporary
            _with_usual_rights(temporary, target)
            os.replace(temporary, target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        # a full disk does not say which file it was
        raise NotWritten(error.errno, error.strerror or str(error), shown_path(path)) from error


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it appears whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_bytes(content)


@lru_cache(maxsize=64)
def _clean_once(folder: Path) -> None:
    """Once for each folder and process: folders of studies hold many thousand files."""
    remove_left(folder)


def remove_left(folder: Path) -> None:
    """Remove what processes that are no more have left unfinished in a folder."""
    with suppress(OSError):
        for left in folder.glob(f"{UNFINISHED}*"):
            with suppress(OSError):
                if _abandoned(left):
                    left.unlink(missing_ok=True)


def _abandoned(left: Path) -> bool:
    name = _TEMPORARY.fullmatch(left.name)
    if name is None:
        return False
    if name[1] == _machine():
        return not _alive(int(name[2]))
    return left.stat().st_mtime < time.time() - _HOUR


def _alive(process: int) -> bool:
    if os.name == "nt":
        # asking for a process by a signal ends it there
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True


def _machine() -> str:
    return hashlib.sha256(platform.node().encode()).hexdigest()[:8]


def _temporary(target: Path) -> tuple[int, str]:
    """An empty file of this process beside the target."""
    suffix = target.suffix if len(target.suffix) < 100 else ""
    return tempfile.mkstemp(prefix=f"{UNFINISHED}{_machine()}-{os.getpid()}-", suffix=suffix, dir=target.parent)


def _real(path: Path) -> Path:
    """Where a link leads; a chain of links without end is refused by whoever opens it."""
    return Path(os.path.realpath(path))


def _with_usual_rights(path: Path, target: Path) -> None:
    """Temporary files are private; give the result the rights and owner of what it replaces, or those of any new file."""
    try:
        before = target.stat()
    except FileNotFoundError:
        mask = os.umask(0)
        os.umask(mask)
        path.chmod(0o666 & ~mask)
        return
    with suppress(OSError, AttributeError):
        # Windows has no owners of this kind, and only the administrator gives files away
        os.chown(path, before.st_uid, before.st_gid)
    path.chmod(stat.S_IMODE(before.st_mode))


class BrokenSeal(ValueError):
    """Bytes that are not those that were written."""


def sealed(content: bytes) -> bytes:
    """Return the content with its seal."""
    return content + b"\n" + _MARK + hashlib.sha256(content).hexdigest().encode() + b"\n"


def unsealed(content: bytes) -> tuple[bytes, bool]:
    """Return what was sealed, and whether there was a seal: files of earlier versions have none.

    `BrokenSeal` if the content is not what was sealed, or its seal is damaged itself.
    """
    end = content[-_LENGTH:]
    match = _SEAL.fullmatch(end)
    if match is not None:
        body = content[:-_LENGTH]
        if hashlib.sha256(body).hexdigest().encode() != match[1]:
            raise BrokenSeal("its bytes are not those that were written")
        return body, True
    if len(end) == _LENGTH and sum(a == b for a, b in zip(end[1:], _MARK, strict=False)) > len(_MARK) // 2:
        raise BrokenSeal("the line at its end is damaged")
    if _MARK in content[-4 * _LENGTH :]:
        raise BrokenSeal("something was added or lost at its end")
    return content, False
