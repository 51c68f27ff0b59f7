"""The values of a fit of one or several curves and what follows from them; beyond the covariance, the likelihood profile.

`FitResult` adds what is made of them. The covariance is a parabola through the minimum. It fails where two parameters trade off
along a curved valley, where a limit cuts the valley, and where the sum of squares is flat. It is believed where it is narrow;
otherwise the interval ends where the profile has grown by the threshold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import xarray as xr

from flatpunch._support.checks import ROUNDING, TINY, Array, BadValue, Flags, shown
from flatpunch._support.readable import readable
from flatpunch.fits.least_squares.minimum import ROUGH, Minimum, minimise, noise_variance
from flatpunch.fits.least_squares.problem import Problem
from flatpunch.fits.measured.curve import Curve, read_lines
from flatpunch.fits.measured.signal import independent, memory_of
from flatpunch.fits.parameters.sample import OF
from flatpunch.fits.parameters.settings import Settings
from flatpunch.fits.report.table import Estimate, correlation_of, half_width
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


_FAR = 3.0
"""Where there is no end in sight, a factor 20 of a logarithmic parameter is shown."""

_BEYOND, _INSIDE = 1.2, 0.1
"""Least factor by which a search for an end goes on, as a picture does; least share of the way that a secant takes."""

_NARROW = 0.03
"""Standard error of an internal parameter (relative, for logarithms) above which intervals come from the profile."""

_OF_NOBODY = 12.0
"""Distance of a limit, in the internal parameter, beyond which nobody set it: it ends no interval."""

_PLACES = (0.0, -1.0, -3.0)
"""Contact points that are descended from where nothing shows the tilt, in ranges of the data from their first reading."""


@readable
@dataclass(frozen=True, slots=True)
class Profile:
    """Likelihood profile of one parameter.

    Attributes
    ----------
    values : ndarray, shape (n,)
        Values of the parameter [SI], ascending.
    signed_root : ndarray, shape (n,)
        Square root of the growth of the sum of squares over its variance, negative below the best value: a straight line
        where the covariance is enough.
    low, high : float
        Interval [SI]; infinite (or a limit) where the profile does not reach the threshold.
    others : dict of str to ndarray, shape (n,)
        Best values of all other parameters at each of `values` [SI]: the valley along which they trade off.

    See Also
    --------
    flatpunch.fits.FitResult : `profile` makes it.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> depth = np.linspace(-200e-9, 400e-9, 121)
    >>> force = np.where(depth > 0, fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.maximum(depth, 1e-12)).force, 0.0)
    >>> curve = fp.Curve(depth=depth + 50e-9, force=force)
    >>> result = fp.fit(curve, gel, fp.Sphere(radius=5e-6), {"layers[0].young": fp.Free(2e3)})
    >>> profile = result.profile("layers[0].young")
    >>> print(profile.values.size == profile.signed_root.size, sorted(profile.others))
    True ['baseline', 'contact']
    """

    values: Array
    signed_root: Array
    low: float
    high: float
    others: dict[str, Array]


def profile(result: Fitted, name: str, level: float | None, points: int) -> Profile:
    """Likelihood profile; see `FitResult.profile`."""
    held = _Held(result, result.index(name), result.problem)
    ends = held.ends(half_width(level or result.settings.level, result.freedom))
    best = held.best
    reach = [e if np.isfinite(e) else best + side * _FAR for e, side in zip(ends, (-1, 1), strict=True)]
    x = best + _BEYOND * np.linspace(reach[0] - best, reach[1] - best, points)
    x = np.unique(np.clip(x, held.limits[0], held.limits[1]))
    roots, valley = [], []
    for value in x:
        roots.append(held.root(value))
        valley.append(held.warm)
    external = result.problem.external
    others = {n: external(i, np.array(valley)[:, i]) for i, n in enumerate(result.names) if n != name}
    low, high = external(held.j, np.array(ends)).tolist()
    return Profile(external(held.j, x), np.array(roots), low, high, others)


def by_profile(result: Fitted, shared: Array) -> dict[str, Estimate]:
    """Estimates with intervals by the profile, on block means, where those by the covariance do not do.

    `shared` is covariance (p, p) of errors that all readings share, such as that of the calibration; the profile does not know
    of it.
    """
    estimates, problem = dict(result.estimates), result.problem
    if result.settings.loss != "linear":
        return estimates
    errors = np.sqrt(np.diag(result.covariance))[: len(problem.free)]
    if not problem.tabulated:
        # each step of a profile would solve the contact many times: what exceeds a factor e says nothing
        unknown = [name for name, error in zip(problem.free, errors, strict=True) if not error < 1]
        return estimates | {name: replace(estimates[name], by="nothing") for name in unknown}
    cut = bool(result.minimum.at_bound.any()) or bool(len(result.undetermined)) or tilt_or_contact(result)
    # one parameter of the sample has no valley; contact and baseline are linear enough
    narrow = _NARROW * (10 if len(problem.free) == 1 else 1)
    for j, name in enumerate(problem.free):
        if not cut and errors[j] <= narrow:
            continue
        held = _Held(result, j, problem.coarse)
        reach = half_width(result.settings.level, result.freedom)
        ends = np.array(held.ends(reach))
        by = "profile" if np.isfinite(ends).any() else "nothing"
        near = np.abs(held.limits - held.best) < _OF_NOBODY
        ends = np.where(~np.isfinite(ends) & near, held.limits, ends)
        if shared[j, j] > 0:
            wider = np.hypot(ends - held.best, reach * np.sqrt(shared[j, j]))
            ends = np.clip(held.best + np.array([-1, 1]) * wider, held.limits[0], held.limits[1])
        low, high = problem.external(j, ends).tolist()
        estimates[name] = replace(estimates[name], low=low, high=high, by=by)
    return estimates


def tilt_or_contact(result: Fitted) -> bool:
    """Whether a contact that began at the first reading, over another tilt, is within the interval of the contact point.

    Then nothing shows the tilt by itself. Judged where most readings are in contact; more before it show the tilt.
    """
    problem, found = result.problem, result.minimum
    model = problem.parts[0].model
    if not {"contact", "tilt"} <= set(problem.names) or model.adhesive or model.over_time:
        return False
    objective, x = problem.parts[0], found.x.copy()
    before = objective.depth < objective.split(x)[1]["contact"]
    if not before.any() or 2 * before.sum() > before.size:
        return False
    contact = result.index("contact")
    # contacts are counted from the first reading
    x[contact] = np.clip(0.0, problem.bounds[0][contact], problem.bounds[1][contact])
    other = minimise(problem.evaluate, x, *problem.bounds, fixed=np.arange(x.size) == contact)
    return other.cost - found.cost < half_width(result.settings.level, result.freedom) ** 2 * result.variance


@dataclass(eq=False)
class _Held:
    """The sum of squares with parameter j held, all others fitted anew."""

    result: Fitted
    j: int
    problem: Problem

    def __post_init__(self) -> None:
        found = self.result.minimum
        self.best, self.warm = float(found.x[self.j]), found.x
        self.limits = np.array([limit[self.j] for limit in self.problem.bounds])
        residual = found.residual if self.problem is self.result.problem else self.problem.evaluate(found.x)[0]
        self.least = float(residual @ residual)

    def root(self, value: float) -> float:
        starts = [self.warm.copy(), *(x.copy() for x in self.minima)]
        for start in starts:
            start[self.j] = value
        fixed = np.arange(self.warm.size) == self.j
        ends = [minimise(self.problem.evaluate, x, *self.problem.bounds, fixed=fixed, settled=ROUGH) for x in starts]
        found = min(ends, key=lambda end: end.cost)
        self.warm = found.x
        growth = max(found.cost - self.least, 0.0) / max(self.result.variance, TINY)
        return float(np.copysign(np.sqrt(growth), value - self.best))

    @cached_property
    def minima(self) -> list[Array]:
        """The minimum and the best other one where nothing shows the tilt: a contact before the first reading over less of it."""
        if "contact" not in self.problem.names or not tilt_or_contact(self.result):
            return []
        ends, contact = [], self.result.index("contact")
        for place in _PLACES:
            start = self.result.minimum.x.copy()
            start[contact] = place
            ends.append(minimise(self.problem.evaluate, start, *self.problem.bounds))
        outside = [end for end in ends if end.x[contact] < 0] or ends
        return [self.result.minimum.x, min(outside, key=lambda end: end.cost).x]

    def ends(self, threshold: float) -> list[float]:
        """Ends of the interval, internal; infinite where the profile does not reach the threshold within the limits."""
        return [self._crossing(side, threshold) for side in (-1, 1)]

    def _crossing(self, side: int, threshold: float) -> float:
        """Where the profile reaches the threshold on one side, by secants."""
        best, limit = self.best, float(self.limits[0 if side < 0 else 1])
        error = np.sqrt(self.result.covariance[self.j, self.j])
        step = threshold * (error if np.isfinite(error) and error > 0 else 0.1)
        inner, outer = (0.0, 0.0), None
        for other in self.minima:
            # the interval reaches across what lies between two minima
            off = side * float(other[self.j] - best)
            if off > inner[0] and (value := abs(self.root(best + side * off))) < threshold:
                inner = (off, value)
        x = best + side * (inner[0] + min(step, _FAR))
        for _ in range(30):
            x = float(np.clip(x, self.limits[0], self.limits[1]))
            value, offset = abs(self.root(x)), abs(x - best)
            if abs(value - threshold) < 1e-2 * threshold:
                break
            if value < threshold:
                if x == limit:
                    return side * np.inf
                inner = (offset, value)
            else:
                outer = (offset, value)
            if outer is None:
                x = best + side * offset * min(max(threshold / max(value, 1e-9), _BEYOND), _FAR)
            else:
                part = (threshold - inner[1]) / max(outer[1] - inner[1], ROUNDING)
                x = best + side * (inner[0] + float(np.clip(part, _INSIDE, 1 - _INSIDE)) * (outer[0] - inner[0]))
        return x
