"""Functions of log(beta), sampled once on Chebyshev panels and kept.

Everything that a medium's flat punches say is analytic in log(beta). Panels are built when first asked for, half a decade
wide (a decade where the contact is small against every length of the medium), and halved until the series ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._validation import Array, Flags, Indices
from flatpunch.compliance import Kernel
from flatpunch.punch.matrix import effective_beta

NODES = 24
"""Chebyshev nodes per panel: they leave 1e-12 of every answer for modulus ratios 1e-4 .. 1e4 (measured)."""

_TOLERANCE = 1e-10
_GRADED_TOLERANCE = 1e-9
"""Responses of graded media are interpolated to 2e-12, so that their derivatives, which the edges need, know 1e-10 at best."""

_NARROWEST = np.log(10) / 16
_WIDTH = np.log(10) / 2

Sampler = Callable[[Array], Array]
"""Radii beta, shape (n,), ascending or not -> values, shape (n, outputs)."""


def tail(series: Array) -> float:
    """Largest of the last three coefficients over the largest of all."""
    size = np.abs(series).max()
    return float(np.abs(series[-3:]).max() / size) if size > 0 else 0.0


@dataclass(frozen=True, slots=True)
class Panel:
    """Chebyshev coefficients over log(beta) on one interval, shape (NODES, outputs), and the size of their tail."""

    low: float
    high: float
    series: Array
    error: float

    def at(self, log_beta: Array, outputs: int | None = None) -> Array:
        """Values of the first `outputs` columns (all by default), shape (n, outputs)."""
        return np.asarray(polynomials(self.unit(log_beta)).T @ self.series[:, :outputs])

    def with_slope(self, log_beta: Array) -> Array:
        """Values and derivatives by log(beta) side by side, shape (n, 2 outputs)."""
        slopes = _derivative() @ self.series * (2 / (self.high - self.low))
        basis = polynomials(self.unit(log_beta)).T
        return np.hstack([basis @ self.series, basis[:, :-1] @ slopes])

    def unit(self, log_beta: Array) -> Array:
        """Coordinate in [-1, 1]."""
        return np.asarray((2 * log_beta - self.low - self.high) / (self.high - self.low))


@dataclass(eq=False)
class Panels:
    """A function of log(beta) for one medium.

    Parameters
    ----------
    kernel : Kernel
        The medium: its shortest length decides where panels may be wide.
    sample : callable
        Computes the function at the nodes of one panel.
    judge : callable
        Chebyshev coefficients, shape (NODES, outputs) -> relative size of their tail, which decides on halving.
    floor : callable
        The same -> tail that is rounding, which no halving removes.
    """

    kernel: Kernel
    sample: Sampler
    judge: Callable[[Array], float] = tail
    floor: Callable[[Array], float] = lambda series: 0.0
    _panels: dict[tuple[float, float], list[Panel]] = field(default_factory=dict)

    def over(self, logs: Array) -> Iterator[tuple[Panel, Flags]]:
        """Panels that hold the given log(beta), each with the mask of what it holds."""
        index = np.floor(logs / _WIDTH).astype(int)
        coarse = effective_beta(self.kernel, 1.0) * np.exp((index + 1) * _WIDTH) < (
            np.inf if self.kernel.graded else 0.1
        )
        start = np.where(coarse, index - index % 2, index)
        # the parity of the code tells wide panels from narrow ones
        code = 2 * start + coarse
        for key in np.unique(code):
            first, wide = int(key) // 2, bool(key % 2)
            span = (first * _WIDTH, (first + (2 if wide else 1)) * _WIDTH)
            if span not in self._panels:
                self._panels[span] = self._build(*span)
            inside = code == key
            for panel in self._panels[span]:
                chosen = inside & (logs >= panel.low) & ((logs < panel.high) | (panel.high == span[1]))
                if chosen.any():
                    yield panel, chosen

    def at(self, logs: Array) -> Array:
        """Values at log(beta), shape (n, outputs); all panels must have the same number of outputs."""
        return self._gather(logs, Panel.at)

    def with_slope(self, logs: Array) -> tuple[Array, Array]:
        """Values and derivatives by log(beta), shapes (n, outputs)."""
        both = self._gather(logs, Panel.with_slope)
        outputs = both.shape[1] // 2
        return both[:, :outputs], both[:, outputs:]

    def _gather(self, logs: Array, take: Callable[[Panel, Array], Array]) -> Array:
        result = np.empty((logs.size, 0))
        for panel, chosen in self.over(logs):
            values = take(panel, logs[chosen])
            if result.shape[1] == 0:
                result = np.empty((logs.size, values.shape[1]))
            result[chosen] = values
        return result

    def _build(self, low: float, high: float) -> list[Panel]:
        series = nodal_transform() @ self.sample(nodes(low, high))
        error = self.judge(series)
        tolerance = _GRADED_TOLERANCE if self.kernel.graded else _TOLERANCE
        if error > max(tolerance, self.floor(series)) and high - low > _NARROWEST:
            middle = (low + high) / 2
            return self._build(low, middle) + self._build(middle, high)
        return [Panel(low, high, series, error)]


def polynomials_on(parts: list[tuple[Panel, Indices]], logs: Array) -> Array:
    """Chebyshev polynomials at many log(beta), each of its own panel, shape (NODES, n): once for all panels, which is faster."""
    x = np.empty_like(logs)
    for panel, inside in parts:
        x[inside] = panel.unit(logs[inside])
    return polynomials(x)


def nodes(low: float, high: float) -> Array:
    """Radii beta at the Chebyshev nodes of an interval of log(beta), shape (NODES,)."""
    return np.asarray(np.exp((low + high) / 2 + (high - low) / 2 * _unit_nodes()))


def nodal_transform() -> Array:
    """Matrix from values at the nodes to Chebyshev coefficients."""
    transform = chebyshev.chebvander(_unit_nodes(), NODES - 1).T * 2 / NODES
    transform[0] /= 2
    return np.asarray(transform)


def log_derivative(beta: Array) -> Array:
    """Matrix from values at the nodes `beta` of a panel to derivatives by log(beta) there, shape (NODES, NODES)."""
    t = _unit_nodes()
    stretch = (t[0] - t[-1]) / np.log(beta[0] / beta[-1])
    coefficients = chebyshev.chebder(nodal_transform()) * stretch
    return np.asarray(chebyshev.chebvander(t, NODES - 2) @ coefficients)


def polynomials(x: Array, degree: int = NODES - 1) -> Array:
    """Chebyshev polynomials T_0(x) ... T_degree(x), shape (degree + 1, *x.shape)."""
    values = np.empty((degree + 1, *x.shape))
    values[0] = 1.0
    if degree:
        values[1] = x
    twice = 2 * x
    for n in range(2, degree + 1):
        np.multiply(twice, values[n - 1], out=values[n])
        values[n] -= values[n - 2]
    return values


@lru_cache(maxsize=1)
def _derivative() -> Array:
    """Matrix from Chebyshev coefficients to those of the derivative, shape (NODES - 1, NODES)."""
    return np.asarray(chebyshev.chebder(np.eye(NODES)))


def _unit_nodes() -> Array:
    return np.asarray(np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES))
