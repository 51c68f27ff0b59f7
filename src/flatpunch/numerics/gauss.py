"""Quadrature rules that many parts of the package share."""

from __future__ import annotations

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array


@byte_cached
def gauss(nodes: int) -> tuple[Array, Array]:
    """Points on [-1, 1] and weights of Gauss-Legendre quadrature, shape (nodes,); read-only, as they are kept."""
    points, weights = np.polynomial.legendre.leggauss(nodes)
    points.setflags(write=False)
    weights.setflags(write=False)
    return points, weights
