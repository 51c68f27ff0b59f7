"""Before and after a fit: priors of its parameters, and the posterior, draws of all of them with quantiles."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array, BadValue, positive, real, shown
from flatpunch._support.declared import Place
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch._version import __version__
from flatpunch.fits.measured.signal import ROUNDED
from flatpunch.fits.report.table import Estimate, Row, Rows, Tabled, csv_of, saved, unit_of


class Prior(ABC):
    """What is known of one parameter, SI."""

    __slots__ = ()

    @property
    def support(self) -> tuple[float, float]:
        """Smallest and largest possible value; everything unless a kind has limits."""
        return -np.inf, np.inf

    @property
    @abstractmethod
    def centre(self) -> float:
        """Median."""

    @property
    @abstractmethod
    def spread(self) -> float:
        """Standard deviation, of a lognormal prior to first order."""

    @abstractmethod
    def logarithm(self, value: Array) -> Array:
        """ln of the probability density, up to a constant."""


@readable
@dataclass(frozen=True, slots=True)
class Normal(Prior):
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
class LogNormal(Prior):
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
class Uniform(Prior):
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
        return (self.high - self.low) * ROUNDED

    def logarithm(self, value: Array) -> Array:
        """ln of the probability density, up to a constant."""
        return np.where((value >= self.low) & (value <= self.high), 0.0, -np.inf)


@readable
@dataclass(frozen=True, eq=False)
class Posterior(Tabled):
    """Draws from the posterior of a fit.

    Attributes
    ----------
    curve : str
        Name of the curve.
    numbers : mapping of str to Place
        Parameters with their declarations: those of the fit, then those that have a prior only.
    draws : ndarray, shape (n, parameters)
        Draws [SI].
    log_probability : ndarray, shape (n,)
        ln of the posterior density over the internal parameters, up to a constant.
    priors : mapping of str to Normal, LogNormal or Uniform
        What was given. Parameters without are uniform in their internal form: logarithms of moduli, lengths, times and slopes;
        Poisson ratios, contact and background as they are; all within the limits of the fit.
    times : ndarray, shape (parameters,)
        Autocorrelation times of the chains [steps].
    effective : ndarray, shape (parameters,)
        Number of independent draws that these are worth.
    acceptance : float
        Share of the proposals that were accepted.
    level : float
        Probability of the intervals in the summary.
    notes : tuple of str
        What to know before using the numbers.

    See Also
    --------
    flatpunch.fits.FitResult : `posterior` makes it.
    flatpunch.fits.Normal, flatpunch.fits.LogNormal, flatpunch.fits.Uniform : What is known before.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> depth = np.linspace(-200e-9, 400e-9, 121)
    >>> force = np.where(depth > 0, fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.maximum(depth, 1e-12)).force, 0.0)
    >>> force += 2e-11 * np.random.default_rng(0).normal(size=force.size)
    >>> curve = fp.Curve(depth=depth + 50e-9, force=force)
    >>> result = fp.fit(curve, gel, fp.Sphere(radius=5e-6), {"layers[0].young": fp.Free(2e3)})
    >>> found = result.posterior(draws=400, seed=1)
    >>> print(found.names, found.draws.shape[1] == len(found.names))
    ('layers[0].young', 'contact', 'baseline') True
    """

    curve: str
    numbers: Mapping[str, Place]
    draws: Array
    log_probability: Array
    priors: Mapping[str, Prior]
    times: Array
    effective: Array
    acceptance: float
    level: float
    notes: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(self.numbers)

    def __getitem__(self, name: str) -> Array:
        """Draws of one parameter [SI], shape (n,)."""
        if name not in self.names:
            raise ValueError(f"{shown(name)} was not drawn; drawn were {', '.join(self.names)}.")
        return np.asarray(self.draws[:, self.names.index(name)])

    def quantiles(self, name: str, probabilities: Any = (0.025, 0.5, 0.975)) -> Array:
        """Values below which the parameter lies with the given probabilities [SI]."""
        return np.asarray(np.quantile(self[name], probabilities))

    def interval(self, name: str, level: float | None = None) -> tuple[float, float]:
        """Central interval that holds the parameter with a probability; the level of the fit by default."""
        tail = (1 - (self.level if level is None else level)) / 2
        low, high = self.quantiles(name, (tail, 1 - tail)).tolist()
        return low, high

    @property
    def correlation(self) -> Array:
        """Correlations of the draws, shape (parameters, parameters)."""
        return np.atleast_2d(np.corrcoef(self.draws, rowvar=False))

    def _line_(self) -> str:
        found = ", ".join(
            f"{name}={text(float(np.median(self[name])), unit_of(each))}" for name, each in self.numbers.items()
        )
        return f"Posterior({self.curve!r}: {found}, {len(self.draws)} draws)"

    def table(self) -> Rows:
        """The table: a row for each parameter, with its effective draws and its prior."""
        rows = []
        for (name, number), draws, effective in zip(self.numbers.items(), self.draws.T, self.effective, strict=True):
            note = f"{effective:.0f} effective draws"
            if name in self.priors:
                note += f", prior {_prior_text(self.priors[name], unit_of(number))}"
            estimate = Estimate(float(np.median(draws)), float(np.std(draws)), *self.interval(name), by="draws")
            rows.append(Row.of(number, estimate, note))
        title = (
            f"{self.curve}: {len(self.draws)} draws, worth {self.effective.min():.0f} independent ones or more; autocorrelation "
            f"{self.times.max():.0f} steps, {100 * self.acceptance:.0f} % accepted"
        )
        return Rows(title, tuple(rows), self.level, self.notes, value="median")

    def to_csv(self) -> str:
        """The draws as CSV text, a column for each parameter [SI]."""
        units = {name: unit_of(each) or "1" for name, each in self.numbers.items()}
        return csv_of([dict(zip(self.names, row, strict=True)) for row in self.draws.tolist()], units)

    def dataset(self) -> xr.Dataset:
        """All draws, for a file."""
        names = list(self.names)
        data: dict[str, object] = {
            "draws": (("draw", "parameter"), self.draws, {"long_name": "draws from the posterior, SI"}),
            "log_probability": (
                "draw",
                self.log_probability,
                {"units": "1", "long_name": "ln of the posterior density"},
            ),
            "effective": ("parameter", self.effective, {"units": "1", "long_name": "effective number of draws"}),
            "autocorrelation_time": ("parameter", self.times, {"units": "1", "long_name": "in steps of the chains"}),
        }
        attributes = {
            "title": f"Posterior of the fit of {self.curve}",
            "units": ", ".join(f"{name} [{unit_of(each) or '1'}]" for name, each in self.numbers.items()),
            "priors": "; ".join(f"{name}: {prior}" for name, prior in self.priors.items()),
            "notes": "\n".join(self.notes),
            "flatpunch_version": __version__,
        }
        return xr.Dataset(data, {"parameter": names, "draw": np.arange(len(self.draws))}, attributes)

    def save(self, path: str | Path) -> Path:
        """Write the draws: .nc with everything, or .csv, a column for each parameter [SI]."""
        return saved(path, self.to_csv, self.dataset)


def _prior_text(prior: Prior, unit: str) -> str:
    low, high = prior.support
    if np.isfinite(low) and np.isfinite(high):
        return f"{text(low, unit)} .. {text(high, unit)}"
    if np.isfinite(low):
        return f"{text(prior.centre, unit)} ± {100 * prior.spread / prior.centre:.3g} %"
    return f"{text(prior.centre, unit)} ± {text(prior.spread, unit)}"
