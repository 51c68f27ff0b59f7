"""The form of the page: fields with dotted names and texts as values, which are the address of the page as well.

    layers.0.young = "5 kPa"      base.kind = "rigid"      control.quantity = "depth"      control.start = "10 nm"

`case_text` turns them into the text of a case file, `form_of` a case file into fields. A text in brackets is taken as TOML, so
that every value of a case file has a place: `{ law = "linear", top = "5 kPa", bottom = "9 kPa" }` as a modulus. Tables for which
the page has no fields stay as lines of TOML in the field `more`. What a fit looks for has the fields .fit ("on"), .min and .max.

Strengths and residual stresses are beside the layer they belong to, so that they move with it: layers.0.stress.yield_stress. In a
case file they are lists in [stress], from the surface down, the base last.
"""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import parse_qsl, urlencode

from flatpunch._support.checks import LAYERS, Problem
from flatpunch._support.paths import Plain
from flatpunch.files.cases import check_nesting
from flatpunch.files.tables.stress import StrengthTable

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(data: Plain) -> str:
    """Return tables as TOML: single values first, then a [table] for each dict, a [[table]] for each of a list of them."""
    single = {name: value for name, value in data.items() if not _is_table(value)}
    tables = {name: value for name, value in data.items() if _is_table(value)}
    blocks = [_lines(single)] if single else []
    for name, value in tables.items():
        for table in [value] if isinstance(value, Mapping) else value:
            brackets = ("[", "]") if isinstance(value, Mapping) else ("[[", "]]")
            blocks.append("\n".join([_key(name).join(brackets), *([_lines(table)] if table else [])]))
    return "\n\n".join(blocks) + "\n" if blocks else ""


