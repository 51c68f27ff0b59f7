"""Checks of arguments that are not numbers: words, lists of objects, mappings.

Comparing or iterating over an array, a quantity or a data set raises errors of NumPy and pint, so that the type is tested first.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TypeVar

from flatpunch._support.checks import BadValue, shown

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
