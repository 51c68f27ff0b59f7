"""The posterior of a fit: draws of all parameters, quantiles, and how many of the draws count as independent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array, shown
from flatpunch._support.declared import Place
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch._version import __version__
from flatpunch.fits.parameters.priors import Prior
from flatpunch.fits.report.quantities import unit_of
from flatpunch.fits.report.table import Estimate, Row, Rows, Tabled, csv_of, saved


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
        """The medians."""
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
    """A prior in words."""
    low, high = prior.support
    if np.isfinite(low) and np.isfinite(high):
        return f"{text(low, unit)} .. {text(high, unit)}"
    if np.isfinite(low):
        return f"{text(prior.centre, unit)} ± {100 * prior.spread / prior.centre:.3g} %"
    return f"{text(prior.centre, unit)} ± {text(prior.spread, unit)}"
