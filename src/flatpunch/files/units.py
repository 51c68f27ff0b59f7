"""Quantities with units, as people write them in case files: "1.2 um", "5 kPa", "35 deg".

Inside the package numbers are plain floats in SI; this is the only module where units have names. A quantity is a number,
then a unit expression that `pint` understands. A bare number is refused where a unit is due: it would be right only by luck.
"""

from __future__ import annotations

import difflib
import functools
import math
import re
import tokenize
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from flatpunch._support.checks import BadValue, shown
from flatpunch._support.prefixes import readable as readable
from flatpunch._support.prefixes import text as text

_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:[0-9]++\.?[0-9]*+|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(.*?)\s*", re.DOTALL)

_DECIMAL_COMMA = re.compile(r"\s*([+-]?[0-9]+),([0-9]+(?:[eE][+-]?[0-9]+)?(?:\s*[^\s0-9,].*)?)", re.DOTALL)

LONGEST = 200
"""Characters of a quantity."""

_POWERS = re.compile(r"[0-9]{3,}|\*\*.*\*\*.*\*\*")
"""Numbers in a unit that are no exponent, and towers of powers, whose evaluation may not end."""


@dataclass(frozen=True, slots=True)
class Dimension:
    """Kind of quantity: the name used in messages, the SI unit, an example, and unit names worth suggesting."""

    name: str
    unit: str
    example: str
    common: tuple[str, ...]

    @property
    def phrase(self) -> str:
        """Name with its article, for messages."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"


_LENGTHS = ("m", "cm", "mm", "um", "nm", "pm")
LENGTH = Dimension("length", "m", "1.2 um", _LENGTHS)
PRESSURE = Dimension("pressure", "Pa", "5 kPa", ("Pa", "kPa", "MPa", "GPa", "TPa", "bar", "psi"))
FORCE = Dimension("force", "N", "2.5 nN", ("N", "kN", "MN", "mN", "uN", "nN", "pN", "lbf"))
ANGLE = Dimension("angle", "rad", "35 deg", ("deg", "rad", "mrad", "degree", "radian"))
CURVATURE = Dimension("curvature", "1/m", "0.05 1/um", tuple(f"1/{unit}" for unit in _LENGTHS))
TIME = Dimension("time", "s", "0.5 s", ("s", "ms", "us", "min", "h"))
WORK_OF_ADHESION = Dimension(
    "work of adhesion", "J/m^2", "50 mJ/m^2", ("J/m^2", "mJ/m^2", "uJ/m^2", "N/m", "mN/m", "erg/cm^2")
)
STIFFNESS = Dimension("stiffness", "N/m", "50 kN/m", ("N/m", "kN/m", "MN/m", "mN/m", "N/mm", "nN/nm"))
INTERFACE = Dimension(
    "interface stiffness", "Pa/m", "20 GPa/um", ("Pa/m", "kPa/um", "MPa/um", "GPa/um", "GPa/nm", "N/m^3", "N/mm^3")
)
TENSION = Dimension("force per length", "N/m", "1 mN/m", ("N/m", "mN/m", "uN/m", "nN/um", "nN/nm", "J/m^2", "mJ/m^2"))
BENDING = Dimension("bending stiffness", "J", "0.1 aJ", ("J", "nJ", "pJ", "fJ", "aJ", "eV", "N*m"))
DIMENSIONS = (LENGTH, PRESSURE, FORCE, CURVATURE, ANGLE, TIME, WORK_OF_ADHESION, INTERFACE, TENSION, BENDING)
BY_UNIT = {dimension.unit: dimension for dimension in (*DIMENSIONS, STIFFNESS)}
"""All of them by their SI unit."""


NO_UNIT = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    KeyError,
    RecursionError,
    TypeError,
    ValueError,
    tokenize.TokenError,
)
"""What pint raises for text that is no unit: its own errors, which derive from three of these, and those of its evaluation.

