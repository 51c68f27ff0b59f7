"""Files of microscopes and nanoindenters, by afmformats (extra `afm`) and Nanosurf's NSFopen (extra `nanosurf`)."""

from __future__ import annotations

import logging
import re
import struct
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.checks import shown
from flatpunch._support.reading import Unreadable, check_archive, shown_path
from flatpunch.fits.measured.columns import Constants, Table
from flatpunch.fits.measured.curve import CurveError

MEASURED = "height (measured)"
_UNITS = {"force": "N", "time": "s"}


class UnknownFormat(CurveError):
    """A file that afmformats does not know."""


class AfmTables(Sequence[Table]):
    """The curves of a microscope file as tables, read when asked for."""

    def __init__(self, path: Path, given: dict[str, float], height: str) -> None:
        self.path, self.height, self.data = path, height, _loaded(path, given)

    def __len__(self) -> int:
        return len(self.data)

    def __getitem__(self, index: Any) -> Any:
        """One curve."""
        data = self.data[index]
        known, there = dict(data.metadata), list(data.columns)
        if self.height not in there:
            raise CurveError(f"{self.path.name}: no column {shown(self.height)}; there are {', '.join(there)}.")
        names = [n for n in ("tip position", self.height, "force", "time") if n in there]
        with explained(self.path):
            columns = [np.asarray(data[name], dtype=float) for name in names]
            segment = np.asarray(data["segment"], dtype=float) if "segment" in there else np.zeros(1)
        # one segment, or numbers that do not count up, show nothing
        several = np.unique(segment).size > 1 and not (np.diff(segment) < 0).any()
        return Table(
            f"{self.path.name}, curve {index}",
            tuple(names),
            tuple(_UNITS.get(name, "m") for name in names),
            np.column_stack(columns),
            constants=Constants(_constant(known.get("spring constant")), _constant(known.get("sensitivity"))),
            segment=segment if several else None,
            ways=("forth", "back") if np.unique(segment).size == 2 else ("",) * np.unique(segment).size,
            segmented="the file",
            outwards=True,
            meta={"metadata": known, "source": self.path.name},
        )


def _constant(value: Any) -> float | None:
    """A constant that a file was written with; None where it has none that is a positive number."""
    return float(value) if value is not None and np.isfinite(value) and value > 0 else None


def _loaded(path: Path, given: dict[str, float]) -> Any:
    try:
        import afmformats
    except ImportError:
        raise CurveError(f"{path.name}: reading it needs afmformats: pip install 'flatpunch[afm]'.") from None
    try:
        check_archive(path)
    except Unreadable as error:
        raise CurveError(f"{shown_path(path)}: {error}.") from None
    # errors are reported here: without a handler of the caller's own their tracebacks are not printed
    for library in ("afmformats", "igor2"):
        logging.getLogger(library).addHandler(logging.NullHandler())
    if path.suffix.lower() == ".ibw":
        check_sizes(path)
    with explained(path):
        _forget_archive(path)
        try:
            return afmformats.load_data(path)
        except afmformats.errors.MissingMetaDataError as error:
            # constants of the file are replaced later; here only those that it does not have
            missing = {name: given[name] for name in error.meta_keys if name in given}
            if not missing:
                raise
            return afmformats.load_data(path, meta_override=missing)


def _forget_archive(path: Path) -> None:
    """Close the archive of that name that afmformats keeps open: it may be another file by now."""
    try:
        from afmformats.formats.fmt_jpk.jpk_reader import ArchiveCache
    except ImportError:
        # no public name; other versions may keep nothing
        return
    before = ArchiveCache.open_archives.pop(path, None)
    if before is not None:
        before.close()


