"""Text files of measured curves: runs of rows of numbers with their titles and units."""

from __future__ import annotations

import csv
import re
from bisect import bisect
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from flatpunch._support.reading import Unreadable, content, shown_path
from flatpunch.fit.measured.calibration import Constants, constants_in
from flatpunch.fit.measured.columns import Table, names_a_curve, split_name
from flatpunch.fit.measured.curve import FEWEST, CurveError

LARGEST = 500_000_000
"""Largest text file of a curve [bytes]."""

_LABEL = re.compile(r"[#%\s]*(columns|units)\s*:\s*", re.IGNORECASE)
_SEGMENT = re.compile(r"[#%\s]*segment\b", re.IGNORECASE)
_NUMBER = re.compile(r"\s*(?:[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|nan|NaN|)\s*")
_GROUPED = {
    ".": re.compile(r"[+-]?[0-9]{1,3}(?:,[0-9]{3})+\.[0-9]*"),
    ",": re.compile(r"[+-]?[0-9]{1,3}(?:\.[0-9]{3})+,[0-9]*"),
}
"""Numbers with marks between thousands, by the decimal mark; without decimals they cannot be distinguished from others."""


def text_tables(path: Path, decimal: str = ".") -> list[Table]:
    """Read a text file: runs of rows of numbers, the titles above each, a row of units between them if there is one.

    Titles between two runs make them two tables, or one where comments call the runs segments. Words without titles are a break
    in a table; comments, blank lines and single cells that are no number are not.
    """
    lines = _lines(path)
    delimiter = _delimiter(lines, decimal)
    grouped = _GROUPED[decimal]
    rows = [_cells(line, delimiter) for line in lines]
    if any(grouped.search(line) for line in lines):
        # 1,234.5 is a number
        rows = [[_ungrouped(cell, grouped) for cell in row] for row in rows]
    runs, width = _runs(path, rows)
    tables: list[Table] = []
    for run, start in runs:
        names, unit_row = _titles(rows[start : run[0]], width)
        body, breaks = _body(rows[run[0] : run[-1] + 1], decimal)
        if not names and tables:
            last = tables[-1]
            tables[-1] = replace(
                last, rows=[*last.rows, *body], breaks=(*last.breaks, *(len(last.rows) + at for at in (0, *breaks)))
            )
            continue
        pairs = [split_name(title) for title in names or [f"column {i}" for i in range(width)]]
        own = {i: unit.strip("()[] ") for i, unit in enumerate(unit_row or ())}
        found = tuple(own.get(i) or unit for i, (_, unit) in enumerate(pairs))
        above = lines[start : run[0]]
        constants = constants_in(above)
        if constants == Constants() and tables:
            constants = tables[0].constants
        table = Table(path.name, tuple(n for n, _ in pairs), found, body, run[0] + 1, breaks, constants)
        if tables and any(_SEGMENT.match(line) for line in above):
            tables[-1] = _with_segment(tables[-1], table)
        else:
            tables.append(table)
    if len(tables) == 1:
        return tables
    return [replace(table, source=f"{path.name}, block {i + 1}") for i, table in enumerate(tables)]


