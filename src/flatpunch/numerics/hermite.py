"""Cubic between two points by values and slopes there, for many pairs of points at once."""

from __future__ import annotations

from flatpunch._support.checks import Array


def cubic_hermite(share: Array, width: Array, values: tuple[Array, Array], slopes: tuple[Array, Array]) -> Array:
    """Value at a `share` of each gap of some `width`, from the values and slopes at its two ends; all of one shape."""
    t, rest = share, 1 - share
    ends = values[0] * (1 + 2 * t) * rest**2 + values[1] * t**2 * (3 - 2 * t)
    return ends + width * (slopes[0] * t * rest**2 - slopes[1] * t**2 * rest)
