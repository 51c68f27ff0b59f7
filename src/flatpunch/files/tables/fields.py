"""What all tables of a case file share: field types that read units, unknown-field advice, and readable error messages.

Each table of the file is one pydantic model that knows how to build the object it describes. Ranges are checked by those
objects alone; here their messages are traced back to the field and to the value as it stands in the file.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, TypeVar, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    StrictBool,
    StrictInt,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic_core import ErrorDetails, PydanticCustomError

from flatpunch._support.checks import LAYERS, BadValue, Problem, shown
from flatpunch._support.messages import brief
from flatpunch._support.paths import Plain, steps
from flatpunch.files import units


class CaseError(ValueError):
    """A case file that cannot be read or does not describe a case; the message says where and what to do.

    Attributes
    ----------
    problems : tuple of (str, str)
        Place in the file and sentence of each problem; empty where the file cannot be read.

    See Also
    --------
    flatpunch.read_case : Raises it.

    Examples
    --------
    >>> from pathlib import Path
    >>> _ = Path("case.toml").write_text("title = 'no bodies'")
    >>> try:
    ...     fp.read_case("case.toml")
    ... except fp.files.CaseError as error:
    ...     print(str(error).splitlines()[0])
    case.toml: indenter is missing; it needs a table [indenter] such as kind = 'sphere', radius = '5 um'.
    """

    def __init__(self, message: str, problems: Iterable[Problem] = ()) -> None:
        super().__init__(message)
        self.problems = tuple(problems)


def _reader(dimension: units.Dimension) -> BeforeValidator:
    return BeforeValidator(lambda value: units.to_si(value, dimension))


def _number(value: object) -> float:
    if isinstance(value, str) and (with_point := units.decimal_point(value)):
        raise ValueError(f"has a decimal comma; write {with_point}, without quotation marks.")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError("must be a plain number, without quotation marks and without a unit.")
    try:
        return float(value)
    except OverflowError:
        raise ValueError("is too large for a number.") from None


def _described(dimension: units.Dimension) -> Any:
    return Field(description=f"{dimension.phrase} such as {dimension.example!r}")


Length = Annotated[float, _reader(units.LENGTH), _described(units.LENGTH)]
Pressure = Annotated[float, _reader(units.PRESSURE), _described(units.PRESSURE)]
Force = Annotated[float, _reader(units.FORCE), _described(units.FORCE)]
Angle = Annotated[float, _reader(units.ANGLE), _described(units.ANGLE)]
WorkOfAdhesion = Annotated[float, _reader(units.WORK_OF_ADHESION), _described(units.WORK_OF_ADHESION)]
Time = Annotated[float, _reader(units.TIME), _described(units.TIME)]
Number = Annotated[float, BeforeValidator(_number), Field(description="a number such as 0.3")]
Count = Annotated[StrictInt, Field(description="a whole number such as 4")]
Switch = Annotated[StrictBool, Field(description="true or false")]
OF_UNITS: dict[str, Any] = {
    "": Number,
    **{each.unit: Annotated[float, _reader(each), _described(each)] for each in units.DIMENSIONS},
}
"""Types of fields by the unit of their numbers."""


class Table(BaseModel):
    """One table of a case file."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
    section: ClassVar[str] = ""  # name of the table in the file, where `kind` chooses between several models
    describes: ClassVar[Callable[..., Any]]
    _built: Any = PrivateAttr(default=None)

    @model_validator(mode="before")
    @classmethod
    def _known_fields_only(cls, data: object) -> object:
        """Refuse unknown fields before pydantic does: here the nearest known name can be suggested."""
        if not isinstance(data, Mapping):
            raise PydanticCustomError("table", "must be a table with the fields {fields}", {"fields": cls._listed()})
        if unknown := [name for name in data if name not in cls.model_fields]:
            context = {"unknown": unknown, "known": list(cls.model_fields), "listed": cls._listed()}
            raise PydanticCustomError("unknown_fields", "unknown fields", context)
        return data

    @model_validator(mode="after")
    def _buildable(self, info: ValidationInfo) -> Table:
        folder = (info.context or {}).get("folder", Path())
        self._built = self.build(folder)
        return self

    def build(self, folder: Path) -> Any:
        """Return the object this table describes; paths in it are relative to `folder`."""
        return self.described()

    def described(self, but: Iterable[str] = ()) -> Any:
        """An object of the class `describes`, whose arguments have the names of the fields."""
        kept = [name for name in type(self).model_fields if name not in ("kind", *but)]
        return self.describes(**{name: getattr(self, name) for name in kept})

    @property
    def built(self) -> Any:
        """The object this table describes."""
        return self._built

    @classmethod
    def _listed(cls) -> str:
        return ", ".join(cls.model_fields)


