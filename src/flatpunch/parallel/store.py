"""Where outcomes are kept: a folder with one file for each point, or the memory of this process.

A solved point is `<key>.npz`, which NumPy alone reads; a failed one is `<key>.json` with its reason. Files are written under a
temporary name and renamed: whatever interrupts the work, a file that is there is whole.
"""

from __future__ import annotations

import io
import json
import os
import time
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from flatpunch._support.whole_file import UNFINISHED, write_whole
from flatpunch.parallel.work import Outcome

_HOUR = 3600.0


class Store(Protocol):
    """What the engine asks of a place where outcomes are kept."""

    def states(self, keys: Iterable[str]) -> dict[str, bool]:
        """Keys that are there, each with whether it was solved (True) or failed (False)."""
        ...

    def read(self, key: str) -> Outcome:
        """Outcome of a point that is there."""
        ...

    def write(self, key: str, outcome: Outcome) -> None:
        """Keep an outcome; afterwards it is there, whatever happens."""
        ...


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
        The folder. What interrupted runs have left unfinished in it is removed once it is an hour old.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            old = time.time() - _HOUR
            for left in self.path.glob(UNFINISHED + "*"):
                if left.stat().st_mtime < old:
                    left.unlink(missing_ok=True)
        except OSError as error:
            raise OSError(
                f"{self.path}: no folder to keep points in ({error.strerror or error}). Choose one that is yours."
            ) from None

    def states(self, keys: Iterable[str]) -> dict[str, bool]:
        """Keys that are there, from one look into the folder."""
        there = {entry.name for entry in os.scandir(self.path)}
        solved = {key: f"{key}.npz" in there for key in keys}
        return {key: good for key, good in solved.items() if good or f"{key}.json" in there}

    def read(self, key: str) -> Outcome:
        """Outcome of a point; a damaged file is named."""
        good = self.path / f"{key}.npz"
        if not good.exists():
            record = json.loads((self.path / f"{key}.json").read_text(encoding="utf-8"))
            return Outcome(None, record["reason"], record["seconds"])
        try:
            with np.load(good, allow_pickle=False) as data:
                numbers: dict[str, Any] = {name: data[name][()] for name in data.files}
        except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
            raise ValueError(f"{good} cannot be read ({error}). Delete it and run again.") from None
        return Outcome(numbers, "", float(numbers.pop(_SECONDS)))

    def write(self, key: str, outcome: Outcome) -> None:
        """Keep an outcome, whole or not at all."""
        if outcome.numbers is None:
            record = {"reason": outcome.reason, "seconds": outcome.seconds}
            write_whole(self.path / f"{key}.json", json.dumps(record, ensure_ascii=False).encode())
            return
        buffer = io.BytesIO()
        np.savez(buffer, **{**outcome.numbers, _SECONDS: outcome.seconds})
        write_whole(self.path / f"{key}.npz", buffer.getvalue())
        (self.path / f"{key}.json").unlink(missing_ok=True)  # it failed before and was tried again


_SECONDS = "_seconds"
