"""What files of numbers hold: texts in any encoding, sheets of Excel files, members of archives, and tables among their cells."""

from __future__ import annotations

import csv
import io
import re
import tempfile
import zipfile
from bisect import bisect
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from flatpunch._support.checks import shown
from flatpunch._support.reading import DAMAGED, Unreadable, check_archive, content, shown_path
from flatpunch.fits.measured.calibration import constants_in, place_in
from flatpunch.fits.measured.columns import (
    WAYS,
    WORDS,
    Constants,
    Table,
    listed,
    names_a_curve,
    split_name,
    way_of,
    words,
)
from flatpunch.fits.measured.curve import FEWEST, CurveError

Row = list[object]

WIDEST = 5000
"""Most columns of a table; as many tests side by side are compared with each other."""
NUMBER = re.compile(r"[+-]?[\d.,]*\d[.,]?(?:[eE][+-]?\d+)?|nan|NaN")
"""A number with any decimal mark."""
_PLAIN = re.compile(r"(?=.*\d)[-+.,;\s\deE]+")
"""A line with nothing but numbers."""
_LABEL = re.compile(r"[#%\s]*([^:=\t]*?)\s*[:=\t]\s*(.*?)\s*$")
_UNIT = re.compile(r"[A-Za-zµμ%°]{1,4}(?:[/^*][A-Za-zµμ0-9]{1,4})?|[^\x00-\x7f]{1,2}[A-Za-z]?")


def tables_of(source: str, rows: list[Row], lines: Sequence[str]) -> list[Table]:
    """Tables among rows of cells: numbers, text, None.

    Rows that follow words and titles are another table, or the next segment of the one before where these say so. Comments, blank
    rows and single cells are no end of a table; words without titles are a break in it.
    """
    if (most := max(map(len, rows), default=0)) > WIDEST:
        raise CurveError(f"{source}: {most} columns; at most {WIDEST} are read.")
    tables: list[Table] = []
    for run, start in _runs(rows, lines):
        last = tables[-1] if tables else None
        above = [i for i in range(start, run[0]) if any(map(_filled, rows[i]))]
        (number, way), head = _segment([lines[i] for i in above]), [lines[i] for i in above]
        titles, given = _titles([rows[i] for i in above], head, int(np.median([len(rows[i]) for i in run])))
        # a last row that was cut off, or has words in the place of numbers, is none of the readings
        body = [rows[i] for i in (run[:-1] if _is_less(rows[run[-1]], rows[run[-2]]) else run)]
        blank = (bisect(run, i) for i in range(run[0], run[-1]) if not any(map(_filled, rows[i])))
        breaks = tuple(sorted({*blank} - {0, len(body)}))
        if titles or last is None:
            titles = titles or [f"column {i}" for i in range(max(map(len, body)))]
            pairs = [split_name(str(title or "")) for title in titles]
            own = [str(unit or "").strip("()[] ") for unit in given] + [""] * len(pairs)
            units = tuple(mine or unit for mine, (_, unit) in zip(own, pairs, strict=False))
            names = tuple(name for name, _ in pairs)
        else:
            names, units = last.names, last.units
        constants = constants_in(head)
        if constants == Constants() and tables:
            constants = tables[0].constants
        cells = np.array([(row + [""] * len(names))[: len(names)] for row in body], dtype=object)
        table = Table(source, names, units, cells, run[0] + 1, breaks, constants, ways=(way,), numbers=(number,))
        if place := place_in(head):
            table = replace(table, meta={"metadata": place})
        if last is not None and not titles and not way and number is None:
            at = len(last.rows)
            breaks = (*last.breaks, at, *(at + i for i in breaks))
            tables[-1] = replace(last, rows=np.concatenate([last.rows, cells]), breaks=breaks)
        elif last is not None and _goes_on(last, number, way):
            tables[-1] = _joined(last, table)
        else:
            tables.append(table)
    names = (source,) if len(tables) == 1 else tuple(f"{source}, block {i + 1}" for i in range(len(tables)))
    return [_in_order(replace(table, source=name)) for table, name in zip(tables, names, strict=True)]


