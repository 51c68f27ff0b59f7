"""What the jobs share: the case of a form, what is wrong with it field by field, and results as plain data and as bytes of files.

Errors carry the place in the case file that they are about.
"""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.messages import problems
from flatpunch._support.paths import Plain, dotted
from flatpunch._support.whole_file import sealed
from flatpunch.app.form import TOP, case_text, is_mark, strength_place
from flatpunch.files import Case
from flatpunch.files.cases import case_from, parsed
from flatpunch.files.results import netcdf

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

CALLED = Path("case.toml")
"""What messages call the case file of the page."""

_FIELD = re.compile(
    r"(?:layers\.\d+|base)\.(?:stress\.)?[a-z_]+|vary\..+|(?:indenter|control|fit|curve|correct|stress|slip)\.[A-Za-z_]+"
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


def plain(values: object) -> object:
    """Return an array as nested lists of floats, None where there is no finite number; floats keep every digit."""
    array = np.asarray(values)
    if array.dtype.kind == "f":
        listed = array.tolist()
        return listed if np.isfinite(array).all() else _without_infinities(listed)
    return array.tolist()


def short(values: Array) -> object:
    """Return an array with five significant digits, for drawings."""
    array = np.asarray(values, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 10.0 ** (4 - np.floor(np.log10(np.abs(array))))
        rounded = np.where(np.isfinite(scale), np.round(array * scale) / scale, array)
    return plain(rounded)


def case_of(fields: Mapping[str, str], tab: str = "press") -> Case:
    """Return the case of a form."""
    return case_from(parsed(case_text(fields, tab), CALLED), CALLED)


def _without_infinities(value: Any) -> Any:
    if isinstance(value, list):
        return [_without_infinities(entry) for entry in value]
    return value if math.isfinite(value) else None


def file_bytes(
    kind: str, dataset: Callable[[], xr.Dataset], table: Callable[[], str], figure: Callable[[], Figure]
) -> bytes:
    """Return the file of a kind, "nc", "csv", "png" or "svg", of which only what it needs is made."""
    if kind == "nc":
        return sealed(netcdf(dataset()))
    if kind == "csv":
        return table().encode("utf-8")
    from flatpunch.plots.result import save_figure

    with tempfile.TemporaryDirectory() as folder:
        return save_figure(figure(), Path(folder) / f"picture.{kind}").read_bytes()
