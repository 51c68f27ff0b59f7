"""Standard output and errors as they may be: closed, full, a pipe that nobody reads, or in an alphabet without Greek letters."""

from __future__ import annotations

import codecs
import os
import sys
import warnings
from typing import TextIO

from flatpunch._support.checks import FlatpunchWarning
from flatpunch._support.messages import wants_traceback

_ASCII = {"µ": "u", "²": "^2", "°": " deg", "·": "*", "–": "-", "…": "..."}
_HANDLER = "flatpunch"


def prepare() -> None:
    """Make both streams take everything that is printed."""
    codecs.register_error(_HANDLER, _in_ascii)
    # closed ones are None
    sys.stdout = _usable(sys.stdout)
    sys.stderr = _usable(sys.stderr)
    warnings.showwarning = _note


def finish() -> str | None:
    """Write out what is buffered; report what went wrong, and leave nothing for Python to write when it ends."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        _silence()
        raise
    except OSError as error:
        _silence()
        return f"standard output: {error.strerror or type(error).__name__}."
    return None


def _silence() -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)


def _note(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Show a warning of the package as a note; those of libraries help nobody without the place, which goes with tracebacks."""
    if issubclass(category, FlatpunchWarning):
        print(f"Note: {message}", file=sys.stderr)
    elif wants_traceback():
        print(f"{filename}:{lineno}: {category.__name__}: {message}", file=sys.stderr)


def _usable(stream: TextIO | None) -> TextIO:
    if stream is None:
        return open(os.devnull, "w", encoding="utf-8")
    reconfigure = getattr(stream, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors=_HANDLER)
    return stream


def _in_ascii(error: UnicodeError) -> tuple[str, int]:
    """Letters that the alphabet of the terminal lacks, in ones that it has."""
    assert isinstance(error, UnicodeEncodeError)
    lost = error.object[error.start : error.end]
    return "".join(_ASCII.get(letter, "?") for letter in lost), error.end
