"""Columns of measured files: which is which, in which unit, and what is wrong with them.

What instruments call their columns is data, `columns.toml`; here is how titles are compared with it.
"""

from __future__ import annotations

import difflib
import re
import tomllib
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, shown
from flatpunch._support.paths import Plain
from flatpunch.files import units
from flatpunch.fits.measured.curve import CurveError

WORDS: Plain = tomllib.loads(Path(__file__).with_name("columns.toml").read_text(encoding="utf-8"))
"""What instruments call their columns, segments, tests and constants."""
STIFFNESS = units.Dimension("stiffness", "N/m", "120 N/m", ("N/m", "mN/nm", "uN/nm", "N/mm", "mN/um"))
_DIMENSIONS = {
    "length": units.LENGTH,
    "force": units.FORCE,
    "stiffness": STIFFNESS,
    "time": units.Dimension("time", "s", "0.5 s", ("s", "ms", "min", "us")),
}
SIGNALS = (
    units.Dimension("voltage", "V", "0.5 V", ("V", "mV")),
    units.Dimension("current", "A", "2 nA", ("A", "nA")),
)
ROLES = {role: _DIMENSIONS[about["dimension"]] for role, about in WORDS["roles"].items()}
"""What a column can be, and its dimension."""
FORCES, POSITIONS = {"force", "deflection"}, {"depth", "piezo"}
_UNITS = {unit for kind in (*_DIMENSIONS, "signal") for unit in WORDS["units"][kind]}

WAYS = {word for way in ("forth", "hold", "back") for word in WORDS["segments"][way]}
"""Words for the way of a segment."""

_BRACKETS = re.compile(r"^(.*?)\s*(?:\(([^()]*)\)|\[([^\[\]]*)\])\s*$")
_BEHIND = re.compile(r"^(.*\S)(?:\s*/\s*|\s*,\s*|\s+in\s+|_|\s+)([^\s_/,]+(?:/[^\s_/,]+)?)$")
"""A unit in brackets, and one behind a name: "depth / nm", "load_uN", "Depth nm", "Kraft in N"."""
_NARROW = str.maketrans("（）［］：", "()[]:")
_NO_VALUE = 1e300
"""Numbers of this size or larger mark a value that was not measured."""
_COMMA = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?\s*")


@dataclass(frozen=True)
class Constants:
    """Constants that a file was written with, None where it does not say, and where they are from."""

    spring_constant: float | None = None
    sensitivity: float | None = None
    origin: str = "from the file"


@dataclass(frozen=True, eq=False)
class Table:
    """Columns as they stand in a file: names, units where given, cells (text or numbers) by row."""

    source: str
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    rows: Any
    """Array of cells, a row for each reading."""
    first_row: int = 1
    breaks: tuple[int, ...] = ()
    """Rows before which the file has blank lines."""
    constants: Constants = field(default_factory=Constants)
    segment: Array | None = None
    """Number of the segment of each row, where the file sets segments apart."""
    ways: tuple[str, ...] = ()
    """Way of each segment: "forth", "hold", "back", or "" where the file does not say."""
    numbers: tuple[int | None, ...] = ()
    """Number of each segment that is a block of the file."""
    segmented: str = "blocks of the file"
    """What sets segments apart."""
    outwards: bool = False
    """Whether positions grow away from the sample."""
    meta: Plain = field(default_factory=dict)


@lru_cache(maxsize=10_000)
def words(title: str) -> tuple[str, ...]:
    """Words of a title: no capitals, accents and underscores; verticalTipPosition is three."""
    for other, same in WORDS["titles"]["same"].items():
        if other == f"= {title.strip()}":
            return (same,)
    bare = "".join(c for c in unicodedata.normalize("NFKD", title) if not unicodedata.combining(c))
    found = re.findall(r"[^\W\d_]+|\d+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", bare).lower())
    text = " ".join(found)
    for other, same in WORDS["titles"]["same"].items():
        text = text.replace(other, same)
    return tuple(text.split())


