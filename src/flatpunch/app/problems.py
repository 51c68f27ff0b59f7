"""What is wrong with a form, field by field: errors carry the place in the case file that they are about."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from flatpunch._support.messages import problems
from flatpunch._support.paths import Plain, dotted
from flatpunch.app.form import TOP, is_mark
from flatpunch.app.strengths import strength_place

CALLED = Path("case.toml")
"""What messages call the case file of the page."""

_FIELD = re.compile(
    r"(?:layers\.\d+|base)\.(?:stress\.)?[a-z_]+|vary\..+|(?:indenter|control|fit|curve|correct|stress)\.[A-Za-z_]+"
)
"""Names of fields of the page; those that are empty are not in the form."""


def field_of(place: str, fields: Mapping[str, str]) -> str:
    """Return the field of the form that a place in a case file is about: "layers.0.young" for "layers[0].young"; "" for none."""
    # no field has a longer name, and each of its parts is looked for
    name = strength_place(dotted(place), fields)[:200]
    if name.removeprefix("control.").partition(".")[0] == fields.get("control.quantity", "depth"):
        part = f"control.{name.rpartition('.')[2]}"
        name = part if part in fields else "control.values" if "control.values" in fields else "control.start"
    while name:
        if name in fields or name in TOP or _FIELD.fullmatch(name):
            return name.rpartition(".")[0] if is_mark(name, fields) else name
        below = [field for field in fields if field.startswith(f"{name}.")]
        if below:
            return below[0]
        name = name.rpartition(".")[0]
    return ""


def explained(error: Exception, fields: Mapping[str, str], sections: Mapping[str, str] | None = None) -> Plain:
    """Return what is wrong with a form, field by field; the field is empty for sentences about none.

    `sections` are the tables of the case file that hold the arguments of the called function.
    """
    found, sections = [], {"finite_strain": "material", **(sections or {})}
    for place, text in problems(error):
        section = sections.get(place.partition("[")[0], "")
        place, text = (f"{section}.{place}", f"{section}.{text}") if section else (place, text)
        found.append({"field": field_of(place, fields), "text": text.removeprefix(f"{CALLED}: ")})
    return {"problems": found}
