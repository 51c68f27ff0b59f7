"""TOML text from the tables of a case file: the way back from what `tomllib` reads."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping

from flatpunch._support.paths import Plain

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
