"""Records of a batch that are kept as it goes, so that an interrupted run goes on where it was.

A folder holds one file for each group of curves that was fitted together, {digest: record}, written whole or not at all and
sealed. The digest is that of the curve, the case and the version: a curve or a case that has changed is fitted again.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from flatpunch._support.checks import FlatpunchWarning
from flatpunch._support.paths import Plain
from flatpunch._support.reading import Unreadable, as_path, content
from flatpunch._support.whole_file import BrokenSeal, made_folder, remove_left, sealed, unsealed, write_whole
from flatpunch._version import __version__
from flatpunch.fit.measured.curve import Curve
from flatpunch.fit.parameters.sample import Sample
from flatpunch.fit.parameters.settings import Free, Settings
from flatpunch.fit.places import Place, digests
from flatpunch.parallel.interruption import held
from flatpunch.parallel.keys import content_key


class Records:
    """Records of fitted curves in a folder, which is made if it is not there.

    Parameters
    ----------
    path : path
        The folder.

    Attributes
    ----------
    known : dict of str to dict
        Records by the digest of their curve.
    reused : int
        How many of them a run has used.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = as_path("store", path)
        made_folder("store", self.path)
        remove_left(self.path)
        self.known: dict[str, Plain] = {}
        self.reused = 0
        self._told = False
        self._files: list[Path] = []
        for file in sorted(self.path.glob("*.json")):
            if found := _whole(file):
                self.known |= found
                self._files.append(file)

    def keep(self, keys: Sequence[str | None], rows: Sequence[Plain]) -> None:
        """Keep the records of fitted curves; those without values are tried again by the next run."""
        good = {key: dict(row) for key, row in zip(keys, rows, strict=True) if key is not None and "points" in row}
        if not good:
            return
        with held():
            body = json.dumps(good, ensure_ascii=False).encode()
            self._files.append(self.path / f"{content_key(sorted(good))}.json")
            try:
                write_whole(self._files[-1], sealed(body))
            except OSError as error:
                # a full disk costs the resumption, not the fits
                self._warn(error)
            self.known |= good

    def _warn(self, error: OSError) -> None:
        if not self._told:
            self._told = True
            warnings.warn(
                f"{error.filename or self.path}: records of fitted curves cannot be kept ({error.strerror or error}). The run "
                "goes on; after an interruption these curves are fitted again.",
                FlatpunchWarning,
                stacklevel=4,
            )

    def remove(self) -> None:
        """Delete the records, files with a whole seal, and the folder if nothing else is in it."""
        for file in self._files:
            file.unlink(missing_ok=True)
        with suppress(OSError):
            self.path.rmdir()


def _whole(file: Path) -> dict[str, Plain]:
    """Records in a file; none, with a warning, if it is damaged."""
    try:
        # largest file of records that is read [bytes]
        body, has_seal = unsealed(content(file, 1_000_000_000))
        if not has_seal:
            raise BrokenSeal("it has no seal")
        found: dict[str, Plain] = json.loads(body)
        if file.stem != content_key(sorted(found)):
            raise BrokenSeal("it is sealed, but no record of a batch")
    except (Unreadable, ValueError, TypeError, OSError) as error:
        warnings.warn(
            f"{file}: damaged, or no record ({error}). Its curves are fitted again, and the file stays where it is.",
            FlatpunchWarning,
            stacklevel=4,
        )
        return {}
    return found


def keys_of(
    items: Sequence[Curve | Place], sample: Sample, free: Mapping[str, Free], settings: Settings, reading: Plain
) -> list[str | None]:
    """Digest of each item with the case and the version of the package; TypeError for functions and other unreadable content."""
    try:
        case = content_key(__version__, sample, dict(free), settings, dict(reading))
    except TypeError as error:
        raise TypeError(f"store: a run with this case cannot be resumed, leave store out. ({error})") from None
    return list(digests(items, case))