def _in_order(table: Table) -> Table:
    """A table whose segments count up as the file numbers them."""
    if table.segment is None:
        return replace(table, ways=())
    order = np.arange(len(table.ways)) if None in table.numbers else np.argsort(np.array(table.numbers, dtype=float))
    rank = np.argsort(order).astype(float)
    return replace(table, segment=rank[table.segment.astype(int)], ways=tuple(table.ways[i] for i in order))


def _is_less(row: Row, before: Row) -> bool:
    words = (
        cell
        for cell, its in zip(row, before, strict=False)
        if _filled(cell) and not _is_number(cell) and _is_number(its)
    )
    return len(row) < len(before) or any(True for _ in words)


def _filled(cell: object) -> bool:
    return cell is not None and cell != ""


def _is_number(cell: object) -> bool:
    return isinstance(cell, (int, float)) or (isinstance(cell, str) and NUMBER.fullmatch(cell) is not None)


def _runs(rows: list[Row], lines: Sequence[str]) -> list[tuple[list[int], int]]:
    """Runs of rows of numbers, each with the row at which what belongs to it begins."""
    filled = [len(row) - row.count("") - row.count(None) for row in rows]
    numbers = [
        n if _PLAIN.fullmatch(line) else sum(map(_is_number, row))
        for n, line, row in zip(filled, lines, rows, strict=True)
    ]
    counts = list(zip(numbers, filled, strict=True))
    # a column of words, such as names of segments, is the lesser part of a row, or there is nothing else
    found = [i for i, (n, all_) in enumerate(counts) if n >= 2 and 2 * n > all_]
    found = found if len(found) > 1 else [i for i, (n, _) in enumerate(counts) if n >= 2]
    if len(found) < 2:
        return []
    points = set(found)
    divide = [i for i, row in enumerate(rows) if i not in points and (_words_only(row) or _labels(lines[i]))]
    runs: list[list[int]] = [[found[0]]]
    for before, i in pairwise(found):
        if bisect(divide, i) > bisect(divide, before):
            runs.append([])
        runs[-1].append(i)
    long = [run for run in runs if len(run) >= FEWEST] or [found]
    return list(zip(long, [0, *(run[-1] + 1 for run in long)], strict=False))


def _words_only(row: Row) -> bool:
    filled = [cell for cell in row if _filled(cell)]
    comment = bool(filled) and str(filled[0]).startswith(("#", "%"))
    return bool(filled) and not comment and not any(re.match(r"[+-]?\d", str(cell)) for cell in filled)


def _label(line: str) -> tuple[str, str]:
    """What a line names, and its value: "# units: m N" names units."""
    match = _LABEL.match(line)
    return (match[1], match[2]) if match and match[2] else ("", line.strip("#%-=[]*: \t"))


def _labels(line: str) -> bool:
    """Whether a comment is one of titles or of a segment."""
    name, value = _label(line)
    return listed(name, (f"= {WORDS['lines']['titles']}",)) or (_segment([line]) != (None, "") and bool(name or value))


def _segment(lines: Sequence[str]) -> tuple[int | None, str]:
    """Number and way of the segment that lines above it name: "# segmentIndex: 1", "# direction: retrace", "Unloading"."""
    number, way, about = None, "", WORDS["segments"]
    for line in lines:
        name, value = _label(line)
        digits, found = re.search(r"\d+", f"{name} {value}"), set(words(re.sub(r"\d", "", value)))
        if listed(re.sub(r"\d", "", name), about["titles"]):
            number = int(digits[0]) if digits and not way_of(value) else number
            # what a segment is called without a known word does not begin a cycle
            way = way_of(value) or way or ("" if digits else "hold")
        elif listed(name, about["worded"]) or (not name and found and found <= WAYS | set(about["fillers"])):
            number, way = int(digits[0]) if digits and not name else number, way_of(value) or way
    return number, way


def _goes_on(last: Table, number: int | None, way: str) -> bool:
    """Whether a block is another segment of the cycle before it."""
    if number is not None and None not in last.numbers:
        return number not in last.numbers
    if way == "forth":
        return last.ways == ("back",) or (last.ways[-1] == "hold" and "back" not in last.ways)
    return way == "hold" or (way == "back" and "back" not in last.ways)


