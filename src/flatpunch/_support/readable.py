"""How objects show themselves: one line as `repr`, a table with units as `str` and in notebooks, a record in result files.

`readable` gives a dataclass the first three. A class whose table is not simply its fields defines `_table_`, which returns a
`Table`; one whose line is not simply its constructor defines `_line_`; one that has some fields in some cases only names in
`_absent_` those that are not shown.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from html import escape
from typing import Any, NamedTuple, TypeVar

import numpy as np

from flatpunch._support.declared import number_of
from flatpunch._support.prefixes import text

UNITS = {
    **dict.fromkeys(("pressure", "traction"), "Pa"),
    **dict.fromkeys(("radius", "depth", "spacing", "reach", "apex", "center"), "m"),
    "force": "N",
    "time": "s",
}
"""SI units of fields that are not declared, by their names."""

_LISTED = 4
"""Longest sequence that is written in full."""

T = TypeVar("T")


class Table(NamedTuple):
    """A table of texts.

    Attributes
    ----------
    title : str
        One line above it.
    header : tuple of str
        Titles of the columns; empty if there are none.
    rows : tuple of tuple of str
        Cells.
    notes : tuple of str
        Sentences below it.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()


def readable(cls: type[T]) -> type[T]:
    """Give a dataclass a line, a table and an HTML table of itself."""
    for name, method in (("__repr__", line_of), ("__str__", text_of), ("_repr_html_", html_of)):
        setattr(cls, name, method)
    return cls


def line_of(thing: object) -> str:
    """An object in one line, numbers with six digits, long sequences shortened."""
    own = getattr(thing, "_line_", None)
    if own is not None:
        return str(own())
    shown = ", ".join(f"{field.name}={_short(getattr(thing, field.name))}" for field in _fields(thing))
    return f"{type(thing).__name__}({shown})"


def source_of(thing: object) -> str:
    """The call that makes an object again, every number to its last digit."""
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        made = ", ".join(
            f"{field.name}={source_of(getattr(thing, field.name))}" for field in _fields(thing) if field.init
        )
        return f"{type(thing).__name__}({made})"
    if isinstance(thing, tuple):
        return f"({', '.join(map(source_of, thing))}{',' if len(thing) == 1 else ''})"
    return repr(thing)


def table_of(thing: object) -> Table:
    """The table of an object: its own, or its fields with their units."""
    own = getattr(thing, "_table_", None)
    if own is not None:
        found: Table = own()
        return found
    title = type(thing).__name__
    rows = tuple((f.name, quantity_of(getattr(thing, f.name), unit_of(thing, f.name))) for f in _fields(thing))
    return Table(title, (), rows)


def text_of(thing: object) -> str:
    """The table as text, columns below each other."""
    table = table_of(thing)
    rows = [table.header, *table.rows] if table.header else list(table.rows)
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))] if rows else []
    lines = [
        "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
    return "\n".join([table.title, *lines, *(f"  Note: {note}" for note in table.notes)])


def html_of(thing: object) -> str:
    """The table as HTML."""
    table = table_of(thing)
    head = f"<tr>{''.join(f'<th>{escape(cell)}</th>' for cell in table.header)}</tr>" if table.header else ""
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in table.rows)
    notes = "".join(f"<p>Note: {escape(note)}</p>" for note in table.notes)
    return f"<div><b>{escape(table.title)}</b><table>{head}{body}</table>{notes}</div>"


def unit_of(thing: object, name: str) -> str:
    """SI unit of a field of an object, empty without one."""
    owner: Any = type(thing)
    declared = number_of(owner, name)
    return UNITS.get(name, "") if declared is None else declared.unit or ""


def quantity_of(value: object, unit: str) -> str:
    """The value of a field in words."""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (float, np.floating)):
        if unit == "rad":
            return f"{math.degrees(value):.4g} deg"
        # 1/m takes no prefix: that of its denominator would be another one
        return f"{value:.6g} {unit}".rstrip() if unit in ("", "1/m") or not value else text(float(value), unit)
    if isinstance(value, (tuple, np.ndarray)) and len(value) <= _LISTED:
        return ", ".join(quantity_of(entry, unit) for entry in value) or "none"
    return _short(value)


def _fields(thing: object) -> list[dataclasses.Field[object]]:
    assert dataclasses.is_dataclass(thing)
    absent = getattr(thing, "_absent_", ())
    return [field for field in dataclasses.fields(thing) if field.repr and field.name not in absent]


def _short(value: object) -> str:
    if isinstance(value, (float, np.floating)):
        return f"{value:.6g}"
    if isinstance(value, np.ndarray) and (value.ndim != 1 or value.dtype.kind not in "fiu"):
        return f"<array of shape {value.shape}>"
    if isinstance(value, (tuple, list, np.ndarray)):
        entries = [_short(entry) for entry in (value if len(value) <= _LISTED else (*value[:2], *value[-1:]))]
        if len(value) > _LISTED:
            entries.insert(2, "...")
        inside = ", ".join(entries)
        if isinstance(value, tuple):
            return f"({inside}{',' if len(value) == 1 else ''})"
        return f"[{inside}]"
    if isinstance(value, Mapping):
        listed = ", ".join(f"{key!r}: {_short(entry)}" for key, entry in value.items())
        return f"{{{listed}}}" if len(value) <= _LISTED else f"<mapping of {len(value)} entries>"
    if callable(value) and not dataclasses.is_dataclass(value):
        return f"<function {getattr(value, '__qualname__', type(value).__name__)}>"
    return " ".join(repr(value).split())


def record(thing: object) -> Any:
    """Return dataclasses as {"type": name, field: ...}, arrays and tuples as lists, numbers as they are.

    Functions, and objects of classes that are no dataclasses, are recorded by their name: they cannot be read back.
    """
    if hasattr(thing, "recorded") and not isinstance(thing, type):
        # it stands for another, which says more to a reader
        return record(thing.recorded)
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        fields = {f.name: record(getattr(thing, f.name)) for f in dataclasses.fields(thing) if f.init or f.repr}
        return {"type": type(thing).__name__, **fields}
    if isinstance(thing, np.ndarray):
        return thing.tolist()
    if isinstance(thing, dict):
        return {name: record(value) for name, value in thing.items()}
    if isinstance(thing, (list, tuple)):
        return [record(entry) for entry in thing]
    if isinstance(thing, np.generic):
        return thing.item()
    if callable(thing):
        return f"function {getattr(thing, '__qualname__', type(thing).__name__)}"
    if thing is None or isinstance(thing, (bool, int, float, str)):
        return thing
    # a shape or medium of the user's own: by its name, like a function
    return {"type": type(thing).__name__}
