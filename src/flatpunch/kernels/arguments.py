"""Arguments of this room, checked: media as objects of the package or as plain tuples, and wave vectors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from flatpunch._support.checks import Array
    from flatpunch.media import AnyLayer, Body, Medium
    from flatpunch.numerics.chebyshev import Numbers

Tuples = tuple[Sequence[Sequence[float]], Sequence[float] | None]
"""Layers from the surface down and the base, as plain tuples."""


def body_of(medium: Body | Tuples) -> Body:
    """The body of an object or of tuples ((layer, ...), base), checked."""
    from flatpunch.compliances import compliance
    from flatpunch.media import underlying

    body = _from_tuples(medium) if isinstance(medium, (tuple, list)) else underlying(medium)
    compliance(body, membrane=True)  # refuses what is no medium
    return body


def _from_tuples(given: Any) -> Medium:
    from flatpunch.media import (
        HalfSpace,
        Layer,
        Medium,
        RigidBase,
        TransverselyIsotropicHalfSpace,
        TransverselyIsotropicLayer,
    )

    form = (
        "A medium as tuples is ((layer, ...), base): a layer is (young, poisson, thickness) or (young_in_plane, young_axial, "
        "poisson_in_plane, poisson_axial, shear, thickness), each with or without `bonded` at its end; a base is (young, "
        "poisson), five such constants, or None if it is rigid."
    )
    if len(given) != 2 or not isinstance(given[0], (tuple, list)):
        raise TypeError(f"medium has {len(given)} entries. {form}")
    layers: list[AnyLayer] = []
    for i, layer in enumerate(given[0]):
        size = len(layer) if isinstance(layer, (tuple, list)) else 0
        if size not in (3, 4, 6, 7):
            raise TypeError(f"medium: layer {i} is {layer!r}. {form}")
        layers.append(Layer(*layer) if size < 5 else TransverselyIsotropicLayer(*layer))
    base = given[1]
    if base is None:
        return Medium(layers, RigidBase())
    size = len(base) if isinstance(base, (tuple, list)) else 0
    if size not in (2, 5):
        raise TypeError(f"medium: the base is {base!r}. {form}")
    return Medium(layers, HalfSpace(*base) if size == 2 else TransverselyIsotropicHalfSpace(*base))


def wave_vectors(**given: Numbers) -> tuple[list[Array], Array]:
    """Components of wave vectors, broadcast together, and their magnitudes; both in the range of other numbers, or zero."""
    from flatpunch._support.checks import LARGEST, SMALLEST, BadValue, numbers, values
    from flatpunch.numerics.shapes import common_shape

    arrays = [numbers(name, value, "1/m") for name, value in given.items()]
    for name, array in zip(given, arrays, strict=True):
        values(name, array.ravel(), minimum=-np.inf)
    shape = common_shape(**dict(zip(given, arrays, strict=True)))
    components = [np.broadcast_to(array, shape) for array in arrays]
    magnitude = np.asarray(np.hypot(*components) if len(components) > 1 else np.abs(components[0]))
    bad = (magnitude != 0) & ~((magnitude >= SMALLEST) & (magnitude <= LARGEST))
    if bad.any():
        raise BadValue(
            " and ".join(given),
            ", ".join(f"{component[bad][0]:.6g}" for component in components),
            f"must be a wave vector of {SMALLEST:g} to {LARGEST:g} 1/m, or zero. Check the units.",
        )
    return components, magnitude


def at_zero_wave(undetermined: float, unit: str) -> float:
    """Value where a uniform traction determines none: one number, which may be NaN or infinite."""
    from flatpunch._support.checks import numbers, real

    value = numbers("undetermined", undetermined, unit)
    return float(value) if value.ndim == 0 else real("undetermined", value)
