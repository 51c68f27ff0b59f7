"""Reading measured curves: text and Excel tables with named columns and units, files of atomic force microscopes.

A table needs the force, and the depth or the piezo position with the cantilever's spring constant:

    depth, force                            as they are
    piezo, force, spring constant           depth = piezo - force/k
    piezo, deflection, spring constant      force = k deflection, depth = piezo - deflection
"""

from __future__ import annotations

import csv
import re
from bisect import bisect
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.archives import check_archive
from flatpunch._support.checks import Array, positive, shown, whole
from flatpunch._support.reading import Unreadable, as_path, content, shown_path
from flatpunch.fit.measured.columns import Table, chosen_columns, in_si, split_name
from flatpunch.fit.measured.curve import FEWEST, Curve, CurveError

EXCEL = (".xls", ".xlsx", ".xlsm")
AFM = (".ibw", ".jpk-force", ".jpk-force-map", ".jpk-qi-data", ".jpk-qi-series", ".tab", ".h5")
TEXT = (".csv", ".tsv", ".txt", ".dat")


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
        .csv, .tsv, .txt, .dat (text), .xls, .xlsx (Excel), or a file that afmformats reads.
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
        Of the cantilever [N/m].
    skip_nan : bool
        Drop rows in which a number is missing; otherwise they are an error.
    flip : bool
        Change the sign of depth and piezo: for heights that grow away from the sample.
    index : int
        Which curve of a file with many (a force map, a workbook of tests, blocks one below the other), from 0.
    calibration : mapping, optional
        Relative standard deviations of "spring_constant" and "sensitivity"; they enter the intervals of a fit.
    **afm
        For microscope files, see `flatpunch.fit.measured.afm.read_afm`: sensitivity, height. A text file for
        which one of them is given is read as a microscope's.

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
    if not path.is_file():
        raise CurveError(f"{shown_path(path)}: no such file.")
    if spring_constant is not None:
        spring_constant = positive("spring_constant", spring_constant, unit="N/m")
    if index is not None:
        index = whole("index", index, 0, "It is counted from 0.")
    if _by_afmformats(path, afm):
        from flatpunch.fit.measured.afm import AfmFile

        _check_size(path)
        file = AfmFile.opened(path, spring_constant=spring_constant, **afm)
        curve = file.curve(_only(path, [str(i) for i in range(len(file))], index))
        where = "given" if spring_constant is not None else "from the file"
        known = [f"spring constant {curve.spring_constant:.4g} N/m ({where})"] if curve.spring_constant else []
        known += [f"sensitivity {afm['sensitivity']:.4g} m/V or m/A (given)"] if afm.get("sensitivity") else []
        lines = (f"{path.name}, curve {index or 0}: {curve.meta['columns']}", *known)
        return replace(curve, meta={**curve.meta, "read": lines, "calibration": dict(calibration or {})})
    tables = tables_in(path, columns, decimal, sheet)
    table = tables[_only(path, [t.source for t in tables], index)]
    curve = curve_of(table, path.stem, columns, units, spring_constant, skip_nan=skip_nan, flip=flip)
    return replace(curve, meta={**curve.meta, "calibration": dict(calibration or {})})


def _only(path: Path, found: list[str], index: int | None) -> int:
    """Which curve: the one asked for, or the only one."""
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


def tables_in(path: Path, columns: Mapping[str, str | int] | None, decimal: str, sheet: str | None) -> list[Table]:
    """Return all curves of a text or Excel file as tables, with columns and decimal as for `read_curve`."""
    kind = path.suffix.lower()
    if kind in EXCEL:
        from flatpunch.fit.measured.excel import excel_tables

        return _with_columns(excel_tables(path, sheet), columns, path)
    if kind in TEXT:
        return text_tables(path, decimal)
    known = ", ".join((*TEXT, *EXCEL, *AFM))
    raise CurveError(f"{path}: the ending {shown(kind)} is none of those that are read: {known}.")


