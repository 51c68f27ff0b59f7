"""Sheets of Excel files, old (.xls, by xlrd) and new (.xlsx, by openpyxl)."""

from __future__ import annotations

import io
from pathlib import Path

from flatpunch._support.checks import shown
from flatpunch._support.reading import Unreadable, check_archive
from flatpunch.fit.measured.columns import Table
from flatpunch.fit.measured.curve import CurveError
from flatpunch.fit.measured.files.cells import tables_of


def excel_tables(path: Path, sheet: str | None = None) -> list[Table]:
    """Tables of all sheets of a file, or of one.

    Raises
    ------
    CurveError
        If the file cannot be read, or has no such sheet.
    """
    sheets = excel_sheets(path)
    if sheet is not None and sheet not in sheets:
        raise CurveError(f"{path.name}: there is no sheet {shown(sheet)}; there are {', '.join(map(repr, sheets))}.")
    tables: list[Table] = []
    for name, rows in sheets.items():
        if sheet in (None, name):
            cells = [[cell.strip() if isinstance(cell, str) else cell for cell in row] for row in rows]
            lines = ["\t".join(str(cell) for cell in row if cell not in (None, "")) for row in cells]
            tables += tables_of(f"{path.name}, sheet {name}", cells, lines)
    return tables


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
