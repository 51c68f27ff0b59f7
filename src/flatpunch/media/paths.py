"""Numbers of a medium and a tip by their attribute paths: reading and replacing them.

"layers[0].young", "base.poisson", "layers[1].young.entries[3]" (a node of a table), "upper.layers[0].thickness" of two bodies,
"layers[1].surface_modulus" (all moduli of a graded layer at their ratios), "indenter.radius". A half-space by itself is its own
base.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, TypeVar

from flatpunch._support.paths import Plain, steps
from flatpunch.media.laws import Constant
from flatpunch.media.material import Material
from flatpunch.media.stack import Base

M = TypeVar("M")
T = TypeVar("T")

_GROUPS = {"young", "surface_modulus"}
"""Moduli that stand for all those of a material, at their ratios, where they are none of its fields."""


def value_of(medium: object, indenter: object, name: str) -> float:
    """Value of a number, SI."""
    side, way = _side(name)
    thing: Any = indenter if side == "indenter" else medium
    for step in way:
        if isinstance(step, int):
            thing = thing[step]
        else:
            thing = getattr(thing, step)
    return float(thing.value if isinstance(thing, Constant) else thing)


def with_values(medium: M, indenter: T, values: Mapping[str, float]) -> tuple[M, T]:
    """Medium and tip with some numbers replaced; those of one table or list are replaced together."""
    tree: Plain = {}
    for name, value in values.items():
        side, (*way, last) = _side(name)
        branch = tree.setdefault(side, {})
        for step in way:
            branch = branch.setdefault(step, {})
        branch[last] = float(value)
    return _replaced(medium, tree.get("medium", {})), _replaced(indenter, tree.get("indenter", {}))


def _side(name: str) -> tuple[str, list[str | int]]:
    """Whether it is a number of the tip or of the medium, and its path there."""
    way = steps(name)
    return ("indenter", way[1:]) if way[0] == "indenter" else ("medium", way)


def _replaced(thing: Any, changes: Any) -> Any:
    """A frozen object with the numbers of nested `changes` in their places."""
    if not isinstance(changes, dict):
        return Constant(changes) if isinstance(thing, Constant) else changes
    if not changes:
        return thing
    if isinstance(thing, tuple):
        entries = list(thing)
        for j, change in changes.items():
            entries[j] = _replaced(entries[j], change)
        return tuple(entries)
    if isinstance(thing, Base) and "base" in changes:
        return _replaced(thing, changes["base"])
    own = {field.name for field in dataclasses.fields(thing)}
    groups = (_GROUPS & changes.keys()) - own if isinstance(thing, Material) else set()
    found: Any = dataclasses.replace(
        thing,
        **{name: _replaced(getattr(thing, name), change) for name, change in changes.items() if name not in groups},
    )
    for group in groups:
        found = found.times(changes[group] / getattr(found, group))
    return found
