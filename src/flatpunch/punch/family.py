"""Flat-punch answers as smooth functions of the punch radius.

The answers of `solve_round` are analytic in log(beta). They are sampled at Chebyshev nodes on panels of log(beta) that are
built when first asked for and kept with the kernel, so that a whole curve costs a few dozen small linear systems.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._validation import Array
from flatpunch.compliance import Kernel
from flatpunch.punch.basis import regular_part
from flatpunch.punch.matrix import LARGEST, Answers, effective_beta, solve_round, sufficient_terms

_NODES = 24
"""Chebyshev nodes per panel: leaves 1e-12 on half a decade (a decade below beta = 0.1) for modulus ratios 1e-4 .. 1e4."""
_TOLERANCE = 1e-10
_NARROWEST = np.log(10) / 16
_SMALLEST = 1e-12
"""beta below which every medium is its own surface's half-space to rounding."""


@dataclass(frozen=True, slots=True)
class _Panel:
    """Chebyshev coefficients over log(beta) on one interval: flat, edge and slope side by side, (_NODES, 3 terms)."""

    low: float
    high: float
    series: Array
    error: float
    lowest_pressure: float

    @property
    def terms(self) -> int:
        return int(self.series.shape[1]) // 3

    def at(self, log_beta: Array) -> Array:
        """Flat, edge and slope answers, shape (n, 3, terms)."""
        x = (2 * log_beta - self.low - self.high) / (self.high - self.low)
        return (chebyshev.chebvander(x, _NODES - 1) @ self.series).reshape(x.size, 3, self.terms)


@dataclass(eq=False)
class PunchFamily:
    """All cylindrical flat punches on one medium.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    """

    kernel: Kernel
    _panels: dict[tuple[float, float], list[_Panel]] = field(default_factory=dict)

    def at(self, beta: Array) -> Answers:
        """Answers of the unit-disc matrices at radii beta = a/l.

        Parameters
        ----------
        beta : ndarray, shape (n,)
            Punch radii in units of the medium's length, >= 0 (any value on a half-space).

        Returns
        -------
        Answers
            Arrays of shape (n, terms), padded with zeros to the largest number of terms needed.

        Raises
        ------
        ValueError
            If a radius is too large for the resolution of the thinnest layer.
        """
        live = np.flatnonzero((beta > _SMALLEST) & (not self.kernel.homogeneous))
        if not live.size:
            return _answers(_half_space(beta.size, 1))
        logs = np.log(beta[live])
        parts = self._panels_over(logs)
        result = _half_space(beta.size, max(panel.terms for panel, _ in parts))
        for panel, inside in parts:
            result[live[inside], :, : panel.terms] = panel.at(logs[inside])
        return _answers(result)

    def error(self, beta: Array) -> float:
        """Relative interpolation error of the answers over the panels that hold `beta` (from the Chebyshev tail)."""
        return max((panel.error for panel in self._touched(beta)), default=0.0)

    def lowest_pressure(self, beta: Array) -> float:
        """Smallest punch pressure times sqrt(1 - rho^2) on the panels that hold `beta`, relative to the mean; < 0 is tension."""
        return min((panel.lowest_pressure for panel in self._touched(beta)), default=1.0)

    def _touched(self, beta: Array) -> list[_Panel]:
        live = beta[(beta > _SMALLEST) & (not self.kernel.homogeneous)]
        return [panel for panel, _ in self._panels_over(np.log(live))] if live.size else []

    def _panels_over(self, logs: Array) -> list[tuple[_Panel, Array]]:
        """Panels that hold the given log(beta), each with the mask of what it holds."""
        check_resolution(self.kernel, float(np.exp(logs.max())))
        width = np.log(10) / 2
        index = np.floor(logs / width).astype(int)
        # below effective beta = 0.1 the answers are so smooth that one panel spans a decade
        coarse = effective_beta(self.kernel, 1.0) * np.exp((index + 1) * width) < 0.1
        result = []
        start = np.where(coarse, index - index % 2, index)
        # the parity of the code tells wide panels from narrow ones
        code = 2 * start + coarse
        for key in np.unique(code):
            i, wide = int(key) // 2, bool(key % 2)
            span = (i * width, (i + (2 if wide else 1)) * width)
            if span not in self._panels:
                self._panels[span] = _build(self.kernel, *span)
            inside = code == key
            for panel in self._panels[span]:
                chosen = inside & (logs >= panel.low) & ((logs < panel.high) | (panel.high == span[1]))
                if chosen.any():
                    result.append((panel, chosen))
        return result


def check_resolution(kernel: Kernel, beta: float) -> None:
    """Refuse radii so large that the thinnest layer cannot be resolved."""
    if effective_beta(kernel, beta) > LARGEST:
        raise ValueError(
            f"The contact radius {beta * kernel.length:.3g} m is {effective_beta(kernel, beta):.3g} times the shortest length "
            f"of the medium; up to {LARGEST:g} is resolved. Such a layer is a membrane: leave it out, or join it with "
            "the next one."
        )


def _half_space(size: int, terms: int) -> Array:
    """Answers of the homogeneous half-space, shape (size, 3, terms)."""
    values = np.zeros((size, 3, terms))
    values[:, 0, 0] = 1 / np.pi
    return values


def _answers(values: Array) -> Answers:
    return Answers(values[:, 0], values[:, 1], values[:, 2])


def _build(kernel: Kernel, low: float, high: float) -> list[_Panel]:
    """Sample one interval of log(beta), halving it until the Chebyshev series ends."""
    t = np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)
    beta = np.exp((low + high) / 2 + (high - low) / 2 * t)
    terms = sufficient_terms(kernel, float(np.exp(high)))
    answers = solve_round(kernel, beta, terms)
    transform = chebyshev.chebvander(t, _NODES - 1).T * 2 / _NODES
    transform[0] /= 2
    parts = [transform @ values for values in (answers.flat, answers.edge, answers.slope)]
    error = max(_tail(c) for c in parts[:2])
    if error > _TOLERANCE and high - low > _NARROWEST:
        middle = (low + high) / 2
        return _build(kernel, low, middle) + _build(kernel, middle, high)
    return [_Panel(low, high, np.hstack(parts), error, _lowest_pressure(answers, terms))]


def _tail(series: Array) -> float:
    size = np.abs(series).max()
    return float(np.abs(series[-3:]).max() / size) if size > 0 else 0.0


def _lowest_pressure(answers: Answers, terms: int) -> float:
    r = np.append(np.sin(np.linspace(0, np.pi / 2, 24)[:-1]), 1.0)
    pressure = answers.flat @ regular_part(0, terms, r) / answers.flat[:, :1]
    return float(pressure.min())


@lru_cache(maxsize=128)
def punch_family(kernel: Kernel) -> PunchFamily:
    """The family of a kernel; solutions already computed are shared."""
    return PunchFamily(kernel)
