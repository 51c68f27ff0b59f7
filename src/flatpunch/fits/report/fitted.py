"""The values of a fit of one or several curves, and what follows from them at once; `FitResult` adds what is made of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array, BadValue, Flags, shown
from flatpunch.fits.least_squares.minimum import Minimum, noise_variance
from flatpunch.fits.least_squares.problem import Problem
from flatpunch.fits.measured.curve import Curve, read_lines
from flatpunch.fits.measured.signal import independent, memory_of
from flatpunch.fits.parameters.sample import OF
from flatpunch.fits.parameters.settings import Settings
from flatpunch.fits.report.table import Estimate, correlation_of
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body


@dataclass(frozen=True, eq=False, kw_only=True)
class Fitted:
    """Values, covariance and curves of a fit; see `flatpunch.fits.FitResult`."""

    problem: Problem
    minimum: Minimum
    estimates: dict[str, Estimate]
    covariance: Array
    undetermined: Array
    settings: Settings
    parts: tuple[Self, ...] = ()
    excess: tuple[tuple[float, int], ...] = ()
    notes: tuple[str, ...] = ()
    unseen: Array | None = None

    @property
    def results(self) -> tuple[Self, ...]:
        """One for each curve, with what belongs to it (`curve`, `depth`, `force`, `case`, ...); the fit itself of one curve."""
        return self.parts or (self,)

    def __getitem__(self, name: str) -> float:
        """Best value of a parameter, SI."""
        return self.estimates[name].value

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters in the order of the covariance."""
        return tuple(self.problem.names)

    @property
    def shared(self) -> tuple[str, ...]:
        """Free parameters that all curves share."""
        return tuple(name for name in self.problem.free if OF not in name)

    @property
    def values(self) -> dict[str, float]:
        """Best values of the free parameters of the case, SI."""
        return {name: self.estimates[name].value for name in self.problem.free}

    @property
    def correlation(self) -> Array:
        """Correlations as an array, shape (parameters, parameters)."""
        return correlation_of(self.covariance)

    def correlations(self) -> xr.DataArray:
        """Correlations of the estimates, shape (parameters, parameters)."""
        names = list(self.names)
        return xr.DataArray(self.correlation, {"parameter": names, "with": names}, ("parameter", "with"))

    @property
    def memory(self) -> float:
        """Correlation of neighbouring residuals; 0 for independent noise."""
        return memory_of(self.minimum.residual)

    @property
    def freedom(self) -> int:
        """Readings beyond the number of parameters, at least one."""
        return max(self.minimum.residual.size - len(self.names), 1)

    @property
    def variance(self) -> float:
        """Variance of independent residuals that would be as certain as these, which are over the noise of several curves."""
        size = self.minimum.residual.size
        alone = len(self.problem.setups) == 1
        return self.minimum.cost / self.freedom * size / max(independent(self.minimum.residual), 1.0) if alone else 1.0

    @property
    def agreement(self) -> float:
        """Probability that curves of one sample differ by their noise as much as these do; small where they do not agree."""
        from scipy.stats import f as fisher

        more = sum(count for _, count in self.excess) - len(self.problem.free)
        if not self.excess or not more:
            return 1.0
        return float(fisher.sf(sum(fall for fall, _ in self.excess) / more, more, max(self.freedom - more, 1)))

    def index(self, name: str) -> int:
        """Position of a parameter in `names`."""
        if name not in self.names:
            raise ValueError(f"{shown(name)} was not fitted; fitted were {', '.join(self.names)}.")
        return self.names.index(name)

    def _only(self, what: str) -> int:
        if self.parts:
            raise BadValue(what, "", f"belongs to each of the {len(self.parts)} curves: take it from one of `results`.")
        return 0

    @property
    def objective(self) -> Any:
        """Least-squares problem of the curve, an `Unknowns` of its kind."""
        return self.problem.parts[self._only("objective")]

    @property
    def curve(self) -> Curve:
        """The approach that was fitted."""
        return self.problem.setups[self._only("curve")].part

    @property
    def used(self) -> Flags:
        """Which points of the curve were fitted."""
        return self.problem.setups[self._only("used")].used

    @property
    def noise(self) -> float:
        """Standard deviation of the residuals [N]."""
        variance = noise_variance(self.minimum, len(self.names), self.settings.loss)[0]
        return math.sqrt(variance) * float(self.objective.frame.span)

    @property
    def read(self) -> tuple[str, ...]:
        """Where the numbers come from: file, sheet, columns with units, calibration, segment."""
        return read_lines(self.curve, int(self.used.size))

    @property
    def case(self) -> tuple[Body, Indenter]:
        """Medium and indenter with the fitted values."""
        medium, indenter = self.objective.model.case(self.values)
        return medium, indenter

    @cached_property
    def depth(self) -> Array:
        """Indentation depth at the points of the curve [m]."""
        return np.asarray(self.objective.indentation(self.curve, self.minimum.x))

    @cached_property
    def force(self) -> Array:
        """Fitted force at the points of the curve [N]."""
        return np.asarray(self.objective.over(self.curve, self.minimum.x))

    @cached_property
    def residual(self) -> Array:
        """Measured minus fitted force at the points of the curve [N]."""
        return np.asarray(self.curve.force - self.force)
