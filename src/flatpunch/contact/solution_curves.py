"""Smooth curves through boundary element solutions over x = ln d, and what they are expected to err by between these."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flatpunch._validation import Array

FEWEST = 5
"""Solutions below which leaving one out tells little, over ranges of some spacings."""
_CAUTION = 2.0
"""What is told as interpolation error over what leaving a solution out tells, which decides on more of them (catalogue)."""
_DISPUTE = 0.7
"""Error of the force over the difference between the two best curves, through five solutions: few may please one by chance."""
_SHAPE_DISPUTE = 0.4
"""The same of the outline, over what the ratios to the series change of it."""
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class ForceCurve:
    """ln F over x = ln d as the sum of a theory's (column `form` of its forces) and a smooth curve.

    `error` is its estimated error at the nodes, shape (nodes,), and `spread` that between them, shape (nodes - 1,); `other` the
    next best such curve, where there is one.
    """

    form: int
    curve: Callable[..., Array]
    error: Array
    spread: Array
    other: ForceCurve | None = None

    def dispute(self, x: Array, theory: Array) -> Array:
        """Estimated error from the difference to the other curve at x, shape (n,); `theory` has shape (n, forms)."""
        if self.other is None:
            return np.zeros_like(x)
        one, two = (part.curve(x) + theory[:, part.form] for part in (self, self.other))
        return np.asarray(_DISPUTE * min(1.0, FEWEST / self.error.size) * np.abs(one - two))


@dataclass(frozen=True, slots=True)
class ShapeCurve:
    """Logarithms of shapes over x = ln d: curves through them and through their ratios to the series, one value per column.

    `weight` is that of the latter at the nodes and `error` the estimated error there over the mean radius, shape (nodes,).
    """

    nodes: Array
    absolute: Callable[[Array], Array]
    relative: Callable[[Array], Array]
    weight: Array
    error: Array

    def blended(self, x: Array, theory: Array) -> tuple[Array, Array]:
        """Logarithms at x where the series has `theory`, shape (n, columns) each, and the error their difference tells, (n,)."""
        absolute = self.absolute(x)
        change = np.interp(x, self.nodes, self.weight)[:, None] * (self.relative(x) + theory - absolute)
        blended = absolute + change
        dispute = np.abs(change[:, 2:]) * np.exp(blended[:, 2:] - blended[:, :1])
        return blended, _SHAPE_DISPUTE * dispute.max(axis=1)


def constant(value: float, slope: float) -> Callable[..., Array]:
    """Curve through one solution; its slope counts in derivatives only, as all points are that one."""
    return lambda x, nu=0: np.full_like(x, slope if nu else value)


def standing(table: Array) -> Callable[[Array], Array]:
    """Curve through one row."""
    return lambda x: np.repeat(table, x.size, axis=0)


def error_between(nodes: Array, error: Array, x: Array, spread: Array | float = 0.0) -> Array:
    """Estimated error at points: between two solutions the worse of them counts or what is known of the gap, at one none."""
    if nodes.size == 1:
        return np.zeros_like(x)
    upper = np.clip(np.searchsorted(nodes, x), 1, nodes.size - 1)
    worse = np.maximum(
        _CAUTION * np.maximum(error[upper - 1], error[upper]), np.broadcast_to(spread, nodes.size - 1)[upper - 1]
    )
    return np.asarray(np.where(np.abs(nodes[:, None] - x).min(axis=0) < _ROUNDING, 0.0, worse))
