"""Residuals of a force history against a viscoelastic model; derivatives by central differences.

A history cannot be cut into points of their own as a curve over depth can: what was before is remembered. It is averaged over
some hundred stretches of time, each with the weight of the readings in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.measured.curve import Curve
from flatpunch.fit.parameters.unknowns import Unknowns
from flatpunch.fit.viscoelastic.model import HistoryModel

_STEP = 1e-4
"""Parameters are of order one: central differences then err by 1e-8 of the third derivative, rounding by 1e-5 of the first."""


@dataclass(frozen=True, eq=False, kw_only=True)
class HistoryObjective(Unknowns):
    """Least-squares problem in x, see `Unknowns`.

    `depth` holds tip positions; with a `spring` it holds the positions of the cantilever's base instead, and the tip's are part
    of the answer. `once` says that positions rise once and fall once.
    """

    model: HistoryModel
    time: Array
    counts: Array
    once: bool = True

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Residuals, shape (n,), and derivatives, shape (parameters, n), both over the force range."""
        residual = self.residuals(x)
        rows = np.empty((x.size, residual.size))
        for j in range(x.size):
            ends = []
            for side in (1, -1):
                y = x.copy()
                y[j] += side * _STEP
                ends.append(self.residuals(y))
            rows[j] = (ends[0] - ends[1]) / (2 * _STEP)
        return residual, rows

    def residuals(self, x: Array) -> Array:
        """Residuals over the force range, shape (n,)."""
        residual = (self._force(x) - self.force) / self.frame[2] * np.sqrt(self.counts)
        return residual if self.weight is None else residual * self.weight

    def _force(self, x: Array) -> Array:
        theta, rest = self.split(x)
        straight = rest["baseline"] + self.background(rest, self.depth, self.speed)
        if self.spring is None:
            return np.asarray(straight + self.model.history(self.time, self.depth - rest["contact"], theta))
        # tilt and drag are read by the detector and move no tip, see `flatpunch.fit.least_squares.objective`
        piezo = self.depth - rest["contact"] - rest["baseline"] / self.spring
        depth, force = self.model.behind(
            self.time, piezo, self.spring, theta, self._before.get("depth"), once=self.once
        )
        self._before["depth"] = depth
        return np.asarray(straight + force)

    def over(self, curve: Curve, x: Array) -> Array:
        """Fitted force at all points of the curve that is shown [N]."""
        assert curve.time is not None
        return np.interp(curve.time, self.time, self._force(x))

    def indentation(self, curve: Curve, x: Array) -> Array:
        """Indentation depth at all points of the curve that is shown [m]."""
        rest = self.split(x)[1]
        inside = curve.depth - rest["contact"]
        if curve.spring_constant is None:
            return np.asarray(inside)
        moving = self.background(rest, curve.position, curve.meta.get("speed"))
        return np.asarray(inside + moving / curve.spring_constant)