def listed(title: str, entries: Iterable[str]) -> bool:
    """Whether a title is among entries of `columns.toml`."""
    return _listed(words(title), tuple(entries))


@lru_cache(maxsize=10_000)
def _listed(found: tuple[str, ...], entries: tuple[str, ...]) -> bool:
    for entry in entries:
        alone, own = entry.startswith("= "), entry.removeprefix("= ").split()
        if alone and tuple(own) == found:
            return True
        if not alone and all(any(fnmatchcase(word, each) for word in found) for each in own):
            return True
    return False


def split_name(title: str) -> tuple[str, str | None]:
    """Name and unit of a column's title: "Load (uN)", "force [nN]", "depth / nm", "load_uN", "Depth nm", "Kraft in N"."""
    title = re.sub(r"(?<=[)\]])\.\d+$", "", title.translate(_NARROW).strip().strip('"').strip())
    if match := _BRACKETS.match(title):
        unit = (match[2] if match[2] is not None else match[3]).strip()
        if not (words(unit) and way_of(unit)):
            return match[1].strip(), unit or None
    if (match := _BEHIND.match(title)) and _plain(match[2]) in _UNITS:
        return match[1].strip(" _"), match[2]
    return title, None


def way_of(text: str) -> str:
    """The way that a word for a segment names: "forth", "hold", "back"; "" without such a word."""
    found = set(words(text))
    return next((way for way in ("hold", "back", "forth") if found & set(WORDS["segments"][way])), "")


def _plain(unit: str) -> str:
    """A unit in plain letters."""
    unit = unicodedata.normalize("NFC", unit.strip("()[] "))
    for letter, plain in WORDS["units"]["letters"].items():
        unit = unit.replace(letter, plain)
    return unit


def si_scale(unit: str, dimension: units.Dimension) -> float:
    """SI value of one unit; ValueError for a unit of another kind."""
    plain = _plain(unit)
    return units.to_si(f"1 {f'u{dimension.unit}' if plain in WORDS['units']['swallowed'] else plain}", dimension)


def scale_of(unit: str | None, *dimensions: units.Dimension) -> float | None:
    """SI value of one unit, of the first kind that it is of; None where it is of another, or there is none."""
    for dimension in dimensions if unit else ():
        try:
            return si_scale(str(unit), dimension)
        except ValueError:
            continue
    return None


def chosen_columns(table: Table, wanted: Mapping[str, str | int] | None) -> dict[str, int]:
    """Position of the column of each role: as named by the user, or recognised by its title.

    Raises
    ------
    CurveError
        If several columns could have a role; the message has the lines that choose one.
    """
    found = {role: _named(table, role, title) for role, title in (wanted or {}).items()}
    for role in ROLES:
        if role in found:
            continue
        hits = recognised(table.names, table.units, role, set(found.values()))
        # the piezo and the deflection are used where there is no depth, no force
        needed = role in ("depth", "force") or {"piezo": "depth", "deflection": "force"}.get(role, role) not in found
        if len(hits) > 1 and needed and role not in ("stiffness", "time"):
            # columns of the same name are chosen by their number
            same = len({table.names[i] for i in hits}) < len(hits)
            lines = " or ".join(f"{role} = {i}" if same else f'{role} = "{table.names[i]}"' for i in hits)
            raise CurveError(
                f"{table.source}: several columns could be the {role}: {', '.join(repr(table.names[i]) for i in hits)}. Choose "
                f"one in the case file, [curve.columns] {lines}."
            )
        if hits:
            found[role] = hits[0]
    return found


def recognised(names: Sequence[str], given: Sequence[str | None], role: str, taken: set[int]) -> list[int]:
    """Columns that the surest titles of a role find; those whose unit is of another kind only if there is nothing else."""
    about, free = WORDS["roles"][role], [i for i in range(len(names)) if i not in taken]
    free = [i for i in free if not listed(names[i], WORDS["titles"]["none"])]
    wrong: list[int] = []
    for entries in about["titles"]:
        hits = [i for i in free if listed(names[i], entries)]
        if right := [i for i in hits if not given[i] or scale_of(given[i], ROLES[role])]:
            return right
        wrong += hits
    by_unit = [i for i in free if listed(names[i], about.get("by_unit", ()))]
    return [i for i in by_unit if scale_of(given[i], ROLES[role])] or wrong[:1]


