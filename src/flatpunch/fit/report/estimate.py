"""A fitted parameter with its interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.readable import readable
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
        Where the interval comes from: the likelihood profile where the covariance does not tell the whole story.
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


def interval_text(estimate: Estimate, name: str) -> str:
    """Interval in words."""
    unit = unit_of(name)
    if estimate.by == "nothing":
        return "any value (not determined by the data)"
    if name == "contact" and np.isfinite(estimate.stderr):
        # far from its own zero an interval would need many digits
        return f"± {quantity((estimate.high - estimate.low) / 2, unit)}"
    return f"{quantity(estimate.low, unit)} .. {quantity(estimate.high, unit)}"
