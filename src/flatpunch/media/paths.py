"""Numbers of a medium and a tip by their attribute paths: listing, reading and replacing them.

"layers[0].young", "base.poisson", "layers[1].young.entries[3]" (a node of a table), "upper.layers[0].thickness" of two bodies,
"layers[1].surface_modulus" (all moduli of a graded layer at their ratios), "indenter.radius". A half-space by itself is its own
base.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

from flatpunch._support.declared import Place, numbers_of
from flatpunch._support.paths import Plain, steps
from flatpunch.media.laws import Constant
from flatpunch.media.material import Material
from flatpunch.media.stack import Base, Body

M = TypeVar("M")
T = TypeVar("T")


class LayerOrBase(NamedTuple):
    """A layer or a base of a medium, and where it is.

    Attributes
    ----------
    path : str
        "layers[0]", "upper.base".
    body : int
        Which of the elastic bodies it belongs to.
    part : int
        Layer from the surface down; the base comes last.
    material : Material
        The layer or base itself.
    """

    path: str
    body: int
    part: int
    material: Material

    @property
    def places(self) -> Iterator[Place]:
        """Its numbers, but for stiffnesses of zero, where there are no springs."""
        return (each for each in numbers_of(self.material, self.path) if each.value or not each.number.positive)


class Group(NamedTuple):
    """All moduli of a layer or base, at their ratios, as one number.

    Attributes
    ----------
    place : Place
        The number: "layers[0].surface_modulus".
    members : tuple of str
        Paths of the moduli that it moves, which do not vary beside it.
    """

    place: Place
    members: tuple[str, ...]


def layers_and_bases(medium: Body) -> Iterator[LayerOrBase]:
    """Yield all layers and bases that deform, upper body first, from the surface down."""
    for index, (name, body) in enumerate(side for side in medium.sides if not side[1].rigid):
        prefix = f"{name}." if name else ""
        names = [*(f"layers[{i}]" for i in range(len(body.layers))), "base"]
        for i, part in enumerate(body.parts):
            if not part.rigid:
                yield LayerOrBase(f"{prefix}{names[i]}", index, i, part)


def numbers(medium: Body, indenter: object = None) -> list[Place]:
    """All numbers of a medium and a tip with their declarations, each by itself; what two bodies share varies in neither."""
    if medium.free:
        found = list(numbers_of(medium))
    else:
        found = [place for part in layers_and_bases(medium) for place in part.places]
    if len(medium.elastic) > 1:
        found = [each for each in found if not each.number.shared]
    return found + list(numbers_of(indenter, "indenter"))


def groups(medium: Body) -> list[Group]:
    """Moduli that vary together, of the layers and bases that have such a number beside their own."""
    found = []
    for path, _, _, material in () if medium.free else layers_and_bases(medium):
        name, number = material.group
        if name not in _own(material):
            members = tuple(each.path for each in numbers_of(material, path) if each.number.unit == "Pa")
            place = Place(f"{path}.{name}", float(getattr(material, name)), number, material)
            found.append(Group(place, members))
    return found


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


def replaced(thing: T, way: Sequence[str | int], value: float) -> T:
    """A frozen object with another value at the end of a way of attributes and indices."""
    changes: Any = value
    for step in reversed(way):
        changes = {step: changes}
    changed: T = _replaced(thing, changes)
    return changed


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
    group = thing.group[0] if isinstance(thing, Material) else ""
    moved = group in changes and group not in _own(thing)
    inside = {
        name: _replaced(getattr(thing, name), each) for name, each in changes.items() if not moved or name != group
    }
    found: Any = dataclasses.replace(thing, **inside)
    return found.times(changes[group] / getattr(found, group)) if moved else found


def _own(thing: Any) -> set[str]:
    """Names of the fields of an object."""
    return {field.name for field in dataclasses.fields(thing)}
