"""Curves of a batch, in memory or in files that are read when their turn comes, and the records of those that are fitted.

An interrupted run goes on where it was: a folder holds one file for each group of curves that was fitted together,
{digest: record}, written whole or not at all and sealed. The digest is that of the curve, the case and the version: a curve or a
case that has changed is fitted again.
"""

from __future__ import annotations

import csv
import hashlib
import json
import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flatpunch._support.checks import Array, FlatpunchWarning, Indices, shown
from flatpunch._support.declared import Place as Record
from flatpunch._support.paths import Plain
from flatpunch._support.reading import Unreadable, as_path, content, is_file, is_folder, shown_path, text_content
from flatpunch._support.whole_file import BrokenSeal, made_folder, remove_left, sealed, unsealed, write_whole
from flatpunch._version import __version__
from flatpunch.files.units import NO_UNIT, registry
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.files.contents import LARGEST, by_number
from flatpunch.fits.measured.files.readers import AFM, EXCEL, TEXT, curves_in, read_curve
from flatpunch.fits.parameters.sample import Sample
from flatpunch.fits.parameters.settings import Free, Settings
from flatpunch.parallel.store import content_key
from flatpunch.parallel.worker import held


@dataclass(frozen=True, slots=True)
class Place:
    """One curve of a file."""

    path: Path
    index: int | None = None

    @property
    def name(self) -> str:
        """File, and number of the curve in it."""
        return self.path.name if self.index is None else f"{self.path.name}[{self.index}]"

    def read(self, reading: Plain) -> Curve:
        """Return the curve; `reading` has arguments of `read_curve`."""
        return read_curve(self.path, **{**reading, "index": self.index})


def listed(curves: Iterable[Curve | str | Path], reading: Plain | None = None) -> list[Curve | Place]:
    """Curves and places of curves; a file with many of them is opened to count them."""
    items: list[Curve | Place] = []
    for item in curves:
        if isinstance(item, Curve):
            items.append(item)
            continue
        try:
            chosen = (reading or {}).get("index")
            if chosen is not None:
                items.append(Place(as_path("curves", item), int(chosen)))
                continue
            count = curves_in(item, **(reading or {}))
        except CurveError:
            # reported again in the record of this file, when its turn comes
            count = 1
        items += [Place(as_path("curves", item), i if count > 1 else None) for i in range(count)]
    return items


def listed_in(path: Path, reading: Plain | None = None) -> list[Place]:
    """Places of the curves of a folder, or of a file."""
    found = listed(files_in(path) if is_folder(path) else [path], reading)
    return [place for place in found if isinstance(place, Place)]


def values_in(path: Path, items: Sequence[Place], numbers: Mapping[str, Record]) -> dict[str, Array]:
    """Known values of curves from a CSV file: the column `curve` has their names, "layers[0].thickness [nm]" values and unit."""
    try:
        rows = list(csv.reader(text_content(path, LARGEST).splitlines()))
    except Unreadable as error:
        raise ValueError(f"{shown_path(path)}: {error}.") from None
    heads = (title.strip().partition(" ") for title in (rows[0] if rows else []))
    titles = [(name, unit.strip("[]() ")) for name, _, unit in heads]
    if not titles or titles[0][0] != "curve" or len(titles) < 2:
        raise ValueError(
            f"{shown_path(path)}: the first line must be curve,NAME [UNIT], such as curve,layers[0].thickness [nm]."
        )
    lines = {row[0]: row[1:] for row in rows[1:] if row}
    missing = [item.name for item in items if item.name not in lines]
    if missing:
        raise ValueError(
            f"{shown_path(path)}: no line for {', '.join(missing[:3])}{', ...' if len(missing) > 3 else ''}."
        )
    found = {}
    for at, (name, unit) in enumerate(titles[1:]):
        try:
            cells = [float(lines[item.name][at]) for item in items]
        except (ValueError, IndexError):
            raise ValueError(f"{shown_path(path)}: the column {name} must have a number for each curve.") from None
        found[name] = np.array(cells) * (
            _scale(unit, numbers[name].number.unit or "") if name in numbers and unit else 1.0
        )
    return found


