"""One parameter of a family: its range, and the coordinate in which solutions are smooth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._support.checks import ROUNDING, Array, numbers, real, shown, values
from flatpunch._support.kinds import one_of
from flatpunch._support.readable import readable

Scale = Literal["linear", "log", "upper"]


@readable
@dataclass(frozen=True, slots=True)
class Parameter:
    """A named parameter with a range.

    Parameters
    ----------
    name : str
        As it is written in calls, files and on the command line.
    meaning : str
        One line for a reader of the data set, with the definition.
    low, high : float
        Range, both included.
    scale : "linear", "log" or "upper"
        Coordinate v: the value; its logarithm; or -ln(shift + (high - value)/(high - low)) for what changes fast near the upper
        end, as everything does near incompressibility.
    shift : float
        Of the scale "upper": relative distance from the upper end below which nothing changes any more.
    unit : str
        "1" for what has none.

    See Also
    --------
    flatpunch.atlas.Family : Takes it.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> ratio = atlas.Parameter("ratio", "E1/E2", 0.3, 3.0, "log")
    >>> print(ratio.low, ratio.high)
    0.3 3.0
    """

    name: str
    meaning: str
    low: float
    high: float
    scale: Scale = "linear"
    shift: float = 0.0
    unit: str = "1"

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise TypeError(f"Parameter.name = {shown(self.name)} must be a text.")
        for name in ("low", "high", "shift"):
            object.__setattr__(self, name, real(f"{self.name}.{name}", getattr(self, name)))
        if not (np.isfinite(self.low) and np.isfinite(self.high) and self.low < self.high):
            raise ValueError(f"{self.name}: the range {self.low!r} ... {self.high!r} must be finite and ascending.")
        one_of(f"{self.name}.scale", self.scale, ("linear", "log", "upper"))
        if self.scale == "log" and self.low <= 0:
            raise ValueError(f"{self.name}: a logarithmic range begins above zero, not at {self.low!r}.")
        if self.scale == "upper" and not self.shift > 0:
            raise ValueError(f"{self.name}: the scale 'upper' needs a shift > 0.")

    def check(self, given: Array | float) -> Array:
        """Values as an array, refused outside the range."""
        found = numbers(self.name, given, self.unit.replace("^", "**"))
        # a value may be outside the range by rounding
        slack = 1e-9 * (self.high - self.low)
        bad = ~((found >= self.low - slack) & (found <= self.high + slack))
        if bad.any():
            raise ValueError(
                f"{self.name} = {np.ravel(found)[np.ravel(bad)][0]:.6g} lies outside the table, which holds "
                f"{self.low:g} ... {self.high:g}. Outside it the medium is solved directly: flatpunch.flat_punch, or "
                "atlas.tabulated(medium, outside='solve')."
            )
        return np.asarray(np.clip(found, self.low, self.high))

    def unit_coordinate(self, inside: Array | float) -> Array:
        """Coordinate x in [-1, 1] of values inside the range."""
        low, high = self._coordinate(np.array([self.low, self.high]))
        return np.asarray((2 * self._coordinate(np.asarray(inside, dtype=float)) - low - high) / (high - low))

    def at(self, x: Array) -> Array:
        """Values at coordinates x in [-1, 1]; the ends are exact."""
        low, high = self._coordinate(np.array([self.low, self.high]))
        v = (low + high) / 2 + (high - low) / 2 * np.asarray(x)
        if self.scale == "linear":
            values = v
        elif self.scale == "log":
            values = np.exp(v)
        else:
            values = self.high - (np.exp(-v) - self.shift) * (self.high - self.low)
        return np.asarray(
            np.where(x == -1, self.low, np.where(x == 1, self.high, np.clip(values, self.low, self.high)))
        )

    def _coordinate(self, values: Array) -> Array:
        if self.scale == "linear":
            return values
        if self.scale == "log":
            return np.log(values)
        return np.asarray(-np.log(self.shift + (self.high - values) / (self.high - self.low)))


def lobatto(intervals: int) -> Array:
    """Chebyshev-Lobatto points cos(pi j/intervals), j = intervals ... 0, ascending; doubling `intervals` keeps every point."""
    j = np.arange(intervals, -1, -1)
    points = np.sin(np.pi * (intervals - 2 * j) / (2 * intervals))
    return np.asarray(points)


def lobatto_transform(intervals: int) -> Array:
    """Matrix from values at the Lobatto points to Chebyshev coefficients, shape (intervals + 1, intervals + 1)."""
    if intervals == 0:
        return np.ones((1, 1))
    return np.asarray(np.linalg.inv(chebyshev.chebvander(lobatto(intervals), intervals)))


def check_beta(beta: float | Array, low: float, high: float) -> Array:
    """Radii as an array, refused outside the range of a table."""
    found = values("beta", np.atleast_1d(beta), strict=True).reshape(np.shape(beta))
    outside = (found < low * (1 - ROUNDING)) | (found > high * (1 + ROUNDING))
    if outside.any():
        raise ValueError(
            f"beta = {np.ravel(found)[np.ravel(outside)][0]:.6g} lies outside the table, which holds {low:g} ... {high:g} "
            "(punch radius over the length of the medium)."
        )
    return found
