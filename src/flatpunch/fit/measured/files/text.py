"""Text files of measured curves, in whatever encoding and with whatever mark between columns."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import Path

from flatpunch._support.reading import Unreadable, content, shown_path
from flatpunch.fit.measured.columns import WORDS, Table, names_a_curve
from flatpunch.fit.measured.curve import CurveError
from flatpunch.fit.measured.files.cells import NUMBER, Row, tables_of

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