AnyTable = TypeVar("AnyTable", bound=Table)


def validated(table: type[AnyTable], data: Plain, called: Path | str, **context: Any) -> AnyTable:
    """Check what a file, which messages call `called`, holds against a table.

    `context` is what the tables need to know besides: `folder`, where files named in them are looked for. A CaseError lists all
    problems found.
    """
    _check_lengths(data, called)
    try:
        return table.model_validate(data, context=context)
    except ValidationError as error:
        found = explain(error.errors(), data)
        raise CaseError(
            "\n".join(f"{called}: {line}" for each in found for line in each.text.splitlines()), found
        ) from None


def _check_lengths(data: Plain, called: Path | str) -> None:
    """Refuse lists and tables that would take minutes to be checked entry by entry."""
    found: list[tuple[str, object]] = [("", data)]
    while found:
        path, thing = found.pop()
        if isinstance(thing, (dict, list)) and len(thing) > LONGEST:
            what = "entries" if isinstance(thing, list) else "fields"
            raise CaseError(f"{called}: {path or 'the file'} has {len(thing)} {what}; at most {LONGEST} are read.")
        if isinstance(thing, list) and path == "layers" and len(thing) > LAYERS:
            raise CaseError(
                f"{called}: layers has {len(thing)} entries; at most {LAYERS} are solved. Write thin ones as one graded layer."
            )
        entries = thing.items() if isinstance(thing, dict) else enumerate(thing) if isinstance(thing, list) else ()
        found += [(_join(path, str(key)), value) for key, value in entries if isinstance(value, (dict, list))]


_TOP_LEVEL = ("title", "method", "angles", "work_of_adhesion", "range_of_action", "strength")


def explain(details: Sequence[ErrorDetails], data: object) -> list[Problem]:
    """Return pydantic's list of errors as sentences that name the field, its value in the file and the remedy."""
    # unknown fields of a table come as one entry
    each = [(entry, name) for entry in details for name in entry.get("ctx", {}).get("unknown", [""])]
    found = [_problem(entry, data, name) for entry, name in each[:_LISTED]]
    more = [Problem("", f"... and {len(each) - _LISTED} more problems.")] if len(each) > _LISTED else []
    return [*(Problem(place, brief(text)) for place, text in found), *more]


_LISTED = 10
"""Problems of one file that are listed."""

LONGEST = 100_000
"""Entries of a list, or keys of a table."""

_SHAPES = {
    "list_type": "must be a list",
    "model_attributes_type": "must be one table",
    "model_type": "must be one table",
}


def _problem(entry: ErrorDetails, data: object, unknown: str) -> Problem:
    value, kind, context = entry["input"], entry["type"], entry.get("ctx", {})
    path = _path(entry["loc"], data, missing=kind == "missing")
    if kind == "value_error":
        return _value_error(path, value, context["error"])
    if unknown:
        return _unknown(path, unknown, context["known"], context["listed"])
    if kind == "missing":
        return Problem(path, f"{path} is missing{_needed(path)}.")
    if kind == "union_tag_not_found":
        return Problem(f"{path}.kind", f"{path}.kind is missing; it is one of {_kinds(path)}.")
    if kind == "union_tag_invalid":
        known = f"{path}.kind = {shown(context['tag'])} is unknown; it is one of {context['expected_tags']}."
        return Problem(f"{path}.kind", known)
    if kind in _SHAPES:
        brackets = ("[[", "]]") if kind == "list_type" else ("[", "]")
        return Problem(path, f"{path} {_SHAPES[kind]}: write {path.join(brackets)}.")
    message = entry["msg"].replace("Input should be", "must be")
    return Problem(
        path, f"{path}: {message}." if isinstance(value, (Mapping, list)) else f"{path} = {shown(value)} {message}."
    )


