"""Results as one table of numbers: name, value, interval, unit and note of each; as text, as a table, as CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from typing import NamedTuple

from flatpunch._support.prefixes import text
from flatpunch._support.readable import Table


class Row(NamedTuple):
    """One number of a result, SI.

    Attributes
    ----------
    name : str
        In the words of the field.
    value : float
        nan where the data do not determine it.
    low, high : float
        Interval; nan without one.
    unit : str
    note : str
    """

    name: str
    value: float
    low: float = math.nan
    high: float = math.nan
    unit: str = ""
    note: str = ""


def table_of_rows(title: str, rows: Iterable[Row], level: float = 0.95, notes: Iterable[str] = ()) -> Table:
    """Rows with units for people; intervals are those of a level of confidence."""
    cells = [
        (
            row.name,
            text(row.value, row.unit) if math.isfinite(row.value) else "not determined",
            "" if math.isnan(row.low) else f"{text(row.low, row.unit)} .. {text(row.high, row.unit)}",
            row.note,
        )
        for row in rows
    ]
    titles = ("", "value", f"{100 * level:g} % interval", "note")
    shown = [i for i in range(4) if i < 2 or any(row[i] for row in cells)]
    return Table(
        title, tuple(titles[i] for i in shown), tuple(tuple(row[i] for i in shown) for row in cells), tuple(notes)
    )


def csv_of_rows(rows: Iterable[Row]) -> str:
    """Rows as CSV, in SI units to the last digit."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([Row._fields, *rows])
    return out.getvalue()
