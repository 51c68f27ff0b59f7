"""Wave vectors, checked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flatpunch._support.checks import Array
    from flatpunch.numerics.chebyshev import Numbers


def wave_vectors(**given: Numbers) -> tuple[list[Array], Array]:
    """Components of wave vectors, broadcast together, and their magnitudes; both in the range of other numbers, or zero."""
    from flatpunch._support.checks import LARGEST, SMALLEST, BadValue, numbers, values

    arrays = [numbers(name, value, "1/m") for name, value in given.items()]
    for name, array in zip(given, arrays, strict=True):
        values(name, array.ravel(), minimum=-np.inf)
    components = list(np.broadcast_arrays(*arrays))
    magnitude = np.asarray(np.hypot(*components) if len(components) > 1 else np.abs(components[0]))
    bad = (magnitude != 0) & ~((magnitude >= SMALLEST) & (magnitude <= LARGEST))
    if bad.any():
        raise BadValue(
            " and ".join(given),
            ", ".join(f"{component[bad][0]:.6g}" for component in components),
            f"must be a wave vector of {SMALLEST:g} to {LARGEST:g} 1/m, or zero. Check the units.",
        )
    return components, magnitude
