"""What files that carry one case share: the name of the module, the parameters that stay free, and the case as source."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from flatpunch._support.checks import BadValue, instance, shown
from flatpunch._support.readable import source_of
from flatpunch._support.reading import as_path
from flatpunch.fits.elastic.model import method_for
from flatpunch.fits.parameters.sample import numbers_in
from flatpunch.fits.parameters.scaling import scaling
from flatpunch.fits.parameters.settings import FitMethod
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, underlying

_MOST_COORDINATES = 2
"""Free parameters that change the shape of the force curve; with three, the table in the file would have millions of numbers."""


@dataclass(frozen=True)
class Entry:
    """One parameter of a file: its key there, its name here, how it is shown, and how it becomes ours."""

    key: str
    name: str
    label: str
    unit: str
    value: float
    fitted: bool
    most: float | None = None
    convert: str = "{}"


def module_path(path: str | Path, example: str) -> Path:
    """The path of a Python module, refused if Python could not import it."""
    path = as_path("path", path)
    if path.suffix != ".py" or not path.stem.isidentifier():
        raise BadValue("path", shown(str(path)), f": this file is a Python module; name it like {example}.")
    return path


def shown_title(title: str, default: str) -> str:
    """A title that can stand in a docstring."""
    instance("title", title, (str,), "a text")
    return (title or default).replace('"', "'").replace("\\", "/")


def entries_of(medium: Body, indenter: Indenter) -> list[Entry]:
    """Modulus of the top layer, and those of its thickness and the tip's size whose tables are made in seconds."""
    kept: list[Entry] = []
    for entry in _entries(medium, indenter):
        names = tuple(e.name for e in (*kept, entry))
        if len(scaling(medium, indenter, names).coordinates) <= _MOST_COORDINATES:
            kept.append(entry)
    return kept


def parts_of(
    medium: Body, indenter: Indenter, entries: list[Entry], title: str, method: FitMethod
) -> dict[str, object]:
    """Title, imports, case and free parameters as texts of a template."""
    chosen = method_for(indenter, method)
    return {
        "title": shown_title(title, "Layered sample (flatpunch)"),
        "method": chosen if isinstance(chosen, str) else chosen.name,
        "imports": "\n".join(_imports(medium, indenter)),
        "medium": source_of(medium),
        "indenter": source_of(indenter),
        "free": repr(tuple(entry.name for entry in entries)),
        "values": ", ".join(f"{entry.name!r}: {entry.convert.format(entry.key)}" for entry in entries),
    }


def _entries(medium: Body, indenter: Indenter) -> list[Entry]:
    stack = underlying(medium).single
    check_indenter(indenter)
    plain = stack and (stack.base.rigid or stack.base.isotropic) and all(layer.isotropic for layer in stack.layers)
    numbers = numbers_in(medium, indenter)
    of_top = (each for each in numbers.values() if each.path.startswith(("layers[0].", "base.")))
    top = next((each for each in of_top if each.number.unit == "Pa" and each.path not in numbers.members), None)
    if not plain or top is None:
        raise ValueError("a model file needs homogeneous layers on a rigid base or a half-space.")
    name = top.path.rpartition(".")[2]
    key, label = ("E", "Young's Modulus") if name == "young" else (name, top.number.what.title())
    entries = [Entry(key, top.path, label, "Pa", top.value, True)]
    if thickness := numbers.get("layers[0].thickness"):
        entries.append(Entry("h", thickness.path, "Layer Thickness", "m", thickness.value, False))
    tip = [each for name, each in numbers.items() if name.startswith("indenter.")]
    if len(tip) == 1 and tip[0].number.unit == "m":
        entries.append(Entry("R", tip[0].path, "Tip Radius", "m", tip[0].value, False))
    elif len(tip) == 1 and tip[0].number.slanted:
        half, convert = 90 - math.degrees(tip[0].value), "np.pi / 2 - np.radians({})"
        entries.append(Entry("alpha", tip[0].path, "Half Opening Angle", "°", half, False, 90, convert))
    else:
        raise ValueError(
            f"indenter = {type(indenter).__name__}: there are model files for tips with a radius or an angle."
        )
    return entries


def _imports(*things: object) -> list[str]:
    """Lines that import the classes of a case: those of the package by their rooms, others from where they are."""
    homes: dict[str, set[str]] = {}
    for made in {made for thing in things for made in _classes(thing)}:
        room = ".".join(made.__module__.split(".")[:2])
        homes.setdefault(room if room.startswith("flatpunch.") else made.__module__, set()).add(made.__name__)
    return [f"from {home} import {', '.join(sorted(names))}" for home, names in sorted(homes.items())]


def _classes(thing: object) -> Iterator[type]:
    if isinstance(thing, tuple):
        for each in thing:
            yield from _classes(each)
    elif dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        yield type(thing)
        for field in dataclasses.fields(thing):
            if field.init:
                yield from _classes(getattr(thing, field.name))
