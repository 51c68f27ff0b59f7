"""The outcome of a point, its key, and where outcomes are kept: a folder with a file for each, or the memory of this process.

A key is a hash of everything that determines the numbers of a point. Two points share one only if they are the same to the last
bit, types included: 1 and 1.0 differ. What has no content that can be read (functions, open files, objects with hidden state) is
refused rather than named by its address.

A solved point is `<key>.npz`, which NumPy alone reads; a failed one is `<key>.json` with its reason. Files are written under a
temporary name and renamed: whatever interrupts the work, a file that is there is whole. A seal at their end reveals damaged ones,
which are set aside and solved again.
"""

from __future__ import annotations

import dataclasses
import hashlib
import io
import json
import os
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import Any, Protocol

import numpy as np

from flatpunch._support.checks import FlatpunchWarning
from flatpunch._support.paths import Plain
from flatpunch._support.readable import readable
from flatpunch._support.reading import RESULT, Unreadable, archived_arrays, content
from flatpunch._support.whole_file import BrokenSeal, remove_left, sealed, unsealed, unwritable, write_whole


def content_key(*things: object) -> str:
    """Return the same 32 hexadecimal digits for the same content, in every process and on every machine.

    Content is None, numbers, texts, bytes, arrays, paths, dataclasses, and tuples, lists and mappings of them; TypeError for
    all else.
    """
    digest = hashlib.sha256()
    for piece in _pieces(things):
        # the length in front keeps ("ab", "c") apart from ("a", "bc")
        digest.update(b"%d:" % len(piece) + piece)
    return digest.hexdigest()[:32]


def _pieces(thing: object) -> Iterator[bytes]:
    if thing is None or isinstance(thing, (bool, int, str, bytes, PurePath)):
        yield type(thing).__name__.encode() if not isinstance(thing, PurePath) else b"path"
        yield thing if isinstance(thing, bytes) else str(thing).encode()
    elif isinstance(thing, float):
        yield b"float"
        yield thing.hex().encode()
    elif isinstance(thing, (np.ndarray, np.generic)) and not thing.dtype.hasobject:
        yield f"array {thing.dtype.str} {thing.shape}".encode()
        yield thing.tobytes()
    elif isinstance(thing, (tuple, list)):
        yield f"{'list' if isinstance(thing, list) else 'tuple'} {len(thing)}".encode()
        for entry in thing:
            yield from _pieces(entry)
    elif isinstance(thing, Mapping):
        yield f"mapping {len(thing)}".encode()
        yield from sorted(content_key(*pair).encode() for pair in thing.items())
    elif dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        yield f"dataclass {type(thing).__module__}.{type(thing).__qualname__}".encode()
        for field in dataclasses.fields(thing):
            # private fields, and those that are no arguments, follow from the others
            if field.compare and field.init and not field.name.startswith("_"):
                yield from _pieces((field.name, getattr(thing, field.name)))
    else:
        raise TypeError(
            f"point = {thing!r}: the content of a {type(thing).__name__} cannot be read, so that it has no key of its own. "
            "Describe points by numbers, texts, arrays, dataclasses, and lists and mappings of them."
        )


Numbers = Mapping[str, Any]
"""Numbers, texts and arrays by name."""

Function = Callable[[Any], Numbers]


@readable
@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a point.

    Attributes
    ----------
    numbers : mapping or None
        Arrays and scalars by name; None where it failed.
    reason : str
        Why it failed, type and message of the exception; empty where it did not.
    seconds : float
        Time it took.

    See Also
    --------
    flatpunch.parallel.Solved : Holds them by name.

    Examples
    --------
    >>> from flatpunch.parallel import solve_points
    >>> def inverse(x):
    ...     return {"inverse": 1 / x}
    >>> solved = solve_points(inverse, [4.0, 0.0], workers=1)
    >>> print(solved[0].numbers["inverse"], solved[1].reason)
    0.25 ZeroDivisionError: float division by zero
    """

    numbers: Numbers | None
    reason: str = ""
    seconds: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether there are numbers."""
        return self.numbers is not None


def solved(function: Function, point: object) -> Outcome:
    """Solve a point; an exception is the outcome of this point and of no other."""
    start = time.perf_counter()
    try:
        numbers = {str(name): _plain(str(name), value) for name, value in function(point).items()}
    except Exception as error:
        return Outcome(None, f"{type(error).__name__}: {error}", time.perf_counter() - start)
    return Outcome(numbers, "", time.perf_counter() - start)


def _plain(name: str, value: object) -> object:
    """Return an array or NumPy scalar, as it will be read back from a file."""
    array = np.asarray(value)
    if array.dtype.hasobject:
        raise TypeError(
            f"the result {name!r} is a {type(value).__name__}, which cannot be kept: return numbers, texts and arrays."
        )
    return array[()]


class Store(Protocol):
    """Interface of a place where the engine keeps outcomes."""

    def states(self, keys: Iterable[str]) -> dict[str, bool]:
        """Keys that are there, each with whether it was solved (True) or failed (False)."""

    def read(self, key: str) -> Outcome:
        """Outcome of a point that is there."""

    def write(self, key: str, outcome: Outcome) -> None:
        """Keep an outcome; afterwards it is there, whatever happens."""


