"""Quadrature rules that many parts of the package share."""

from __future__ import annotations

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array

NODES = 24
"""Points on a panel: they leave 1e-10 of functions that vary over the panel, and singular beside it; half as many 1e-6, twice as
many cost time. Of stiff films over sliding or soft layers, whose responses have sharp peaks, 16 leave 1.5e-10 and 20 1e-12."""


@byte_cached
def gauss(nodes: int = NODES) -> tuple[Array, Array]:
    """Points on [-1, 1] and weights of Gauss-Legendre quadrature, shape (nodes,); read-only, as they are kept."""
    if nodes > 10_000:
        raise ValueError(
            f"This contact is too wide beside the thinnest layer: its integrals need {nodes:.2g} points; 10 000 are "
            "the most. Ask for a smaller contact, or check the units of thickness and contact."
        )
    # NumPy's rule is tested to 100 points; beyond it loses digits of the weights, and time with the cube of their number
    points, weights = np.polynomial.legendre.leggauss(nodes) if nodes <= 100 else _by_newton(nodes)
    points.setflags(write=False)
    weights.setflags(write=False)
    return points, weights


def _by_newton(nodes: int) -> tuple[Array, Array]:
    """Points and weights by Newton's method in the polar angle, which keeps the digits of both near the ends.

    It begins at Tricomi's approximation (Ann. Mat. Pura Appl. 31, 93, 1950): P_n(cos t) is almost cos((n + 1/2) t - pi/4).
    """
    half = (nodes + 1) // 2
    angle = np.pi * (np.arange(1, half + 1) - 0.25) / (nodes + 0.5)
    # the start is 2 % of a distance between points off at most, and each step squares that; the last finds the slope
    for _ in range(5):
        x = np.cos(angle)
        before, value = np.ones(half), x
        for k in range(1, nodes):
            before, value = value, ((2 * k + 1) * x * value - k * before) / (k + 1)
        slope = nodes * (x * value - before) / np.sin(angle)
        angle = angle - value / slope
    points, weights = np.cos(angle), 2 / slope**2
    if nodes % 2:
        points[-1] = 0.0
    mirrored = slice(None, nodes // 2)
    points = np.concatenate([-points[mirrored], points[::-1]])
    weights = np.concatenate([weights[mirrored], weights[::-1]])
    return points, weights * (2 / weights.sum())
