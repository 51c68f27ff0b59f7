"""One relaxation for each layer and the base: their checks, and the medium with other moduli."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from flatpunch._support.checks import shown
from flatpunch.indenters.profile import Indenter
from flatpunch.media import (
    Body,
    GradedLayer,
    HalfSpace,
    Layer,
    Medium,
    Prony,
    RigidBase,
    StandardLinearSolid,
    TransverselyIsotropicHalfSpace,
    TransverselyIsotropicLayer,
)
from flatpunch.media.transverse import scaled

Relaxations = tuple[Prony | None, ...]


def relaxations(medium: Medium, given: Sequence[object]) -> Relaxations:
    """One Prony series or None for each layer and the base, checked."""
    rigid = isinstance(medium.base, RigidBase)
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
        body = medium.layers[i] if i < len(medium.layers) else medium.base
        if entry is not None and isinstance(body, GradedLayer):
            raise TypeError(
                f"relaxation[{i}] belongs to a GradedLayer, which is elastic here; give it as homogeneous layers."
            )
        found.append(entry)
    if all(entry is None for entry in found):
        raise ValueError("relaxation has no entry but None, so that nothing relaxes; leave time and relaxation out.")
    return tuple(found)


def check_each(medium: Body, indenter: Indenter, method: Any, given: Sequence[object]) -> Relaxations:
    """The relaxations of each layer and the base, refused where they are not solved."""
    if method is not None and method.name != "exact":
        raise ValueError("method is not chosen with one relaxation for each layer, which is solved for round tips.")
    if not isinstance(medium, Medium):
        raise TypeError(
            f"relaxation is a list, which goes with a Medium: one entry for each layer and the base. medium = {shown(medium)}."
        )
    if not indenter.round:
        raise ValueError(
            f"indenter = {type(indenter).__name__} is not round, and relaxation for each layer is solved for round tips; give "
            "one relaxation of the whole, or a round tip."
        )
    return relaxations(medium, given)


def with_moduli(medium: Medium, factors: Sequence[float]) -> Medium:
    """The medium with the moduli of each layer and the base multiplied."""
    layers = [_times(layer, factor) for layer, factor in zip(medium.layers, factors, strict=False)]
    base = medium.base if isinstance(medium.base, RigidBase) else _times(medium.base, factors[-1])
    return Medium(layers, base)


def _times(body: Any, factor: float) -> Any:
    if factor == 1:
        return body
    if isinstance(body, (TransverselyIsotropicLayer, TransverselyIsotropicHalfSpace)):
        return scaled(body, factor)
    assert isinstance(body, (Layer, HalfSpace))
    return replace(body, young=factor * body.young)
