"""Beyond the covariance: likelihood profiles of one parameter, maps over two."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from flatpunch._support.checks import ROUNDING, TINY, Array, shown
from flatpunch._support.readable import Table, readable
from flatpunch.fit.least_squares.joint import JointObjective
from flatpunch.fit.least_squares.minimum import Minimum, minimise
from flatpunch.fit.least_squares.objective import Objective
from flatpunch.fit.measured.signal import memory_of
from flatpunch.fit.parameters.scaling import external, kind, plain_limits
from flatpunch.fit.parameters.settings import Settings
from flatpunch.fit.parameters.unknowns import Unknowns
from flatpunch.fit.report.estimate import Estimate, interval_text, value_text
from flatpunch.fit.report.quantities import label, quantity, unit_of

_FAR = 3.0
"""Where there is no end in sight, a factor 20 of a logarithmic parameter is shown."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Fitted(ABC):
    """What fits of one curve and of several have in common; see `flatpunch.fit.FitResult`."""

    objective: Unknowns | JointObjective
    minimum: Minimum
    estimates: dict[str, Estimate]
    covariance: Array
    undetermined: Array
    settings: Settings
    bounds: tuple[Array, Array]
    notes: tuple[str, ...] = ()
    unseen: Array | None = None

    def __getitem__(self, name: str) -> float:
        """Best value of a parameter, SI."""
        return self.estimates[name].value

    @property
    @abstractmethod
    def variance(self) -> float:
        """Variance of independent residuals that would be as certain as these are."""

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters in the order of the covariance."""
        return tuple(self.objective.names)

    @property
    def correlation(self) -> Array:
        """Correlations as an array, shape (parameters, parameters)."""
        scale = np.sqrt(np.diag(self.covariance))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.covariance / scale[:, None] / scale)

    @property
    def memory(self) -> float:
        """Correlation of neighbouring residuals; 0 for independent noise."""
        return memory_of(self.minimum.residual)

    def index(self, name: str) -> int:
        """Position of a parameter in `names`."""
        if name not in self.names:
            raise ValueError(f"{shown(name)} was not fitted; fitted were {', '.join(self.names)}.")
        return self.names.index(name)

    def external(self, j: int, x: Array) -> Array:
        """Internal values x of parameter j in SI."""
        name, scales = self.names[j], self.objective.scales()
        if name in scales:
            offset, unit = scales[name]
            return np.asarray(offset + unit * x)
        with np.errstate(over="ignore"):
            return np.array([external(name, v) if np.isfinite(v) else _end(name, v) for v in x])

    def profile(self, name: str, level: float | None = None, points: int = 21) -> Profile:
        """Likelihood profile of one parameter, see `flatpunch.fit.report.likelihood.profile`."""
        return profile(self, name, level, points)

    def ridge(self, first: str, second: str, points: int = 25, width: float = 4.0) -> xr.Dataset:
        """Sum of squares over two parameters, see `flatpunch.fit.report.likelihood.ridge`."""
        return ridge(self, first, second, points, width)

    def _rows_of(self, title: str) -> Table:
        """A row for each fitted value."""
        rows = tuple(
            (label(name), value_text(e, name), quantity(e.stderr, unit_of(name)), interval_text(e, name))
            for name, e in self.estimates.items()
        )
        header = ("", "value", "standard error", f"{100 * self.settings.level:g} % interval")
        return Table(title, header, rows, self.notes)


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

    See Also
    --------
    flatpunch.fit.FitResult : `profile` makes it.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> depth = np.linspace(-200e-9, 400e-9, 121)
    >>> force = np.where(depth > 0, fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.maximum(depth, 1e-12)).force, 0.0)
    >>> curve = fp.Curve(depth=depth + 50e-9, force=force)
    >>> result = fp.fit(curve, gel, fp.Sphere(radius=5e-6), {"layers[0].young": fp.Free(2e3)})
    >>> profile = result.profile("layers[0].young")
    >>> print(profile.values.size == profile.signed_root.size)
    True
    """

    values: Array
    signed_root: Array
    low: float
    high: float


