"""Columns of measured files: which is which, in which unit, and what is wrong with them."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flatpunch._support.checks import Array, shown
from flatpunch.files import units
from flatpunch.fit.measured.calibration import PRINTED, SIGNALS, Constants, ratio_of, signal_size
from flatpunch.fit.measured.curve import FEWEST, CurveError

if TYPE_CHECKING:
    pass

STIFFNESS = units.Dimension("stiffness", "N/m", "120 N/m", ("N/m", "mN/nm", "uN/nm", "N/mm", "mN/um"))
TIME = units.Dimension("time", "s", "0.5 s", ("s", "ms", "min", "us"))

ROLES: dict[str, tuple[units.Dimension, tuple[str, ...]]] = {
    "depth": (
        units.LENGTH,
        (
            r"^depth$|^indentation( depth)?$|^h$|^pd$",
            r"(displacement|disp\b).*(surface|sample)|tip.*position|indentation|indent.*disp",
            r"\bdepth\b|displacement|\bdispl?\b|\bsep(aration)?\b",
        ),
    ),
    "force": (
        units.FORCE,
        (r"^force$|^load$|^[fFpP]$|^fn$", r"(load|force).*sample|indent.*(load|force)", r"\bforce\b|\bload\b"),
    ),
    "piezo": (
        units.LENGTH,
        (
            r"^piezo$|^z$|^zsnsr$",
            r"(gauge|sensor|measured) ?height|height.*(sensor|measured)",
            r"\bpiezo\b|\bheight\b|\bz\b",
            r"\bextension\b|\bramp\b",
        ),
    ),
    "deflection": (units.LENGTH, (r"deflection|\bdefl\b|cantilever",)),
    "stiffness": (STIFFNESS, (r"^stiffness$|contact stiffness", r"stiffness")),
    "time": (TIME, (r"^series ?time$", r"^time$|^t$", r"\btime\b")),
}
"""What a column can be: its dimension, and how its name is recognised, the surest patterns first."""
_DERIVED = re.compile(
    r"\bamp|amplitude|contact depth|\bact\b|actuat|\braw\b|\brate\b|noise|\bstd|error|phase|hardness|modulus|correction|drift"
    r"|^h ?deflection|lateral|horizontal|\blsb\b|^smoothed|\bmax(imum)?\b|\btarget\b|\bmean\b|\baverage|\bavg\b"
)
"""Columns that are derived from others, of the machine, or of results: no depth and no force along a test."""

_ERROR = re.compile(r"\bdefl(ection)? error\b")
"""The deflection itself in instruments whose loop holds it."""

_BY_UNIT = {"force": re.compile(r"deflection|\bdefl\b")}
"""Names of columns that have a role if their unit is of its kind: a deflection in newtons is a force."""

_SEGMENT = re.compile(r"^(segment|seg) ?(number|no|index|name|type|id)?$")

_UNIT = re.compile(r"^(.*?)\s*(?:\(([^()]*)\)|\[([^\[\]]*)\]|/\s*([^/\s]+)|,\s*(\S+))\s*$")
_NO_VALUE = 1e300
"""Numbers of this size or larger mark a value that was not measured."""
_COMMA = re.compile(r"\s*[+-]?\d+,\d+(?:[eE][+-]?\d+)?\s*")


@dataclass(frozen=True)
class Table:
    """Columns as they stand in a file: names, units where given, cells (text or numbers) by row."""

    source: str
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    rows: Sequence[Sequence[object]]
    first_row: int = 1
    breaks: tuple[int, ...] = ()
    """Rows before which the file has blank lines."""
    constants: Constants = field(default_factory=Constants)
    """Spring constant and sensitivity that are written above the numbers."""
    segment: Array | None = None
    """Number of the segment of each row, where the file sets segments apart."""


def split_name(title: str) -> tuple[str, str | None]:
    """Name and unit of a column's title: "Load (uN)", "force [nN]", "depth / nm", "load_uN", "Depth nm"."""
    match = _UNIT.match(title.strip())
    if match is not None:
        unit = next(group for group in match.groups()[1:] if group is not None).strip()
        return match[1].strip(), unit or None
    for mark, more in (("_", SIGNALS), (" ", ())):
        name, _, unit = title.strip().rpartition(mark)
        plain = re.sub("[µμ]", "u", unit)
        if name and any(plain in dimension.common for dimension in (*units.DIMENSIONS, STIFFNESS, TIME, *more)):
            return name.replace("_", " "), unit
    return title.strip(), None


