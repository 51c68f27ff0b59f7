"""Strengths of layers and interfaces, and how close stresses come to them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from flatpunch._support.checks import Array, shown
from flatpunch._support.declared import Checked, a_pressure
from flatpunch._support.readable import readable
from flatpunch.media import Stack
from flatpunch.stresses.points import principal, von_mises


@readable
@dataclass(frozen=True, slots=True)
class Strength(Checked):
    """Strengths of a layer and of the interface below it; criteria left as None are not checked.

    Parameters
    ----------
    yield_stress : float, optional
        Von Mises stress at which the layer yields [Pa].
    tensile : float, optional
        Largest principal stress at which it cracks [Pa]: rings at the rim, radial cracks at the lower face of a film.
    shear : float, optional
        Largest shear stress at which it fails [Pa].
    interface_tension, interface_shear : float, optional
        Normal tension and shear traction at which its lower face comes off what is below [Pa].

    Raises
    ------
    ValueError, TypeError
        If a value is not > 0.

    See Also
    --------
    critical_load : Takes one for each layer.

    Examples
    --------
    >>> fp.Strength(yield_stress=2e9)
    Strength(yield_stress=2e+09, tensile=None, shear=None, interface_tension=None, interface_shear=None)
    """

    yield_stress: Annotated[float | None, a_pressure("yield stress")] = None
    tensile: Annotated[float | None, a_pressure("tensile strength")] = None
    shear: Annotated[float | None, a_pressure("shear strength")] = None
    interface_tension: Annotated[float | None, a_pressure("interface, tension")] = None
    interface_shear: Annotated[float | None, a_pressure("interface, shear")] = None

    @property
    def of_bulk(self) -> bool:
        """Whether a criterion of the inside of the layer is given."""
        return any(value is not None for value in (self.yield_stress, self.tensile, self.shear))

    @property
    def of_interface(self) -> bool:
        """Whether a criterion of its lower face is given."""
        return self.interface_tension is not None or self.interface_shear is not None

    def utilisation(self, stress: Array) -> Iterator[tuple[str, Array]]:
        """Stress over strength inside the layer, kind by kind; stress of shape (6, ...)."""
        if self.yield_stress is not None:
            yield "yield", von_mises(stress) / self.yield_stress
        if self.tensile is not None or self.shear is not None:
            main = principal(stress)
            if self.tensile is not None:
                yield "tensile", main[0] / self.tensile
            if self.shear is not None:
                yield "shear", (main[0] - main[2]) / 2 / self.shear

    def interface_utilisation(self, stress: Array) -> Iterator[tuple[str, Array]]:
        """Stress over strength on the lower face, kind by kind; stress of shape (6, ...)."""
        if self.interface_tension is not None:
            yield "interface tension", stress[2] / self.interface_tension
        if self.interface_shear is not None:
            yield "interface shear", np.hypot(stress[3], stress[4]) / self.interface_shear


def checked_strengths(body: Stack, strengths: Any) -> tuple[Strength, ...]:
    """One strength for each layer and the base."""
    layers = len(body.layers)
    given: Sequence[object] = (strengths,) if isinstance(strengths, Strength) else strengths
    if not isinstance(given, (list, tuple)):
        raise TypeError(
            f"strengths = {shown(strengths)} must be a Strength, or a list of one for each layer and then the base."
        )
    for i, each in enumerate(given):
        if each is not None and not isinstance(each, Strength):
            raise TypeError(f"strengths[{i}] = {shown(each)} must be a Strength, or None where nothing is checked.")
    if len(given) > layers + 1:
        raise ValueError(
            f"strengths has {len(given)} entries for {layers} layers and a base; give at most {layers + 1}, layers from the "
            "surface down, then the base."
        )
    found = tuple(each or Strength() for each in given) + (Strength(),) * (layers + 1 - len(given))
    if found[layers].of_interface:
        raise ValueError(
            f"strengths[{layers}] belongs to the base, which has no interface below it. Give it to a layer."
        )
    if not any(each.of_bulk or each.of_interface for each in found):
        raise ValueError("strengths has nothing to check; give at least one of the values of Strength.")
    return found
