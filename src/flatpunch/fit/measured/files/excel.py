"""Tables of Excel files, old (.xls, by xlrd) and new (.xlsx, by openpyxl): titles in the first row, units in the second."""

from __future__ import annotations

import io
from itertools import pairwise
from pathlib import Path

import numpy as np

from flatpunch._support.checks import shown
from flatpunch._support.reading import Unreadable, check_archive
from flatpunch.fit.measured.columns import Table, split_name
from flatpunch.fit.measured.curve import CurveError


def excel_tables(path: Path, sheet: str | None = None) -> list[Table]:
    """Sheets of a file as tables.

    Parameters
    ----------
    path : Path
        The file.
    sheet : str, optional
        Only this one.

    Raises
    ------
    CurveError
        If the file cannot be read, or has no such sheet.
    """
    sheets = excel_sheets(path)
    if sheet is not None:
        if sheet not in sheets:
            raise CurveError(
                f"{path.name}: there is no sheet {shown(sheet)}; there are {', '.join(map(repr, sheets))}."
            )
        sheets = {sheet: sheets[sheet]}
    return [table for name, rows in sheets.items() for table in _tables(f"{path.name}, sheet {name}", rows)]


def excel_sheets(path: Path) -> dict[str, list[list[object]]]:
    """All cells of all sheets; empty ones are None or ""."""
    try:
        check_archive(path)
        if path.suffix.lower() == ".xls":
            import xlrd

            # it prints warnings of damaged files
            with xlrd.open_workbook(path, logfile=io.StringIO()) as book:
                return {s.name: [s.row_values(i) for i in range(s.nrows)] for s in book.sheets()}
        import openpyxl

        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        try:
            return {s.title: [list(row) for row in s.iter_rows(values_only=True)] for s in book.worksheets}
        finally:
            book.close()
    except Unreadable as error:
        raise CurveError(f"{path.name}: {error}.") from None
    # xlrd and openpyxl index and unpack damaged bytes unchecked: KeyError, struct.error, zlib.error, AssertionError, ...
    except Exception:
        raise CurveError(f"{path.name}: damaged, or no Excel file. Save it again, or as CSV.") from None


def _tables(source: str, rows: list[list[object]]) -> list[Table]:
    """Tables of a sheet: first rows of text are titles and units, what follows is data; the same titles again begin another."""
    cells = [[_value(cell) for cell in row] for row in rows]
    first = next((i for i, row in enumerate(cells) if sum(isinstance(c, str) and bool(c) for c in row) >= 2), None)
    if first is None:
        return []
    begins = [i for i in range(first, len(cells)) if cells[i] == cells[first]]
    names = [source] if len(begins) == 1 else [f"{source}, block {i + 1}" for i in range(len(begins))]
    return [
        _table(name, cells[begin:end], begin)
        for name, (begin, end) in zip(names, pairwise([*begins, len(cells)]), strict=True)
    ]


def _table(source: str, cells: list[list[object]], begin: int) -> Table:
    titles = [str(cell or "") for cell in cells[0]]
    body = cells[1:]
    unit_row: list[object] = [None] * len(titles)
    if body and not any(isinstance(cell, (int, float)) for cell in body[0]):
        unit_row, body = [cell.strip("()[] ") if isinstance(cell, str) else cell for cell in body[0]], body[1:]
    # notes below the last row of numbers are none of the data
    while body and sum(isinstance(cell, (int, float)) for cell in body[-1]) < 2:
        body = body[:-1]
    filled = [any(cell not in (None, "") for cell in row) for row in body]
    breaks = tuple(np.unique(np.cumsum(filled)[~np.array(filled, dtype=bool)]).tolist())
    body = [row for row, has in zip(body, filled, strict=True) if has]
    pairs = [split_name(title) for title in titles]
    units = [str(unit_row[i]) if i < len(unit_row) and unit_row[i] else unit for i, (_, unit) in enumerate(pairs)]
    return Table(source, tuple(name for name, _ in pairs), tuple(units), body, begin + 3, breaks)


def _value(cell: object) -> object:
    """A cell without blanks around it; a number that is stored as text is a number."""
    if not isinstance(cell, str):
        return cell
    try:
        return float(cell)
    except ValueError:
        # a word
        return cell.strip()
