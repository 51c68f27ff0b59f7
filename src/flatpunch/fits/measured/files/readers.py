"""Reading measured curves: text and Excel tables with named columns and units, files of atomic force microscopes.

A table needs the force, and the depth or the piezo position with the cantilever's spring constant:

    depth, force                            as they are
    piezo, force, spring constant           depth = piezo - force/k
    piezo, deflection, spring constant      force = k deflection, depth = piezo - deflection
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, BadValue, mapping, non_negative, one_of, positive, shown, switch, whole
from flatpunch._support.reading import Unreadable, as_path, check_archive, is_file, is_folder, shown_path
from flatpunch.files.units import LENGTH, Dimension
from flatpunch.fits.measured.calibration import PRINTED, calibrated, ratio_of
from flatpunch.fits.measured.columns import (
    ROLES,
    SIGNALS,
    WORDS,
    Constants,
    Table,
    check_title,
    chosen_columns,
    column_numbers,
    in_si,
    scale_of,
    split_name,
)
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.files.afm import MEASURED, AfmTables, UnknownFormat, nanosurf_tables
from flatpunch.fits.measured.files.contents import LARGEST, excel_tables, text_tables, unpacked
from flatpunch.fits.measured.records import begins_free, curves_among, in_time, tests_in

TEXT, EXCEL, AFM = (tuple(WORDS["files"][kind]) for kind in ("text", "excel", "afm"))
AFM += tuple(WORDS["files"]["nanosurf"])
"""Endings of files; exports of some instruments have none."""
_NANOSCOPE = re.compile(r"\.(spm|pfc|[0-9]{3})")  # endings of Bruker's files
CONSTANTS = {"spring constant": "spring_constant", "sensitivity": "sensitivity"}
UNTITLED = ("column 0", "column 1", "column 2")
CLIPPED = 0.1
"""Share of readings at the very least depth above which the depth was not measured before the contact."""
KEPT = LARGEST // 10
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
        For microscopes: sensitivity, deflection per signal [m/V] or [m/A], needed for raw signals, otherwise in the place of the
        file's; height, "height (measured)" or "height (piezo)", as afmformats calls it, which also reads a text for which it is
        given.

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
        folder = "is a folder; fit_batch reads its files." if is_folder(path) else "no such file."
        raise CurveError(f"{shown_path(path)}: {folder}")
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
    tables = tables_in(path, columns=columns, decimal=decimal, sheet=sheet, spring_constant=spring_constant, **afm)
    at = _only(path, tables, index)
    name, sensitivity = f"{path.stem}-{at}" if at else path.stem, afm.get("sensitivity")
    curve = curve_of(
        tables[at], name, columns, units, spring_constant, sensitivity=sensitivity, skip_nan=skip_nan, flip=flip
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


def _only(path: Path, found: Sequence[Table], index: int | None) -> int:
    """Which curve: the one asked for, or the only one."""
    if not found:
        raise CurveError(f"{path.name}: the file holds no curve.")
    if index is None and len(found) > 1:
        names = ", ".join(table.source for table in found[:4]) + (", ..." if len(found) > 4 else "")
        raise CurveError(
            f"{path.name}: the file holds {len(found)} curves ({names}); one must be chosen: index = 0 to {len(found) - 1}"
            + (" or sheet = '...'" if path.suffix.lower() in EXCEL else "")
            + ", or all are fitted with fit_batch([path], ...) or `flatpunch fit`."
        )
    if not 0 <= (index or 0) < len(found):
        raise CurveError(f"{path.name}: there is no curve {index}; the file holds {len(found)}, counted from 0.")
    return index or 0


class MissingColumn(CurveError):
    """No column of a role was recognised."""

    def __init__(self, text: str, role: str) -> None:
        super().__init__(text)
        self.role = role


def curves_in(path: str | Path, **reading: Any) -> int:
    """Number of curves in a file: a force map, a workbook of tests, blocks one below the other.

    Parameters
    ----------
    path : path
        The file.
    **reading
        As for `read_curve`.
    """
    path = as_path("path", path)
    if not is_file(path) or path.suffix.lower() not in (*EXCEL, *TEXT, *AFM, ".zip"):
        return 1
    known = ("columns", "decimal", "sheet", "spring_constant", "sensitivity", "height")
    return len(tables_in(path, **{name: reading[name] for name in known if name in reading}))


def tables_in(
    path: Path, *, columns: Mapping[str, str | int] | None = None, decimal: str = ".", **how: Any
) -> Sequence[Table]:
    """Return all curves of a file as tables, by arguments of `read_curve`; those of the last files are kept."""
    for role, title in mapping("columns", columns, '{"force": "Load"}').items():
        one_of("columns", role, ROLES, wrong="is no kind of column", error=CurveError)
        check_title(role, title)
    one_of("decimal", decimal, (".", ","))
    try:
        changed = path.stat()
    except OSError as error:
        raise CurveError(f"{path}: not readable ({error.strerror or error}).") from None
    read = _kept if changed.st_size < KEPT or path.suffix.lower() in AFM else _kept.__wrapped__
    wanted = tuple((columns or {}).items())
    return read(path, (changed.st_mtime_ns, changed.st_size), columns=wanted, decimal=decimal, **how)


@lru_cache(maxsize=2)
def _kept(path: Path, changed: tuple[int, int], **how: Any) -> Sequence[Table]:
    kind, wanted, decimal = path.suffix.lower(), dict(how["columns"]), how["decimal"]
    given = {name: how[key] for name, key in CONSTANTS.items() if how.get(key)}
    if kind in WORDS["files"]["nanosurf"]:
        return nanosurf_tables(path)
    if kind in AFM or how.get("height") is not None:
        return AfmTables(path, given, how.get("height") or MEASURED)
    if kind == ".zip":
        return _members(path, how)
    if kind in EXCEL:
        tables = excel_tables(path, how.get("sheet"))
    elif kind in TEXT or _NANOSCOPE.fullmatch(kind):
        # text exports of NanoScope are read, its binary files are named for what they are
        tables = text_tables(path, decimal)
        if "sensitivity" in given and not wanted and all(t.names == UNTITLED for t in tables):
            tables = [_untitled(t) for t in text_tables(path, ",")]
    else:
        known = ", ".join(filter(None, (*TEXT, *EXCEL, *AFM)))
        raise CurveError(f"{path}: the ending {shown(kind)} is none of those that are read: {known}.")
    try:
        return tuple(test for table in curves_among(tables, wanted) for test in tests_in(table, wanted))
    except CurveError as error:
        raise CurveError(f"{path.name}: {error}") from None


def _members(path: Path, how: dict[str, Any]) -> Sequence[Table]:
    """Curves of the files of an archive, in the order of their names; texts and sheets that are none are left out."""
    try:
        check_archive(path)
    except Unreadable as error:
        raise CurveError(f"{shown_path(path)}: {error}.") from None
    tables: list[Table] = []
    for file in unpacked(path):
        if file.suffix.lower() in (*TEXT, *EXCEL, *AFM):
            try:
                tables += _kept.__wrapped__(file, (0, 0), **how)
            except UnknownFormat:
                raise
            except CurveError:
                # a text without rows of numbers beside the curves
                continue
    return curves_among(tables, dict(how["columns"]))


def _untitled(table: Table) -> Table:
    """An export without titles: NT-MDT's height, deflection on approach and on retract.

    Constant readings before the deep end are padding of the export; those of a free tip are its baseline.
    """
    names, given = zip(*map(split_name, WORDS["titles"]["untitled"]), strict=True)
    height, *signals = (column_numbers(table, at) for at in range(3))
    rows, grows = table.rows.copy(), bool(height[-1] > height[0])
    for at, values in enumerate(signals, 1):
        if not begins_free(values):
            rows[: max(int(np.argmax(values != values[0])) - 1, 0), at] = ""
    return replace(table, names=names, units=given, rows=rows, outwards=grows != begins_free(signals[0]))


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
    own = _constants(table, positions, units, spring_constant)
    k = own.spring_constant or spring_constant
    roles = _needed(table, positions, explicit, k)
    if "depth" in roles and "depth" not in explicit and "piezo" in positions and k is not None:
        depth = column_numbers(table, positions["depth"])
        if np.mean(depth == np.nanmin(depth)) > CLIPPED:
            # instruments that count the depth from the contact write zero before it
            roles = ("piezo", roles[1])
    if own.spring_constant is None and spring_constant is not None and _bent(table, positions, units, LENGTH):
        # no constant relates the forces of the file to its deflections: the deflections are what was measured
        roles = (roles[0], "deflection")
    if "deflection" in roles and _bent(table, positions, units, *SIGNALS):
        own = replace(own, sensitivity=sensitivity or own.sensitivity, spring_constant=spring_constant or k)
        k = own.spring_constant
    data = {role: in_si(table, role, positions[role], units, own.sensitivity) for role in roles}
    if "stiffness" in positions:
        data["stiffness"] = in_si(table, "stiffness", positions["stiffness"], units)
    used = ", ".join(
        f"{role} from {table.names[positions[role]]!r} ({(units or {}).get(role) or table.units[positions[role]]})"
        for role in data
    )
    if table.segment is not None:
        data["segment"] = table.segment
        used += f", segments from {table.segmented}"
    meta: dict[str, object] = {"source": table.source, **table.meta, "read": (f"{table.source}: {used}",)}
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
    data = in_time(data, table.ways)
    try:
        curve = _assembled(name, data, k, -1.0 if flip != table.outwards else 1.0, meta)
    except CurveError as error:
        # which of several tests
        raise CurveError(f"{table.source}: {str(error).removeprefix(f'{name}: ')}") from None
    return calibrated(curve, own, spring_constant, sensitivity, inwards="piezo" in roles or table.outwards)


def _bent(table: Table, positions: Mapping[str, int], units: Mapping[str, str] | None, *kinds: Dimension) -> bool:
    """Whether there is a column of deflections of a kind."""
    at = positions.get("deflection")
    return at is not None and scale_of((units or {}).get("deflection") or table.units[at], *kinds) is not None


def _constants(
    table: Table, positions: Mapping[str, int], units: Mapping[str, str] | None, given: float | None
) -> Constants:
    """Constants that a table was written with: the ratio of its forces to its deflections, or what is written above it."""
    if "force" not in positions or not _bent(table, positions, units, LENGTH):
        return table.constants
    ratio = ratio_of(*(in_si(table, role, positions[role], units) for role in ("force", "deflection")))
    written = table.constants.spring_constant
    for known in (written, given):
        if ratio is None or (known is not None and abs(ratio / known - 1) < PRINTED):
            return replace(table.constants, spring_constant=written if ratio is None else known)
    why = "force over deflection in the file" + ("" if written is None else f", whose header has {written:.4g}")
    return replace(table.constants, spring_constant=ratio, origin=why)


def _needed(table: Table, positions: Mapping[str, int], explicit: set[str], k: float | None) -> tuple[str, ...]:
    """Columns to use: those the user named first, then depth, then piezo."""
    found = ", ".join(f"{table.names[i]!r} as {role}" for role, i in positions.items()) or "none"
    listed = ", ".join(map(repr, table.names)) or "none"
    by_piezo = "piezo" in positions and ("piezo" in explicit or "depth" not in positions)
    bends = "force" in positions or "deflection" in positions
    if by_piezo and bends and k is None:
        raise CurveError(
            f"{table.source}: a piezo position needs the cantilever's spring constant to become a depth. Write [curve] "
            'spring_constant = "0.05 N/m" into the case file (Python: spring_constant=... [N/m]); if it is the position of the '
            f'tip already, [curve.columns] depth = "{table.names[positions["piezo"]]}". Recognised: {found}.'
        )
    if by_piezo and bends:
        return ("piezo", "deflection") if "force" not in positions or "deflection" in explicit else ("piezo", "force")
    if {"depth", "force"} <= set(positions):
        return "depth", "force"
    role = "depth" if "force" in positions or "deflection" not in positions else "piezo"
    role = "deflection" if by_piezo else "force" if "depth" in positions else role
    raise MissingColumn(
        f"{table.source}: no column of {role} recognised. Columns are {listed}; recognised: {found}. Name it in the case "
        f"file, [curve.columns] {role} = '...' (Python: columns={{'{role}': '...'}}).",
        role,
    )


def _assembled(name: str, data: Mapping[str, Array], k: float | None, sign: float, meta: dict[str, object]) -> Curve:
    more = {role: data[role] for role in ("stiffness", "time", "segment") if role in data}
    if "depth" in data:
        return Curve(sign * data["depth"], data["force"], spring_constant=k, name=name, meta=meta, **more)
    assert k is not None
    force = data["force"] if "force" in data else k * data["deflection"]
    return Curve.from_piezo(sign * data["piezo"], force, k, name=name, meta=meta, **more)