def _scale(unit: str, in_si: str) -> float:
    try:
        return float(registry().Quantity(1, unit).to(in_si.replace("^", "**")).magnitude)
    except NO_UNIT:
        raise ValueError(f"values: the unit {shown(unit)} is none of {in_si or 'a plain number'}.") from None


def files_in(folder: str | Path) -> list[Path]:
    """Files of a folder that can be read as curves, in order; tables that a fit has written there are none."""
    folder = Path(folder)
    # files without an ending are read when they are named; in a folder they may be anything
    known = {ending for ending in (*TEXT, *EXCEL, *AFM, ".zip") if ending}
    files = (p for p in folder.iterdir() if p.suffix.lower() in known and not _is_table(p) and is_file(p))
    found = sorted(files, key=lambda path: by_number(path.name))
    if not found:
        raise ValueError(f"{folder}: no files of curves ({', '.join(filter(None, (*TEXT, *EXCEL, *AFM)))}).")
    return found


def _is_table(path: Path) -> bool:
    if path.suffix.lower() != ".csv" or not path.is_file():
        return False
    with suppress(OSError), path.open("rb") as file:
        title = file.readline(1000)
        return title.startswith(b"curve,") and b",ok,reason," in title
    return False


def on_grid(rows: Sequence[Plain]) -> list[Plain]:
    """Records in the order of the grid of a map, line by line, with "row" and "column"; as they are where they fill no grid."""
    try:
        x, y = (np.array([float(row[f"position {axis}"]) for row in rows]) for axis in "xy")
    except KeyError:
        return [dict(row) for row in rows]
    columns, lines = _levels(x), _levels(y)
    places = list(zip(lines.tolist(), columns.tolist(), strict=True))
    if len(rows) < 2 or len(set(places)) < len(rows) or (lines.max() + 1) * (columns.max() + 1) != len(rows):
        return [dict(row) for row in rows]
    return [
        {**rows[i], "row": places[i][0], "column": places[i][1]}
        for i in sorted(range(len(rows)), key=places.__getitem__)
    ]


def _levels(values: Array) -> Indices:
    """Number of the line at which each coordinate lies; those of one line differ by less than half the distance of lines."""
    order = np.argsort(values, kind="stable")
    steps = np.diff(values[order])
    found = np.zeros(values.size, dtype=int)
    if steps.size and steps.max() > 0:
        found[order[1:]] = np.cumsum(steps > 0.5 * steps.max())
    return found


def _content(curve: Curve) -> tuple[object, ...]:
    """What of a curve reaches its record."""
    columns = (curve.depth, curve.force, curve.stiffness, curve.time, curve.segment)
    known = curve.meta.get("metadata", {})
    place = [known.get(f"position {axis}") for axis in "xy"]
    notes = [curve.meta.get(name) for name in ("piezo", "read", "calibration", "no time")]
    return (curve.name, curve.spring_constant, columns, place, notes)


def _of_file(path: Path) -> str | None:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return None


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
    items: Sequence[tuple[Curve | Place, Mapping[str, float]]],
    sample: Sample,
    free: Mapping[str, Free],
    settings: Settings,
    reading: Plain,
) -> list[str | None]:
    """Digest of each item with the case and the version of the package; TypeError for functions and other unreadable content."""
    try:
        case = content_key(__version__, sample, dict(free), settings, dict(reading))
    except TypeError as error:
        raise TypeError(f"store: a run with this case cannot be resumed, leave store out. ({error})") from None
    # all curves of a file have its digest
    files = {path: _of_file(path) for path in {item.path for item, _ in items if isinstance(item, Place)}}
    found: list[str | None] = []
    for item, values in items:
        key = None
        if isinstance(item, Curve):
            key = content_key(case, *_content(item))
        elif (digest := files[item.path]) is not None:
            key = content_key(case, digest, item.name, item.index)
        found.append(content_key(key, dict(values)) if key is not None and values else key)
    return found
