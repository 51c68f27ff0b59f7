"""Strengths and residual stresses in the form: beside the layer they belong to, so that they move with it.

    layers.0.stress.yield_stress = "2 GPa"    base.stress.tensile = "300 MPa"    layers.0.stress.residual_stress = "-1 GPa"

In a case file they are lists in [stress], from the surface down, the base last.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from flatpunch._support.paths import Plain
from flatpunch.files.tables.stress import StrengthTable

STRENGTHS = tuple(StrengthTable.model_fields)
"""Names of the strengths of a layer."""

_RESIDUAL = "residual_stress"
_NO_STRESS = "0 Pa"


def with_strengths(stress: Mapping[str, object], fields: Mapping[str, str], layers: int) -> Plain:
    """Return the table [stress] with the strengths and residual stresses of the form, which has so many layers."""
    owners = _owners(fields, layers)
    given = [{name: text for name in STRENGTHS if (text := fields.get(f"{owner}.stress.{name}"))} for owner in owners]
    residual = [fields.get(f"{owner}.stress.{_RESIDUAL}", "") for owner in owners]
    found = dict(stress)
    if any(given):
        found["strengths"] = _without_end(given)
    if any(residual):
        # every layer has its entry; the base may be left out
        found[_RESIDUAL] = [text or _NO_STRESS for text in (residual if residual[-1] else residual[:-1])]
    return found


def strengths_form(stress: Mapping[str, object], layers: int) -> tuple[Plain, dict[str, str]]:
    """Return what is left of the table [stress] of a case file, and the fields of its strengths and residual stresses."""
    rest: Plain = dict(stress)
    found: dict[str, str] = {}
    owners = [*(f"layers.{i}" for i in range(layers)), "base"]
    strengths, residual = rest.get("strengths", ()), rest.get(_RESIDUAL, ())
    if _fits(strengths, Mapping, owners):
        del rest["strengths"]
        for owner, strength in zip(owners, strengths, strict=False):
            found |= {f"{owner}.stress.{name}": str(value) for name, value in strength.items()}
    if _fits(residual, str, owners) and len(residual) >= layers:
        del rest[_RESIDUAL]
        found |= {f"{owner}.stress.{_RESIDUAL}": text for owner, text in zip(owners, residual, strict=False)}
    return rest, found


def strength_place(name: str, fields: Mapping[str, str]) -> str:
    """Return the field that a place such as "stress.strengths.1.tensile" of a case file is about; other places as they are."""
    match = re.fullmatch(r"stress\.(strengths|residual_stress)\.(\d+)(?:\.(\w+))?", name)
    if not match:
        return name
    layers = len({field.split(".")[1] for field in fields if re.match(r"layers\.\d+\.", field)})
    owners = _owners(fields, layers)
    owner = owners[min(int(match[2]), len(owners) - 1)]
    return f"{owner}.stress.{match[3] or (_RESIDUAL if match[1] == _RESIDUAL else STRENGTHS[0])}"


def _owners(fields: Mapping[str, str], layers: int) -> list[str]:
    numbers = sorted({int(match[1]) for field in fields if (match := re.match(r"layers\.(\d{1,6})\.", field))})
    return [*(f"layers.{i}" for i in numbers[:layers]), "base"]


def _without_end(given: list[dict[str, str]]) -> list[dict[str, str]]:
    """Entries up to the last that says something."""
    last = max(i for i, entry in enumerate(given) if entry)
    return given[: last + 1]


def _fits(values: object, kind: type, owners: list[str]) -> bool:
    return isinstance(values, list) and len(values) <= len(owners) and all(isinstance(each, kind) for each in values)