def roles_of(titles: Iterable[tuple[str, str | None]]) -> set[str]:
    """What there is among columns, by name and unit."""
    names, given = zip(*titles, strict=True)
    return {role for role in ROLES if recognised(names, given, role, set())}


def names_a_curve(titles: Iterable[tuple[str, str | None]]) -> bool:
    """Whether columns, by name and unit, are a force or deflection and a position."""
    roles = roles_of(titles)
    return bool(roles & FORCES and roles & POSITIONS)


def check_title(role: str, title: object) -> None:
    """Refuse what names no column."""
    if not isinstance(title, (str, int)) or isinstance(title, bool):
        raise CurveError(f"columns: {shown(title)} for {role} must be a title or the number of a column, from 0.")


def _named(table: Table, role: str, title: str | int) -> int:
    check_title(role, title)
    if isinstance(title, int):
        if not 0 <= title < len(table.names):
            raise CurveError(f"{table.source}: column {title} for {role} does not exist; there are {len(table.names)}.")
        return title
    meant = {words(part) for part in (title, split_name(title)[0])}
    for i, name in enumerate(table.names):
        if name == title or words(name) in meant:
            return i
    near = difflib.get_close_matches(title, table.names, n=1, cutoff=0.5)
    advice = f" Did you mean {near[0]!r}?" if near else ""
    known = ", ".join(map(repr, table.names)) or "none"
    raise CurveError(f"{table.source}: there is no column {shown(title)} for {role}; there are {known}.{advice}")


def in_si(
    table: Table, role: str, index: int, given: Mapping[str, str] | None, sensitivity: float | None = None
) -> Array:
    """One column in SI units; empty cells and text that is no number become NaN.

    A deflection may be a signal [V, A], which the sensitivity [m/V, m/A] makes a length.
    """
    dimension, name = ROLES[role], table.names[index]
    unit = (given or {}).get(role) or table.units[index]
    if unit is None:
        usual = dimension.common[-2 if len(dimension.common) > 4 else 0]
        raise CurveError(
            f"{table.source}: column {name!r} ({role}) has no unit. Write it into the header, '{name} ({usual})', or into the "
            f'case file, [curve.units] {role} = "{usual}" (Python: units={{{role!r}: {usual!r}}}).'
        )
    if role == "deflection" and (signal := scale_of(unit, *SIGNALS)) is not None:
        if sensitivity is None:
            raise CurveError(
                f"{table.source}: column {name!r} (deflection) is a signal ({unit}); a length needs the sensitivity. Write "
                f'[curve] sensitivity = "70 nm/{unit}" into the case file (Python: sensitivity=... [m/V] or [m/A]).'
            )
        return sensitivity * signal * column_numbers(table, index)
    try:
        scale = si_scale(unit, dimension)
    except ValueError as error:
        raise CurveError(f"{table.source}: column {name!r} ({role}) {error}") from None
    return scale * column_numbers(table, index)


def column_numbers(table: Table, index: int) -> Array:
    """One column as it stands in the file; empty cells and text that is no number become NaN."""
    cells = table.rows[:, index]
    try:
        numbers = np.asarray(cells, dtype=float)
    except (TypeError, ValueError):
        numbers = np.array([_number(cell) for cell in cells])
        commas = [i for i, cell in enumerate(cells) if isinstance(cell, str) and _COMMA.fullmatch(cell)]
        if commas:
            raise CurveError(
                f"{table.source}: row {table.first_row + commas[0]} of column {table.names[index]!r} reads "
                f"{cells[commas[0]]!r}: decimal commas. Read the file with decimal=','."
            ) from None
    # instruments write the largest float where there is no value
    return np.where(np.abs(numbers) < _NO_VALUE, numbers, np.nan)


def _number(cell: Any) -> float:
    try:
        return float(cell)
    except (TypeError, ValueError):
        return float("nan")