def curves_in(
    path: str | Path,
    *,
    spring_constant: float | None = None,
    columns: Mapping[str, str | int] | None = None,
    decimal: str = ".",
    sheet: str | None = None,
    **reading: Any,
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
    afm: dict[str, Any] = {name: reading[name] for name in ("sensitivity", "height") if name in reading}
    if not path.is_file():
        return 1
    if _by_afmformats(path, afm):
        from flatpunch.fit.measured.afm import AfmFile

        _check_size(path)
        return len(AfmFile.opened(path, spring_constant=spring_constant, **afm))
    return len(tables_in(path, columns, decimal, sheet)) if path.suffix.lower() in (*EXCEL, *TEXT) else 1


def _check_size(path: Path) -> None:
    """Refuse archives that are too large once they are unpacked."""
    try:
        check_archive(path)
    except Unreadable as error:
        raise CurveError(f"{shown_path(path)}: {error}.") from None


def _by_afmformats(path: Path, afm: Mapping[str, Any]) -> bool:
    return path.suffix.lower() in (*AFM, ".zip") or bool(afm)


def _with_columns(tables: list[Table], columns: Mapping[str, str | int] | None, path: Path) -> list[Table]:
    """The tables with a column of forces, long enough to be curves; the longest if none is."""
    found, reasons = [], []
    for table in tables:
        try:
            positions = chosen_columns(table, columns)
            # a sheet of results has force and depth as well, one row for each test
            if "force" in positions and {"depth", "piezo"} & set(positions) and len(table.rows) >= FEWEST:
                found.append(table)
        except CurveError as error:
            if len(tables) == 1:
                raise
            reasons.append(str(error))
    if not found and len(tables) == 1:
        return tables
    if not found:
        names = "; ".join(f"{t.source}: {', '.join(t.names)}" for t in tables) or "no table at all"
        why = " ".join(reasons) or "Name the columns with columns=...."
        raise CurveError(f"{path}: no sheet with a column of forces. Found {names}. {why}")
    return found


def curve_of(
    table: Table,
    name: str,
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
    spring_constant: float | None = None,
    *,
    skip_nan: bool = False,
    flip: bool = False,
) -> Curve:
    """Make a curve of a table's columns."""
    positions = chosen_columns(table, columns)
    explicit = set(columns or ())
    roles = _needed(table, positions, explicit, spring_constant)
    data = {role: in_si(table, role, positions[role], units) for role in roles}
    if "stiffness" in positions and "stiffness" not in data:
        data["stiffness"] = in_si(table, "stiffness", positions["stiffness"], units)
    used = ", ".join(
        f"{role} from {table.names[positions[role]]!r} ({(units or {}).get(role) or table.units[positions[role]]})"
        for role in roles
    )
    known = [f"spring constant {spring_constant:.4g} N/m (given)"] if spring_constant is not None else []
    meta: dict[str, Any] = {"source": table.source, "read": (f"{table.source}: {used}", *known)}
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
    return _assembled(name, data, spring_constant, -1.0 if flip else 1.0, meta)


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


def _assembled(name: str, data: Mapping[str, Array], k: float | None, sign: float, meta: dict[str, Any]) -> Curve:
    more = {role: data[role] for role in ("stiffness", "time") if role in data}
    if "depth" in data:
        return Curve(sign * data["depth"], data["force"], spring_constant=k, name=name, meta=meta, **more)
    assert k is not None
    force = data["force"] if "force" in data else k * data["deflection"]
    return Curve.from_piezo(sign * data["piezo"], force, k, name=name, meta=meta, **more)


LARGEST = 500_000_000
"""Largest text file of a curve [bytes]."""

_NUMBER = re.compile(r"\s*(?:[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|nan|NaN|)\s*")


def text_tables(path: Path, decimal: str = ".") -> list[Table]:
    """Read a text file: runs of rows of numbers, the titles above each, a row of units between them if there is one.

    Words between two runs make them two tables; comments, blank lines and single cells that are no number do not.
    """
    if decimal not in (".", ","):
        raise ValueError(f"decimal = {shown(decimal)} must be '.' or ','.")
    try:
        raw = content(path, LARGEST)
    except Unreadable as error:
        raise CurveError(f"{shown_path(path)}: {error}.") from None
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    if "\0" in text[:1000]:
        raise CurveError(f"{path.name}: not a text file.")
    lines = text.splitlines()
    delimiter = _delimiter(lines, decimal)
    rows = [_cells(line, delimiter) for line in lines]
    numeric = [i for i, row in enumerate(rows) if _is_data(row)]
    if len(numeric) < 2:
        raise CurveError(
            f"{path.name}: no rows of numbers found. Text files need a line of titles, then one row a point."
        )
    width = int(np.median([len(rows[i]) for i in numeric]))
    numeric = [i for i in numeric if len(rows[i]) >= width]
    points = set(numeric)
    words = [i for i, row in enumerate(rows) if i not in points and _only_words(row)]
    runs, above = [[numeric[0]]], [0]
    for before, i in pairwise(numeric):
        if words[bisect(words, before) : bisect(words, i)]:
            runs.append([])
            above.append(before + 1)
        runs[-1].append(i)
    long = [(run, start) for run, start in zip(runs, above, strict=True) if len(run) >= FEWEST] or [(numeric, 0)]
    tables: list[Table] = []
    for count, (run, start) in enumerate(long):
        names, unit_row = _titles(rows[start : run[0]], width)
        pairs = [split_name(title) for title in names]
        own = dict(enumerate(unit_row or ()))
        found = tuple(own.get(i) or unit for i, (_, unit) in enumerate(pairs))
        body = [row for row in rows[run[0] : run[-1] + 1] if any(cell.strip() for cell in row)]
        if decimal == ",":
            body = [[cell.replace(",", ".") for cell in row] for row in body]
        source = path.name if len(long) == 1 else f"{path.name}, block {count + 1}"
        table = Table(source, tuple(n for n, _ in pairs), found, body, run[0] + 1)
        if tables and names[0].startswith("column "):
            table = replace(table, names=tables[0].names, units=tables[0].units)
        tables.append(table)
    return tables


def _only_words(row: list[str]) -> bool:
    filled = [cell for cell in row if cell.strip()]
    return (
        bool(filled)
        and not filled[0].startswith("#")
        and not any(re.search(r"^[+-]?\d", cell.strip()) for cell in filled)
    )


def _delimiter(lines: list[str], decimal: str) -> str | None:
    """Tab or semicolon if rows have them, else comma (unless it is the decimal mark), else white space."""
    body = [line for line in lines if re.search(r"\d", line)]
    sample = body[len(body) // 2 :][:50] or lines[:50]
    for mark in ("\t", ";", *([","] if decimal == "." else [])):
        if sum(mark in line for line in sample) > 0.8 * max(len(sample), 1):
            return mark
    return None


def _cells(line: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return line.split()
    if '"' not in line:
        # most of the lines of a large file
        return [cell.strip() for cell in line.split(delimiter)] if line else []
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]


def _is_data(row: list[str]) -> bool:
    filled = [cell for cell in row if cell]
    return len(filled) >= 2 and all(_NUMBER.fullmatch(cell.replace(",", ".")) for cell in filled)


def _titles(above: list[list[str]], width: int) -> tuple[list[str], list[str] | None]:
    """Titles, and the row of units below them if there is one."""
    candidates = [
        [re.sub(r"^#+\s*", "", cell) for cell in row]
        for row in above
        if len(row) >= width and any(cell.strip() for cell in row)
    ]
    if not candidates:
        return [f"column {i}" for i in range(width)], None
    last = candidates[-1]
    if len(candidates) > 1 and _looks_like_units(last):
        return candidates[-2], last
    return last, None


def _looks_like_units(row: list[str]) -> bool:
    """Whether all filled cells are short and could be units."""
    filled = [cell.strip("()[] ") for cell in row if cell.strip()]
    return bool(filled) and all(re.fullmatch(r"[A-Za-zµμ%]{1,4}(?:[/^*][A-Za-zµμ0-9]{1,4})?", cell) for cell in filled)