class Memory:
    """Outcomes kept by this process."""

    def __init__(self) -> None:
        self._outcomes: dict[str, Outcome] = {}

    def states(self, keys: Iterable[str]) -> dict[str, bool]:
        """Keys that are there."""
        return {key: self._outcomes[key].ok for key in keys if key in self._outcomes}

    def read(self, key: str) -> Outcome:
        """Outcome of a point."""
        return self._outcomes[key]

    def write(self, key: str, outcome: Outcome) -> None:
        """Keep an outcome."""
        self._outcomes[key] = outcome


class Folder:
    """Outcomes kept in a folder, which is made if it is not there.

    Parameters
    ----------
    path : path
        The folder. What interrupted runs have left unfinished in it is removed.

    See Also
    --------
    flatpunch.parallel.solve_points : Takes it as `store`.

    Examples
    --------
    >>> from flatpunch.parallel import Folder, Outcome
    >>> store = Folder("points")
    >>> store.write("a", Outcome({"x": 1.0}))
    >>> print(store.states(["a", "b"]), float(store.read("a").numbers["x"]))
    {'a': True} 1.0
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _no_folder(self.path, error.strerror or str(error)) from None
        remove_left(self.path)
        if (reason := unwritable(self.path / "point.npz")) is not None:
            raise _no_folder(self.path, reason)
        self._unkept: dict[str, Outcome] = {}
        self._told = False

    def states(self, keys: Iterable[str]) -> dict[str, bool]:
        """Keys that are there and whole; damaged files are set aside, so that their points are solved again."""
        wanted = list(keys)
        there = {entry.name for entry in os.scandir(self.path)}
        found = {key: self._unkept[key].ok for key in wanted if key in self._unkept}
        for key in wanted:
            for ending, good in ((".npz", True), (".json", False)):
                if key not in found and f"{key}{ending}" in there and self._whole(f"{key}{ending}"):
                    found[key] = good
        return found

    def read(self, key: str) -> Outcome:
        """Outcome of a point that is there."""
        if key in self._unkept:
            return self._unkept[key]
        good = self.path / f"{key}.npz"
        return _outcome(good if good.exists() else self.path / f"{key}.json")

    def write(self, key: str, outcome: Outcome) -> None:
        """Keep an outcome, whole or not at all; where the disk is full it stays in memory, with a warning."""
        try:
            self._write(key, outcome)
        except OSError as error:
            self._unkept[key] = outcome
            if not self._told:
                self._told = True
                warnings.warn(
                    f"{error.filename or self.path}: points cannot be kept ({error.strerror or error}). The run goes on, and "
                    "later results, too, are lost at its end unless they are saved.",
                    FlatpunchWarning,
                    stacklevel=2,
                )

    def _write(self, key: str, outcome: Outcome) -> None:
        if outcome.numbers is None:
            record = {"reason": outcome.reason, "seconds": outcome.seconds}
            write_whole(self.path / f"{key}.json", sealed(json.dumps(record, ensure_ascii=False).encode()))
            return
        buffer = io.BytesIO()
        np.savez(buffer, **{**outcome.numbers, _SECONDS: outcome.seconds})
        write_whole(self.path / f"{key}.npz", sealed(buffer.getvalue()))
        (self.path / f"{key}.json").unlink(missing_ok=True)  # it failed before and was tried again

    def _whole(self, name: str) -> bool:
        """Whether a file holds what was written; a damaged one is renamed, with a warning."""
        path = self.path / name
        try:
            _outcome(path)
        except ValueError as error:
            with suppress(OSError):
                path.replace(path.with_name(f"{name}{DAMAGED}"))
            warnings.warn(f"{error} It is set aside, and its point is solved again.", FlatpunchWarning, stacklevel=3)
            return False
        return True


DAMAGED = ".damaged"
"""Ending of files that were set aside."""


def _outcome(path: Path) -> Outcome:
    """Outcome in a file; a ValueError if it is not what was written."""
    try:
        body, has_seal = unsealed(content(path, RESULT))
        if not has_seal:
            raise BrokenSeal("it has no seal")
        if path.suffix == ".json":
            record = json.loads(body)
            return Outcome(None, str(record["reason"]), float(record["seconds"]))
        numbers: Plain = {name: array[()] for name, array in archived_arrays(body).items()}
        return Outcome(numbers, "", float(numbers.pop(_SECONDS)))
    except (ValueError, KeyError, TypeError) as error:
        reason = str(error) if isinstance(error, (BrokenSeal, Unreadable)) else type(error).__name__
        raise ValueError(f"{path}: damaged or changed after it was written ({reason}).") from None


def _no_folder(path: Path, reason: str) -> OSError:
    return OSError(f"{path}: no folder to keep points in ({reason.rstrip('.')}). Choose one that is yours.")


_SECONDS = "_seconds"