def _kinds(section: str) -> str:
    name = section.split(".")[-1]
    # a tip of asperities, or one that is worn, is an indenter
    tables = [table for table in _all_tables() if table.section == {"tip": "indenter"}.get(name, name)]
    chosen = [table.model_fields["kind"] for table in tables if "kind" in table.model_fields]
    return ", ".join(repr(kind) for field in chosen for kind in get_args(field.annotation))


def _unknown(path: str, field: str, known: list[str], listed: str) -> Problem:
    full = _join(path, field)
    near = difflib.get_close_matches(field, known, n=1)
    advice = f"did you mean '{near[0]}'?" if near else f"known here: {listed}."
    if path and field in _TOP_LEVEL:
        advice = f"'{field}' belongs at the top of the file, above the first [table]."
    return Problem(full, f"{full} is no known field; {advice}")


def _value_error(path: str, value: object, error: ValueError) -> Problem:
    """What an object says of its field, in the words of the file; messages about a single value continue the sentence."""
    if not isinstance(value, (Mapping, list)):
        return Problem(path, f"{path} = {shown(value)} {error}")
    if not isinstance(error, BadValue):
        return Problem(path, f"{path}: {error}" if path else str(error))
    # the text of a formula is the value of its field
    key = "formula" if error.field == "Formula.text" else error.key
    way, written = _written(value, key)
    place, single = _join(path, way or key), isinstance(written, (str, int, float))
    known = BadValue(
        place, error.value, error.text.replace(error.field.removesuffix(error.key) or "\0", f"{path}." if path else "")
    )
    return Problem(place, known.about(place, shown(written) if single and error.value else error.value))


def _written(table: Any, key: str) -> tuple[str, object]:
    """The part of a key that a table has, "value" of "value[0]" for a single value, and what is written there."""
    way = ""
    for step in steps(key):
        if isinstance(table, Mapping) and step in table:
            way = _join(way, str(step))
        elif isinstance(table, list) and isinstance(step, int) and step < len(table):
            way += f"[{step}]"
        else:
            # an entry of a range is not written
            return (way, table) if isinstance(table, (str, int, float)) else (key if way else "", None)
        table = table[step]
    return way, table


def _needed(path: str) -> str:
    """What a missing field wants, from the description of its type in a table of its section, or wherever a table has it."""
    *_, owner, field = f".{path}".split(".")
    section = owner.partition("[")[0]
    for table in sorted(_all_tables(), key=lambda each: each.section != section):
        info = table.model_fields.get(field)
        if info is not None and info.description:
            return f"; it needs {info.description}"
    return ""


def _all_tables() -> list[type[Table]]:
    found = Table.__subclasses__()
    for table in found:  # grows on the way
        found.extend(table.__subclasses__())
    return found


def _path(location: Sequence[str | int], data: object, *, missing: bool) -> str:
    """`layers[0].thickness` from pydantic's location, without the union tags in it: those are no keys of the file."""
    path, here = "", data
    for i, step in enumerate(location):
        if isinstance(step, int):
            path += f"[{step}]"
            here = here[step] if isinstance(here, list) and step < len(here) else None
        elif isinstance(here, Mapping) and step in here:
            path, here = _join(path, step), here[step]
        elif missing and i == len(location) - 1:
            path = _join(path, step)
    return path


def _join(path: str, step: str) -> str:
    return f"{path}.{step}" if path else step