Found with 120 000 random texts; a test goes on looking.
"""


@functools.cache
def registry() -> Any:
    """Return the unit registry, made on first use: importing pint takes longer than solving a case."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def named_si(name: str, value: object, dimension: Dimension) -> float:
    """`to_si` with the name of the value in its messages: "<name> = <value> ..."."""
    try:
        return to_si(value, dimension)
    except ValueError as error:
        raise BadValue(name, shown(value), f"{error}") from None


def to_si(value: object, dimension: Dimension) -> float:
    """Return a quantity, "1.2 um", as a float in SI units.

    The message of the ValueError for something else continues a sentence that starts "<field> = <value> ".
    """
    remedy = f"{dimension.phrase} such as {dimension.example!r} is needed"
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise ValueError(f"is no quantity; {remedy}, written as text with its unit.")
    if not isinstance(value, str):
        raise ValueError(f"has no unit; {remedy}, in quotation marks.")
    if len(value) > LONGEST:
        raise ValueError(f"is no quantity, with {len(value)} characters; {remedy}.")
    if with_point := decimal_point(value):
        raise ValueError(f"has a decimal comma; write {with_point!r}.")
    match = _NUMBER_AND_UNIT.fullmatch(value)
    if match is None:
        raise ValueError(f"does not start with a number; {remedy}.")
    number, unit = match[1], match[2]
    if not unit:
        raise ValueError(f"has no unit; {remedy}.")
    scale = _scale(unit, dimension)
    if isinstance(scale, str):
        raise ValueError(f"{scale}; {remedy}.")
    try:
        # in decimal arithmetic "5 um" is 5e-6 to the last bit, as if it had been written so
        result = float(Decimal(number) * scale)
    except ArithmeticError:
        result = math.inf
    if not math.isfinite(result):
        raise ValueError(f"is not finite; {remedy}.")
    return result


def decimal_point(value: str) -> str:
    """Return a text whose number has a decimal comma with a point instead, and an empty text for any other."""
    found = _DECIMAL_COMMA.fullmatch(value)
    return f"{found[1]}.{found[2]}" if found else ""


@functools.lru_cache(maxsize=1000)
def _scale(unit: str, dimension: Dimension) -> Decimal | str:
    """SI value of one `unit`, or what is wrong with it; kept, as each column of each file of a folder asks again."""
    if len(unit) > LONGEST // 2 or _POWERS.search(unit):
        return f"has the unknown unit {shown(unit)}"
    ureg = registry()
    target = ureg.parse_units(dimension.unit)
    try:
        one = ureg.parse_units(unit)
        compatible = one.dimensionality == target.dimensionality
        size = ureg.Quantity(Decimal(1), one).to(target).magnitude if compatible else 0
    except NO_UNIT:
        return f"has the unknown unit {shown(unit)}{_suggestion(unit, dimension)}"
    # An angle has no dimension for pint, and a percentage or a plain ratio would pass for one.
    if compatible and dimension is ANGLE:
        compatible = bool(re.search("radian|degree|arc|turn|grad", str(one)))
    if not compatible:
        return f"has {_dimension_name(one)}"
    return Decimal(size)


def _suggestion(unit: str, dimension: Dimension) -> str:
    names = [name for known in (dimension, *DIMENSIONS) for name in known.common]
    same_letters = [name for name in names if name.lower() == unit.lower()]
    near = same_letters or difflib.get_close_matches(unit, names, n=1, cutoff=0.5)
    return f" (did you mean {near[0]!r}?)" if near else ""


def _dimension_name(unit: Any) -> str:
    if unit.dimensionless and re.search("radian|degree", str(unit)):
        return "the dimension of an angle"
    for known in DIMENSIONS:
        if known is not ANGLE and unit.dimensionality == registry().parse_units(known.unit).dimensionality:
            return f"the dimension of {known.phrase}"
    if unit.dimensionless:
        return "no dimension"
    return f"the dimension {unit.dimensionality}"