def _lines(path: Path) -> list[str]:
    """Lines of a file in whatever encoding."""
    try:
        raw = content(path, LARGEST)
    except Unreadable as error:
        raise CurveError(f"{shown_path(path)}: {error}.") from None
    if raw.startswith((b"\\*File", b"\\*Force")):
        raise CurveError(
            f"{path.name}: a binary file of Bruker's NanoScope, which is not read. Export the curve as text with units "
            "(NanoScope Analysis: File, Export, ASCII); that is read as it is."
        )
    try:
        # what spreadsheets call Unicode text is UTF-16 with its mark
        text = raw.decode("utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    if "\0" in text[:1000]:
        raise CurveError(f"{path.name}: not a text file.")
    return text.splitlines()


def _runs(path: Path, rows: list[list[str]]) -> tuple[list[tuple[list[int], int]], int]:
    """Runs of rows of numbers, each with the line at which what belongs to it begins, and their number of columns."""
    numeric = [i for i, row in enumerate(rows) if _is_data(row)]
    if len(numeric) < 2:
        # a column of words, such as names of segments
        numeric = [i for i, row in enumerate(rows) if _is_data([cell for cell in row if _NUMBER.fullmatch(cell)])]
    if len(numeric) < 2:
        raise CurveError(
            f"{path.name}: no rows of numbers found. Text files need a line of titles, then one row a point."
        )
    width = int(np.median([len(rows[i]) for i in numeric]))
    numeric = [i for i in numeric if len(rows[i]) >= width]
    points = set(numeric)
    words = [i for i, row in enumerate(rows) if i not in points and (_only_words(row) or _labelled(row)[0])]
    runs, above = [[numeric[0]]], [0]
    for before, i in pairwise(numeric):
        if words[bisect(words, before) : bisect(words, i)]:
            runs.append([])
            above.append(before + 1)
        runs[-1].append(i)
    return [(run, start) for run, start in zip(runs, above, strict=True) if len(run) >= FEWEST] or [(numeric, 0)], width


def _body(rows: list[list[str]], decimal: str) -> tuple[list[list[str]], tuple[int, ...]]:
    """Rows that are not blank, with decimal points, and those of them before which blank ones are."""
    filled = [any(cell.strip() for cell in row) for row in rows]
    breaks = tuple(np.unique(np.cumsum(filled)[~np.array(filled)]).tolist())
    body = [row for row, has in zip(rows, filled, strict=True) if has]
    if decimal == ",":
        body = [[cell.replace(",", ".") for cell in row] for row in body]
    return body, breaks


def _with_segment(table: Table, more: Table) -> Table:
    """A table with another segment below it, whose columns may be in another order."""
    before = np.zeros(len(table.rows)) if table.segment is None else table.segment
    places = {title: i for i, title in reversed(list(enumerate(zip(more.names, more.units, strict=True))))}
    at = [places.get(title) for title in zip(table.names, table.units, strict=True)]
    rows = [["" if i is None or i >= len(row) else row[i] for i in at] for row in more.rows]
    return replace(
        table, rows=[*table.rows, *rows], segment=np.concatenate([before, np.full(len(rows), before[-1] + 1)])
    )


def _ungrouped(cell: str, grouped: re.Pattern[str]) -> str:
    """A number without the marks between its thousands."""
    if grouped.fullmatch(cell) is None:
        return cell
    mark = cell.lstrip("+-0123456789")[0]
    return cell.replace(mark, "")


def _only_words(row: list[str]) -> bool:
    filled = [cell for cell in row if cell.strip()]
    return (
        bool(filled)
        and not filled[0].startswith(("#", "%"))
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
        # a unit in brackets belongs to the title before it, the mark of a comment to the word after it
        line = re.sub(r"(?<=[^\s)\]])\s+(?=[(\[])|(?<=[#%])\s+", "", line) if re.search(r"[(\[#%]", line) else line
        return line.split()
    if '"' not in line:
        # most of the lines of a large file
        return [cell.strip() for cell in line.split(delimiter)] if line else []
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter), [])]


def _is_data(row: list[str]) -> bool:
    filled = [cell for cell in row if cell]
    return len(filled) >= 2 and all(_NUMBER.fullmatch(cell.replace(",", ".")) for cell in filled)


def _labelled(row: list[str]) -> tuple[str, list[str]]:
    """What a line says that its cells are, "columns" or "units", and these cells: "# columns: height vDeflection"."""
    match = _LABEL.match(row[0].strip()) if row else None
    if match is None:
        return "", row
    rest = [row[0].strip()[match.end() :], *row[1:]]
    return match[1].lower(), [cell for cell in rest[:1] if cell] + rest[1:]


def _titles(above: list[list[str]], width: int) -> tuple[list[str] | None, list[str] | None]:
    """Titles, None if there are none, and the row of units below them if there is one.

    Below the titles may be words: the last row counts that has a column of a force or deflection and one of a position, else
    the last one.
    """
    labelled = {name: cells for name, cells in map(_labelled, above) if name and len(cells) >= width}
    if "columns" in labelled:
        return labelled["columns"], labelled.get("units")
    candidates = [
        [re.sub(r"^[#%]+\s*", "", cell) for cell in row]
        for row in above
        if len(row) >= width and any(cell.strip() for cell in row)
    ]
    if not candidates:
        return None, None
    last = len(candidates) - 1 - (len(candidates) > 1 and _looks_like_units(candidates[-1]))
    chosen = next((i for i in range(last, -1, -1) if names_a_curve(map(split_name, candidates[i]))), last)
    below = next((row for row in candidates[chosen + 1 :] if _looks_like_units(row)), None)
    return candidates[chosen], below


def _looks_like_units(row: list[str]) -> bool:
    """Whether all filled cells are short and could be units."""
    # a dash is the unit of a number
    filled = [bare for cell in row if (bare := cell.strip("()[]- "))]
    return bool(filled) and all(re.fullmatch(r"[A-Za-zµμ%]{1,4}(?:[/^*][A-Za-zµμ0-9]{1,4})?", cell) for cell in filled)
