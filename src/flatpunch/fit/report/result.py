"""What a fit returns: values with intervals, correlations, what the data do not determine, profiles and ridges."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array, Flags
from flatpunch._support.deprecation import deprecated
from flatpunch._support.paths import Plain
from flatpunch._support.progress import Report
from flatpunch._support.readable import Table, readable
from flatpunch._support.record import record
from flatpunch._version import __version__
from flatpunch.fit.elastic.model import method_for
from flatpunch.fit.measured.curve import Curve, read_lines
from flatpunch.fit.measured.signal import independent
from flatpunch.fit.parameters.priors import Prior
from flatpunch.fit.parameters.sample import Sample
from flatpunch.fit.parameters.unknowns import Unknowns
from flatpunch.fit.report.estimate import Estimate, half_width, interval_text, value_text
from flatpunch.fit.report.likelihood import Fitted
from flatpunch.fit.report.lmfit_problem import lmfit_problem
from flatpunch.fit.report.posterior import Posterior
from flatpunch.fit.report.pull_off import pull_off_force
from flatpunch.fit.report.quantities import label, quantity, unit_of
from flatpunch.fit.report.sampling import draw
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body

if TYPE_CHECKING:
    pass


@readable
@dataclass(frozen=True, eq=False, kw_only=True)
class FitResult(Fitted):
    """A fitted curve.

    Attributes
    ----------
    curve : Curve
        The approach that was fitted.
    used : ndarray of bool
        Which of its points.
    estimates : dict
        By name: the free parameters, "contact" [m], "baseline" [N], "tilt" [N/m].
    covariance : ndarray
        Of the internal parameters (logarithms; contact and baseline in units of the curve's ranges), in the order of `names`.
    noise : float
        Standard deviation of the residuals [N].
    notes : tuple of str
        What to know before using the numbers.
    unseen : ndarray, optional
        The part of `covariance` from a tilt of the baseline that the data do not exclude.

    See Also
    --------
    flatpunch.fit : Makes it.
    flatpunch.plot_fit : The picture.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> depth = np.linspace(-200e-9, 400e-9, 121)
    >>> force = np.where(depth > 0, fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.maximum(depth, 1e-12)).force, 0.0)
    >>> curve = fp.Curve(depth=depth + 50e-9, force=force)
    >>> result = fp.fit(curve, gel, fp.Sphere(radius=5e-6), {"layers[0].young": fp.Free(2e3)})
    >>> print(f"{result['layers[0].young'] / 1e3:.2f} kPa, contact at {result['contact'] * 1e9:.1f} nm")
    5.00 kPa, contact at 50.0 nm
    """

    curve: Curve
    used: Flags
    objective: Unknowns
    noise: float

    def _line_(self) -> str:
        """The fitted values of the case."""
        found = ", ".join(f"{name}={quantity(value, unit_of(name))}" for name, value in self.values.items())
        return f"FitResult({self.curve.name!r}: {found or 'nothing fitted'}, {int(self.used.sum())} points)"

    def _table_(self) -> Table:
        """A row for each fitted value."""
        points, noise = int(self.used.sum()), quantity(self.noise, "N")
        return self._rows_of(f"Fit of {self.curve.name}: {points} points, noise {noise}")

    @property
    def read(self) -> tuple[str, ...]:
        """Where the numbers come from: file, sheet, columns with units, calibration, segment."""
        return read_lines(self.curve, int(self.used.size))

    @property
    def values(self) -> dict[str, float]:
        """Best values of the free parameters of the case, SI."""
        return {name: self.estimates[name].value for name in self.objective.model.free}

    @property
    def case(self) -> tuple[Body, Indenter]:
        """Medium and indenter with the fitted values."""
        medium, indenter = self.objective.model.case(self.values)
        return medium, indenter

    @property
    def pull_off(self) -> Estimate | None:
        """Pull-off force at the fitted values [N], the largest tension of the contact; None without adhesion."""
        reach = half_width(self.settings.level, max(self.minimum.residual.size - len(self.names), 1))
        return pull_off_force(self.objective.model, self.minimum.x, self.covariance, reach)

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

    @property
    def variance(self) -> float:
        """Variance of independent readings, over the force range squared, that would be as certain as these are."""
        size = self.minimum.residual.size
        noise = self.minimum.cost / max(size - len(self.names), 1)
        return noise * size / max(independent(self.minimum.residual), 1.0)

    def correlations(self) -> xr.DataArray:
        """Correlations of the estimates, shape (parameters, parameters)."""
        names = list(self.names)
        return xr.DataArray(self.correlation, {"parameter": names, "with": names}, ("parameter", "with"))

    def model_error(self, points: int = 12) -> float:
        """Largest difference between the tabulated model and the exact one, over the largest force."""
        deepest = float(self.depth.max())
        if deepest <= 0:
            return 0.0
        depth = deepest * np.geomspace(1e-2, 1, points)
        exact = self.objective.model.exact(depth, self.values)[0]
        return float(np.abs(self.objective.model.force(depth, self.values) - exact).max() / exact.max())

    def to_lmfit(self) -> Any:
        """Return this least-squares problem for lmfit, to which it needs to be installed.

        Returns
        -------
        lmfit.Minimizer
            Residuals in units of the force range of the curve, without the loss of a robust fit. Its `params` are the values
            found, in internal form: log_layers_0_young is the natural logarithm of layers[0].young in Pa.

        Raises
        ------
        ValueError
            Without lmfit.

        Examples
        --------
        >>> gel, tip = fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6)
        >>> depth = np.linspace(-2e-7, 4e-7, 300)
        >>> force = np.zeros(300)
        >>> force[depth > 0] = fp.indent(gel, tip, depth=depth[depth > 0]).force
        >>> curve = fp.Curve(depth=depth, force=force + 1e-11 * np.random.default_rng(0).normal(size=300))
        >>> result = fp.fit(curve, gel, tip, ["base.young"])
        >>> found = result.to_lmfit().leastsq()
        >>> print(f"{np.exp(found.params['log_base_young'].value) / result['base.young']:.4f}")
        1.0000
        """
        return lmfit_problem(self.objective, self.minimum, *self.bounds)

    @property
    def lmfit(self) -> Any:
        """lmfit's result; deprecated, see `to_lmfit`."""
        return _lmfit(self)

    def posterior(
        self,
        draws: int = 10_000,
        priors: Mapping[str, Prior] | None = None,
        *,
        seed: int = 0,
        progress: bool | Report | None = None,
    ) -> Posterior:
        """Draw from the posterior: all that curve and prior knowledge say together.

        Parameters
        ----------
        draws : int
            Number of draws returned, evenly from chains of 20 to 50 autocorrelation times, the more the more draws.
        priors : mapping of str to Normal, LogNormal or Uniform, optional
            By parameter, SI: of fitted ones, the contact point "contact" and the background; of numbers of the case that were
            held in the fit, which are then drawn as well ("layers[0].thickness" from ellipsometry, "indenter.radius"); of the
            "spring_constant" [N/m], and of the "sensitivity" relative to the one used. A calibration with an uncertainty in the
            curve has one. Without a prior, logarithms of moduli, lengths, times and slopes are uniform, Poisson ratios,
            contact and background as they are, within the limits of the fit.
        seed : int
            Of the random numbers; the same seed gives the same draws.
        progress : bool or callable, optional
            True shows a bar; a function is called with (steps done, steps expected).

        Returns
        -------
        Posterior
            Draws, quantiles, effective number of draws, notes.

        Raises
        ------
        ValueError, TypeError
            On bad input.

        Notes
        -----
        The noise is normal, its unknown standard deviation is integrated out with the prior 1/s; readings with correlated
        neighbours count as fewer independent ones. The sampler is the
        ensemble of Foreman-Mackey et al., PASP 125 (2013) 306, with moves by differential evolution.

        Examples
        --------
        >>> layer, bead = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], base=fp.RigidBase()), fp.Sphere(5e-6)
        >>> depth = np.linspace(-1e-7, 4e-7, 300)
        >>> force = np.zeros(300)
        >>> force[depth > 0] = fp.indent(layer, bead, depth=depth[depth > 0]).force
        >>> curve = fp.Curve(depth, force + 1e-11 * np.random.default_rng(0).normal(size=300))
        >>> result = fp.fit(curve, layer, bead, ["layers[0].young"])
        >>> from flatpunch.fit import Normal
        >>> ellipsometry = {"layers[0].thickness": Normal(2e-6, 5e-8)}
        >>> found = result.posterior(draws=2000, priors=ellipsometry)
        >>> low, high = found.interval("layers[0].young")
        >>> low < 5e3 < high
        True
        """
        return draw(self, (self.curve,), draws, priors, seed, progress)

    def row(self) -> Plain:
        """One line of a table: values, standard errors, intervals, noise, notes."""
        line: Plain = {"curve": self.curve.name, "ok": True, "reason": ""}
        for name, estimate in self.estimates.items():
            line[name] = estimate.value
            line[f"{name} stderr"] = estimate.stderr
            line[f"{name} low"], line[f"{name} high"] = estimate.low, estimate.high
        line["deepest"] = float(self.depth.max())
        line["noise"] = self.noise
        if (pull := self.pull_off) is not None:
            line["pull-off force"], line["pull-off force stderr"] = pull.value, pull.stderr
        line["points"] = int(self.used.sum())
        if self.read:
            line["read"] = "; ".join(self.read)
        line["notes"] = " ".join(self.notes)
        return line

    def dataset(self) -> xr.Dataset:
        """Curve, fitted force and estimates, for a file."""
        data: Plain = {
            "depth": ("point", self.depth, {"units": "m", "long_name": "indentation depth"}),
            "force": ("point", self.curve.force, {"units": "N", "long_name": "measured force"}),
            "fitted": ("point", self.force, {"units": "N", "long_name": "fitted force"}),
            "used": ("point", self.used, {"long_name": "whether the point was fitted"}),
        }
        columns = ("value", "stderr", "low", "high", "start")
        for column in columns:
            data[column] = ("parameter", [getattr(e, column) for e in self.estimates.values()])
        data["correlation"] = (("parameter", "with"), self.correlations().values)
        names = list(self.estimates)
        attributes = {
            "title": f"Fit of {self.curve.name}",
            "units": ", ".join(f"{name} [{unit_of(name)}]" for name in names),
            "noise": self.noise,
            "notes": "\n".join(self.notes),
            "read": "\n".join(self.read),
            **self._sample(),
            "flatpunch_version": __version__,
        }
        coordinates = {"point": np.arange(self.curve.depth.size), "parameter": names, "with": names}
        return xr.Dataset(data, coordinates, attributes)

    def _sample(self) -> dict[str, str | float]:
        """Sample and method as attributes of a file."""
        model, values = self.objective.model, self.values
        sample = model.sample.replaced(values) if hasattr(model, "sample") else Sample(*model.case(values))
        method = method_for(sample.indenter, model.method)
        found: dict[str, str | float] = {
            "method": method if isinstance(method, str) else method.name,
            "medium": json.dumps(record(sample.medium)),
            "indenter": json.dumps(record(sample.indenter)),
        }
        if sample.work_of_adhesion is not None:
            found["work_of_adhesion"] = sample.work_of_adhesion
        if sample.relaxation is not None:
            found["relaxation"] = json.dumps(record(sample.relaxation))
        return found

    def summary(self) -> str:
        """The result in words."""
        deepest, noise = quantity(float(self.depth.max()), "m"), quantity(self.noise, "N")
        lines = [f"{self.curve.name}: {int(self.used.sum())} points, deepest {deepest}, noise {noise}"]
        lines += [f"  Read {line}" for line in self.read]
        for name, e in self.estimates.items():
            interval = f"{100 * self.settings.level:g} % {'' if name == 'contact' else 'in '}{interval_text(e, name)}"
            stated = "at its limit" if e.at_bound and e.by == "covariance" else interval
            lines.append(f"  {label(name):<24} {value_text(e, name):>12}   {stated}")
        if (pull := self.pull_off) is not None:
            within = f"{100 * self.settings.level:g} % in {quantity(pull.low, 'N')} .. {quantity(pull.high, 'N')}"
            lines.append(f"  {'pull-off force':<24} {quantity(pull.value, 'N'):>12}   {within}")
        return "\n".join([*lines, *(f"  Note: {note}" for note in self.notes)])


@deprecated(since="1.0", gone="2.0", instead="result.to_lmfit().leastsq()")
def _lmfit(result: FitResult) -> Any:
    """lmfit's own result."""
    return result.to_lmfit().leastsq()
