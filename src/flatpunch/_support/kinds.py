"""Checks of arguments that are not numbers: words, lists of objects, mappings.

Comparing or iterating over an array, a quantity or a data set raises errors of NumPy and pint, so that the type is tested first.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, TypeVar

from flatpunch._support.checks import shown

Word = TypeVar("Word", bound=str)
Kind = TypeVar("Kind")


def one_of(
    name: str,
    value: Word,
    known: Collection[str],
    hint: str = "",
    *,
    wrong: str = "is unknown",
    error: type[ValueError] = ValueError,
) -> Word:
    """Return a word that is among those known.

    Raises
    ------
    ValueError, or `error`
        With the words that are known.
    """
    if not isinstance(value, str) or value not in known:
        raise error(f"{name} = {shown(value)} {wrong}; it is one of {', '.join(map(repr, known))}. {hint}".rstrip())
    return value


def listed(name: str, value: Kind | Sequence[Kind], kind: type[Kind], written: str) -> list[Kind]:
    """Return one object of a kind, or several, as a list; `written` is how a list of them is described.

    Raises
    ------
    TypeError
        If it is no sequence, or an entry is of another kind.
    """
    if isinstance(value, kind):
        return [value]
    if not isinstance(value, Sequence) or not all(isinstance(entry, kind) for entry in value):
        raise TypeError(f"{name} = {shown(value)} must be a list of {written}.")
    return list(value)


def mapping(name: str, value: Any, example: str) -> Mapping[Any, Any]:
    """Return a mapping, empty for None.

    Raises
    ------
    TypeError
        If it is something else.
    """
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise TypeError(f"{name} = {shown(value)} must be a mapping, such as {example}.")
    return value
