"""Values that are looked for in a case file: { fit = ..., min = ..., max = ..., each = true } in the place of a value."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Iterator

from flatpunch._support.checks import BadValue
from flatpunch._support.paths import Plain
from flatpunch.files import units as si
from flatpunch.fit.parameters.settings import Free

_DIMENSIONS: dict[str, si.Dimension | None] = {
    "young": si.PRESSURE,
    "thickness": si.LENGTH,
    "radius": si.LENGTH,
    "inclination": si.ANGLE,
    "half_opening_angle": si.ANGLE,
    "poisson": None,
    "work_of_adhesion": si.WORK_OF_ADHESION,
    "time": si.TIME,
    "times": si.TIME,
    "equilibrium": None,
    "exponent": None,
    "weights": None,
    "interface_normal": si.INTERFACE,
    "interface_shear": si.INTERFACE,
}
"""What parameters are measured in, by the last part of their names; None for plain numbers."""
BESIDE: dict[str, si.Dimension | None] = {
    "contact": si.LENGTH,
    "baseline": si.FORCE,
    "tilt": si.STIFFNESS,
    "spring_constant": si.STIFFNESS,
    "sensitivity": None,
    "relative": None,
}
"""The same of numbers that a fit or a prior has beside the parameters of a case."""


def split(data: Plain) -> tuple[Plain, dict[str, Free], tuple[str, ...]]:
    """Separate { fit = ..., min = ..., max = ..., each = true } from a file.

    Returns the file with the starts in their place, the free parameters, and which of them each curve of a joint fit has for
    itself.
    """
    plain = copy.deepcopy(data)
    found: dict[str, Free] = {}
    own: list[str] = []
    for prefix, table in _places(plain):
        for name, value in table.items():
            if isinstance(value, list):
                places = [(f"{prefix}{name}[{i}]", value, i, entry) for i, entry in enumerate(value)]
            else:
                places = [(f"{prefix}{name}", table, name, value)]
            for label, where, key, wanted in places:
                if isinstance(wanted, dict) and "fit" in wanted:
                    path, found_free = _free(label, name, wanted)
                    found[path], where[key] = found_free, wanted["fit"]
                    own += [path] if wanted.get("each") else []
    return plain, found, tuple(own)


def value_in_si(name: str, given: object, called: str = "") -> float:
    """Value of a named parameter, or of a number beside them, as it stands in a file, SI; messages call it `called`."""
    kind = name.replace("bonded.", "interface_").split(".")[-1].split("[")[0]
    known = _DIMENSIONS | (BESIDE if called else {})
    if kind not in known:
        raise BadValue(name, "", f"is no parameter; parameters end in {', '.join(sorted(_DIMENSIONS))}.")
    path, dimension = called or name, known[kind]
    if dimension is not None:
        return si.named_si(path, given, dimension)
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        raise BadValue(path, repr(given), "must be a plain number.")
    return float(given)


def share_of(given: object) -> float | None:
    """A percentage as a share; None for anything else."""
    match = re.fullmatch(r"\s*([\d.eE+-]+)\s*%\s*", given) if isinstance(given, str) else None
    return float(match[1]) / 100 if match else None


def _places(plain: Plain) -> Iterator[tuple[str, Plain]]:
    """Tables in which something can be fitted, with what their names begin with."""
    for prefix, body in (("", plain), ("upper.", plain.get("upper")), ("lower.", plain.get("lower"))):
        if isinstance(body, dict):
            layers = body.get("layers")
            tables = [(f"layers[{i}].", table) for i, table in enumerate(layers if isinstance(layers, list) else [])]
            tables.append(("base.", body.get("base")))
            yield from ((prefix + name, table) for name, table in tables if isinstance(table, dict))
    more = (("indenter.", plain.get("indenter")), ("relaxation.", plain.get("relaxation")), ("", plain))
    yield from ((prefix, table) for prefix, table in more if isinstance(table, dict))


def _free(path: str, name: str, value: Plain) -> tuple[str, Free]:
    """Name and limits of a fitted value."""
    if unknown := set(value) - {"fit", "min", "max", "each"}:
        raise ValueError(
            f"{path}.{min(unknown)} is no known field; a fitted value is written {{ fit = ..., min = ..., max = ... }}."
        )
    if name not in _DIMENSIONS:
        raise ValueError(f"{path} cannot be fitted; one can fit {', '.join(sorted(_DIMENSIONS))}.")
    if not isinstance(value.get("each", False), bool):
        raise BadValue(f"{path}.each", repr(value["each"]), "must be true or false.")
    limits = [value_in_si(name, value[key], f"{path}.{key}") if key in value else None for key in ("min", "max")]
    if name == "half_opening_angle":
        limits = [None if v is None else math.pi / 2 - v for v in reversed(limits)]
        path = path.replace("half_opening_angle", "inclination")
    return path.replace("interface_", "bonded."), Free(None, *limits)
