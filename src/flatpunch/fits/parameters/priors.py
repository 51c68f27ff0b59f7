"""Priors: what is known of a parameter before the curve is measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flatpunch._support.checks import Array, BadValue, positive, real
from flatpunch._support.readable import readable


class Prior(Protocol):
    """What is known of one parameter, SI."""

    @property
    def support(self) -> tuple[float, float]:
        """Smallest and largest possible value."""
        ...

    @property
    def centre(self) -> float:
        """Median."""
        ...

    @property
    def spread(self) -> float:
        """Standard deviation, of a lognormal prior to first order."""
        ...

    def logarithm(self, value: Array) -> Array:
        """ln of the probability density, up to a constant."""
        ...


@readable
@dataclass(frozen=True, slots=True)
class Normal:
    """A value with a standard uncertainty, such as a thickness from ellipsometry.

    Parameters
    ----------
    mean, std : float
        Mean and standard deviation, SI.

    See Also
    --------
    flatpunch.fits.LogNormal, flatpunch.fits.Uniform : Other priors.
    flatpunch.fits.Posterior : What they lead to.

    Examples
    --------
    >>> from flatpunch.fits import Normal
    >>> Normal(1e-6, 2e-8).centre
    1e-06
    """

    mean: float
    std: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "mean", real("Normal.mean", self.mean))
        object.__setattr__(self, "std", positive("Normal.std", self.std))

    @property
    def support(self) -> tuple[float, float]:
        """Everything."""
        return -np.inf, np.inf

    @property
    def centre(self) -> float:
        """Median."""
        return self.mean

    @property
    def spread(self) -> float:
        """Standard deviation."""
        return self.std

    def logarithm(self, value: Array) -> Array:
        """ln of the probability density, up to a constant."""
        return np.asarray(-0.5 * ((value - self.mean) / self.std) ** 2)


@readable
@dataclass(frozen=True, slots=True)
class LogNormal:
    """A positive value with a relative uncertainty, such as a spring constant known to 10 %.

    Parameters
    ----------
    median : float
        Median, SI.
    relative : float
        Standard deviation of the natural logarithm: 0.1 is about 10 %.

    See Also
    --------
    flatpunch.fits.Normal, flatpunch.fits.Uniform : Other priors.
    flatpunch.fits.Posterior : What they lead to.

    Examples
    --------
    >>> from flatpunch.fits import LogNormal
    >>> LogNormal(0.05, 0.1).support
    (0.0, inf)
    """

    median: float
    relative: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "median", positive("LogNormal.median", self.median))
        object.__setattr__(self, "relative", positive("LogNormal.relative", self.relative))

    @property
    def support(self) -> tuple[float, float]:
        """All positive values."""
        return 0.0, np.inf

    @property
    def centre(self) -> float:
        """Median."""
        return self.median

    @property
    def spread(self) -> float:
        """Standard deviation, to first order."""
        return self.median * self.relative

    def logarithm(self, value: Array) -> Array:
        """ln of the probability density, up to a constant."""
        with np.errstate(divide="ignore", invalid="ignore"):
            log = np.log(value)
            return np.where(value > 0, -0.5 * ((log - np.log(self.median)) / self.relative) ** 2 - log, -np.inf)


@readable
@dataclass(frozen=True, slots=True)
class Uniform:
    """All values between two limits, equally probable.

    Parameters
    ----------
    low, high : float
        Limits, SI.

    See Also
    --------
    flatpunch.fits.Normal, flatpunch.fits.LogNormal : Other priors.
    flatpunch.fits.Posterior : What they lead to.

    Examples
    --------
    >>> from flatpunch.fits import Uniform
    >>> Uniform(0.3, 0.5).centre
    0.4
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        for name in ("low", "high"):
            object.__setattr__(self, name, real(f"Uniform.{name}", getattr(self, name)))
        if not self.low < self.high:
            raise BadValue("Uniform.low", repr(self.low), f"must be below Uniform.high = {self.high!r}.")

    @property
    def support(self) -> tuple[float, float]:
        """The limits."""
        return self.low, self.high

    @property
    def centre(self) -> float:
        """Middle."""
        return (self.low + self.high) / 2

    @property
    def spread(self) -> float:
        """Standard deviation."""
        return (self.high - self.low) / math.sqrt(12.0)

    def logarithm(self, value: Array) -> Array:
        """ln of the probability density, up to a constant."""
        return np.where((value >= self.low) & (value <= self.high), 0.0, -np.inf)
