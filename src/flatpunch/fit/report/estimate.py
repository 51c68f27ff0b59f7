"""A fitted parameter with its interval."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    pass


@dataclass(frozen=True, slots=True)
class Estimate:
    """One fitted value, SI.

    Attributes
    ----------
    value, stderr : float
        Best value and its standard error.
    low, high : float
        Confidence interval from the covariance, symmetric in the logarithm for moduli, lengths and slopes.
    start : float
        Where the search began.
    at_bound : bool
        Whether the value sits on a limit; it then has no interval.
    """

    value: float
    stderr: float
    low: float
    high: float
    start: float = float("nan")
    at_bound: bool = False
