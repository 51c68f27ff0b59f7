"""Checks shared by everything a user constructs or calls: each message names the argument, the value and the remedy.

Every public number passes `real` (one number) or `numbers` (an array). Both take what is a real number and refuse the rest:
texts, truth values, complex numbers, times of a calendar, masked entries, NaN and infinity. Quantities with a unit (pint,
astropy, unyt: whatever has a method `to`) are converted to the SI unit of the argument, which checks their dimension. Words,
lists of objects and mappings are tested by their type first, since comparing arrays, quantities or data sets raises errors.

The largest sizes of a problem are far above what a contact needs: beyond them memory or time run out.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple, NoReturn, Protocol, TypeGuard, TypeVar

import numpy as np
from numpy.typing import NDArray

STEPS = 1_000_000
"""Largest number of steps of a curve, or times of a history: 100 MB of results without outlines."""
ANGLES = 100_000
"""Polar angles of an outline at most."""
SIDES = 100
"""Faces of a pyramid at most: beyond, it is its round limit to 2e-4, which takes a hundred times less."""
LAYERS = 2000
"""Layers of a body at most: C(k) takes time in proportion, about a second for each solved radius at this number."""
CELLS = 4096
"""Cells along a side in boundary elements at most: 16 million cells take some GB."""
FEWEST = 8
"""Cells along a side in boundary elements at least."""
POINTS = 200_000
"""Points of a sweep or of a table of the atlas at most."""
NUMBERS = 50_000_000
"""Numbers of one argument, or steps times angles of one result, at most: 400 MB."""
AT_ONCE = 2_000_000
"""Numbers of one intermediate array: larger sums are made in parts. Half or twice as many cost no time."""
INSIDE = AT_ONCE
"""Points inside a body at which fields are wanted in one call, at most: about 2 GB of arrays."""

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]


class ArrayOfNumbers(Protocol):
    """What NumPy turns into an array: an array itself, a column of a table, a variable of a data set."""

    def __array__(self) -> NDArray[Any]: ...


Values = float | Sequence[float] | ArrayOfNumbers
"""One number or several, as users give them."""

SMALLEST, LARGEST = 1e-50, 1e50
"""Range of quantities with a dimension [SI]: products of several of them, as the theory forms, stay within floating point."""

TINY = 1e-300
"""Smallest divisor: where nothing varies a quotient is zero or huge, and no error."""
ROUNDING = 1e-12
"""Relative difference that is rounding after some thousand operations; ten times as much or as little changes no result."""

_NO_NUMBERS = (bool, np.bool_, str, bytes, bytearray, complex, np.complexfloating, np.datetime64, np.timedelta64)
_PLAIN = {float, int, np.float64, np.int64, np.float32, np.int32}
SHOWN = 200
"""Characters of a value that a message repeats at most."""


class FlatpunchWarning(UserWarning):
    """A result is returned, but with a limit of the method that the user should know about.

    See Also
    --------
    indent : Its results carry the same text in `notes`.

    Examples
    --------
    >>> import warnings
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("error", fp.FlatpunchWarning)  # limits of a method as errors
    ...     curve = fp.indent(fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6), depth=1e-7)
    """


class Problem(NamedTuple):
    """A sentence about what is wrong, and the place that it is about: "layers[0].young", empty for none."""

    place: str
    text: str


class BadValue(ValueError):
    """A value that is refused: the field, its value, and the rest of the sentence with the remedy.

    Attributes
    ----------
    field : str
        As its owner names it: "depth[1]", "Layer.thickness".
    value : str
        As the message writes it; empty for a sentence about the field itself.
    text : str
        The condition and the remedy.
    """

    def __init__(self, field: str, value: str, text: str) -> None:
        # all three are arguments, so that the error can be pickled
        super().__init__(field, value, text)
        self.field, self.value, self.text = field, value, text.rstrip()

    def __str__(self) -> str:
        return self.about(self.field, self.value)

    def about(self, field: str, value: str) -> str:
        """The sentence with another name of the field, and the value as it is written there."""
        return f"{field}{f' = {value}' if value else ''}{'' if self.text.startswith(':') else ' '}{self.text}"

    @property
    def key(self) -> str:
        """The field without the class that owns it: what case files call it."""
        return re.sub(r"^[A-Z]\w*\.", "", self.field)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """The one problem, as other errors list theirs."""
        return (Problem(self.key, str(self)),)


def shown(value: object, most: int = SHOWN) -> str:
    """Return `value` as messages write it: `repr` on one line, shortened where it is long."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # integers of thousands of digits have no decimal form, and a caller's object may raise anything
        text = f"<{type(value).__name__}>"
    return text if len(text) <= most else f"{text[: most - 4]} ..."


