"""Values that are looked for in a case file: { fit = ..., min = ..., max = ..., each = true } in the place of a value."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from typing import Any

from flatpunch._support.checks import BadValue
from flatpunch._support.paths import Plain
from flatpunch.files import units as si
from flatpunch.fit.parameters.settings import Free

_DIMENSIONS = {
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
            for label, where, key, wanted in _wanted(f"{prefix}{name}", table, name, value):
                label, found_free = _free(label, name, wanted)
                found[label] = found_free
                where[key] = wanted["fit"]
                if not isinstance(wanted.get("each", False), bool):
                    raise BadValue(f"{label}.each", repr(wanted["each"]), "must be true or false.")
                own += [label] if wanted.get("each") else []
    return plain, found, tuple(own)


def value_in_si(name: str, given: object) -> float:
    """Value of a named parameter as it stands in a file, SI."""
    kind = name.replace("bonded.", "interface_").split(".")[-1].split("[")[0]
    if kind not in _DIMENSIONS:
        raise BadValue(name, "", f"is no parameter; parameters end in {', '.join(sorted(_DIMENSIONS))}.")
    value = _limit(name, kind, given)
    assert value is not None
    return value


def _wanted(label: str, table: Any, name: str, value: object) -> list[tuple[str, Any, str | int, Plain]]:
    """Fitted values in a field: itself, or entries of its list."""
    if isinstance(value, dict) and "fit" in value:
        return [(label, table, name, value)]
    if isinstance(value, list):
        return [(f"{label}[{i}]", value, i, v) for i, v in enumerate(value) if isinstance(v, dict) and "fit" in v]
    return []


def _places(plain: Plain) -> list[tuple[str, Any]]:
    """Tables in which something can be fitted, with what their names begin with."""
    places: list[tuple[str, Any]] = []
    for prefix, body_ in (("", plain), ("upper.", plain.get("upper")), ("lower.", plain.get("lower"))):
        if isinstance(body_, dict):
            places += [(f"{prefix}layers[{i}].", table) for i, table in enumerate(_tables(body_.get("layers")))]
            places.append((f"{prefix}base.", body_.get("base")))
    places += [(f"{name}.", plain.get(name)) for name in ("indenter", "relaxation")]
    return [(prefix, table) for prefix, table in [*places, ("", plain)] if isinstance(table, dict)]


def _tables(value: object) -> list[object]:
    return value if isinstance(value, list) else []


def _free(path: str, name: str, value: Mapping[str, object]) -> tuple[str, Free]:
    unknown = set(value) - {"fit", "min", "max", "each"}
    if unknown:
        raise ValueError(
            f"{path}.{min(unknown)} is no known field; a fitted value is written {{ fit = ..., min = ..., max = ... }}."
        )
    if name not in _DIMENSIONS:
        raise ValueError(f"{path} cannot be fitted; one can fit {', '.join(sorted(_DIMENSIONS))}.")
    limits = [_limit(f"{path}.{key}", name, value.get(key)) for key in ("min", "max")]
    if name == "half_opening_angle":
        limits = [None if v is None else math.pi / 2 - v for v in reversed(limits)]
        path = path.replace("half_opening_angle", "inclination")
    return path.replace("interface_", "bonded."), Free(None, *limits)


def _limit(path: str, name: str, value: object) -> float | None:
    if value is None:
        return None
    dimension = _DIMENSIONS[name]
    if dimension is None:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise BadValue(path, repr(value), "must be a plain number.")
        return float(value)
    return si.named_si(path, value, dimension)
