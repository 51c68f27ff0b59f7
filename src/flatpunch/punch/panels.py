"""Functions of log(beta), sampled once on Chebyshev panels and kept.

Everything that a medium's flat punches say is analytic in log(beta). Panels are built when first asked for: a decade wide where
the contact is small against every length of the medium, an eighth of one where it is large, as radii cost the more the larger
they are and a panel should not reach far beyond what is asked. They are halved until the series ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.compliance import Kernel
from flatpunch.numerics.chebyshev import NODES, derivative, nodal_transform, nodes, polynomials, tail
from flatpunch.punch.matrix import RESOLVED, effective_beta

_TOLERANCE = 1e-10
_GRADED_TOLERANCE = 1e-9
"""Responses of graded media are interpolated to 2e-12, so that their derivatives, which the edges need, know 1e-10 at best."""

_SKIN_TOLERANCE = 1e-5
"""Beyond the resolved lengths, where terms leave as much of radii; forces at given depth feel its square."""

_NARROWEST = np.log(10) / 16
_UNIT = np.log(10) / 8
_HALF = 4
_WIDTHS = np.array([8, _HALF, 2, 1, _HALF])
"""Widths of panels, in units: a decade, half of one, a quarter, an eighth; beyond all resolved lengths half a decade again."""
_SKIN_NODES = 10
"""Nodes of a panel beyond the resolved lengths, where 1e-8 is enough of answers that are nearly powers of beta."""
_NODES = {8: NODES, _HALF: NODES, 2: 16, 1: 12}
"""Nodes by width: 16 and 12 leave the same on the narrow ones (1e-14 to 1e-12 of flat and edge answers)."""
_ENDS = np.array([0.1, 4.0, 12.0, 1.06 * RESOLVED])
"""Effective beta at the end of a half decade up to which panels are as wide as a decade, half of one, a quarter and an eighth."""

Sampler = Callable[[Array], Array]
"""Radii beta, shape (n,), ascending or not -> values, shape (n, outputs)."""


@dataclass(frozen=True, slots=True)
class Panel:
    """Chebyshev coefficients over log(beta) on one interval, shape (nodes, outputs), and the size of their tail."""

    low: float
    high: float
    series: Array
    error: float

    def at(self, log_beta: Array, outputs: int | None = None) -> Array:
        """Values of the first `outputs` columns (all by default), shape (n, outputs)."""
        return np.asarray(self._basis(log_beta) @ self.series[:, :outputs])

    def with_slope(self, log_beta: Array) -> Array:
        """Values and derivatives by log(beta) side by side, shape (n, 2 outputs)."""
        slopes = derivative(self.nodes) @ self.series * (2 / (self.high - self.low))
        basis = self._basis(log_beta)
        return np.hstack([basis @ self.series, basis[:, :-1] @ slopes])

    @property
    def nodes(self) -> int:
        """Number of nodes and coefficients."""
        return int(self.series.shape[0])

    def _basis(self, log_beta: Array) -> Array:
        return polynomials(self.unit(log_beta), self.nodes - 1).T

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
        unit = np.floor(logs / _UNIT).astype(int)
        width = _WIDTHS[np.searchsorted(self._bounds, unit // _HALF, side="right")]
        # 16 is more than any width: the code tells spans apart
        code = 16 * (unit // width * width) + width
        for key in np.unique(code):
            first, units = int(key) // 16, int(key) % 16
            span = (first * _UNIT, (first + units) * _UNIT)
            if span not in self._panels:
                skin = self._beyond(span[0])
                self._panels[span] = self._build(*span, _SKIN_NODES if skin else _NODES[units])
            inside, panels = code == key, self._panels[span]
            for panel in panels:
                # the ends of the span are where the code has them, not where a second comparison does
                above = inside if panel is panels[0] else inside & (logs >= panel.low)
                chosen = above if panel is panels[-1] else above & (logs < panel.high)
                if chosen.any():
                    yield panel, chosen

    @cached_property
    def _bounds(self) -> Array:
        """Half decades of log(beta) from which on panels are half a decade, a quarter and an eighth wide."""
        if self.kernel.graded:
            # radii of any size cost the same
            return np.full(4, np.inf)
        with np.errstate(divide="ignore"):
            return np.asarray(
                np.ceil(np.log(_ENDS / np.float64(effective_beta(self.kernel, 1.0))) / (_HALF * _UNIT) - 1)
            )

    def _beyond(self, log_beta: float) -> bool:
        """Whether a panel from here on is wider than the shortest length is resolved for."""
        return bool(log_beta > (self._bounds[-1] * _HALF - 0.5) * _UNIT)

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

    def _build(self, low: float, high: float, count: int) -> list[Panel]:
        series = nodal_transform(count) @ self.sample(nodes(low, high, count))
        error = self.judge(series)
        tolerance = _GRADED_TOLERANCE if self.kernel.graded else _SKIN_TOLERANCE if self._beyond(low) else _TOLERANCE
        if error > max(tolerance, self.floor(series)) and high - low > _NARROWEST:
            middle = (low + high) / 2
            return self._build(low, middle, count) + self._build(middle, high, count)
        return [Panel(low, high, series, error)]


def polynomials_on(parts: list[tuple[Panel, Indices]], logs: Array) -> Array:
    """Chebyshev polynomials at many log(beta), each of its own panel, shape (nodes, n): once for all panels, which is faster."""
    x = np.empty_like(logs)
    for panel, inside in parts:
        x[inside] = panel.unit(logs[inside])
    return polynomials(x, max((panel.nodes for panel, _ in parts), default=1) - 1)
