"""What is wrong with a form, field by field: messages of the package begin with the place in the case file they are about."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from flatpunch.app.form import TOP, is_mark
from flatpunch.app.strengths import strength_place

_FIELD = re.compile(
    r"(?:layers\.\d+|base)\.(?:stress\.)?[a-z_]+|vary\..+|(?:indenter|control|fit|curve|correct|stress)\.[A-Za-z_]+"
)
"""Names of fields of the page; those that are empty are not in the form."""


_PLACE = re.compile(r"(?:--)?([A-Za-z_]\w*(?:\[\d+\])?(?:\.\w+(?:\[\d+\])?)*)(?= = | is | has |: | must | \")")
"""The place in a case file that a message begins with."""


def field_of(place: str, fields: Mapping[str, str]) -> str:
    """Return the field of the form that a place in a case file is about: "layers.0.young" for "layers[0].young"; "" for none.

    Parameters
    ----------
    place : str
        As messages begin.
    fields : mapping
        The form.
    """
    name = strength_place(re.sub(r"\[(\d+)\]", r".\1", place), fields)
    if re.match(rf"(control\.)?{fields.get('control.quantity', 'depth')}(\.|$)", name):
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


def problems(error: Exception, fields: Mapping[str, str], message: str) -> Iterator[tuple[str, str]]:
    """Yield (field, message) for each line of a message; the field is empty where a line is about none.

    Parameters
    ----------
    error : Exception
        What was raised, for its kind.
    fields : mapping
        The form.
    message : str
        Its text.
    """
    for line in message.splitlines():
        text = re.sub(r"^case\.toml: ", "", line)
        place = _PLACE.match(text.removeprefix("control: "))
        yield (field_of(place[1], fields) if place else ""), text