def chosen_columns(table: Table, wanted: Mapping[str, str | int] | None) -> dict[str, int]:
    """Position of the column of each role: as named by the user, or recognised by its title.

    Raises
    ------
    CurveError
        If several columns could have a role; the message has the lines that choose one.
    """
    found: dict[str, int] = {}
    for role, title in (wanted or {}).items():
        found[role] = _named(table, role, title)
    for role in ROLES:
        if role in found:
            continue
        hits = _recognised(table, role, set(found.values()))
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


def _recognised(table: Table, role: str, taken: set[int]) -> list[int]:
    """Columns that the surest pattern finds; those whose unit is of another kind only if there is nothing else."""
    dimension, patterns = ROLES[role]
    # a capital H is a hardness
    names = [name if name == "H" else name.lower().replace("_", " ") for name in table.names]
    wrong: list[int] = []
    for pattern in patterns:
        hits = [
            i
            for i, name in enumerate(names)
            if re.search(pattern, name) and not _DERIVED.search(_ERROR.sub("", name)) and i not in taken
        ]
        right = [i for i in hits if _fits(table.units[i], dimension)]
        if right:
            return right
        wrong += hits
    by_unit = _BY_UNIT.get(role)
    right = [
        i
        for i, name in enumerate(names)
        if by_unit and by_unit.search(name) and not _DERIVED.search(name) and table.units[i] and i not in taken
    ]
    return [i for i in right if _fits(table.units[i], dimension)] or wrong[:1]


def names_a_curve(titles: Iterable[tuple[str, str | None]]) -> bool:
    """Whether columns, by name and unit, are a force or deflection and a position."""
    names, found = zip(*titles, strict=True)
    table = Table("", names, found, ())
    has = {role for role in ROLES if _recognised(table, role, set())}
    return bool(has & {"force", "deflection"} and has & {"depth", "piezo"})


def _fits(unit: str | None, dimension: units.Dimension) -> bool:
    if unit is None:
        return True
    try:
        units.to_si(f"1 {unit}", dimension)
    except ValueError:
        return False
    return True


def check_title(role: str, title: object) -> None:
    """Refuse what names no column."""
    if not isinstance(title, (str, int)) or isinstance(title, bool):
        raise CurveError(f"columns: {shown(title)} for {role} must be a title or the number of a column, from 0.")


def _named(table: Table, role: str, title: str | int) -> int:
    check_title(role, title)
    known = ", ".join(repr(name) for name in table.names) or "none"
    if isinstance(title, int):
        if not 0 <= title < len(table.names):
            raise CurveError(f"{table.source}: column {title} for {role} does not exist; there are {len(table.names)}.")
        return title
    meant = {part.lower().replace("_", " ") for part in (title, split_name(title)[0])}
    for i, name in enumerate(table.names):
        if name.lower().replace("_", " ") in meant:
            return i
    near = difflib.get_close_matches(title, table.names, n=1, cutoff=0.5)
    advice = f" Did you mean {near[0]!r}?" if near else ""
    raise CurveError(f"{table.source}: there is no column {shown(title)} for {role}; there are {known}.{advice}")


def in_si(
    table: Table, role: str, index: int, given: Mapping[str, str] | None, sensitivity: float | None = None
) -> Array:
    """One column in SI units; empty cells and text that is no number become NaN.

    A deflection may be a signal [V, A], which the sensitivity [m/V, m/A] makes a length.
    """
    dimension = ROLES[role][0]
    unit = (given or {}).get(role) or table.units[index]
    name = table.names[index]
    if unit is None:
        usual = dimension.common[-2 if len(dimension.common) > 4 else 0]
        raise CurveError(
            f"{table.source}: column {name!r} ({role}) has no unit. Write it into the header, '{name} ({usual})', or into the "
            f'case file, [curve.units] {role} = "{usual}" (Python: units={{{role!r}: {usual!r}}}).'
        )
    if role == "deflection" and (signal := signal_size(unit)) is not None:
        if sensitivity is None:
            raise CurveError(
                f"{table.source}: column {name!r} (deflection) is a signal ({unit}); a length needs the sensitivity. Write "
                f'[curve] sensitivity = "70 nm/{unit}" into the case file (Python: sensitivity=... [m/V] or [m/A]).'
            )
        return sensitivity * signal * column_numbers(table, index)
    try:
        scale = units.to_si(f"1 {unit}", dimension)
    except ValueError as error:
        raise CurveError(f"{table.source}: column {name!r} ({role}) {error}") from None
    return scale * column_numbers(table, index)


