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
from flatpunch.fit.measured.columns import Table, split_name
from flatpunch.fit.measured.curve import FEWEST, CurveError

LARGEST = 500_000_000
"""Largest text file of a curve [bytes]."""

_NUMBER = re.compile(r"\s*(?:[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|nan|NaN|)\s*")
_GROUPED = {
    ".": re.compile(r"[+-]?[0-9]{1,3}(?:,[0-9]{3})+\.[0-9]*"),
    ",": re.compile(r"[+-]?[0-9]{1,3}(?:\.[0-9]{3})+,[0-9]*"),
}
"""Numbers with marks between thousands, by the decimal mark; without decimals they cannot be distinguished from others."""


def text_tables(path: Path, decimal: str = ".") -> list[Table]:
    """Read a text file: runs of rows of numbers, the titles above each, a row of units between them if there is one.

    Words between two runs make them two tables; comments, blank lines and single cells that are no number do not.
    """
    try:
        raw = content(path, LARGEST)
    except Unreadable as error:
        raise CurveError(f"{shown_path(path)}: {error}.") from None
    try:
        # what spreadsheets call Unicode text is UTF-16 with its mark
        text = raw.decode("utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    if "\0" in text[:1000]:
        raise CurveError(f"{path.name}: not a text file.")
    lines = text.splitlines()
    delimiter = _delimiter(lines, decimal)
    grouped = _GROUPED[decimal]
    rows = [_cells(line, delimiter) for line in lines]
    if any(grouped.search(line) for line in lines):
        # 1,234.5 is a number
        rows = [[_ungrouped(cell, grouped) for cell in row] for row in rows]
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
        own = {i: unit.strip("()[] ") for i, unit in enumerate(unit_row or ())}
        found = tuple(own.get(i) or unit for i, (_, unit) in enumerate(pairs))
        filled = [any(cell.strip() for cell in row) for row in rows[run[0] : run[-1] + 1]]
        body = [row for row, has in zip(rows[run[0] : run[-1] + 1], filled, strict=True) if has]
        places = np.cumsum(filled)
        breaks = tuple(np.unique(places[~np.array(filled)]).tolist())
        if decimal == ",":
            body = [[cell.replace(",", ".") for cell in row] for row in body]
        source = path.name if len(long) == 1 else f"{path.name}, block {count + 1}"
        table = Table(source, tuple(n for n, _ in pairs), found, body, run[0] + 1, breaks)
        if tables and names[0].startswith("column "):
            table = replace(table, names=tables[0].names, units=tables[0].units)
        tables.append(table)
    return tables


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


def _titles(above: list[list[str]], width: int) -> tuple[list[str], list[str] | None]:
    """Titles, and the row of units below them if there is one."""
    candidates = [
        [re.sub(r"^[#%]+\s*", "", cell) for cell in row]
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