def real(name: str, value: object, unit: str | None = None) -> float:
    """Return one real number as a finite float; a TypeError or ValueError names the argument and what is wrong.

    `unit` is the SI unit of the argument, such as "m", "Pa", "J/m**2"; "1" and "rad" are without dimension. Quantities are
    converted to it.
    """
    bare = _bare(name, value, unit)
    if isinstance(bare, (*_NO_NUMBERS, list, tuple)) or getattr(bare, "ndim", 0) > 0:
        _no_number(name, bare)
    try:
        number = float(bare)
    except OverflowError:
        raise BadValue(name, shown(bare), "must be finite: it is too large for a number.") from None
    except (TypeError, ValueError):
        _no_number(name, bare)
    if not math.isfinite(number):
        raise BadValue(name, repr(number), "must be finite.")
    if _has_dimension(unit) and number and not SMALLEST <= abs(number) <= LARGEST:
        raise BadValue(name, repr(number), _out_of_range(unit))
    return number


def positive(name: str, value: object, hint: str = "", *, unit: str | None = None) -> float:
    """Return `value` as a float > 0."""
    return _bounded(name, value, hint, unit, zero=False)


def non_negative(name: str, value: object, hint: str = "", *, unit: str | None = None) -> float:
    """Return `value` as a float >= 0."""
    return _bounded(name, value, hint, unit, zero=True)


def _bounded(name: str, value: object, hint: str, unit: str | None, *, zero: bool) -> float:
    condition = ">= 0" if zero else "> 0"
    number = real_or_hint(name, value, condition, hint, unit)
    if number < 0 or (number == 0 and not zero):
        raise BadValue(name, repr(number), f"must be finite and {condition}. {hint}")
    return number


def real_or_hint(name: str, value: object, condition: str, hint: str, unit: str | None = None) -> float:
    """Return `value` as a finite float; the message for NaN and infinity repeats the whole condition."""
    if _infinite(value):
        raise BadValue(name, repr(float(value)), f"must be finite and {condition}. {hint}")
    return real(name, value, unit)


def whole(name: str, value: object, least: int, hint: str = "", *, most: int | None = None) -> int:
    """Return `value` as a whole number, `least` or more, and `most` or less."""
    number = math.nan if _infinite(value) else real(name, value, "1")
    if not number >= least or number != int(number):
        raise BadValue(name, shown(value), f"must be a whole number of at least {least}. {hint}")
    if most is not None and number > most:
        raise BadValue(name, shown(value), f"must be a whole number of at most {most}. {hint}")
    return int(number)