def toml_value(value: object) -> str:
    """Return one value on one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # the escapes of JSON are those of TOML, which escapes one character more
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else "nan" if math.isnan(value) else f"{'-' * (value < 0)}inf"
    if isinstance(value, Mapping):
        return f"{{ {', '.join(_pairs(value))} }}" if value else "{}"
    if isinstance(value, list):
        return f"[{', '.join(map(toml_value, value))}]"
    return value.isoformat() if hasattr(value, "isoformat") else str(value)


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping) or (
        isinstance(value, list) and bool(value) and all(isinstance(entry, Mapping) for entry in value)
    )


def _lines(table: Mapping[str, object]) -> str:
    return "\n".join(_pairs(table))


def _pairs(table: Mapping[str, object]) -> Iterator[str]:
    return (f"{_key(name)} = {toml_value(value)}" for name, value in table.items())


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else toml_value(name)


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


LONGEST = 200_000
"""Characters of a form."""

_TWO_BODIES = "two bodies"
"""Choice of base for cases with [upper] and [lower], which stand in the field `more`."""

_HISTORY = "history"
"""Choice of what is prescribed for cases with [history], which stands in the field `more`."""

TOP = ("title", "method", "angles", "work_of_adhesion", "range_of_action", "strength")
_TEXTS = {"title", "method", "kind", "sheet", "decimal"}
"""Fields that are texts whatever they look like."""

_NUMBER = re.compile(r"[+-]?(?:[0-9]++\.?[0-9]*+|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_ADHESION = {"work_of_adhesion", "range_of_action", "strength"}

_TAB_TABLES = {
    "press": {"control", "history", "relaxation", "material", "design", *_ADHESION},
    "fit": {"fit", "curve", "plan", "relaxation", "material", *_ADHESION},
    "correct": {"correct"},
    "coating": {"control", "stress", "vary", *_ADHESION},
    "slip": {"control", "slip"},
    "compare": {"control", "material"},
}
"""Parts of a case file beside the sample that a tab reads; the others belong to other tabs and are left out."""

_OF_TABS = set().union(*_TAB_TABLES.values()) | {"film"}
_SINGLE = ("fit", "curve", "correct", "stress", "slip", "material")
"""Tables whose entries are fields."""

_LIMITS = ("min", "max")


class FormError(ValueError):
    """A form that is no case; the message names the field in the words of case files.

    Attributes
    ----------
    field : str
        The field of the form, or empty.
    """

    def __init__(self, message: str, field: str = "") -> None:
        super().__init__(message)
        self.field, self.problems = field, (Problem(field, message),)


def fields_of(query: str) -> dict[str, str]:
    """Return the fields of an address or of a request, the last value of each name."""
    if len(query) > 3 * LONGEST:
        raise FormError(f"the form has {len(query)} characters; at most {LONGEST} are read.")
    return {name: value.strip() for name, value in parse_qsl(query, keep_blank_values=True) if value.strip()}


def address_of(fields: Mapping[str, str]) -> str:
    """Return fields as the query of an address, which `fields_of` reads."""
    return urlencode({name: value for name, value in fields.items() if value.strip()})


def case_text(fields: Mapping[str, str], tab: str = "press") -> str:
    """Return the case file that a form means; see `case_data`."""
    return toml_text(case_data(fields, tab))


def case_data(fields: Mapping[str, str], tab: str = "press") -> Plain:
    """Return the tables of the case file that a form means on a tab; values to be fitted are marked on the tab "fit" only."""
    fitted, two = tab == "fit", fields.get("base.kind") == _TWO_BODIES
    data: Plain = {name: _marked(name, fields, fitted) for name in TOP if fields.get(name)}
    if not two:
        layers = [_table(fields, f"layers.{i}.", fitted) for i in _indices(fields, "layers")]
        data |= {"layers": layers} if layers else {}
        data |= {"base": base} if (base := _table(fields, "base.", fitted)) else {}
    data["indenter"] = _table(fields, "indenter.", fitted)
    data |= {"control": control} if (control := _control(fields)) else {}
    for name in _SINGLE:
        data |= {name: table} if (table := _table(fields, f"{name}.", fitted)) else {}
    count = 0 if two else len(_indices(fields, "layers"))
    data |= {"stress": stress} if (stress := with_strengths(data.get("stress", {}), fields, count)) else {}
    if fields.get("map") == "on":
        data["vary"] = {name.removeprefix("vary."): fields[name] for name in fields if name.startswith("vary.")}
    for name, value in _more(fields.get("more", "")).items():
        if name in data:
            raise FormError(f"more: {name} has fields of its own above; leave it out here.", "more")
        data[name] = value
    left_out = _OF_TABS - _TAB_TABLES[tab]
    if tab != "fit" and data.get("method") == "auto":
        del data["method"]
    if isinstance(data["indenter"], dict) and "file" in data["indenter"]:
        raise FormError(
            "indenter.file: the page reads no files that a case names. Solve it with `flatpunch solve`.",
            "indenter.file",
        )
    return {name: value for name, value in data.items() if name not in left_out}


def form_of(data: Mapping[str, Any]) -> dict[str, str]:
    """Return the fields of a case file, from its tables."""
    found: dict[str, str] = {}
    rest: Plain = {}
    for name, value in data.items():
        if name in TOP:
            found |= _flat(name, value)
        elif name == "layers" and _is_list_of_tables(value):
            for i, layer in enumerate(value):
                found |= _flat_table(f"layers.{i}", layer)
        elif name == "vary" and isinstance(value, dict):
            found |= {"map": "on", **{f"vary.{path}": _text(values) for path, values in value.items()}}
        elif name == "stress" and isinstance(value, dict):
            value, strengths = strengths_form(value, len(data.get("layers", ())))
            found |= _flat_table(name, value) | strengths
        elif name in ("base", "indenter", *_SINGLE) and isinstance(value, dict):
            found |= _flat_table(name, value)
        elif name == "control" and isinstance(value, dict) and (control := _control_form(value)):
            found |= control
        else:
            rest[name] = value
    if "base" not in data and "upper" in data:
        found["base.kind"] = _TWO_BODIES
    if "history" in data:
        found["control.quantity"] = _HISTORY
    if rest:
        found["more"] = toml_text(rest).strip()
    return {name: text for name, text in found.items() if text.strip()}


def _flat_table(prefix: str, table: Mapping[str, object]) -> dict[str, str]:
    """Fields of a table; those of columns and their units one level deeper."""
    found: dict[str, str] = {}
    for name, value in table.items():
        deeper = prefix == "curve" and name in ("columns", "units")
        if deeper and isinstance(value, dict):
            found |= _flat_table(f"{prefix}.{name}", value)
        else:
            found |= _flat(f"{prefix}.{name}", value)
    return found


def _indices(fields: Mapping[str, str], name: str) -> list[int]:
    """Numbers of the entries of a list, ascending; gaps do not count."""
    found = {int(match[1]) for field in fields if (match := re.match(rf"{name}\.(\d{{1,6}})\.", field))}
    if len(found) > LAYERS:
        raise FormError(f"{name} has {len(found)} entries; at most {LAYERS} are solved.")
    return sorted(found)


def _table(fields: Mapping[str, str], prefix: str, fitted: bool) -> Plain:
    """Fields below a prefix as a table, with tables inside it for names with a dot."""
    found: Plain = {}
    for field in fields:
        *above, name = field.removeprefix(prefix).split(".")
        if not field.startswith(prefix) or ".stress." in field or is_mark(field, fields):
            continue
        table = found
        for step in above:
            table = table.setdefault(step, {})
            if not isinstance(table, dict):
                raise FormError(f"{field} lies in a field that has a value of its own; leave one of them out.", field)
        table[name] = _marked(field, fields, fitted)
    return {} if found.get("kind") == _TWO_BODIES else found


def is_mark(field: str, fields: Mapping[str, str]) -> bool:
    """Whether a field says of another one how it is fitted."""
    owner, _, part = field.rpartition(".")
    return owner in fields and part in ("fit", *_LIMITS)


def _marked(field: str, fields: Mapping[str, str], fitted: bool) -> object:
    """Value of a field; in a fit as { fit = ..., min = ..., max = ... } if it is looked for."""
    value = _value(field.rpartition(".")[2], fields[field])
    if not fitted or fields.get(f"{field}.fit") != "on":
        return value
    limits = {end: _value(end, text) for end in _LIMITS if (text := fields.get(f"{field}.{end}"))}
    return {"fit": value, **limits}


def _value(name: str, text: str) -> object:
    """Value of a text in a case file: TOML in brackets, a number, true or false, or the text itself."""
    if name in _TEXTS:
        return text
    if _NUMBER.fullmatch(text):
        return int(text) if re.fullmatch(r"[+-]?(?:0|[1-9][0-9]{0,17})", text) else float(text)
    if text in ("true", "false"):
        return text == "true"
    if text[:1] in "[{" and text[-1:] in "]}":
        try:
            check_nesting(text)
            return tomllib.loads(f"v = {text}")["v"]
        except (ValueError, RecursionError):
            return text
    return text


def _control(fields: Mapping[str, str]) -> Plain:
    quantity = fields.get("control.quantity", "")
    if not quantity or quantity == _HISTORY:
        return {}
    if "control.values" in fields:
        return {quantity: _value("values", fields["control.values"])}
    steps = {
        name: _value(name, fields[f"control.{name}"])
        for name in ("start", "stop", "points", "spacing")
        if f"control.{name}" in fields
    }
    return {quantity: steps}


def _control_form(table: Mapping[str, object]) -> dict[str, str]:
    """Fields of [control]; none if it is not of one quantity."""
    if len(table) != 1:
        return {}
    ((quantity, steps),) = table.items()
    if isinstance(steps, dict) and set(steps) <= {"start", "stop", "points", "spacing"}:
        return {"control.quantity": quantity, **{f"control.{name}": _text(value) for name, value in steps.items()}}
    return {"control.quantity": quantity, "control.values": _text(steps)}


def _more(text: str) -> Plain:
    if not text:
        return {}
    try:
        check_nesting(text)
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise FormError(f"more: not valid TOML: {error}", "more") from None


def _flat(name: str, value: object) -> dict[str, str]:
    """Fields of a value, which may be one to be fitted."""
    if isinstance(value, dict) and "fit" in value and set(value) <= {"fit", *_LIMITS}:
        limits = {f"{name}.{end}": _text(value[end]) for end in _LIMITS if end in value}
        return {name: _text(value["fit"]), f"{name}.fit": "on", **limits}
    return {name: _text(value)}


def _text(value: object) -> str:
    return value if isinstance(value, str) else toml_value(value)


def _is_list_of_tables(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(entry, dict) for entry in value)
