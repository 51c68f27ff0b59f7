"""Tables of case files made of constructors: each declared argument is a field (`_support.numbers`)."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from types import GenericAlias
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, PlainValidator, ValidationInfo, create_model
from pydantic_core import PydanticCustomError

from flatpunch._support.declared import KINDS, Argument, Kind, Section, Wear, arguments
from flatpunch.files.tables import fields
from flatpunch.files.tables.fields import AnyTable, Table


class Made(Table):
    """A table whose object one of several constructors makes."""

    ways: ClassVar[tuple[Callable[..., Any], ...]] = ()
    given: ClassVar[frozenset[str]] = frozenset()
    """Fields that are arguments of the constructors; others say what is done with the object."""
    beside: ClassVar[dict[str, Any]] = {}
    """Types and defaults of fields beside those of the constructors, after the ones that are needed."""
    laws: ClassVar[dict[str, Any]] = {}
    """Types of numbers that may vary over the depth, by their unit."""

    def build(self, folder: Path) -> Any:
        """Return the object."""
        return self.made()

    def value(self, name: str) -> Any:
        """Value of a field as constructors take it."""
        return getattr(self, name)

    def made(self, **more: Any) -> Any:
        """The object, by the constructor whose arguments are given; `more` are arguments that are no fields."""
        own = own_fields(self.ways)
        given = {name for names in own for name in names if getattr(self, name) is not None}
        for way, names in zip(self.ways, own, strict=True):
            if given == set(names):
                return way(**{name: self.value(name) for name in arguments(way) if name in self.given}, **more)
        choices = [_in_words(way, names) for way, names in zip(self.ways, own, strict=True)]
        raise ValueError(f"give either {' or '.join(choices)}, and only one of the two.")

    @classmethod
    def proposed(cls) -> set[str]:
        """Fields with which the page begins where there are several constructors: those of the last one."""
        return set(own_fields(cls.ways)[-1]) if len(cls.ways) > 1 else set()


def kinds_in(section: Section, bases: Mapping[Wear, type[Made]]) -> dict[str, type[Table]]:
    """Tables of the kinds of a section, in alphabetical order; that of the usual layers has no name."""
    return {kind: _kind(kind, section, made, bases[made.wear]) for kind, made in sorted(KINDS[section].items())}


@functools.cache
def _kind(kind: str, section: Section, made: Kind, base: type[Made]) -> type[Made]:
    return table_of(kind, section, made.ways, base)


def table_of(
    kind: str, section: str, ways: Sequence[Callable[..., Any]], base: type[Made] = Made, may: Collection[str] = ()
) -> type[Made]:
    """The table of a kind, or of a section without kinds, made of its constructors; fields in `may` can be left out."""
    found = fields_of(ways, may, base.model_fields, base.laws)
    # sentences on the page are plain text
    about = (inspect.getdoc(ways[0]) or "").partition("\n")[0].replace("`", "")
    name = f"{(kind or section).title().replace('-', '')}Table"
    if kind:
        found = {"kind": (Literal[kind], ...)} | found
    needed = {name: field for name, field in found.items() if field[1] is ... or field[1].is_required()}
    of_all: dict[str, Any] = needed | base.beside | found
    table: type[Made] = create_model(name, __base__=base, __module__=__name__, __doc__=about, **of_all)
    table.section, table.ways, table.given = section, tuple(ways), frozenset(found)
    return table


def chosen(tables: Callable[[], Mapping[str, type[AnyTable]]]) -> PlainValidator:
    """Validator that reads a table by the kind that it gives; kinds that are added later are known, the usual one has no name."""

    def read(value: object, info: ValidationInfo) -> AnyTable:
        known, kind = tables(), value.get("kind") if isinstance(value, Mapping) else None
        named = [each for each in known if each]
        if "" in known and (kind is None or not named):
            kind = ""
        elif not isinstance(value, Mapping):
            raise PydanticCustomError("model_attributes_type", "must be one table")
        elif kind is None:
            raise PydanticCustomError("union_tag_not_found", "has no kind")
        if not isinstance(kind, str) or kind not in known:
            listed = ", ".join(map(repr, named))
            raise PydanticCustomError("union_tag_invalid", "is unknown", {"tag": kind, "expected_tags": listed})
        return known[kind].model_validate(value, context=info.context)

    return PlainValidator(read)


def fields_of(
    ways: Sequence[Callable[..., Any]],
    may: Collection[str] = (),
    skip: Collection[str] = (),
    laws: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Types and defaults of the fields for the declared arguments of constructors, but for those to skip; as in `table_of`."""
    common = set.intersection(*(set(arguments(way)) for way in ways))
    return {
        name: _field(argument, laws or {}, optional=name not in common or name in may)
        for way in ways
        for name, argument in arguments(way).items()
        if name not in skip
    }


def own_fields(ways: Sequence[Callable[..., Any]]) -> list[list[str]]:
    """Arguments of each constructor that not all of them have."""
    common = set.intersection(*(set(arguments(way)) for way in ways)) if ways else set()
    return [[name for name in arguments(way) if name not in common] for way in ways]


def _field(argument: Argument, laws: Mapping[str, Any], *, optional: bool) -> tuple[Any, Any]:
    number, default = argument.number, argument.default
    if number is None:
        return (fields.Switch | None, Field(default=None)) if optional else (fields.Switch, Field(default=default))
    of_units = laws if number.law else fields.OF_UNITS
    kind: Any = fields.Count if number.whole else of_units[number.unit or ""]
    about: dict[str, Any] = {}
    if argument.many:
        kind, about = GenericAlias(list, (kind,)), {"description": f"a list such as {number.example or '[...]'}"}
    if optional or argument.optional:
        return Annotated[kind | None, number], Field(default=None, **about)
    if number.needed or default is inspect.Parameter.empty:
        return Annotated[kind, number], Field(**about)
    return Annotated[kind, number], Field(default=list(default) if argument.many else default, **about)


def _in_words(way: Callable[..., Any], names: Sequence[str]) -> str:
    numbers = [number for name in names if (number := arguments(way)[name].number) is not None]
    about = ", ".join(dict.fromkeys(number.about for number in numbers if number.about))
    return " and ".join(names) + (f" ({about})" if about else "")
