"""Files of atomic force microscopes and nanoindenters, through the package afmformats (extra `afm`)."""

from __future__ import annotations

import logging
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.checks import shown
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.igor import check_sizes
from flatpunch.fit.measured.ntmdt import free_tip_first
from flatpunch.fit.measured.unpacked import unpacked


class UnknownFormat(CurveError):
    """A file that afmformats does not know."""


def read_afm(
    path: str | Path,
    *,
    spring_constant: float | None = None,
    sensitivity: float | None = None,
    height: str = "height (measured)",
) -> list[Curve]:
    """Read all curves of a microscope file.

    Parameters
    ----------
    path : path
        Any file that afmformats knows (JPK, Asylum, HDF5, tab, NT-MDT, Chiaro), also inside a .zip.
    spring_constant : float, optional
        Cantilever [N/m]; needed where the file does not say, otherwise it must be left out or takes the place of the file's.
    sensitivity : float, optional
        Deflection per signal [m/V] or [m/A], for files with raw signals.
    height : str
        Which height to use: "height (measured)" or "height (piezo)".

    Returns
    -------
    list of Curve
        Approach and retract as they are; depth = -(height + force/k), as heights there grow away from the sample.

    Raises
    ------
    CurveError
        If afmformats is not installed or cannot read the file.
    """
    file = AfmFile.opened(path, spring_constant=spring_constant, sensitivity=sensitivity, height=height)
    return [file.curve(i) for i in range(len(file))]


@dataclass(frozen=True, eq=False)
class AfmFile:
    """An open microscope file; its curves are read when asked for, and an open file is kept for the next one."""

    path: Path
    data: Sequence[Any]
    height: str

    @classmethod
    def opened(
        cls,
        path: str | Path,
        *,
        spring_constant: float | None = None,
        sensitivity: float | None = None,
        height: str = "height (measured)",
    ) -> AfmFile:
        """Open a file, or return it if it still is; parameters as for `read_afm`."""
        path = Path(path)
        override = {
            name: value
            for name, value in (("spring constant", spring_constant), ("sensitivity", sensitivity))
            if value is not None
        }
        try:
            changed = path.stat().st_mtime_ns
        except OSError as error:
            raise CurveError(f"{path}: not readable ({error.strerror or error}).") from None
        return _kept(path, changed, tuple(override.items()), height)

    def __len__(self) -> int:
        return len(self.data)

    def curve(self, index: int) -> Curve:
        """One curve."""
        if not 0 <= index < len(self.data):
            raise CurveError(
                f"{self.path.name}: there is no curve {index}; the file holds {len(self.data)}, counted from 0."
            )
        return _curve(self.data[index], self.path, index, self.height)


@lru_cache(maxsize=2)
def _kept(path: Path, changed: int, override: tuple[tuple[str, float], ...], height: str) -> AfmFile:
    if path.suffix.lower() == ".zip":
        return AfmFile(path, _zipped(path, dict(override)), height)
    return AfmFile(path, _loaded(path, dict(override)), height)


def _zipped(path: Path, override: dict[str, float]) -> Sequence[Any]:
    """afmformats takes a zip for a workshop file; here it is only a wrapping. Columns are read before the folder goes."""
    curves: list[Any] = []
    with unpacked(path) as files:
        for inner in files:
            curves += [_Columns(dict(data.metadata), _columns_of(data, path)) for data in _loaded(inner, override)]
    return curves


@dataclass(frozen=True, eq=False)
class _Columns:
    """A curve that no longer needs its file."""

    metadata: dict[str, Any]
    data: dict[str, Any]

    @property
    def columns(self) -> list[str]:
        return list(self.data)

    def __getitem__(self, name: str) -> Any:
        return self.data[name]


def _columns_of(data: Any, path: Path) -> dict[str, Any]:
    with _explained(path):
        return {name: np.asarray(data[name]) for name in data.columns}


def _loaded(path: Path, override: dict[str, float]) -> Any:
    try:
        import afmformats
    except ImportError:
        raise CurveError(f"{path.name}: reading it needs afmformats: pip install 'flatpunch[afm]'.") from None
    # errors are reported here: without a handler of the caller's own their tracebacks are not printed
    for library in ("afmformats", "igor2"):
        logging.getLogger(library).addHandler(logging.NullHandler())
    if path.suffix.lower() == ".ibw":
        check_sizes(path)
    with _explained(path):
        _forget_archive(path)
        found = afmformats.load_data(path, meta_override=override)
        if len(found) == 1 and "NT-MDT" in str(found[0].metadata.get("format", "")):
            columns = free_tip_first(path, override["sensitivity"] * override["spring constant"])
            return found if columns is None else [_Columns(dict(found[0].metadata), columns)]
        return found


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
def _explained(path: Path) -> Iterator[None]:
    """Errors of afmformats in words that say what to do; its readers raise any type on damaged files."""
    from afmformats.errors import AFMFileFormatError, MissingMetaDataError

    try:
        # damaged numbers overflow or are none; the curve refuses them. What afmformats warns of, such as one curve of a map
        # in a file of its own, is no reason for doubt, and what it cannot read it raises
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.filterwarnings("ignore", module="afmformats")
            yield
    except CurveError:
        raise
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


def _curve(data: Any, path: Path, index: int, height: str) -> Curve:
    name = path.stem if index == 0 else f"{path.stem}-{index}"
    columns = list(data.columns)
    k = data.metadata.get("spring constant")
    with _explained(path):
        force = np.asarray(data["force"], dtype=float)
        if height not in columns:
            raise CurveError(f"{path.name}: no column {shown(height)}; there are {', '.join(columns)}.")
        position = np.asarray(data["tip position" if "tip position" in columns else height], dtype=float)
        segment = np.asarray(data["segment"], dtype=float) if "segment" in columns else None
        time = np.asarray(data["time"], dtype=float) if "time" in columns else None
    if segment is not None and ((np.diff(segment) < 0).any() or np.unique(segment).size < 2):
        # one segment, or numbers that do not count up, show nothing
        segment = None
    used = "tip position" if "tip position" in columns else height
    meta = {
        "source": str(path.name),
        "columns": f"depth from {used!r}, force from 'force'",
        "metadata": dict(data.metadata),
    }
    k = float(k) if k is not None and np.isfinite(k) else None
    if time is not None and not np.isfinite(time).all():
        time, meta["no time"] = None, f"{path.name}: there are gaps in its column of times."
    more: dict[str, Any] = {"name": name, "meta": meta, "time": time, "segment": segment}
    try:
        if "tip position" in columns:
            return Curve(-position, force, spring_constant=k, **more)
        if k is not None:
            return Curve.from_piezo(-position, force, k, **more)
    except ValueError as error:
        raise CurveError(f"{path.name}: {error}") from None
    raise CurveError(
        f'{path.name}: the file does not say the cantilever\'s spring constant. Write [curve] spring_constant = "0.05 N/m" '
        "into the case file, or pass spring_constant=... [N/m]."
    )