def profile(result: Fitted, name: str, level: float | None = None, points: int = 21) -> Profile:
    """Likelihood profile: the parameter held at each of many values, all others fitted anew.

    Parameters
    ----------
    result : Fitted
        The fit.
    name : str
        One of `names`.
    level : float, optional
        Confidence level; that of the fit if left out.
    points : int
        Number of values over the interval and a little beyond.
    """
    from scipy.stats import t as student

    j = result.index(name)
    freedom = max(result.objective.depth.size - len(result.names), 1)
    threshold = float(student.ppf((1 + (level or result.settings.level)) / 2, freedom))
    minima = _minima(result)
    root = _held_root(result, minima, j)
    ends = [_crossing(result, root, minima, j, side, threshold) for side in (-1, 1)]
    best = float(result.minimum.x[j])
    reach = [e if np.isfinite(e) else best + side * _FAR for e, side in zip(ends, (-1, 1), strict=True)]
    x = np.linspace(best + 1.2 * (reach[0] - best), best + 1.2 * (reach[1] - best), points)
    x = np.unique(np.clip(x, result.bounds[0][j], result.bounds[1][j]))
    roots = np.array([root(v) for v in x])
    return Profile(result.external(j, x), roots, *(float(v) for v in result.external(j, np.array(ends))))


def ends_of(result: Fitted, name: str, coarse: Unknowns | JointObjective | None = None) -> tuple[float, float]:
    """Ends of the interval of one parameter by its profile, internal; infinite where the profile does not reach the threshold.

    `coarse` is the same problem on block means.
    """
    from scipy.stats import t as student

    j = result.index(name)
    freedom = max(result.objective.depth.size - len(result.names), 1)
    threshold = float(student.ppf((1 + result.settings.level) / 2, freedom))
    minima = _minima(result, coarse)
    root = _held_root(result, minima, j, coarse)
    low, high = (_crossing(result, root, minima, j, side, threshold) for side in (-1, 1))
    return low, high


def _held_root(
    result: Fitted, minima: list[Array], j: int, coarse: Unknowns | JointObjective | None = None
) -> Callable[[float], float]:
    """Signed root of the growth of the sum of squares when parameter j is held."""
    variance = result.variance
    fixed = np.zeros(len(result.names), dtype=bool)
    fixed[j] = True
    problem = result.objective if coarse is None else coarse
    least = result.minimum.cost
    if problem is not result.objective:
        residual = problem.evaluate(result.minimum.x)[0]
        least = float(residual @ residual)
    warm = {"x": result.minimum.x}

    def root(value: float) -> float:
        starts = [warm["x"].copy(), *(x.copy() for x in minima)]
        for start in starts:
            start[j] = value
        found = min(
            (minimise(problem.evaluate, x, *result.bounds, fixed=fixed, settled=1e-2) for x in starts),
            key=lambda end: end.cost,
        )
        warm["x"] = found.x
        growth = max(found.cost - least, 0.0) / max(variance, TINY)
        return float(np.copysign(np.sqrt(growth), value - result.minimum.x[j]))

    return root


def tilt_or_contact(result: Fitted) -> bool:
    """Whether a contact that began at the first reading, over another tilt, is within the interval of the contact point.

    Then nothing shows the tilt by itself. Judged where most readings are in contact; more before it show the tilt.
    """
    from scipy.stats import t as student

    objective, found = result.objective, result.minimum
    if (
        not {"contact", "tilt"} <= set(result.names)
        or not isinstance(objective, Objective)
        or objective.loaded is not None
    ):
        return False
    x, contact = found.x.copy(), result.index("contact")
    before = objective.depth < objective.split(x)[1]["contact"]
    if 2 * before.sum() > before.size:
        return False
    lower, upper = result.bounds
    # contacts are counted from the first reading
    x[contact] = np.clip(0.0, lower[contact], upper[contact])
    held = np.arange(x.size) == contact
    other = minimise(objective.evaluate, x, lower, upper, fixed=held)
    freedom = max(objective.depth.size - x.size, 1)
    reach = float(student.ppf((1 + result.settings.level) / 2, freedom))
    return bool(before.any()) and other.cost - found.cost < reach**2 * result.variance


def _minima(result: Fitted, coarse: Unknowns | JointObjective | None = None) -> list[Array]:
    """The minimum and the best other one where nothing shows the tilt: a contact before the first reading over less of it."""
    if "contact" not in result.names or not tilt_or_contact(result):
        return []
    problem, ends = result.objective if coarse is None else coarse, []
    # contacts that are descended from, in ranges of the data before their first reading
    for place in (0.0, -0.3, -1.0, -3.0):
        start = result.minimum.x.copy()
        start[result.index("contact")] = place
        ends.append(minimise(problem.evaluate, start, *result.bounds))
    outside = [end for end in ends if end.x[result.index("contact")] < 0] or ends
    return [result.minimum.x, min(outside, key=lambda end: end.cost).x]


