"""One relaxation for each layer and the base: their checks, and the medium with other moduli."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

from flatpunch._support.checks import shown
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, Material, Medium, Prony, Stack, StandardLinearSolid

M = TypeVar("M", bound=Material)

Relaxations = tuple[Prony | None, ...]


def relaxations(medium: Stack, given: Sequence[object]) -> Relaxations:
    """One Prony series or None for each layer and the base, checked."""
    rigid = medium.base.rigid
    count = len(medium.layers) + (0 if rigid else 1)
    entries = list(given)
    if len(entries) != count:
        raise ValueError(
            f"relaxation has {len(entries)} entries for {len(medium.layers)} layers and {'a rigid' if rigid else 'an elastic'} "
            f"base; give {count}, layers from the surface down{'' if rigid else ', then the base'}, None for what is elastic."
        )
    found: list[Prony | None] = []
    for i, entry in enumerate(entries):
        if isinstance(entry, StandardLinearSolid):
            entry = entry.prony
        if entry is not None and not isinstance(entry, Prony):
            raise TypeError(
                f"relaxation[{i}] = {shown(entry)} must be a Prony series, a StandardLinearSolid or None: layers of different "
                "relaxation are solved with exponentials."
            )
        if entry is not None and medium.parts[i].varies:
            raise TypeError(
                f"relaxation[{i}] belongs to a GradedLayer, which is elastic here; give it as homogeneous layers."
            )
        found.append(entry)
    if all(entry is None for entry in found):
        raise ValueError("relaxation has no entry but None, so that nothing relaxes; leave time and relaxation out.")
    return tuple(found)


def check_each(medium: Body, indenter: Indenter, method: Any, given: Sequence[object]) -> tuple[Stack, Relaxations]:
    """The stack, and the relaxations of each layer and the base, refused where they are not solved."""
    if method is not None and method.name != "exact":
        raise ValueError("method is not chosen with one relaxation for each layer, which is solved for round tips.")
    stack = medium.single
    if not stack or not stack.layers:
        raise TypeError(
            f"relaxation is a list, which goes with a Medium: one entry for each layer and the base. medium = {shown(medium)}."
        )
    if not indenter.round:
        raise ValueError(
            f"indenter = {type(indenter).__name__} is not round, and relaxation for each layer is solved for round tips; give "
            "one relaxation of the whole, or a round tip."
        )
    return stack, relaxations(stack, given)


def with_moduli(medium: Stack, factors: Sequence[float]) -> Medium:
    """The medium with the moduli of each layer and the base multiplied."""
    layers = [_times(layer, factor) for layer, factor in zip(medium.layers, factors, strict=False)]
    base = medium.base if medium.base.rigid else _times(medium.base, factors[-1])
    return Medium(layers, base, medium.membrane)


def _times(part: M, factor: float) -> M:
    return part if factor == 1 else part.times(factor)
