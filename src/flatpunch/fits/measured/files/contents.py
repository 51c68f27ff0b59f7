"""What files of numbers hold: texts in any encoding, sheets of Excel files by xlrd and openpyxl, the members of archives."""

from __future__ import annotations

import csv
import io
import re
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path

from flatpunch._support.checks import shown
from flatpunch._support.reading import Unreadable, check_archive, content, shown_path
from flatpunch.fits.measured.columns import WORDS, Table, names_a_curve
from flatpunch.fits.measured.curve import CurveError
from flatpunch.fits.measured.files.cells import NUMBER, WIDEST, Row, tables_of

LARGEST = 200_000_000
"""Largest text file of a curve [bytes]."""

_GROUPS = {
    ".": re.compile(r"(?<=\d),(?=\d{3}(?:,\d{3})*\.\d*$)"),
    ",": re.compile(r"(?<=\d)\.(?=\d{3}(?:\.\d{3})*,\d*$)"),
}
"""Marks between thousands, by the decimal mark; in numbers without decimals they cannot be distinguished from others."""


def text_tables(path: Path, decimal: str = ".") -> list[Table]:
    """Tables of a text file."""
    tables: list[Table] = []
    for lines in _lines(path):
        mark = _mark(lines, decimal)
        # decimal commas are marks as well
        if mark != " " and (most := max(line.count(mark) for line in lines)) > 2 * WIDEST:
            raise CurveError(f"{path.name}: {most + 1} columns; at most {WIDEST} are read.")
        found = tables_of(path.name, [_cells(line, mark, decimal) for line in lines], lines)
        named = any(names_a_curve(zip(table.names, table.units, strict=True)) for table in found)
        tables = found if named or not tables else tables
        if named:
            break
    if not tables:
        raise CurveError(
            f"{path.name}: no rows of numbers found. Text files need a line of titles, then one row a point."
        )
    return tables


def _lines(path: Path) -> Iterator[list[str]]:
    """Lines of a file, in each encoding in which it may be."""
    try:
        raw = content(path, LARGEST)
    except Unreadable as error:
        raise CurveError(f"{shown_path(path)}: {error}.") from None
    if raw.startswith((b"\\*File", b"\\*Force")) and b"\x1a" in raw:
        raise CurveError(
            f"{path.name}: a binary file of Bruker's NanoScope, which is not read. Export the curve as text with units "
            "(NanoScope Analysis: File, Export, ASCII); that is read as it is."
        )
    # what spreadsheets call Unicode text is UTF-16 with its mark
    marked = raw[:2] in (b"\xff\xfe", b"\xfe\xff")
    for encoding in ["utf-16"] if marked else WORDS["lines"]["encodings"]:
        try:
            text = raw.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" in text[:1000]:
            raise CurveError(f"{path.name}: not a text file.")
        yield text.splitlines()
        if encoding.startswith("utf"):
            return


def _mark(lines: list[str], decimal: str) -> str:
    """Mark between columns: tab, semicolon or comma if rows have them, else white space."""
    body = [line for line in lines if re.search(r"\d", line)]
    sample = body[len(body) // 2 :][:50] or lines[:50]
    known = ("\t", ";", *([","] if decimal == "." else []))
    return next((mark for mark in known if sum(mark in line for line in sample) > 0.8 * len(sample)), " ")


def _cells(line: str, mark: str, decimal: str) -> Row:
    if mark == " ":
        # a unit in brackets belongs to the title before it, the mark of a comment to the word after it
        line = re.sub(r"(?<=[^\s)\]])\s+(?=[(\[])|(?<=[#%])\s+", "", line) if re.search(r"[(\[#%]", line) else line
        cells = line.split()
    else:
        divided = next(csv.reader([line], delimiter=mark), []) if '"' in line else line.split(mark) if line else []
        cells = [cell.strip() for cell in divided]
    if decimal == "," or (mark != "," and "," in line):
        cells = [_GROUPS[decimal].sub("", cell) for cell in cells]
    if decimal == ",":
        return [cell.replace(",", ".") if NUMBER.fullmatch(cell) else cell for cell in cells]
    return list(cells)


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


def unpacked(path: Path) -> Iterator[Path]:
    """The files of an archive one after the other, in the order of their names.

    Raises
    ------
    CurveError
        If the archive is damaged or has a password.
    """
    try:
        with zipfile.ZipFile(path) as archive, tempfile.TemporaryDirectory() as folder:
            for name in sorted((name for name in archive.namelist() if not name.endswith("/")), key=by_number):
                # members of the same name in two folders are read before the next one takes their place
                inner = Path(folder) / Path(name).name
                inner.write_bytes(archive.read(name))
                yield inner
    # what `zipfile` and `zlib` raise on a damaged directory or member: an encrypted member is a RuntimeError, a name that is no
    # text a ValueError
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError, ValueError):
        raise CurveError(
            f"{path.name}: its files cannot be unpacked. It is damaged, or has a password; give it as it was made, or unpack it."
        ) from None


def by_number(name: str) -> list[tuple[int, str]]:
    """Key that sorts names as people count: curve2 before curve10."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", name)]
