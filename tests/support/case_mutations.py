"""Seeded mutations of case files: every field removed, renamed, doubled, of a wrong type, sign, unit or size; and broken text."""

from __future__ import annotations

import copy
import datetime
import json
import random
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

VALUES: dict[str, Any] = {
    "empty text": "",
    "text": "x",
    "long text": "y" * 3000,
    "whole": 3,
    "negative": -1,
    "zero": 0,
    "huge whole": 10**400,
    "float": 0.5,
    "nan": float("nan"),
    "inf": float("-inf"),
    "true": True,
    "date": datetime.date(2020, 2, 3),
    "list": [],
    "nested list": [[1], ["a", []]],
    "table": {},
    "other table": {"kind": "cone", "fit": "1 Pa"},
    "length": "1 um",
    "negative length": "-1 um",
    "zero length": "0 um",
    "tiny": "5e-324 m",
    "enormous": "1e300 m",
    "beyond": "1e999999999 Pa",
    "below": "1e-999999999 N",
    "pressure": "3 kPa",
    "angle": "89.9999999 deg",
    "unit only": "um",
    "number as text": "3",
    "unknown unit": "3 furlings",
    "arabic digits": "\u0663 um",
    "superscript": "1\u00b2 um",
    "expression": "3 um*(((((2)))))**99999999",
    "braces": "{0.__class__}",
    "control": "1 \x07um",
    "range": {"start": "1 nm", "stop": "2 nm", "points": 10**9},
    "kelvin": "3 K",
}


def examples() -> list[Path]:
    """All shipped case files, also those of fits."""
    return [*sorted(EXAMPLES.glob("*.toml")), *sorted((EXAMPLES / "fit").glob("*.toml"))]


def written(data: Any) -> str:
    """Nested tables as TOML, in one line a key."""
    return "".join(f"{_key(name)} = {_value(value)}\n" for name, value in data.items())


def _key(name: str) -> str:
    return json.dumps(name)


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value).replace("\\ud", "?")
    if isinstance(value, float):
        return {"nan": "nan", "inf": "inf", "-inf": "-inf"}.get(repr(value), repr(value))
    return str(value)


def places(data: Any, way: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Ways to all entries of nested tables and lists."""
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in entries:
        yield (*way, key)
        yield from places(value, (*way, key))


def changed(data: Any, way: tuple[Any, ...], value: Any) -> Any:
    """A copy with one entry replaced."""
    new = copy.deepcopy(data)
    owner = new
    for step in way[:-1]:
        owner = owner[step]
    owner[way[-1]] = value
    return new


def field_mutations(path: Path) -> Iterator[tuple[str, str]]:
    """Label and text for every field of a case file and every kind of mistake."""
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    for way in places(data):
        label = f"{path.stem}: {'.'.join(map(str, way))}"
        without = copy.deepcopy(data)
        owner = without
        for step in way[:-1]:
            owner = owner[step]
        value = owner.pop(way[-1])
        yield f"{label} removed", written(without)
        if isinstance(owner, dict):
            yield (
                f"{label} renamed",
                written({**without, "unheard_of": value} if len(way) == 1 else _renamed(data, way)),
            )
            if len(way) == 1:
                yield f"{label} twice", written(data) + f"{_key(way[0])} = {_value(value)}\n"
        else:
            yield f"{label} repeated", written(changed(data, way[:-1], [*owner, value, value]))
        for kind, other in VALUES.items():
            yield f"{label} = {kind}", written(changed(data, way, other))


def _renamed(data: Any, way: tuple[Any, ...]) -> Any:
    new = copy.deepcopy(data)
    owner = new
    for step in way[:-1]:
        owner = owner[step]
    owner[f"{way[-1]}_"] = owner.pop(way[-1])
    return new


def text_mutations(path: Path, seed: int, count: int) -> Iterator[tuple[str, bytes]]:
    """Label and bytes of files with random damage."""
    rng = random.Random(f"{path.stem} {seed}")
    whole = path.read_bytes()
    pieces = [
        b"[",
        b"]",
        b"{",
        b"}",
        b'"',
        b"'",
        b"=",
        b".",
        b"\n",
        b"\x00",
        b"\xff",
        b"#",
        b"0x",
        b"1e9",
        b'"""',
        b"\r",
    ]
    for n in range(count):
        text = bytearray(whole)
        for _ in range(rng.randint(1, 6)):
            at = rng.randrange(len(text) + 1)
            kind = rng.randrange(4)
            if kind == 0:
                text[at:at] = rng.choice(pieces)
            elif kind == 1:
                del text[at : at + rng.randint(1, 20)]
            elif kind == 2:
                start = rng.randrange(len(whole))
                text[at:at] = whole[start : start + rng.randint(1, 60)]
            elif text and at < len(text):
                text[at] = rng.randrange(256)
        yield f"{path.stem} damaged {n}", bytes(text)


def monsters() -> dict[str, bytes]:
    """Files that are large, deep or strange."""
    deep, many = 500, 100_000
    return {
        "nested brackets": b"a = " + b"[" * deep + b"]" * deep,
        "nested tables": b"a = " + b"{a = " * deep + b"1" + b"}" * deep,
        "dotted key": b".".join([b"a"] * many) + b" = 1",
        "dotted header": b"[" + b".".join([b"a"] * many) + b"]",
        "quoted dotted key": b".".join([b'"a"'] * many) + b" = 1",
        "long integer": b"angles = " + b"9" * 5000,
        "hexadecimal": b"angles = 0x" + b"f" * 5000,
        "long float": b"angles = 0." + b"9" * 100_000,
        "long key": b"k" * 1_000_000 + b" = 1",
        "many keys": b"".join(b"k%d = 1\n" % i for i in range(101_000)),
        "many layers": b"[[layers]]\nyoung = '1 kPa'\npoisson = 0.3\nthickness = '1 nm'\n" * 3_000
        + b"[base]\nkind='rigid'\n[indenter]\nkind='sphere'\nradius='1 um'\n[control]\ndepth='1 nm'\n",
        "many depths": b"[[layers]]\nyoung = '1 kPa'\npoisson = 0.3\nthickness = '1 um'\n"
        b"[base]\nkind='rigid'\n[indenter]\nkind='sphere'\nradius='1 um'\n[control]\ndepth=["
        + b"'1 nm'," * 300_000
        + b"]\n",
        "six megabytes": b"# " + b"x" * 6_000_000,
        "binary": bytes(range(256)) * 100,
        "utf-16": "title = 'x'".encode("utf-16"),
        "empty": b"",
        "byte order mark": b"\xef\xbb\xbftitle = 'x'",
        "null": b"\x00" * 1000,
    }
