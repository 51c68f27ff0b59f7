"""What all tables of a case file share: field types that read units, unknown-field advice, and readable error messages.

Each table of the file is one pydantic model that knows how to build the object it describes. Ranges are checked by those
objects alone; here their messages are traced back to the field and to the value as it stands in the file.
"""

from __future__ import annotations

import difflib
import re
from abc import abstractmethod
from collections.abc import Mapping, Sequence
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

from flatpunch import indenters, media
from flatpunch._support.ceilings import LAYERS
from flatpunch._support.checks import brief, shown
from flatpunch.files import units


class CaseError(ValueError):
    """A case file that cannot be read or does not describe a case; the message says where and what to do.

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


def _reader(dimension: units.Dimension) -> BeforeValidator:
    return BeforeValidator(lambda value: units.to_si(value, dimension))


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError("must be a plain number, without quotation marks and without a unit.")
    try:
        return float(value)
    except OverflowError:
        raise ValueError("is too large for a number.") from None


Length = Annotated[float, _reader(units.LENGTH), Field(description="a length such as '1.2 um'")]
Pressure = Annotated[float, _reader(units.PRESSURE), Field(description="a pressure such as '5 kPa'")]
Force = Annotated[float, _reader(units.FORCE), Field(description="a force such as '2.5 nN'")]
Angle = Annotated[float, _reader(units.ANGLE), Field(description="an angle such as '35 deg'")]
Curvature = Annotated[float, _reader(units.CURVATURE), Field(description="a curvature such as '0.05 1/um'")]
Time = Annotated[float, _reader(units.TIME), Field(description="a time such as '0.5 s'")]
WorkOfAdhesion = Annotated[
    float, _reader(units.WORK_OF_ADHESION), Field(description="a work of adhesion such as '50 mJ/m^2'")
]
Number = Annotated[float, BeforeValidator(_number), Field(description="a number such as 0.3")]
Count = Annotated[StrictInt, Field(description="a whole number such as 4")]
Switch = Annotated[StrictBool, Field(description="true or false")]


class Table(BaseModel):
    """One table of a case file."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
    section: ClassVar[str] = ""  # name of the table in the file, where `kind` chooses between several models
    _built: Any = PrivateAttr(default=None)

    @model_validator(mode="before")
    @classmethod
    def _known_fields_only(cls, data: Any) -> Any:
        """Refuse unknown fields before pydantic does: here the nearest known name can be suggested."""
        if not isinstance(data, Mapping):
            raise PydanticCustomError("table", "must be a table with the fields {fields}", {"fields": cls._listed()})
        known = list(cls.model_fields)
        for name in data:
            if name not in known:
                near = difflib.get_close_matches(name, known, n=1, cutoff=0.6)
                advice = f"did you mean '{near[0]}'?" if near else f"known here: {cls._listed()}."
                raise PydanticCustomError("unknown_field", "{advice}", {"field": name, "advice": advice})
        return data

    @model_validator(mode="after")
    def _buildable(self, info: ValidationInfo) -> Table:
        folder = (info.context or {}).get("folder", Path())
        self._built = self.build(folder)
        return self

    @abstractmethod
    def build(self, folder: Path) -> Any:
        """Return the object this table describes; paths in it are relative to `folder`."""

    @property
    def built(self) -> Any:
        """The object this table describes."""
        return self._built

    @classmethod
    def _listed(cls) -> str:
        return ", ".join(cls.model_fields)


AnyTable = TypeVar("AnyTable", bound=Table)


def validated(table: type[AnyTable], data: dict[str, Any], called: Path | str, **context: Any) -> AnyTable:
    """Check what a file holds.

    Parameters
    ----------
    table : type of Table
        What it must be.
    data : dict
        What it is.
    called : path or str
        What messages call the file.
    context : dict
        What the tables need to know besides: `folder`, where files named in them are looked for.

    Raises
    ------
    CaseError
        With all problems found, one a line.
    """
    _check_lengths(data, called)
    try:
        return table.model_validate(data, context=context)
    except ValidationError as error:
        raise CaseError("\n".join(f"{called}: {line}" for line in explain(error.errors(), data).splitlines())) from None


def _check_lengths(data: dict[str, Any], called: Path | str) -> None:
    """Refuse lists and tables that would take minutes to be checked entry by entry."""
    found: list[tuple[str, Any]] = [("", data)]
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


