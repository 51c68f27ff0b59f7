"""Reading measured curves: text and Excel tables with named columns and units, files of atomic force microscopes.

A table needs the force, and the depth or the piezo position with the cantilever's spring constant:

    depth, force                            as they are
    piezo, force, spring constant           depth = piezo - force/k
    piezo, deflection, spring constant      force = k deflection, depth = piezo - deflection
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flatpunch._support.checks import Array, BadValue, non_negative, positive, shown, switch, whole
from flatpunch._support.kinds import mapping, one_of
from flatpunch._support.reading import Unreadable, as_path, check_archive, is_file, shown_path
from flatpunch.fit.measured.calibration import calibrated
from flatpunch.fit.measured.columns import (
    ROLES,
    Table,
    check_title,
    chosen_columns,
    in_si,
    is_length,
    is_signal,
    own_constants,
    segments_of,
    with_columns,
)
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.files.text import text_tables
from flatpunch.fit.measured.files.unpacked import unpacked
from flatpunch.fit.measured.records import records_in
from flatpunch.fit.measured.sides import without_sides

if TYPE_CHECKING:
    from flatpunch.fit.measured.files.afm import AfmFile

EXCEL = (".xls", ".xlsx", ".xlsm")
AFM = (".ibw", ".jpk-force", ".jpk-force-map", ".jpk-qi-data", ".jpk-qi-series", ".tab", ".h5", ".nid")
TEXT = (".csv", ".tsv", ".txt", ".dat", ".asc", "")
"""Endings of text files; exports of some instruments have none."""
_NANOSCOPE = re.compile(r"\.(spm|pfc|[0-9]{3})")  # endings of Bruker's files
KEPT = 20_000_000
"""Largest file whose tables are kept for its next curve [bytes]; they take about ten times as much memory."""


def read_curve(
    path: str | Path,
    *,
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
    decimal: str = ".",
    sheet: str | None = None,
    spring_constant: float | None = None,
    skip_nan: bool = False,
    flip: bool = False,
    index: int | None = None,
    calibration: Mapping[str, float] | None = None,
    **afm: Any,
) -> Curve:
    """Read one measured curve.

    Parameters
    ----------
    path : path
        .csv, .tsv, .txt, .dat, .asc or no ending (text), .xls, .xlsx (Excel), a file that afmformats or NSFopen reads, or a .zip
        of such files or of texts.
    columns : mapping, optional
        Which column is what, {"force": "Load", "piezo": 3}; keys are depth, force, piezo, deflection, stiffness, time. What is
        not named is recognised by its title.
    units : mapping, optional
        Units of columns whose title has none, {"force": "nN"}.
    decimal : "." or ","
        Decimal mark of a text file.
    sheet : str, optional
        Sheet of an Excel file; the first one with such columns if left out.
    spring_constant : float, optional
        Of the cantilever [N/m]. It takes the place of the file's: forces are this constant times the deflection, and deflections
        stay as they are.
    skip_nan : bool
        Drop rows in which a number is missing; otherwise they are an error.
    flip : bool
        Change the sign of depth and piezo: for heights that grow away from the sample.
    index : int
        Which curve of a file with many (a force map, a workbook of tests, records one below the other), from 0.
    calibration : mapping, optional
        Relative standard deviations of "spring_constant" and "sensitivity"; they enter the intervals of a fit.
    **afm
        For microscope files, see `flatpunch.fit.measured.files.afm.read_afm`: sensitivity, height. A text file for which a
        height is given is read as a microscope's, and so is one with a sensitivity unless it has a column of deflections.

    Returns
    -------
    Curve

    Raises
    ------
    CurveError
        If the file cannot be read as a curve; the message says what is missing and where.

    See Also
    --------
    Curve : From arrays.
    fit : From a curve to moduli.
    fit_batch : Many files.

    Examples
    --------
    >>> depth = np.arange(-100.0, 200.0, 5.0)
    >>> columns = np.column_stack([depth, 0.01 * np.maximum(depth, 0.0) ** 1.5])
    >>> np.savetxt("curve.csv", columns, delimiter=",", header="depth (nm),force (nN)", comments="")
    >>> curve = fp.read_curve("curve.csv")
    >>> print(f"{curve.depth.size} points up to {curve.depth.max() * 1e9:.0f} nm")
    60 points up to 195 nm
    """
    path = as_path("path", path)
    if not is_file(path):
        raise CurveError(f"{shown_path(path)}: no such file.")
    if spring_constant is not None:
        spring_constant = positive("spring_constant", spring_constant, unit="N/m")
    if index is not None:
        index = whole("index", index, 0, "It is counted from 0.")
    if sheet is not None and not isinstance(sheet, str):
        raise TypeError(f"sheet = {shown(sheet)} must be the name of a sheet.")
    skip_nan, flip = switch("skip_nan", skip_nan), switch("flip", flip)
    for role in mapping("units", units, '{"force": "nN"}'):
        one_of("units", role, ROLES, wrong="is no kind of column", error=CurveError)
    spread = _calibration(calibration)
    sensitivity = afm.get("sensitivity")
    found = _opened(path, spring_constant, columns, decimal, sheet, afm)
    if not isinstance(found, tuple):
        curve = found.curve(_only(path, [str(i) for i in range(len(found))], index))
    else:
        table = found[_only(path, [t.source for t in found], index)]
        curve = curve_of(
            table, path.stem, columns, units, spring_constant, sensitivity=sensitivity, skip_nan=skip_nan, flip=flip
        )
    return replace(curve, meta={**curve.meta, "calibration": spread})


def _calibration(given: Mapping[str, float] | None) -> dict[str, float]:
    """Relative standard deviations of the numbers of a calibration."""
    spread: dict[str, float] = {}
    for name, std in mapping("calibration", given, '{"spring_constant": 0.1}').items():
        one_of("calibration", name, ("spring_constant", "sensitivity"))
        spread[name] = non_negative(f"calibration[{name!r}]", std, "0.1 stands for 10 %.", unit="1")
        if spread[name] >= 1:
            raise BadValue(f"calibration[{name!r}]", repr(spread[name]), "must be below 1: 0.1 stands for 10 %.")
    return spread


def _only(path: Path, found: list[str], index: int | None) -> int:
    """Which curve: the one asked for, or the only one."""
    if not found:
        raise CurveError(f"{path.name}: the file holds no curve.")
    if index is None and len(found) > 1:
        names = ", ".join(found[:4]) + (", ..." if len(found) > 4 else "")
        raise CurveError(
            f"{path.name}: the file holds {len(found)} curves ({names}); one must be chosen: index = 0 to {len(found) - 1}"
            + (" or sheet = '...'" if path.suffix.lower() in EXCEL else "")
            + ", or all are fitted with fit_batch([path], ...) or `flatpunch fit`."
        )
    if not 0 <= (index or 0) < len(found):
        raise CurveError(f"{path.name}: there is no curve {index}; the file holds {len(found)}, counted from 0.")
    return index or 0


def _opened(
    path: Path,
    spring_constant: float | None,
    columns: Mapping[str, str | int] | None,
    decimal: str,
    sheet: str | None,
    afm: Mapping[str, Any],
) -> AfmFile | tuple[Table, ...]:
    """A microscope's file, or the curves of a text or Excel file as tables.

    Archives and text files with a sensitivity may be either.
    """
    kind = path.suffix.lower()
    tables: tuple[Table, ...] = ()
    if kind not in (*AFM, ".zip") and "height" not in afm:
        tables = tables_in(path, columns, decimal, sheet)
        if "sensitivity" not in afm or any("deflection" in _roles(table, columns) for table in tables):
            return tables
    from flatpunch.fit.measured.files.afm import AfmFile, UnknownFormat

    _check_size(path)
    try:
        return AfmFile.opened(path, spring_constant=spring_constant, **afm)
    except UnknownFormat:
        if kind == ".zip":
            tables = tables_in(path, columns, decimal, sheet)
        if tables:
            return tables
        raise


def _roles(table: Table, columns: Mapping[str, str | int] | None) -> dict[str, int]:
    """Columns that are recognised; none where that is not clear."""
    try:
        return chosen_columns(table, columns)
    except CurveError:
        # of no use here; where the table is read this is raised
        return {}


def tables_in(
    path: Path, columns: Mapping[str, str | int] | None, decimal: str, sheet: str | None
) -> tuple[Table, ...]:
    """Return all curves of a text or Excel file, or of an archive of them, as tables; those of the last file are kept."""
    for role, title in mapping("columns", columns, '{"force": "Load"}').items():
        one_of("columns", role, ROLES, wrong="is no kind of column", error=CurveError)
        check_title(role, title)
    one_of("decimal", decimal, (".", ","))
    kind = path.suffix.lower()
    if _NANOSCOPE.fullmatch(kind):
        # their text exports are read, the binary files are named for what they are
        kind = ""
    if kind not in (*TEXT, *EXCEL, ".zip"):
        known = ", ".join(filter(None, (*TEXT, *EXCEL, *AFM)))
        raise CurveError(f"{path}: the ending {shown(kind)} is none of those that are read: {known}.")
    try:
        changed = path.stat()
    except OSError as error:
        raise CurveError(f"{path}: not readable ({error.strerror or error}).") from None
    wanted = None if columns is None else tuple(columns.items())
    read = _kept if changed.st_size < KEPT else _kept.__wrapped__
    return read(path, (changed.st_mtime_ns, changed.st_size), wanted, decimal, sheet)


@lru_cache(maxsize=1)
def _kept(
    path: Path,
    changed: tuple[int, int],
    columns: tuple[tuple[str, str | int], ...] | None,
    decimal: str,
    sheet: str | None,
) -> tuple[Table, ...]:
    wanted = None if columns is None else dict(columns)
    kind = path.suffix.lower()
    if kind == ".zip":
        return _zipped(path, wanted, decimal)
    if kind in EXCEL:
        from flatpunch.fit.measured.files.excel import excel_tables

        tables = with_columns(excel_tables(path, sheet), wanted, path)
    else:
        tables = text_tables(path, decimal)
    return tuple(record for table in tables for record in records_in(without_sides(table, wanted), wanted))


def _zipped(path: Path, columns: Mapping[str, str | int] | None, decimal: str) -> tuple[Table, ...]:
    """Tables of curves in the text files of an archive, in the order of their names; none if there are none."""
    tables: list[Table] = []
    with unpacked(path) as files:
        for file in files:
            if file.suffix.lower() not in TEXT:
                continue
            try:
                found = text_tables(file, decimal)
            except CurveError:
                # a text without rows of numbers beside the curves
                continue
            tables += [record for table in found for record in records_in(without_sides(table, columns), columns)]
    return tuple(
        table for table in tables if "force" in _roles(table, columns) or "deflection" in _roles(table, columns)
    )


def curves_in(
    path: str | Path,
    *,
    spring_constant: float | None = None,
    columns: Mapping[str, str | int] | None = None,
    decimal: str = ".",
    sheet: str | None = None,
    **reading: object,
) -> int:
    """Number of curves in a file: a force map, a workbook of tests, blocks one below the other.

    Parameters
    ----------
    path : path
        The file.
    spring_constant, columns, decimal, sheet, **reading
        As for `read_curve`.
    """
    path = as_path("path", path)
    afm: dict[str, object] = {name: reading[name] for name in ("sensitivity", "height") if name in reading}
    if not is_file(path):
        return 1
    if path.suffix.lower() not in (*EXCEL, *TEXT, *AFM, ".zip"):
        return 1
    found = _opened(path, spring_constant, columns, decimal, sheet, afm)
    return len(found)


def _check_size(path: Path) -> None:
    """Refuse archives that are too large once they are unpacked."""
    try:
        check_archive(path)
    except Unreadable as error:
        raise CurveError(f"{shown_path(path)}: {error}.") from None


def curve_of(
    table: Table,
    name: str,
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
    spring_constant: float | None = None,
    *,
    sensitivity: float | None = None,
    skip_nan: bool = False,
    flip: bool = False,
) -> Curve:
    """Make a curve of a table's columns."""
    positions = chosen_columns(table, columns)
    explicit = set(columns or ())
    own = own_constants(table, positions, units, spring_constant)
    k = own.spring_constant or spring_constant
    roles = _needed(table, positions, explicit, k)
    if own.spring_constant is None and spring_constant is not None and is_length(table, positions, units):
        # no constant relates the forces of the file to its deflections: the deflections are what was measured
        roles = (roles[0], "deflection")
    if "deflection" in roles and is_signal(table, positions["deflection"], units):
        own = replace(own, sensitivity=sensitivity or own.sensitivity, spring_constant=spring_constant or k)
        k = own.spring_constant
    data = {role: in_si(table, role, positions[role], units, own.sensitivity) for role in roles}
    if "stiffness" in positions and "stiffness" not in data:
        data["stiffness"] = in_si(table, "stiffness", positions["stiffness"], units)
    used = ", ".join(
        f"{role} from {table.names[positions[role]]!r} ({(units or {}).get(role) or table.units[positions[role]]})"
        for role in data
    )
    if (segments := segments_of(table)) is not None:
        data["segment"] = segments[1]
        used += f", segments from {segments[0]!r}"
    meta: dict[str, object] = {"source": table.source, "read": (f"{table.source}: {used}",)}
    if "time" in positions:
        # most fits do without: a column that cannot be used is left out, and why is kept for those that need it
        try:
            data["time"] = in_si(table, "time", positions["time"], units)
        except CurveError as error:
            if "time" in explicit:
                raise
            meta["no time"] = str(error)
    if skip_nan:
        good = np.logical_and.reduce([np.isfinite(column) for column in data.values()])
        data = {role: column[good] for role, column in data.items()}
    if "time" in data and not np.isfinite(data["time"]).all():
        bad = int(np.argmin(np.isfinite(data.pop("time"))))
        meta["no time"] = f"{table.source}: row {table.first_row + bad} has no time."
    try:
        curve = _assembled(name, data, k, -1.0 if flip else 1.0, meta)
    except CurveError as error:
        # which of several tests
        raise CurveError(f"{table.source}: {str(error).removeprefix(f'{name}: ')}") from None
    return calibrated(curve, own, spring_constant, sensitivity, inwards="piezo" in roles)


