"""Quadrature rules that many parts of the package share."""

from __future__ import annotations

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array


@byte_cached
def gauss(nodes: int) -> tuple[Array, Array]:
    """Points on [-1, 1] and weights of Gauss-Legendre quadrature, shape (nodes,); read-only, as they are kept.

    Raises
    ------
    ValueError
        If there are so many that the rule takes minutes and gigabytes.
    """
    if nodes > 10_000:
        raise ValueError(
            f"This contact is too wide beside the thinnest layer: its integrals need {nodes:.2g} points; 10 000 are "
            "the most. Ask for a smaller contact, or check the units of thickness and contact."
        )
    points, weights = np.polynomial.legendre.leggauss(nodes)
    points.setflags(write=False)
    weights.setflags(write=False)
    return points, weights