def _crossing(
    result: Fitted, root: Callable[[float], float], minima: list[Array], j: int, side: int, threshold: float
) -> float:
    """Where the profile reaches the threshold on one side, by secants; infinite if it does not within the limits."""
    best, limit = float(result.minimum.x[j]), float(result.bounds[0 if side < 0 else 1][j])
    error = np.sqrt(result.covariance[j, j])
    step = threshold * (error if np.isfinite(error) and error > 0 else 0.1)
    inner, outer = (0.0, 0.0), None
    for other in minima:
        # the interval reaches across what lies between two minima
        if side * (other[j] - best) > inner[0] and (value := abs(root(float(other[j])))) < threshold:
            inner = (side * float(other[j] - best), value)
    x = best + side * (inner[0] + min(step, 3.0))
    for _ in range(30):
        x = float(np.clip(x, result.bounds[0][j], result.bounds[1][j]))
        value = abs(root(x))
        if abs(value - threshold) < 1e-2 * threshold:
            return x
        offset = abs(x - best)
        if value < threshold:
            if x == limit:
                return side * np.inf
            inner = (offset, value)
        else:
            outer = (offset, value)
        if outer is None:
            grown = offset * min(max(threshold / max(value, 1e-9), 1.2), 3.0)
            x = best + side * grown
        else:
            part = (threshold - inner[1]) / max(outer[1] - inner[1], ROUNDING)
            x = best + side * (inner[0] + float(np.clip(part, 0.05, 0.95)) * (outer[0] - inner[0]))
    return x


def ridge(result: Fitted, first: str, second: str, points: int = 25, width: float = 4.0) -> xr.Dataset:
    """Growth of the sum of squares over two parameters, all others fitted anew: a long valley is a ridge of likelihood.

    The grid follows the valley: for each value of the first parameter it spreads about the best value of the second.

    Parameters
    ----------
    result : Fitted
        The fit.
    first, second : str
        Two of `names`.
    points : int
        Points along and across.
    width : float
        Half width of the map in standard errors, along those of the first parameter, across those of the second when the
        first is held (at most a factor 20 for logarithmic parameters).

    Returns
    -------
    xarray.Dataset
        `growth`(along, across): in units of the noise variance; 5.99 bounds the joint 95 % region. `first`(along),
        `second`(along, across): values [SI]. `line`(along): best value of the second parameter for each of the first.
    """
    j, k = result.index(first), result.index(second)
    low, high = result.bounds
    x, cov = result.minimum.x, result.covariance
    error = float(np.sqrt(cov[j, j]))
    reach = min(width * error, _FAR) if np.isfinite(error) else _FAR
    u = np.linspace(max(x[j] - reach, low[j]), min(x[j] + reach, high[j]), points)
    across = width * _held_error(result, j, k) * np.linspace(-1, 1, points)
    variance = max(result.variance, TINY)
    only = np.zeros(len(result.names), dtype=bool)
    only[j] = True
    fixed = only.copy()
    fixed[k] = True
    growth, line, grid = np.empty((points, points)), np.empty(points), np.empty((points, points))
    # from the best point outwards, each start from its neighbour
    middle = int(np.argmin(np.abs(u - x[j])))
    for side in (range(middle, points), range(middle - 1, -1, -1)):
        start = x
        for a in side:
            trial = start.copy()
            trial[j] = u[a]
            along = minimise(result.objective.evaluate, trial, *result.bounds, fixed=only)
            start, line[a] = along.x, along.x[k]
            grid[a] = np.clip(along.x[k] + across, low[k], high[k])
            for b, v in enumerate(grid[a]):
                trial = along.x.copy()
                trial[k] = v
                cost = minimise(result.objective.evaluate, trial, *result.bounds, fixed=fixed, settled=1e-2).cost
                growth[a, b] = max(cost - result.minimum.cost, 0.0) / variance
    second_values = np.array([result.external(k, row) for row in grid])
    return xr.Dataset(
        {
            "growth": (("along", "across"), growth),
            "first": ("along", result.external(j, u), {"units": unit_of(first), "long_name": first}),
            "second": (("along", "across"), second_values, {"units": unit_of(second), "long_name": second}),
            "line": ("along", result.external(k, line), {"units": unit_of(second)}),
        }
    )


def _held_error(result: Fitted, j: int, k: int) -> float:
    """Standard error of parameter k when j is held."""
    cov = result.covariance
    with np.errstate(invalid="ignore", divide="ignore"):
        variance = cov[k, k] - cov[k, j] ** 2 / cov[j, j]
    return float(np.sqrt(variance)) if np.isfinite(variance) and variance > 0 else 0.1


def _end(name: str, value: float) -> float:
    """External value at an infinite internal one."""
    if value > 0:
        return float(np.pi / 2) if kind(name) == "inclination" else float("inf")
    return float("-inf") if plain_limits(name) else 0.0
