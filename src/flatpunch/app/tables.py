"""What the page asks for: the fields of the tables of case files, with the kind of each, and a value to begin with.

The tables of `files.tables` are the only place where fields are listed. Those of media and tips are made of their classes, whose
fields are declared with their names in words and the values that the page proposes: a new kind is on the page by itself.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Annotated, Literal, get_args, get_origin

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from flatpunch._support.declared import Number
from flatpunch._support.paths import Plain
from flatpunch.files.tables.fields import Table
from flatpunch.files.tables.indenters import kinds
from flatpunch.files.tables.made import Made
from flatpunch.files.tables.media import BASE_KINDS, LAYER_KINDS
from flatpunch.files.tables.stress import StrengthTable

_LEFT_OUT = {"kind", "file"}
"""The kind is chosen by itself; the page reads no files that a case names."""


@dataclass(frozen=True)
class Asked:
    """One field.

    Parameters
    ----------
    name, label : str
        In case files, and on the page.
    kind : {"quantity", "number", "switch", "choice", "text"}
        How it is entered; all are texts in the form.
    value : str
        Proposed; empty where a case can do without it.
    example : str
        What may be written, from the description of its type.
    choices : tuple of str
        For "choice" and "switch".
    """

    name: str
    label: str
    kind: str
    value: str = ""
    example: str = ""
    choices: tuple[str, ...] = ()


def page_tables() -> Plain:
    """Everything the page needs to know to draw its form, as plain data."""
    return {
        "layers": _kinds(LAYER_KINDS()),
        "base": _kinds(BASE_KINDS()),
        "indenter": _kinds(kinds()),
        "strengths": [
            *(asdict(replace(field, example="2 GPa")) for field in asked(StrengthTable)),
            asdict(Asked("residual_stress", "Residual stress", "quantity", example="-1 GPa")),
        ],
    }


def asked(table: type[Table]) -> list[Asked]:
    """Fields of a table."""
    found = []
    begins = table.proposed() if issubclass(table, Made) else set()
    for name, info in table.model_fields.items():
        if name in _LEFT_OUT:
            continue
        kind, example, choices = _how(info)
        number = next((note for note in info.metadata if isinstance(note, Number)), None)
        needed = info.is_required() or name in begins
        value = number.example if number and needed else ""
        if kind == "switch" and info.default is not PydanticUndefined and info.default is not None:
            value = "true" if info.default else "false"
        label = number.what if number else info.title or name.replace("_", " ")
        label = label[:1].upper() + label[1:]
        found.append(Asked(name, label, kind, value, example, choices))
    return found


def _kinds(tables: Mapping[str, type[Table]]) -> Plain:
    """Fields of each kind; the page reads no files."""
    return {
        kind: {"about": (table.__doc__ or "").strip(), "fields": [asdict(field) for field in asked(table)]}
        for kind, table in tables.items()
        if "file" not in table.model_fields or not table.model_fields["file"].is_required()
    }


def _how(info: FieldInfo) -> tuple[str, str, tuple[str, ...]]:
    """How a field is entered: kind, example, choices."""
    description, annotation = _described(info)
    example = match[1] if (match := re.search(r"such as '([^']*)'", description or "")) else ""
    if "true or false" in (description or ""):
        return "switch", "", ("true", "false")
    if get_origin(info.annotation) is list:
        return "text", example, ()
    choices = _literal(annotation)
    if choices:
        return "choice", "", choices
    if example and " " in example:
        return "quantity", example, ()
    if description and "number" in description:
        return ("number", description.split("such as ")[-1], ())
    return "text", "", ()


def _described(info: FieldInfo) -> tuple[str | None, object]:
    """Description and type of a field; those of optional fields are one level deeper."""
    if info.description:
        return info.description, info.annotation
    for part in get_args(info.annotation):
        if get_origin(part) is Annotated:
            inner, *more = get_args(part)
            for note in more:
                if isinstance(note, FieldInfo) and note.description:
                    return note.description, inner
    return None, info.annotation


def _literal(annotation: object) -> tuple[str, ...]:
    return tuple(map(str, get_args(annotation))) if get_origin(annotation) is Literal else ()
