"""Checks shared by everything a user constructs or calls: each message names the argument, the value and the remedy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]


class FlatpunchWarning(UserWarning):
    """A result is returned, but with a limit of the method that the user should know about."""


def real(name: str, value: Any) -> float:
    """Return `value` as a finite float, or say why it is none."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(
            f"{name} = {value!r} must be a number, got {type(value).__name__}. "
            "Inside the package numbers carry no units; convert to SI first (case files do it for you)."
        ) from None
    if not math.isfinite(number):
        raise ValueError(f"{name} = {number!r} must be finite.")
    return number


def positive(name: str, value: Any, hint: str = "") -> float:
    """Return `value` as a float > 0."""
    number = real_or_hint(name, value, "> 0", hint)
    if number <= 0:
        raise ValueError(f"{name} = {number!r} must be finite and > 0. {hint}".rstrip())
    return number


def non_negative(name: str, value: Any, hint: str = "") -> float:
    """Return `value` as a float >= 0."""
    number = real_or_hint(name, value, ">= 0", hint)
    if number < 0:
        raise ValueError(f"{name} = {number!r} must be finite and >= 0. {hint}".rstrip())
    return number


def real_or_hint(name: str, value: Any, condition: str, hint: str) -> float:
    """Return `value` as a finite float; the message of a failure repeats the whole condition."""
    try:
        return real(name, value)
    except ValueError:
        raise ValueError(f"{name} = {value!r} must be finite and {condition}. {hint}".rstrip()) from None


def whole(name: str, value: Any, least: int, hint: str = "") -> int:
    """Return `value` as a whole number, `least` or more."""
    try:
        number = real(name, value)
    except ValueError:
        number = math.nan
    if not number >= least or number != int(number):
        raise ValueError(f"{name} = {value!r} must be a whole number of at least {least}. {hint}".rstrip())
    return int(number)


def poisson_ratio(name: str, value: Any) -> float:
    """Return `value` as a Poisson ratio, -1 < value <= 0.5."""
    number = real(name, value)
    if not -1 < number <= 0.5:
        raise ValueError(
            f"{name} = {number!r} must lie in -1 < poisson <= 0.5. 0.5 is incompressible and allowed; "
            "above it an isotropic body is unstable."
        )
    return number


def values(name: str, value: Any, *, minimum: float = 0.0, strict: bool = False) -> Array:
    """Return scalars or sequences as a one-dimensional float array of finite values above `minimum`.

    The offending entry is named by its index.
    """
    try:
        array = np.atleast_1d(np.asarray(value, dtype=float))
    except (TypeError, ValueError):
        raise TypeError(f"{name} = {value!r} must be a number or a sequence of numbers in SI units.") from None
    if array.ndim != 1 or array.size == 0:
        raise ValueError(
            f"{name} has shape {array.shape}; it must be a number or a non-empty one-dimensional sequence."
        )
    bad = ~np.isfinite(array) | ((array <= minimum) if strict else (array < minimum))
    if bad.any():
        i = int(np.argmax(bad))
        label = name if np.ndim(value) == 0 else f"{name}[{i}]"
        raise ValueError(f"{label} = {float(array[i])!r} must be finite and {'>' if strict else '>='} {minimum:g}.")
    return array
