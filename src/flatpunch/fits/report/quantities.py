"""Numbers of a fit for people: their labels, units, and values in words."""

from __future__ import annotations

import re
from collections.abc import Mapping

from flatpunch._support.declared import Place
from flatpunch._support.prefixes import text
from flatpunch.fits.parameters.numbers import BESIDE, OF


def label(number: Place) -> str:
    """A number in the words of the field: "E of layer 1" for "layers[0].young"."""
    path, _, curve = number.path.partition(OF)
    if curve:
        return f"{label(number._replace(path=path))} ({curve})"
    word, (owner, _, last) = number.number.what, path.rpartition(".")
    if place := re.search(r"\[(\d+)\]$", last):
        word = f"{word} {int(place[1]) + 1}"
    side = f"{path.partition('.')[0]} " if path.startswith(("upper.", "lower.")) else ""
    if layer := re.search(r"layers\[(\d+)\]", owner):
        return f"{word} of {side}layer {int(layer[1]) + 1}"
    if owner.endswith("base"):
        return f"{word} of {side}base"
    return f"tip {word}" if path.startswith("indenter.") else word


def unit_of(number: Place) -> str:
    """SI unit, empty without one."""
    return number.number.unit or ""


def unit_in(column: str, numbers: Mapping[str, Place]) -> str:
    """SI unit of a column of a table, "" where it has none: of "layers[0].young low" that of the modulus."""
    bare = re.sub(r" (stderr|low|high)$", "", column)
    return unit_of(known) if (known := numbers.get(bare, BESIDE.get(bare))) else ""


def between(low: float | None, high: float | None, unit: str) -> str:
    """Limits as the end of a sentence; empty if both are open."""
    if low is None and high is None:
        return ""
    low_text, high_text = ("any" if limit is None else text(limit, unit) for limit in (low, high))
    return f", between {low_text} and {high_text}"


def axis_label(number: Place, unit: str) -> str:
    """Label of an axis of a number."""
    return f"{label(number)} ({unit})" if unit else label(number)
