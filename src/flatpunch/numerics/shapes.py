"""Shapes of arrays that are broadcast to one another."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array, BadValue


def common_shape(**given: Array) -> tuple[int, ...]:
    """Return the shape of arrays broadcast to one another; the error names those that do not fit."""
    shapes = [array.shape for array in given.values()]
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        text = f"have shapes {' and '.join(map(str, shapes))}; they must be equal or broadcast to one another."
        raise BadValue(" and ".join(given), "", text) from None