def _joined(table: Table, more: Table) -> Table:
    """A table with another segment below it, whose columns may be in another order."""
    titles = list(zip(more.names, more.units, strict=True))
    at = [titles.index(title) if title in titles else -1 for title in zip(table.names, table.units, strict=True)]
    rows = np.concatenate([more.rows, np.full((len(more.rows), 1), "", dtype=object)], axis=1)[:, at]
    before = np.zeros(len(table.rows)) if table.segment is None else table.segment
    return replace(
        table,
        rows=np.concatenate([table.rows, rows]),
        segment=np.concatenate([before, np.full(len(rows), before[-1] + 1)]),
        ways=(*table.ways, *more.ways),
        numbers=(*table.numbers, *more.numbers),
    )


def _titles(above: list[Row], lines: Sequence[str], width: int) -> tuple[Row, Row]:
    """Titles and the row of units below them, each empty if there is none.

    The last row counts that has a column of a force or deflection and one of a position, else the last one. A row above titles
    that are repeated has the words for the sides, approach and retract, of the columns below.
    """
    labelled = {name: cells for name, cells in map(_labelled, above) if name and len(cells) >= width}
    if "titles" in labelled:
        return labelled["titles"], labelled.get("units", [])
    above = [row if len(row) == width else _divided(line, width) or row for row, line in zip(above, lines, strict=True)]
    rows = [[re.sub(r"^[#%]+\s*", "", c) if isinstance(c, str) else c for c in row] for row in above]
    rows = [row if len(row) >= width else ["", *row] for row in rows if len(row) >= max(width - 1, 2)]
    rows = [row for row in rows if not all(map(_is_number, row))]
    if not rows:
        return [], []
    named = [i for i, row in enumerate(rows) if _name_a_curve(row)]
    at = named[-1] if named else len(rows) - 1 - (len(rows) > 1 and _are_units(rows[-1]))
    titles, sides = rows[at], [str(cell or "") for cell in rows[at - 1]] if at else []
    if sum(map(bool, map(way_of, sides))) > 1 and len({*map(str, titles)}) < len(titles):
        beside = [max((i for i in range(min(at + 1, len(sides))) if sides[i]), default=0) for at in range(len(titles))]
        titles = [f"{sides[i]} {title}" if _filled(title) else title for i, title in zip(beside, titles, strict=True)]
    return titles, next((row for row in rows[at + 1 :] if _are_units(row)), [])


def _divided(line: str, width: int) -> Row | None:
    """Titles that are divided in another way than the numbers below them."""
    ways = (
        [cell.strip() for cell in re.split(mark, line.strip())]
        for mark in (r"\t", ";", ",", r"\s{2,}", r"\s+(?![(\[])")
    )
    return next((list(row) for row in ways if len(row) == width and _name_a_curve(list(row))), None)


def _name_a_curve(row: Row) -> bool:
    return bool(row) and names_a_curve(split_name(str(cell or "")) for cell in row)


def _labelled(row: Row) -> tuple[str, Row]:
    """What a row says that its cells are, "titles" or "units", and these cells: "# columns: height vDeflection"."""
    name, colon, rest = str(row[0]).partition(":")
    kind = next((kind for kind, word in WORDS["lines"].items() if name.strip("#% ").lower() == word), "")
    cells: Row = [cell for cell in [rest.strip()] if cell]
    return (kind if colon else ""), [*cells, *row[1:]]


def _are_units(row: Row) -> bool:
    """Whether all filled cells are short and could be units; a dash is the unit of a number."""
    filled = [bare for cell in row if (bare := str(cell or "").strip("()[]- "))]
    return bool(filled) and all(_UNIT.fullmatch(cell) for cell in filled)


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
    except DAMAGED:
        raise CurveError(
            f"{path.name}: its files cannot be unpacked. It is damaged, or has a password; give it as it was made, or unpack it."
        ) from None


def by_number(name: str) -> list[tuple[int, str]]:
    """Key that sorts names as people count: curve2 before curve10."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", name)]