def _needed(table: Table, positions: Mapping[str, int], explicit: set[str], k: float | None) -> tuple[str, ...]:
    """Columns to use: those the user named first, then depth, then piezo."""
    found = ", ".join(f"{table.names[i]!r} as {role}" for role, i in positions.items()) or "none"
    listed = ", ".join(map(repr, table.names)) or "none"
    by_piezo = "piezo" in positions and ("piezo" in explicit or "depth" not in positions)
    if by_piezo and k is None:
        raise CurveError(
            f"{table.source}: a piezo position needs the cantilever's spring constant to become a depth. Write [curve] "
            'spring_constant = "0.05 N/m" into the case file (Python: spring_constant=... [N/m]); if it is the position of the '
            f'tip already, [curve.columns] depth = "{table.names[positions["piezo"]]}". Recognised: {found}.'
        )
    if by_piezo and ("force" in positions or "deflection" in positions):
        return ("piezo", "deflection") if "force" not in positions or "deflection" in explicit else ("piezo", "force")
    for role in ("depth", "force"):
        if role not in positions:
            raise CurveError(
                f"{table.source}: no column of {role} recognised. Columns are {listed}; recognised: {found}. Name it in the case "
                f"file, [curve.columns] {role} = '...' (Python: columns={{'{role}': '...'}})."
            )
    return "depth", "force"


def _assembled(name: str, data: Mapping[str, Array], k: float | None, sign: float, meta: dict[str, object]) -> Curve:
    more = {role: data[role] for role in ("stiffness", "time", "segment") if role in data}
    if "depth" in data:
        return Curve(sign * data["depth"], data["force"], spring_constant=k, name=name, meta=meta, **more)
    assert k is not None
    force = data["force"] if "force" in data else k * data["deflection"]
    return Curve.from_piezo(sign * data["piezo"], force, k, name=name, meta=meta, **more)