_TOP_LEVEL = ("title", "method", "angles", "work_of_adhesion", "range_of_action")


def explain(details: Sequence[ErrorDetails], data: Any) -> str:
    """Return pydantic's list of errors as sentences that name the field, its value in the file and the remedy."""
    lines = [brief(_sentence(entry, data)) for entry in details[:_LISTED]]
    more = [f"... and {len(details) - _LISTED} more problems."] if len(details) > _LISTED else []
    return "\n".join([*lines, *more])


_LISTED = 20
"""Problems of one file that are listed."""

LONGEST = 100_000
"""Entries of a list, or keys of a table."""

_SHAPES = {
    "list_type": "must be a list",
    "model_attributes_type": "must be one table",
    "model_type": "must be one table",
}


def _sentence(entry: ErrorDetails, data: Any) -> str:
    value, kind, context = entry["input"], entry["type"], entry.get("ctx", {})
    path = _path(entry["loc"], data, missing=kind == "missing")
    if kind == "unknown_field":
        return _unknown(path, str(context["field"]), str(context["advice"]))
    if kind == "missing":
        return f"{path} is missing{_needed(str(entry['loc'][-1]))}."
    if kind == "value_error":
        return _value_error(path, value, str(context["error"]))
    if kind == "union_tag_not_found":
        return f"{path}.kind is missing; it is one of {_kinds(path)}."
    if kind == "union_tag_invalid":
        return f"{path}.kind = {shown(context['tag'])} is unknown; it is one of {context['expected_tags']}."
    if kind in _SHAPES:
        brackets = ("[[", "]]") if kind == "list_type" else ("[", "]")
        return f"{path} {_SHAPES[kind]}: write {path.join(brackets)}."
    message = entry["msg"].replace("Input should be", "must be")
    return f"{path}: {message}." if isinstance(value, (Mapping, list)) else f"{path} = {shown(value)} {message}."


def _kinds(section: str) -> str:
    tables = [table for table in _all_tables() if table.section == section.split(".")[-1]]
    chosen = [table.model_fields["kind"] for table in tables if "kind" in table.model_fields]
    return ", ".join(repr(kind) for field in chosen for kind in get_args(field.annotation))


def _unknown(path: str, field: str, advice: str) -> str:
    full = _join(path, field)
    if path and field in _TOP_LEVEL:
        advice = f"'{field}' belongs at the top of the file, above the first [table]."
    return f"{full} is no known field; {advice}"


def _value_error(path: str, value: Any, message: str) -> str:
    """Rewrite "Layer.thickness = -2e-06 must be ..." in the words of the file; other messages follow the field's value."""
    match = re.match(r"(?:\w+\.)?(\w+) = (.+?) ((?:must|has|does|is) .*)", message, re.DOTALL)
    if match and isinstance(value, Mapping):
        field, si_value, rest = match.groups()
        written = value.get(field)
        in_file = shown(written) if isinstance(written, (str, int, float)) else si_value
        return f"{_join(path, field)} = {in_file} {rest}"
    if isinstance(value, (Mapping, list)):
        message = _OF_OBJECTS.sub(lambda found: _named(path, value, found[1]), message)
        return f"{path}: {message}" if path and not message.startswith(f"{path}.") else message
    return f"{path} = {shown(value)} {message}"


_NAMES = (*indenters.__all__, *media.__all__, "Target", "Limit", "Strength")

_OF_OBJECTS = re.compile(rf"\b(?:{'|'.join(_NAMES)})\.([a-z_]+)\b")
"""Fields of objects, as their own messages name them: "RadialProfile.f"."""


def _named(path: str, value: Mapping[str, Any] | list[Any], field: str) -> str:
    """The key of the file, where the table has it under this name; the text of a formula is its value."""
    field = "formula" if field == "text" else field
    return _join(path, field) if isinstance(value, Mapping) and field in value else field


def _needed(field: str) -> str:
    """What a missing field wants, from the description of its type wherever a table has it."""
    for table in _all_tables():
        info = table.model_fields.get(field)
        if info is not None and info.description:
            return f"; it needs {info.description}"
    return ""


def _all_tables() -> list[type[Table]]:
    found = Table.__subclasses__()
    for table in found:  # grows on the way
        found.extend(table.__subclasses__())
    return found


def _path(location: Sequence[str | int], data: Any, *, missing: bool) -> str:
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
