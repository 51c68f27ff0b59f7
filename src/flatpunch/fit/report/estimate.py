"""A fitted parameter with its interval."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.readable import readable
from flatpunch.fit.least_squares.joint import JointObjective
from flatpunch.fit.least_squares.minimum import Minimum
from flatpunch.fit.parameters.scaling import external, slope
from flatpunch.fit.parameters.unknowns import Unknowns
from flatpunch.fit.report.quantities import quantity, unit_of


@readable
@dataclass(frozen=True, slots=True)
class Estimate:
    """One fitted value, SI.

    Attributes
    ----------
    value, stderr : float
        Best value and its standard error.
    low, high : float
        Confidence interval, from the covariance symmetric in the logarithm for moduli, lengths and slopes. Infinite or zero (or
        on a limit) on a side on which the data do not end it.
    start : float
        Where the search began.
    at_bound : bool
        Whether the value sits on a limit.
    by : "covariance" or "profile"
        Where the interval comes from: the likelihood profile where the covariance is not enough.

    See Also
    --------
    flatpunch.fit.FitResult : Holds one for each parameter.
    flatpunch.fit.Profile : The likelihood behind wide intervals.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> depth = np.linspace(-200e-9, 400e-9, 121)
    >>> force = np.where(depth > 0, fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.maximum(depth, 1e-12)).force, 0.0)
    >>> curve = fp.Curve(depth=depth + 50e-9, force=force)
    >>> result = fp.fit(curve, gel, fp.Sphere(radius=5e-6), {"layers[0].young": fp.Free(2e3)})
    >>> young = result.estimates["layers[0].young"]
    >>> print(f"{young.value / 1e3:.2f} kPa, interval contains the value: {young.low <= young.value <= young.high}")
    5.00 kPa, interval contains the value: True
    """

    value: float
    stderr: float
    low: float
    high: float
    start: float = float("nan")
    at_bound: bool = False
    by: str = "covariance"

    @property
    def determined(self) -> bool:
        """Whether the data end the interval on both sides."""
        return bool(np.isfinite(self.low) and np.isfinite(self.high) and self.by != "nothing")


def value_text(estimate: Estimate, name: str) -> str:
    """Value in words: a bound, or no number, where the data do not end its interval."""
    unit = unit_of(name)
    below, above = np.isfinite(estimate.low) and estimate.low != 0, np.isfinite(estimate.high)
    if estimate.by == "nothing" or not (below or above):
        return "not determined"
    if not above:
        return f"> {quantity(estimate.low, unit)}"
    if not below and estimate.by == "profile":
        return f"< {quantity(estimate.high, unit)}"
    return quantity(estimate.value, unit)


def interval_text(estimate: Estimate, name: str) -> str:
    """Interval in words."""
    unit = unit_of(name)
    if estimate.by == "nothing":
        return "any value (not determined by the data)"
    if name == "contact" and np.isfinite(estimate.stderr):
        # far from its own zero an interval would need many digits
        return f"± {quantity((estimate.high - estimate.low) / 2, unit)}"
    return f"{quantity(estimate.low, unit)} .. {quantity(estimate.high, unit)}"


@lru_cache(maxsize=1024)
def half_width(level: float, freedom: int) -> float:
    """Half width of a two-sided interval in standard errors."""
    from scipy.stats import t as student

    return float(student.ppf((1 + level) / 2, freedom))


def estimated(
    objective: Unknowns | JointObjective, found: Minimum, spread: Array, lower: Array, upper: Array, level: float
) -> dict[str, Estimate]:
    """Values with standard errors and intervals, SI; intervals are symmetric in the internal parameters."""
    quantile = half_width(level, max(objective.depth.size - found.x.size, 1))
    count = len(objective.model.free)
    start = objective.model.start()
    estimates = {}
    for j, name in enumerate(objective.names):
        error = float(np.sqrt(spread[j, j]))
        x, reach = float(found.x[j]), quantile * error
        if j < count:
            low, high = (float(np.clip(x + s * reach, lower[j], upper[j])) for s in (-1, 1))
            value = external(name, x)
            unit = abs(slope(name, value))
            estimate = Estimate(
                value, error * unit, external(name, low), external(name, high), external(name, start[j])
            )
        else:
            offset, unit = objective.scales()[name]
            estimate = Estimate(
                offset + unit * x, unit * error, offset + unit * (x - reach), offset + unit * (x + reach)
            )
        estimates[name] = replace(estimate, at_bound=bool(found.at_bound[j]))
    return estimates