@contextmanager
def explained(path: Path) -> Iterator[None]:
    """Errors of afmformats in words that say what to do; its readers raise any type on damaged files."""
    from afmformats.errors import AFMFileFormatError, MissingMetaDataError

    try:
        # damaged numbers overflow or are none; the curve refuses them. What afmformats warns of, such as one curve of a map
        # in a file of its own, is no reason for doubt, and what it cannot read it raises
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.filterwarnings("ignore", module="afmformats")
            yield
    except MissingMetaDataError as error:
        # afmformats lists the names in quotation marks
        missing = " and no ".join(re.findall(r"[a-z][a-z ]+(?=')", str(error))) or "complete calibration"
        raise CurveError(
            f"{path.name}: the file has no {missing}. Write what is missing into the case file, "
            '[curve] spring_constant = "0.05 N/m" and sensitivity = "70 nm/V" (Python: Pass spring_constant=... [N/m] and '
            "sensitivity=... [m/V])."
        ) from None
    # the latter is no Exception; its readers index and unpack damaged files unchecked: IndexError, struct.error, zlib.error, ...
    except (Exception, AFMFileFormatError):
        raise UnknownFormat(
            f"{path.name}: afmformats cannot read it. It is damaged, or of a form that afmformats does not know; text "
            "files must be in UTF-8."
        ) from None


_HEADERS = {1: ("hi h", 1, 2), 2: ("hiii h", 1, 3), 3: ("hiiii h", 1, 4), 5: ("hh15i", 2, 15)}
"""Version of the format -> fields of its first header, and which of them are sizes of parts of the file [bytes]."""


def check_sizes(path: Path) -> None:
    """Refuse an Igor binary wave whose parts are longer than its file: its reader believes the header, and loops or allocates.

    Layout: WaveMetrics, Technical Note 003, "Igor Binary Format".

    Raises
    ------
    CurveError
        If a size is negative, or all of them together are more than there is.
    """
    with path.open("rb") as file:
        start = file.read(max(struct.calcsize(f"<{fields}") for fields, *_ in _HEADERS.values()))
    length = path.stat().st_size
    # the version is a small number: its first byte is zero where the larger byte comes first
    order = ">" if start[:1] == b"\0" else "<"
    version = struct.unpack_from(f"{order}h", start)[0] if len(start) >= 2 else 0
    fields, first, end = _HEADERS.get(version, ("", 0, 0))
    size = struct.calcsize(order + fields)
    if not fields or len(start) < size:
        raise CurveError(f"{path.name}: no Igor binary wave, or cut off. Export it anew.")
    sizes = struct.unpack_from(order + fields, start)[first:end]
    # older versions count 16 bytes of padding, which may be missing at the end of a file
    if min(sizes) < 0 or size + sum(sizes) > length + 16:
        raise CurveError(
            f"{path.name}: its header announces more than the {length} bytes of the file. It is damaged; copy or export it anew."
        )


def nanosurf_tables(path: Path) -> list[Table]:
    """Curves of a file.

    Raises
    ------
    CurveError
        If NSFopen is not installed, or the file has no curves.
    """
    try:
        from NSFopen.read import read
    except ImportError:
        raise CurveError(f"{path.name}: reading it needs NSFopen: pip install 'flatpunch[nanosurf]'.") from None
    try:
        file = read(str(path), dataframe=False)
        ways, header = file.data.get("Spec", {}), file.param["HeaderDump"].values()
        spring = file.param["Tip"].get("Prop0", {}).get("Value")
        units = {h["Dim2Name"]: h["Dim2Unit"] for h in header if "Spec" in h.get("Frame", "")}
    # NSFopen indexes and unpacks damaged bytes unchecked: KeyError, IndexError, struct.error, ...
    except Exception:
        raise CurveError(
            f"{path.name}: NSFopen cannot read it. It is damaged, or no file of a Nanosurf microscope."
        ) from None
    parts = [(way, ways[name]) for way, name in (("forth", "Forward"), ("back", "Backward")) if name in ways]
    names = tuple(name for name in units if parts and all(name in part for _, part in parts))
    if not names:
        raise CurveError(f"{path.name}: no force curves: no channels of spectroscopy.")
    constants = Constants(spring if isinstance(spring, float) and spring > 0 else None)
    tables = []
    for number in range(len(parts[0][1][names[0]])):
        there = [(way, [part[name][number] for name in names]) for way, part in parts if number < len(part[names[0]])]
        rows = [np.column_stack([np.asarray(column, dtype=float) for column in columns]) for _, columns in there]
        segment = np.repeat(np.arange(float(len(rows))), [len(part) for part in rows])
        table = Table(f"{path.name}, curve {number}", names, tuple(units[name] for name in names), np.concatenate(rows))
        tables.append(replace(table, constants=constants, segment=segment, ways=tuple(way for way, _ in there)))
    return tables
