"""What classes declare: numbers, and their kinds in case files.

    radius: Annotated[float, a_length("radius", example="5 um")]

From the declaration of a number come the check of the constructor (`Checked`, `checked`), the table of case files and its entries
on the page (`arguments`), the paths in fits, sensitivities, designs and sweeps (`numbers_of`), and labels and units of pictures
and tables. Kinds are layers, bases, tips and relaxations with their constructors; a kind of one's own is one more.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import math
import re
from collections.abc import Callable, Iterator
from typing import Any, Literal, NamedTuple, ParamSpec, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from flatpunch._support.checks import BadValue, real, real_or_hint, switch, values, whole

P = ParamSpec("P")
T = TypeVar("T")


@dataclasses.dataclass(frozen=True, slots=True)
class Number:
    """Declaration of a number, or of each of a sequence of them.

    Attributes
    ----------
    what : str
        Its name in words: "radius".
    unit : str or None
        SI unit, empty for a number without dimension; None where it depends on other numbers.
    above, least, below, most : float
        Ends of the range: those that do not belong to it, and those that do.
    remedy : str
        Last sentence of the message about a value outside the range.
    outside : str
        The whole message, where it is more than the range.
    about : str
        What it is measured between, or in which formula, where a case file may give another number in its place.
    example : str
        The value that the page proposes, as case files write it.
    whole : bool
        Whether it is a whole number, which does not vary.
    varies : bool
        Whether it is a number of the body or the tip; otherwise it says how these are given.
    needed : bool
        Whether a case file must give it although the constructor has a default.
    ascending : bool
        Whether the numbers of a sequence do not fall.
    held : bool
        Of a law of depth: whether it is a value of the law, which has the unit and the range of the field that holds the law, and
        its name after that of the field; without a name of its own the law is this number alone.
    law : bool
        Whether a law of depth may stand in the place of one number; it is checked by the class that holds it.
    shared : bool
        Whether two bodies in contact must have it in common, so that it does not vary in one of them alone.
    """

    what: str
    unit: str | None = ""
    above: float = -math.inf
    least: float = -math.inf
    below: float = math.inf
    most: float = math.inf
    remedy: str = ""
    outside: str = ""
    about: str = ""
    example: str = ""
    whole: bool = False
    varies: bool = True
    needed: bool = False
    ascending: bool = False
    held: bool = False
    law: bool = False
    shared: bool = False

    @property
    def low(self) -> float:
        """Lower end of the range."""
        return max(self.above, self.least)

    @property
    def high(self) -> float:
        """Upper end of the range."""
        return min(self.below, self.most)

    @property
    def positive(self) -> bool:
        """Whether the range is all positive numbers, whose logarithms are fitted."""
        return self.low >= 0 and math.isinf(self.high)

    @property
    def slanted(self) -> bool:
        """Whether it is an angle between 0 and pi/2, of which the logarithm of the tangent is fitted."""
        return self.unit == "rad" and (self.low, self.high) == (0.0, math.pi / 2)

    def checked(self, name: str, value: object) -> float:
        """Return a value as a number in its range; the message of the error has the name, the value and the remedy."""
        if self.whole:
            return whole(name, value, int(self.least), self.remedy, most=int(self.most))
        one_sided = math.isfinite(self.low) and math.isinf(self.high)
        number = (
            real_or_hint(name, value, self._condition, self.remedy, self.converted)
            if one_sided
            else real(name, value, self.converted)
        )
        if fault := self.fault(number):
            raise BadValue(name, repr(number), fault)
        return number

    def fault(self, value: float) -> str:
        """What a value outside the range must fulfil, and the remedy; empty for one inside."""
        if self.above < value < self.below and self.least <= value <= self.most:
            return ""
        if self.outside or (math.isinf(self.low) and math.isinf(self.high)):
            return self.outside or f"must be finite. {self.remedy}"
        limits = (
            f"be finite and {self._condition}"
            if math.isinf(self.high)
            else f"lie between {self.low:g} and {self.high:g}"
        )
        return f"must {limits}. {self.remedy}"

    @property
    def _condition(self) -> str:
        return f">= {self.least:g}" if self.least > self.above else f"> {self.above:g}"

    def sequence(self, name: str, value: Any) -> tuple[float, ...]:
        """Return a sequence of values in the range."""
        found = values(name, value, minimum=-math.inf, unit=self.converted)
        inside = (found > self.above) & (found >= self.least) & (found < self.below) & (found <= self.most)
        if inside.all() and not self.whole:
            return tuple(found.tolist())
        return tuple(
            self.checked(f"{name}[{i}]" if np.ndim(value) else name, each) for i, each in enumerate(found.tolist())
        )

    @property
    def converted(self) -> str | None:
        """The unit to which quantities are converted."""
        return None if self.unit is None else self.unit.replace("^", "**") or "1"


def a_length(what: str, **more: Any) -> Number:
    """A length > 0 [m]."""
    return Number(what, "m", **{"above": 0.0, "example": "1 um", **more})


def a_pressure(what: str, **more: Any) -> Number:
    """A pressure, modulus or strength > 0 [Pa]."""
    return Number(what, "Pa", **{"above": 0.0, "example": "5 kPa", **more})


def a_time(what: str, **more: Any) -> Number:
    """A time > 0 [s]."""
    return Number(what, "s", **{"above": 0.0, "example": "0.5 s", **more})


def a_stiffness(what: str, **more: Any) -> Number:
    """A stiffness of an interface > 0 [Pa/m]."""
    return Number(what, "Pa/m", **{"above": 0.0, "example": "20 GPa/um", **more})


def a_tension(what: str, **more: Any) -> Number:
    """A force per length of a membrane >= 0 [N/m]."""
    return Number(what, "N/m", **{"least": 0.0, "example": "1 mN/m", **more})


def a_bending_stiffness(what: str, **more: Any) -> Number:
    """A bending stiffness of a membrane >= 0 [J]."""
    return Number(what, "J", **{"least": 0.0, "example": "0.1 aJ", **more})


def a_curvature(what: str, **more: Any) -> Number:
    """A curvature > 0 [1/m]."""
    return Number(what, "1/m", **{"above": 0.0, "example": "0.05 1/um", **more})


def a_ratio(what: str, **more: Any) -> Number:
    """A number without dimension."""
    return Number(what, "", **more)


def an_angle(what: str, **more: Any) -> Number:
    """An angle [rad], between 0 and pi/2 where no other range is given."""
    return Number(what, "rad", **({} if {"above", "least"} & more.keys() else _ACUTE), **more)


_ACUTE: dict[str, Any] = {"above": 0.0, "below": math.pi / 2}


def a_count(what: str, least: int, most: int, **more: Any) -> Number:
    """A whole number."""
    return Number(what, "", least=least, most=most, whole=True, varies=False, **more)


class Argument(NamedTuple):
    """An argument with a declared number, or a truth value (number None)."""

    name: str
    number: Number | None
    many: bool
    optional: bool
    default: Any
    """`inspect.Parameter.empty` for none."""


@functools.cache
def arguments(made_by: Any) -> dict[str, Argument]:
    """Declared arguments of a class or function; those of a constructor that a class defines may be declared at its fields."""
    try:
        hints = get_type_hints(made_by.__dict__.get("__init__", made_by), include_extras=True)
    except NameError:
        # a class with types of rooms that are loaded when it solves (a method of contact) declares no numbers
        return {}
    if isinstance(made_by, type):
        hints |= {name: hint for name, hint in get_type_hints(made_by, include_extras=True).items() if number_in(hint)}
    found = {}
    for name, parameter in inspect.signature(made_by).parameters.items():
        hint = hints.get(name)
        number = number_in(hint)
        if number is not None or hint is bool or hint == bool | None:
            parts = {get_origin(part) for part in _parts(hint)}
            optional = parameter.default is None or type(None) in _parts(hint)
            found[name] = Argument(name, number, tuple in parts, optional, parameter.default)
    return found


def number_of(made_by: Any, name: str) -> Number | None:
    """The declaration of an argument, if it has one."""
    argument = arguments(made_by).get(name)
    return argument and argument.number


def number_in(hint: Any) -> Number | None:
    """The declaration in an annotation, of a sequence or an optional number too."""
    notes = (note for part in _parts(hint) for note in getattr(part, "__metadata__", ()))
    return next((note for note in notes if isinstance(note, Number)), None)


def _parts(hint: Any) -> list[Any]:
    return [hint, *(each for part in get_args(hint) for each in _parts(part))]


def _checked(argument: Argument, called: str, value: object) -> object:
    if argument.optional and value is None:
        return None
    if argument.number is None:
        return switch(called, value)
    if argument.number.law:
        return value
    if argument.many and not (argument.default == () and isinstance(value, (tuple, list)) and not value):
        return argument.number.sequence(called, value)
    return () if argument.many else argument.number.checked(called, value)


class Checked:
    """A frozen dataclass whose declared numbers and truth values are checked when it is made.

    Dataclasses with slots cannot call `super()`: a base that checks more calls `Checked.__post_init__` by name.
    """

    __slots__ = ()

    def __post_init__(self) -> None:
        owner: Any = type(self)
        called: dict[str, str] = getattr(owner, "_called_", {})
        for name, argument in arguments(owner).items():
            value = _checked(argument, called.get(name, f"{owner.__name__}.{name}"), getattr(self, name))
            object.__setattr__(self, name, value)
        self._together_()

    def _together_(self) -> None:
        """Check what fields must fulfil together, and make the fields that follow from others."""


def checked(function: Callable[P, T]) -> Callable[P, T]:
    """A function that makes something, whose declared arguments are checked when it is called."""
    name = function.__qualname__.removesuffix(".__init__")
    owner = f"{name}." if "." not in name else ""
    signature = inspect.signature(function)

    @functools.wraps(function)
    def checking(*args: P.args, **kwargs: P.kwargs) -> T:
        given = signature.bind(*args, **kwargs)
        for name, argument in arguments(function).items():
            if name in given.arguments:
                given.arguments[name] = _checked(argument, f"{owner}{name}", given.arguments[name])
        return function(*given.args, **given.kwargs)

    return checking


class Place(NamedTuple):
    """One number of an object.

    Attributes
    ----------
    path : str
        Attributes on the way: "tip.radius", "directions[2]".
    value : float
        Its value [SI].
    number : Number
        Its declaration.
    owner : object
        The object whose field it is.
    """

    path: str
    value: float
    number: Number
    owner: object


def numbers_of(thing: object, path: str = "", law_of: Number | None = None) -> Iterator[Place]:
    """Yield all numbers of an object that may vary, in the order of its fields; without any declarations all its floats.

    `_declared_` of an object has declarations that depend on its kind, in the place of those of its fields.
    `law_of` declares the field that holds the object, where it is a law of depth.
    """
    if isinstance(thing, tuple):
        for i, entry in enumerate(thing):
            yield from numbers_of(entry, f"{path}[{i}]")
    if not dataclasses.is_dataclass(thing):
        return
    owner: Any = type(thing)
    known = {name: argument.number for name, argument in arguments(owner).items()} | getattr(thing, "_declared_", {})
    for field in (each for each in dataclasses.fields(thing) if each.init):
        here, value = f"{path}.{field.name}" if path else field.name, getattr(thing, field.name)
        number = known.get(field.name) if known else Number(field.name, None)
        entries = value if isinstance(value, tuple) else (value,)
        if number is None or not entries or not all(isinstance(each, float) for each in entries):
            yield from numbers_of(value, here, number or law_of)
        elif number.varies:
            if number.held and law_of is not None:
                here = here if number.what else path
                number = dataclasses.replace(law_of, what=f"{law_of.what} {number.what}".rstrip())
            places = [f"{here}[{j}]" for j in range(len(entries))] if isinstance(value, tuple) else [here]
            yield from (Place(at, each, number, thing) for at, each in zip(places, entries, strict=True))


Constructor = TypeVar("Constructor", bound=Callable[..., Any])

Section = Literal["layers", "base", "indenter", "relaxation"]
Wear = Literal["", "tilts", "wears"]


class Kind(NamedTuple):
    """How case files give a kind.

    Attributes
    ----------
    ways : tuple of callable
        Constructors; a file gives the declared arguments of one of them.
    wear : {"", "tilts", "wears"}
        Whether a tip may be tilted, or also rounded and cut off.
    """

    ways: tuple[Callable[..., Any], ...]
    wear: Wear


KINDS: dict[Section, dict[str, Kind]] = {section: {} for section in get_args(Section)}
"""Kinds of each table of case files by their names there; the usual layers have none."""


def in_case_files(
    section: Section, kind: str | None = None, *ways: str, wear: Wear = ""
) -> Callable[[Constructor], Constructor]:
    """Make a class, or a function that makes an object, a kind in case files and on the page.

    Parameters
    ----------
    section : {"layers", "base", "indenter", "relaxation"}
        Table of the case file. The fields are the declared arguments; layers have those of their lower face besides, and take
        `bonded`.
    kind : str, optional
        Its name there; by default that in Python: "afm-pyramid".
    *ways : str
        Names of its constructors, empty for the class itself, which is the only one by default.
    wear : {"", "tilts", "wears"}
        Whether a tip may be tilted, or also rounded and cut off.
    """

    def marked(made: Constructor) -> Constructor:
        name = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", made.__name__).lower() if kind is None else kind
        KINDS[section][name] = Kind(tuple(getattr(made, way) if way else made for way in ways or ("",)), wear)
        return made

    return marked