def switch(name: str, value: object, hint: str = "") -> bool:
    """Return a truth value, or refuse what only resembles one."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} = {shown(value)} must be True or False. {hint}".rstrip())
    return bool(value)


def values(
    name: str,
    value: object,
    *,
    minimum: float = 0.0,
    strict: bool = False,
    unit: str | None = None,
    smallest: float = SMALLEST,
    empty: bool = False,
) -> Array:
    """Return scalars or sequences as a one-dimensional float array of finite values above `minimum`.

    The offending entry is named by its index. Entries of tables, where zero is common, may be as small as they like
    (`smallest` = 0). None at all are taken where they may be `empty`.
    """
    given = numbers(name, value, unit)
    array = np.atleast_1d(given)
    if array.ndim != 1 or (array.size == 0 and not empty):
        wanted = "it must be a number or a non-empty one-dimensional sequence."
        raise BadValue(name, "", f"has shape {array.shape}; {wanted}")
    bad = ~np.isfinite(array) | ((array <= minimum) if strict else (array < minimum))
    if bad.any():
        condition = "" if minimum == -np.inf else f" and {'>' if strict else '>='} {minimum:g}"
        raise _bad_entry(name, given, bad, f"must be finite{condition}.")
    if _has_dimension(unit):
        far = (array != 0) & ((np.abs(array) < smallest) | (np.abs(array) > LARGEST))
        if far.any():
            raise _bad_entry(name, given, far, _out_of_range(unit))
    return array


def point(name: str, value: object, unit: str) -> tuple[float, float]:
    """Return a pair of finite numbers, such as a point of the surface."""
    pair = values(name, value, minimum=-np.inf, unit=unit, smallest=0.0).tolist()
    if len(pair) != 2:
        raise BadValue(name, shown(value), f"must be a pair of two numbers, got {len(pair)}.")
    return pair[0], pair[1]


def numbers(name: str, value: object, unit: str | None = None) -> Array:
    """Return an array of any shape as floats, not checked for NaN, infinity and range."""
    bare = _bare(name, value, unit)
    if isinstance(bare, (list, tuple)):
        return _from_sequence(name, bare, unit)
    if isinstance(bare, (bytes, bytearray, memoryview)):
        _no_number(name, bare)
    try:
        array = np.asarray(bare)
    except (TypeError, ValueError, RuntimeError):  # what array libraries raise for what has no form as a NumPy array
        _no_number(name, bare)
    if array.dtype.kind == "O":
        return _from_sequence(name, list(array), unit) if array.ndim else np.array(real(name, array.item(), unit))
    if array.dtype.kind not in "fiu":
        _no_number(name, bare)
    if array.size > NUMBERS:  # before it is copied: views may be of any size
        raise BadValue(name, "", f"has shape {array.shape}: {array.size} numbers, of which {NUMBERS} are the most.")
    with np.errstate(over="ignore"):  # of extended precision; infinite is refused by the caller
        return np.array(array, dtype=float, order="C")


def _from_sequence(name: str, value: Sequence[object], unit: str | None) -> Array:
    if set(map(type, value)) <= _PLAIN:
        with suppress(OverflowError):
            return np.array(value, dtype=float)
    entries = [numbers(f"{name}[{i}]", entry, unit) for i, entry in enumerate(value)]
    if len({entry.shape for entry in entries}) > 1:
        raise BadValue(name, "", "has entries of different lengths; it must be a number, a sequence or a full table.")
    return np.array(entries, dtype=float)


def _bare(name: str, value: object, unit: str | None) -> Any:
    """`value` without mask, labels and unit, in the SI unit of the argument."""
    attributes = getattr(value, "attrs", None)
    if isinstance(attributes, Mapping) and hasattr(value, "dims") and hasattr(value, "data"):
        stated = attributes.get("units")
        if unit is not None and stated and str(stated).replace("^", "**") != unit:
            raise TypeError(f"{name} is labelled as in {shown(stated)}; it must be {_written(unit)}. Convert it first.")
        value = value.data
    if hasattr(value, "to") and any(hasattr(value, mark) for mark in ("magnitude", "units", "unit")):
        value = _converted(name, value, unit)
    # quantities and labelled arrays may hold masked ones
    if not isinstance(value, np.ma.MaskedArray):
        return value
    if masked := int(np.ma.getmaskarray(value).sum()):
        remedy = "Leave them out: values.compressed()."
        raise BadValue(name, "", f"has {masked} masked entries, which are no numbers. {remedy}")
    return np.ma.getdata(value)


def _converted(name: str, value: Any, unit: str | None) -> Any:
    """Magnitude of a quantity in the SI unit of the argument."""
    if unit is None:
        raise TypeError(f"{name} = {shown(value)} has a unit; give a plain number here, in SI units.")
    try:
        plain = value.to("" if unit == "1" else unit)
    except Exception:  # each library of units has errors of its own
        raise TypeError(
            f"{name} = {shown(value)} must be {_written(unit)} or a unit that converts to it; numbers without a unit are SI."
        ) from None
    return plain.magnitude if hasattr(plain, "magnitude") else plain.value


def _infinite(value: object) -> TypeGuard[float]:
    return isinstance(value, (float, np.floating)) and not math.isfinite(value)


def _no_number(name: str, value: object) -> NoReturn:
    raise TypeError(
        f"{name} = {shown(value)} must be a number, got {type(value).__name__}. Plain numbers are in SI units: convert to SI "
        "first, or give the text with its unit in a case file."
    ) from None


def _has_dimension(unit: str | None) -> bool:
    return unit not in (None, "1", "rad")


def _written(unit: str) -> str:
    return "without dimension" if unit == "1" else f"in {unit.replace('**', '^')}"


def _out_of_range(unit: str | None) -> str:
    return (
        f"must lie between {SMALLEST:g} and {LARGEST:g} {(unit or '').replace('**', '^')} in size: beyond that the numbers of a "
        "contact overflow. Check the units."
    )


def _bad_entry(name: str, given: Array, bad: Flags, text: str) -> BadValue:
    i = int(np.argmax(bad))
    return BadValue(f"{name}[{i}]" if given.ndim else name, repr(float(given.ravel()[i])), text)


@contextmanager
def refused_overflow() -> Iterator[None]:
    """Turn over- and underflows, and arrays beyond the memory, into a ValueError with the remedy; usable as a decorator."""
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except MemoryError as error:
        raise ValueError(
            f"There is not enough memory for this case{f' ({error})' * bool(str(error))}. Take fewer steps, angles, cells or "
            "points at once."
        ) from error
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise ValueError(
            "The numbers of this case overflow, or differ by more than can be computed: moduli, lengths, or the depth against "
            "the tip. Check the units."
        ) from error


Word = TypeVar("Word", bound=str)
Kind = TypeVar("Kind")


def follows(value: object, *kinds: type) -> bool:
    """Whether a value is what its annotation says; callers need not follow it, and type checkers take it for granted."""
    return isinstance(value, kinds)


def one_of(
    name: str,
    value: Word,
    known: Collection[str],
    hint: str = "",
    *,
    wrong: str = "is unknown",
    error: type[ValueError] | None = None,
) -> Word:
    """Return a word that is among those known; else a BadValue, or `error`, lists these."""
    if not follows(value, str) or value not in known:
        wanted = BadValue(name, shown(value), f"{wrong}; it is one of {', '.join(map(repr, known))}. {hint}")
        raise wanted if error is None else error(str(wanted))
    return value


def listed(name: str, value: Kind | Sequence[Kind], kind: type[Kind], written: str) -> list[Kind]:
    """Return one object of a kind, or several, as a list; `written` is how a list of them is described."""
    if isinstance(value, kind):
        return [value]
    if not isinstance(value, Sequence) or not all(isinstance(entry, kind) for entry in value):
        raise TypeError(f"{name} = {shown(value)} must be a list of {written}.")
    return list(value)


def instance(name: str, value: object, kinds: tuple[type, ...], written: str) -> None:
    """Refuse what is none of some kinds; `written` says in words what is expected."""
    if not isinstance(value, kinds):
        raise TypeError(f"{name} = {shown(value)} must be {written}.")


def mapping(name: str, value: object, example: str) -> Mapping[str, object]:
    """Return a mapping, empty for None; a TypeError if it is something else."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise TypeError(f"{name} = {shown(value)} must be a mapping, such as {example}.")
    return value
