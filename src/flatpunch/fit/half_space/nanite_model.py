"""A model file for nanite and PyJibe: the exact thin-layer contact in programs that fit force curves already.

nanite loads single files that say which parameters a model has and how the force follows from the tip position. The file written
here carries one case; it needs flatpunch and lmfit where it runs, and neither it nor this package needs nanite.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flatpunch._support.readable import source_of
from flatpunch.files.results import whole_file
from flatpunch.fit.elastic.model import method_for
from flatpunch.fit.parameters.scaling import parameter_names, scaling, value_of
from flatpunch.fit.parameters.settings import FitMethod
from flatpunch.media import HalfSpace, Medium, RigidBase

_MOST_COORDINATES = 2
"""Free parameters that change the shape of the force curve; with three, the table in the file would have millions of numbers."""
_TEMPLATE = '''"""{title}

Exact contact of a tip with a layered sample, by flatpunch (method {method}). Layers, base and tip other than the parameters are
as written below; write the file anew for another sample.
"""

import lmfit
import numpy as np

from flatpunch.fit import ForwardModel
from flatpunch.indenters import {tips}
from flatpunch.media import {media}

_MODEL = ForwardModel(
    {medium},
    {indenter},
    {free},
    {method!r},
)


def get_parameter_defaults():
    """Parameters in the order of `parameter_keys`."""
    params = lmfit.Parameters()
{defaults}
    params.add("contact_point", value=0)
    params.add("baseline", value=0)
    return params


def flatpunch_layers(delta, {arguments}, contact_point=0, baseline=0):
    """{title}

    Exact contact mechanics of the layered sample; delta is the tip position [m], falling into the sample.
    """
    values = {{{values}}}
    return _MODEL.force(contact_point - np.asarray(delta, dtype=float), values) + baseline


model_doc = flatpunch_layers.__doc__
model_func = flatpunch_layers
model_key = {key!r}
model_name = {title!r}
parameter_keys = {keys!r}
parameter_names = {names!r}
parameter_units = {units!r}
valid_axes_x = ["tip position"]
valid_axes_y = ["force"]
'''


@dataclass(frozen=True)
class _Entry:
    """One parameter of the file: its key there, its name here, how it is shown, and how it becomes ours."""

    key: str
    name: str
    label: str
    unit: str
    value: float
    fitted: bool
    most: float | None = None
    convert: str = "{}"


def write_nanite_model(
    path: str | Path,
    medium: Any,
    indenter: Any,
    *,
    title: str = "",
    key: str | None = None,
    method: FitMethod = "auto",
) -> Path:
    """Write a model file for nanite.

    Parameters
    ----------
    path : path
        Target, a Python module such as "model_thin_gel.py".
    medium : Medium of homogeneous layers, or HalfSpace
        The sample; the modulus of its top layer is what nanite fits.
    indenter : Sphere, Paraboloid, Cylinder, Cone or Pyramid
        The tip; its radius or half opening angle becomes a parameter that is held, like the thickness. With several layers
        only those become parameters whose tables are quick to make.
    title : str
        Name shown in the programs.
    key : str, optional
        Identifier; from the file's name if left out.
    method : str or method
        Contact method, or "auto"; the model file keeps its short name.

    Returns
    -------
    Path
    """
    path = Path(path)
    if path.suffix != ".py" or not path.stem.isidentifier():
        raise ValueError(f"{path}: a model file is a Python module; name it like model_thin_gel.py.")
    entries = _affordable(medium, indenter, _entries(medium, indenter))
    title = (title or "Layered sample (flatpunch)").replace('"', "'").replace("\\", "/")
    chosen = method_for(indenter, method)
    tips, media = sorted(_types(repr(indenter))), sorted(_types(repr(medium)))
    text = _TEMPLATE.format(
        title=title,
        method=chosen if isinstance(chosen, str) else chosen.name,
        tips=", ".join(tips),
        media=", ".join(media),
        medium=source_of(medium),
        indenter=source_of(indenter),
        free=repr(tuple(entry.name for entry in entries)),
        defaults="\n".join(_default(entry) for entry in entries),
        arguments=", ".join(entry.key for entry in entries),
        values=", ".join(f"{entry.name!r}: {entry.convert.format(entry.key)}" for entry in entries),
        key=key or f"flatpunch_{path.stem}",
        keys=[*(entry.key for entry in entries), "contact_point", "baseline"],
        names=[*(entry.label for entry in entries), "Contact Point", "Force Baseline"],
        units=[*(entry.unit for entry in entries), "m", "N"],
    )
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def _entries(medium: Any, indenter: Any) -> list[_Entry]:
    plain = isinstance(medium, HalfSpace) or (
        isinstance(medium, Medium) and isinstance(medium.base, (HalfSpace, RigidBase))
    )
    names = parameter_names(medium, indenter)
    top = next((name for name in names if name.endswith("young")), None)
    if not plain or top is None or "Graded" in repr(medium):
        raise ValueError("a model file needs homogeneous layers on a rigid base or a half-space.")
    entries = [_Entry("E", top, "Young's Modulus", "Pa", value_of(medium, indenter, top), True)]
    if "layers[0].thickness" in names:
        value = value_of(medium, indenter, "layers[0].thickness")
        entries.append(_Entry("h", "layers[0].thickness", "Layer Thickness", "m", value, False))
    if "indenter.radius" in names:
        entries.append(_Entry("R", "indenter.radius", "Tip Radius", "m", indenter.radius, False))
    elif "indenter.inclination" in names:
        half = 90 - math.degrees(indenter.inclination)
        convert = "np.pi / 2 - np.radians({})"
        entries.append(_Entry("alpha", "indenter.inclination", "Half Opening Angle", "°", half, False, 90, convert))
    else:
        raise ValueError(
            f"indenter = {type(indenter).__name__}: there are model files for tips with a radius or an angle."
        )
    return entries


def _affordable(medium: Any, indenter: Any, entries: list[_Entry]) -> list[_Entry]:
    """The parameters whose tables are made in seconds; the others are constants of the file."""
    kept: list[_Entry] = []
    for entry in entries:
        names = tuple(e.name for e in (*kept, entry))
        if len(scaling(medium, indenter, names).coordinates) <= _MOST_COORDINATES:
            kept.append(entry)
    return kept


def _default(entry: _Entry) -> str:
    limits = "min=0" if entry.most is None else f"min=0, max={entry.most:g}"
    return f'    params.add("{entry.key}", value={entry.value!r}, {limits}, vary={entry.fitted})'


def _types(text: str) -> set[str]:
    """Names of the types that a record in Python notation uses."""
    return set(re.findall(r"\b([A-Z]\w+)\(", text))
