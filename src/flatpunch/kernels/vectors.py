"""Wave vectors, checked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flatpunch._support.checks import Array
    from flatpunch.numerics.chebyshev import Numbers


def checked(**given: Numbers) -> list[Array]:
    """Components of wave vectors, broadcast together."""
    from flatpunch._support.checks import numbers

    arrays = []
    for name, value in given.items():
        array = numbers(name, value, "1/m")
        if not np.isfinite(array).all():
            raise ValueError(f"{name} has values that are not finite; wave vectors are in radians per metre.")
        arrays.append(array)
    return list(np.broadcast_arrays(*arrays))
