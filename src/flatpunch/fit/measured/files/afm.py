"""Files of atomic force microscopes and nanoindenters, through the package afmformats (extra `afm`)."""

from __future__ import annotations

import logging
import re
import struct
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.checks import shown
from flatpunch._support.paths import Plain
from flatpunch.fit.measured.calibration import Constants, calibrated
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.files.nanosurf import nanosurf_curves
from flatpunch.fit.measured.files.ntmdt import free_tip_first
from flatpunch.fit.measured.files.unpacked import unpacked


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
        Any file that afmformats knows (JPK, Asylum, HDF5, tab, NT-MDT, Chiaro), or a Nanosurf .nid, also inside a .zip.
    spring_constant : float, optional
        Cantilever [N/m]; needed where the file does not say, otherwise it takes the place of the file's.
    sensitivity : float, optional
        Deflection per signal [m/V] or [m/A]; needed for files with raw signals, otherwise it takes the place of the file's.
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
    data: Sequence[object]
    height: str
    given: Mapping[str, float]

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
        return _curve(self.data[index], self.path, index, self.height, self.given)


@lru_cache(maxsize=2)
def _kept(path: Path, changed: int, override: tuple[tuple[str, float], ...], height: str) -> AfmFile:
    given = dict(override)
    found = _zipped(path, given) if path.suffix.lower() == ".zip" else _loaded(path, given)
    return AfmFile(path, found, height, given)


def _zipped(path: Path, override: dict[str, float]) -> Sequence[object]:
    """afmformats takes a zip for a workshop file; here it is only a wrapping. Columns are read before the folder goes."""
    curves: list[object] = []
    with unpacked(path) as files:
        for inner in files:
            curves += [_Columns(dict(data.metadata), _columns_of(data, path)) for data in _loaded(inner, override)]
    return curves


@dataclass(frozen=True, eq=False)
class _Columns:
    """A curve that no longer needs its file."""

    metadata: dict[str, object]
    data: dict[str, object]

    @property
    def columns(self) -> list[str]:
        return list(self.data)

    def __getitem__(self, name: str) -> object:
        return self.data[name]


def _columns_of(data: Any, path: Path) -> Plain:
    with _explained(path):
        return {name: np.asarray(data[name]) for name in data.columns}


def _loaded(path: Path, override: dict[str, float]) -> Any:
    if path.suffix.lower() == ".nid":
        return [_Columns(metadata, data) for metadata, data in nanosurf_curves(path, override)]
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
        try:
            found = afmformats.load_data(path)
        except afmformats.errors.MissingMetaDataError as error:
            # constants of the file are replaced in `calibrated`; here only those that it does not have
            missing = {name: override[name] for name in error.meta_keys if name in override}
            if not missing:
                raise
            found = afmformats.load_data(path, meta_override=missing)
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


def _curve(data: Any, path: Path, index: int, height: str, given: Mapping[str, float]) -> Curve:
    name = path.stem if index == 0 else f"{path.stem}-{index}"
    columns = list(data.columns)
    own = Constants(_constant(data.metadata, "spring constant"), _constant(data.metadata, "sensitivity"))
    k = own.spring_constant or given.get("spring constant")
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
        "read": (f"{path.name}, curve {index}: depth from {used!r}, force from 'force'",),
        "metadata": dict(data.metadata),
    }
    if time is not None and not np.isfinite(time).all():
        time, meta["no time"] = None, f"{path.name}: there are gaps in its column of times."
    more: Plain = {"name": name, "meta": meta, "time": time, "segment": segment}
    try:
        if "tip position" in columns:
            curve = Curve(-position, force, spring_constant=k, **more)
        elif k is not None:
            curve = Curve.from_piezo(-position, force, k, **more)
        else:
            curve = None
    except ValueError as error:
        raise CurveError(f"{path.name}: {error}") from None
    if curve is not None:
        return calibrated(curve, own, given.get("spring constant"), given.get("sensitivity"), inwards=True)
    raise CurveError(
        f'{path.name}: the file does not say the cantilever\'s spring constant. Write [curve] spring_constant = "0.05 N/m" '
        "into the case file, or pass spring_constant=... [N/m]."
    )


def _constant(metadata: Any, name: str) -> float | None:
    """A constant that a file was written with; None where it has none that is a positive number."""
    value = metadata.get(name)
    return float(value) if value is not None and np.isfinite(value) and value > 0 else None


_HEADERS = {1: "hi h", 2: "hiii h", 3: "hiiii h", 5: "hh15i"}
"""Version of the format -> fields of its first header: the version, a checksum and the sizes of the parts that follow."""
_SIZES = {1: slice(1, 2), 2: slice(1, 3), 3: slice(1, 4), 5: slice(2, 15)}
"""Which of these fields are sizes of parts of the file [bytes]."""


def check_sizes(path: Path) -> None:
    """Refuse an Igor binary wave whose parts are longer than its file: its reader believes the header, and loops or allocates.

    Layout: WaveMetrics, Technical Note 003, "Igor Binary Format".

    Raises
    ------
    CurveError
        If a size is negative, or all of them together are more than there is.
    """
    with path.open("rb") as file:
        start = file.read(64)
    length = path.stat().st_size
    # the version is a small number: its first byte is zero where the larger byte comes first
    order = ">" if start[:1] == b"\0" else "<"
    version = struct.unpack_from(f"{order}h", start)[0] if len(start) >= 2 else 0
    form = order + _HEADERS.get(version, "")
    if version not in _HEADERS or len(start) < struct.calcsize(form):
        raise CurveError(f"{path.name}: no Igor binary wave, or cut off. Export it anew.")
    sizes = struct.unpack_from(form, start)[_SIZES[version]]
    # older versions count 16 bytes of padding, which may be missing at the end of a file
    if min(sizes) < 0 or struct.calcsize(form) + sum(sizes) > length + 16:
        raise CurveError(
            f"{path.name}: its header announces more than the {length} bytes of the file. It is damaged; copy or export it anew."
        )
