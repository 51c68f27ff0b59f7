"""Functions of ln a that are costly to evaluate, sampled span by span and interpolated by splines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import scipy

from flatpunch._validation import Array

_SPANS = 6
"""Spans per decade: values cost more the larger the radius, so that a table should not reach far beyond what is asked."""
_SMOOTH = (6, 7)
_KINKED = (27, 3)
"""Nodes per span and spline degree: 1e-10 of smooth functions, 1e-6 beside the radius at which a kinked ring is reached.

Beside means within a span of it; beyond, the function is smooth again.
"""
_OVERLAP = 6
"""Nodes that a spline has beyond either end of its span, which the next one has as well."""


@dataclass(eq=False)
class LogTable:
    """Table of a vector function of ln a.

    Parameters
    ----------
    sample : callable
        Radii, shape (n,) [m] -> values, shape (n, outputs).
    reach : float
        Largest radius [m].
    kinks : tuple of float
        Radii [m] at which the function has kinks, so that splines of high degree would ring.
    """

    sample: Callable[[Array], Array]
    reach: float = float("inf")
    kinks: tuple[float, ...] = ()
    _spans: dict[int, scipy.interpolate.BSpline] = field(default_factory=dict)
    _nodes: dict[tuple[int, int], Array] = field(default_factory=dict)

    def at(self, radius: Array) -> tuple[Array, Array]:
        """Values and derivatives by ln a at radii > 0, shapes (n, outputs)."""
        x = np.log(np.minimum(radius, self.reach))
        index = np.floor(x * _SPANS / np.log(10)).astype(int)
        parts = [(index == i, self._spline(int(i))) for i in np.unique(index)]
        outputs = parts[0][1](x[:1]).shape[1]
        values, slopes = np.empty((x.size, outputs)), np.empty((x.size, outputs))
        for chosen, spline in parts:
            values[chosen], slopes[chosen] = spline(x[chosen]), spline(x[chosen], nu=1)
        return values, slopes

    def _spline(self, index: int) -> scipy.interpolate.BSpline:
        if index not in self._spans:
            count, degree = _KINKED if self._kinked(index) else _SMOOTH
            step, end = np.log(10) / (_SPANS * count), np.log(self.reach)
            last = (index + 1) * count + _OVERLAP
            if end < (last + 0.5) * step:
                last = round(end / step)
            first = min(index * count - _OVERLAP, last - 2 * _OVERLAP)
            numbers = np.arange(first, last + 1)
            # the node next to the reach is moved there
            x = np.where(np.abs(numbers * step - end) <= step / 2, end, numbers * step)
            keys = [(count, n) for n in numbers.tolist()]
            new = [i for i, key in enumerate(keys) if key not in self._nodes]
            if new:
                self._nodes.update(zip([keys[i] for i in new], self.sample(np.exp(x[new])), strict=True))
            self._spans[index] = scipy.interpolate.make_interp_spline(
                x, np.array([self._nodes[key] for key in keys]), k=degree
            )
        return self._spans[index]

    def _kinked(self, index: int) -> bool:
        """Whether a kink lies on a span or where its spline, were it a smooth one, would look beyond it."""
        beside = _OVERLAP / _SMOOTH[0]
        spans = _SPANS * np.log10(self.kinks) if self.kinks else np.empty(0)
        return bool(np.any((spans > index - beside) & (spans < index + 1 + beside)))
