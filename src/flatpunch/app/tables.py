"""What the page asks for: the fields of the tables of case files, with the kind of each, and a value to begin with.

The tables of `files.tables` are the only place where fields are listed. A new indenter or base is on the page when it has a table
there; only the value that the page proposes may need a line in `_PROPOSED`.
"""

from __future__ import annotations

import re
import types
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from flatpunch._support.paths import Plain
from flatpunch.files.tables.fields import Table
from flatpunch.files.tables.indenters import IndenterTable
from flatpunch.files.tables.media import BaseTable, LayerTable
from flatpunch.files.tables.stress import StrengthTable

_PROPOSED = {
    "young": "5 kPa",
    "poisson": "0.5",
    "thickness": "1.2 um",
    "radius": "5 um",
    "sides": "4",
    "half_opening_angle": "35 deg",
    "radius_x": "20 um",
    "radius_y": "12 um",
    "front": "15 deg",
    "back": "25 deg",
    "side": "20 deg",
    "half_x": "10 um",
    "half_y": "6 um",
    "half_z": "5 um",
    "height_at_axes": "1 um",
    "length": "20 um",
    "half_width": "5 um",
    "corner_radius": "1 um",
    "coefficients": "[24.5, 3.0]",
    "unit": "1 um",
    "limit": "5 um",
    "exponent": "2",
    "height": "1 um",
    "modulus": "5 kPa",
    "depth": "1 um",
    "r": '["0 um", "1 um", "2 um", "3 um"]',
    "f": '["0 nm", "100 nm", "400 nm", "900 nm"]',
}
"""Values that the page proposes for fields that a case needs; all tips with them are solved by a test."""

_PROPOSED_OF = {
    "base.half-space.young": "70 GPa",
    "base.half-space.poisson": "0.22",
    "base.power-law-half-space.exponent": "0.3",
}

_LEFT_OUT = {"kind", "file"}
"""The kind is chosen by itself; the page reads no files that a case names."""

_LABELS = {
    "young": "Young's modulus",
    "poisson": "Poisson ratio",
    "bonded": "Lower face",
    "A": "Curvature A",
    "B": "Curvature B",
    "tensile": "Tensile strength",
    "shear": "Shear modulus along z",
    "strengths.shear": "Shear strength",
    "young_axial": "Young's modulus along z",
    "poisson_axial": "Poisson ratio along z",
    "layers.interface_normal": "Interface stiffness, normal",
    "layers.interface_shear": "Interface stiffness, shear",
    "interface_tension": "Interface, tension",
    "interface_shear": "Interface, shear",
    "r": "Radii r",
    "f": "Heights f",
}


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
        "layers": [asdict(field) for field in asked(LayerTable, "layers")],
        "base": _kinds(BaseTable, "base"),
        "indenter": _kinds(IndenterTable, "indenter"),
        "strengths": [
            *(asdict(replace(field, example="2 GPa")) for field in asked(StrengthTable, "strengths")),
            asdict(Asked("residual_stress", "Residual stress", "quantity", example="-1 GPa")),
        ],
    }


def kinds_of(union: object) -> dict[str, type[Table]]:
    """Tables of a union by the `kind` that chooses them; those that cannot be had without a file are left out."""
    found = {}
    for table in _members(union):
        (kind,) = get_args(table.model_fields["kind"].annotation)
        if "file" not in table.model_fields or not table.model_fields["file"].is_required():
            found[kind] = table
    return found


def asked(table: type[Table], prefix: str) -> list[Asked]:
    """Fields of a table; `prefix` names the section, and its kind if it has kinds."""
    found = []
    for name, info in table.model_fields.items():
        if name in _LEFT_OUT:
            continue
        kind, example, choices = _how(info)
        needed = info.is_required() or name in _either_or(table)
        value = _PROPOSED_OF.get(f"{prefix}.{name}", _PROPOSED.get(name, "")) if needed else ""
        if kind == "switch" and info.default is not PydanticUndefined and info.default is not None:
            value = "true" if info.default else "false"
        label = _LABELS.get(f"{prefix}.{name}") or _LABELS.get(name) or name.replace("_", " ").capitalize()
        found.append(Asked(name, label, kind, value, example, choices))
    return found


def _kinds(union: object, section: str) -> Plain:
    return {
        kind: {
            "about": (table.__doc__ or "").strip(),
            "fields": [asdict(field) for field in asked(table, f"{section}.{kind}")],
        }
        for kind, table in kinds_of(union).items()
    }


def _either_or(table: type[Table]) -> set[str]:
    """Fields of which one of several must be given; the page begins with these."""
    return {"half_opening_angle", "radius_x", "radius_y", "r", "f"} & set(table.model_fields)


def _members(union: Any) -> Iterator[type[Table]]:
    """Tables of a union, through annotations and unions inside it."""
    if get_origin(union) is Annotated:
        yield from _members(get_args(union)[0])
    elif get_origin(union) in (Union, types.UnionType):
        for member in get_args(union):
            yield from _members(member)
    else:
        yield union


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