def segments_of(table: Table) -> tuple[str, Array] | None:
    """Title of a column of segments, and the number of the segment of each row, from 0; None without such a column.

    Segments are runs of equal cells, whatever they are called. A column that changes all the time is none of segments.
    """
    if table.segment is not None:
        return "blocks of the file", table.segment
    for index, name in enumerate(table.names):
        if not _SEGMENT.match(name.lower().replace("_", " ")):
            continue
        cells = [str(row[index]).strip() if index < len(row) else "" for row in table.rows]
        number = np.cumsum([0, *(a != b for a, b in pairwise(cells))])
        if 0 < number[-1] <= len(cells) // FEWEST:
            return name, number.astype(float)
    return None


def is_signal(table: Table, index: int, given: Mapping[str, str] | None) -> bool:
    """Whether a column is a voltage or a current."""
    return signal_size((given or {}).get("deflection") or table.units[index] or "1") is not None


def column_numbers(table: Table, index: int) -> Array:
    """One column as it stands in the file; empty cells and text that is no number become NaN."""
    cells = [row[index] if index < len(row) else "" for row in table.rows]
    commas = [i for i, cell in enumerate(cells) if isinstance(cell, str) and _COMMA.fullmatch(cell)]
    if commas:
        raise CurveError(
            f"{table.source}: row {table.first_row + commas[0]} of column {table.names[index]!r} reads {cells[commas[0]]!r}: "
            "decimal commas. Read the file with decimal=','."
        )
    return np.array([_number(cell) for cell in cells])


def _number(cell: Any) -> float:
    try:
        number = float(cell)
    except (TypeError, ValueError):
        return float("nan")
    # instruments write the largest float where there is no value
    return number if abs(number) < _NO_VALUE else float("nan")


_RESULTS = re.compile(r"\b(results?|summary|statistics?|overview)\b")


_TESTS = re.compile(r"(test|indent|indentation|sample|site|location)( ?(no\.?|number|name|id|#))?")


def with_columns(tables: list[Table], columns: Mapping[str, str | int] | None, path: Path) -> list[Table]:
    """The tables with a column of forces, long enough to be curves; sheets of results only if there is nothing else."""
    found, reasons = [], []
    # a test that was cut off has the titles of the others, a short sheet of results has its own
    titles = {table.names for table in tables if len(table.rows) >= FEWEST}
    for table in tables:
        try:
            positions = chosen_columns(table, columns)
            if "force" in positions and {"depth", "piezo"} & set(positions) and table.names in titles:
                found.append(table)
        except CurveError as error:
            if len(tables) == 1:
                raise
            reasons.append(str(error))
    if not found and len(tables) == 1:
        return tables
    if not found:
        names = "; ".join(f"{t.source}: {', '.join(t.names)}" for t in tables) or "no table at all"
        why = " ".join(reasons) or "Name the columns with columns=...."
        raise CurveError(f"{path}: no sheet with a column of forces. Found {names}. {why}")
    return [table for table in found if not _of_results(table)] or found


def _of_results(table: Table) -> bool:
    """Whether a sheet has one row a test: by its name, or by a column that numbers or names the tests."""
    if _RESULTS.search(table.source.rpartition("sheet ")[2].lower()):
        return True
    for index, name in enumerate(table.names):
        if _TESTS.fullmatch(name.lower().strip()):
            cells = [str(row[index]) for row in table.rows if index < len(row) and row[index] not in (None, "")]
            # a number of the test beside each reading is the same all the time
            return 2 * len(set(cells)) > len(cells)
    return False


def own_constants(
    table: Table, positions: Mapping[str, int], units: Mapping[str, str] | None, given: float | None
) -> Constants:
    """Constants that a table was written with: the ratio of its forces to its deflections, or what is written above it."""
    if "force" not in positions or not is_length(table, positions, units):
        return table.constants
    ratio = ratio_of(*(in_si(table, role, positions[role], units) for role in ("force", "deflection")))
    if ratio is None:
        return table.constants
    written = table.constants.spring_constant
    for known in (written, given):
        if known is not None and abs(ratio / known - 1) < PRINTED:
            return replace(table.constants, spring_constant=known)
    why = "force over deflection in the file" + ("" if written is None else f", whose header has {written:.4g}")
    return replace(table.constants, spring_constant=ratio, origin=why)


def is_length(table: Table, positions: Mapping[str, int], units: Mapping[str, str] | None) -> bool:
    """Whether there is a column of deflections that are lengths."""
    at = positions.get("deflection")
    unit = None if at is None else (units or {}).get("deflection") or table.units[at]
    return unit is not None and at is not None and not is_signal(table, at, units)
