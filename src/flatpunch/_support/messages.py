"""Messages of errors for the command line and the page: one text, in the words of case files, with the path of a file.

Errors that the package raises itself say what is wrong and what to do; they are shown as they are, with Python's spelling turned
into that of TOML. What a library raises, or Python itself, is a mistake of the package: its message would help nobody, so the
place is named, and the traceback is shown on request.
"""

from __future__ import annotations

import linecache
import os
import re
import traceback
from pathlib import Path

from flatpunch._support.checks import SHOWN, Problem
from flatpunch._support.reading import Conflict, shown_path
from flatpunch._support.whole_file import NotWritten

TRACEBACK = "FLATPUNCH_TRACEBACK"
"""Environment variable; set to anything, errors show where they come from."""

_PACKAGE = Path(__file__).resolve().parents[1]
_IN_CASE_FILES = {
    " in radians. Degrees go through math.radians; a half-opening angle t measured from the axis is pi/2 - t.": (
        ". The angle between axis and face is half_opening_angle."
    ),
    " in radians. Degrees go through math.radians.": ".",
}
"""What calls need to know, and what case files with their units say instead."""

_RAISED = (ValueError, TypeError, OSError)


def message(error: BaseException, program: Path = _PACKAGE) -> str:
    """Message of an error for people who write case files; `program` is the folder of what uses this package."""
    if isinstance(error, MemoryError):
        return "there is not enough memory for this. Take fewer steps, angles, cells or points; `flatpunch check` estimates it."
    if isinstance(error, (Conflict, NotWritten)):
        return str(error)
    if isinstance(error, OSError) and error.filename is not None:
        return f"{shown_path(error.filename)}: {error.strerror or type(error).__name__}."
    if isinstance(error, OSError) and error.errno is not None:
        return f"a file or the output could not be read or written ({error.strerror})."
    if isinstance(error, _RAISED) and _by_us(error, program):
        return brief(toml(str(error)))
    frame = _last_of_ours(error)
    where = f"{Path(frame.filename).relative_to(_PACKAGE)}:{frame.lineno}" if frame is not None else "an unknown place"
    return (
        f"this could not be solved: {type(error).__name__} in {where}. That is a mistake of flatpunch; please report it with the "
        f"case file. {TRACEBACK}=1 in the environment shows more."
    )


def brief(message: str, most: int = SHOWN) -> str:
    """Return a message whose quoted texts and long words are shortened: what came from outside may be endless."""
    message = re.sub(rf"'[^'\n]{{{most},}}'", lambda found: f"{found[0][: most - 4]} ...'", message)
    message = re.sub(rf"\S{{{2 * most},}}", lambda found: f"{found[0][: most - 4]} ...", message)
    return "\n".join(line if len(line) <= 4 * most else f"{line[: 4 * most]} ..." for line in message.split("\n"))


def problems(error: BaseException) -> list[Problem]:
    """The message with the places that it is about, which the error carries, or the one in whose place it was raised."""
    own = _carried(error)
    if own:
        return [Problem(place, brief(toml(text))) for place, text in own]
    cause = error.__cause__ or error.__context__
    known = _carried(cause)
    if len(known) == 1:
        return [Problem(known[0].place, message(error))]
    return [Problem("", line) for line in message(error).splitlines()]


def _carried(error: BaseException | None) -> list[Problem]:
    return list(getattr(error, "problems", ()))


def toml(text: str) -> str:
    """Return a message with Python's spelling of settings in that of case files: name=True becomes name = true."""
    for python, written in _IN_CASE_FILES.items():
        text = text.replace(python, written)
    text = re.sub(r"\b([a-z]+)\['([^']+)'\]", r'\1."\2"', text)
    text = re.sub(r"\b(Cone|Cylinder)\((\w+)\)", lambda found: f"kind = '{found[1].lower()}' with {found[2]}", text)
    text = re.sub(r"(?<!--set )\b([a-z_]\w*)=(?=True|False|['\"{\[]|\.\.\.)", r"\1 = ", text)
    return re.sub(r"(?<== )(True|False)\b", lambda found: found[1].lower(), text)


def wants_traceback() -> bool:
    """Whether the user asked for tracebacks."""
    return bool(os.environ.get(TRACEBACK))


def _by_us(error: BaseException, program: Path) -> bool:
    """Whether a `raise` of the package, or of the program that uses it, made the error, as far as its source is there to tell."""
    frames = traceback.extract_tb(error.__traceback__)
    if not frames:
        return True
    last = frames[-1]
    if not any(Path(last.filename).is_relative_to(folder) for folder in (_PACKAGE, program)):
        return False
    line = linecache.getline(last.filename, last.lineno or 0).strip()
    return not line or "raise" in line


def _last_of_ours(error: BaseException) -> traceback.FrameSummary | None:
    frames = traceback.extract_tb(error.__traceback__)
    return next((frame for frame in reversed(frames) if Path(frame.filename).is_relative_to(_PACKAGE)), None)
