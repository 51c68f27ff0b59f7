"""What a fit of one or several curves returns: values with intervals, correlations, profiles, notes, and its table."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.progress import Report
from flatpunch._support.readable import readable, record
from flatpunch._version import __version__
from flatpunch.contact import method_of
from flatpunch.fits.elastic.model import method_for
from flatpunch.fits.parameters.sample import BESIDE, OF, PULL_OFF
from flatpunch.fits.report.fitted import Fitted, Profile, profile
from flatpunch.fits.report.posterior import Posterior, Prior
from flatpunch.fits.report.sampling import draw
from flatpunch.fits.report.table import (
    Estimate,
    Row,
    Rows,
    Tabled,
    csv_of,
    half_width,
    rows_of,
    saved,
    unit_of,
    units_in,
)


@readable
@dataclass(frozen=True, eq=False, kw_only=True)
class FitResult(Fitted, Tabled):
    """One or several curves fitted with one sample.

    Attributes
    ----------
    problem : Problem
        Curves, parameters and residuals.
    minimum : Minimum
        Where the search ended.
    estimates : dict
        By name: the free parameters, "contact" [m], "baseline" [N], "tilt" [N/m]. Of several curves the shared ones have these
        names, those of one curve "name @ curve".
    covariance : ndarray
        Of the internal parameters (logarithms; contact and baseline in units of the curve's ranges), in the order of `names`.
    undetermined : ndarray, shape (n, parameters)
        Directions that change nothing.
    parts : tuple of FitResult
        The fit of each curve where there are several, see `results`.
    excess : tuple of (float, int)
        For each of several curves, the fall of its sum of squares over its noise if it were fitted alone, and its number of
        parameters.
    notes : tuple of str
        What to know before using the numbers.
    unseen : ndarray, optional
        The part of `covariance` from a tilt of the baseline that the data do not exclude.

    See Also
    --------
    flatpunch.fit, flatpunch.fit_together : Make it.
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
    >>> again = fp.Curve(depth=curve.depth, force=curve.force + 2e-12, name="again")
    >>> result = fp.fit_together([curve, again], gel, fp.Sphere(radius=5e-6), free=["layers[0].young"])
    >>> print(f"{result['layers[0].young'] / 1e3:.2f} kPa from {len(result.results)} curves")
    5.00 kPa from 2 curves
    """

    @cached_property
    def pull_off(self) -> Estimate | None:
        """Pull-off force at the fitted values [N], the largest tension of the contact; None without adhesion."""
        model = self.objective.model
        if not model.adhesive:
            return None
        theta, count = self.minimum.x[: len(model.free)], len(model.free)
        ends, points = (model.pull_off(theta)[0], 0.0), 100
        # where the force is smallest it does not change with the depth: its derivatives by parameters are those at
        # this depth; the grid once more between the neighbours of its smallest force
        for _ in range(2):
            depth = np.linspace(*ends, points)
            force, _, by_theta = model.evaluate(depth, theta)
            at = int(np.argmin(force))
            ends = float(depth[max(at - 1, 0)]), float(depth[min(at + 1, points - 1)])
        value, by = max(-float(force[at]), 0.0), by_theta[:, at]
        error = math.sqrt(max(float(by @ self.covariance[:count, :count] @ by), 0.0))
        reach = half_width(self.settings.level, self.freedom) * error
        return Estimate(value, error, max(value - reach, 0.0), value + reach)

    def model_error(self, points: int = 12) -> float:
        """Largest difference between the tabulated model and the exact one, over the largest force."""
        deepest = float(self.depth.max())
        if deepest <= 0:
            return 0.0
        depth = deepest * np.geomspace(1e-2, 1, points)
        exact = self.objective.model.exact(depth, self.values).force
        return float(np.abs(self.objective.model.force(depth, self.values) - exact).max() / exact.max())

    def profile(self, name: str, level: float | None = None, points: int = 21) -> Profile:
        """Likelihood profile: a parameter held at each of many values, all others fitted anew.

        Parameters
        ----------
        name : str
            One of `names`.
        level : float, optional
            Confidence level; that of the fit if left out.
        points : int
            Number of values over the interval and a little beyond.

        Returns
        -------
        Profile
            Values, growth of the sum of squares, interval, and the best values of all other parameters.
        """
        return profile(self, name, level, points)

    def to_lmfit(self) -> Any:
        """Return this least-squares problem for lmfit, to which it needs to be installed.

        Returns
        -------
        lmfit.Minimizer
            Residuals over the force range of the curve, without the loss of a robust fit. Its `params` are the values found, in
            internal form: log_layers_0_young is the natural logarithm of layers[0].young in Pa, Poisson ratios are as they are.

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
        try:
            import lmfit
        except ImportError:
            raise ValueError("to_lmfit needs lmfit: pip install 'flatpunch[fit]'.") from None
        parameters, names = lmfit.Parameters(), []
        for j, name in enumerate(self.names):
            names.append("log_" * (self.problem.scales[name].form != "plain") + re.sub(r"\W+", "_", name).strip("_"))
            # lmfit's transformation of a limit has no slope at the limit: what is there stays there
            value, least, most = (float(v[j]) for v in (self.minimum.x, *self.problem.bounds))
            parameters.add(names[-1], value=value, min=least, max=most, vary=not self.minimum.at_bound[j])

        def residual(p: Any) -> Array:
            return np.asarray(self.problem.evaluate(np.array([p[name].value for name in names]))[0])

        return lmfit.Minimizer(residual, parameters)

    def posterior(
        self,
        draws: int = 10_000,
        priors: Mapping[str, Prior] | None = None,
        *,
        seed: int = 0,
        progress: bool | Report | None = None,
    ) -> Posterior:
        """Draw from the posterior: all that curves and prior knowledge say together.

        The noise is normal, its unknown standard deviation is integrated out with the prior 1/s; readings with correlated
        neighbours count as fewer independent ones. The sampler is emcee's ensemble (Foreman-Mackey et al., PASP 125 (2013) 306),
        with moves by differential evolution.

        Parameters
        ----------
        draws : int
            Number of draws returned, evenly from chains of 20 to 50 autocorrelation times, the more the more draws.
        priors : mapping of str to Normal, LogNormal or Uniform, optional
            By parameter, SI: of fitted ones, the contact point "contact" and the background. Where one curve was fitted without
            adhesion and relaxation, also of numbers of the case that were held in the fit, which are then drawn as well
            ("layers[0].thickness" from ellipsometry, "indenter.radius"); of the "spring_constant" [N/m], and of the
            "sensitivity" relative to the one used. A calibration with an uncertainty in the curve has one. Without a prior,
            logarithms of moduli, lengths, times and slopes are uniform, Poisson ratios, contact and background as they are,
            within the limits of the fit.
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

        Examples
        --------
        >>> layer, bead = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], base=fp.RigidBase()), fp.Sphere(5e-6)
        >>> depth = np.linspace(-1e-7, 4e-7, 300)
        >>> force = np.zeros(300)
        >>> force[depth > 0] = fp.indent(layer, bead, depth=depth[depth > 0]).force
        >>> curve = fp.Curve(depth, force + 1e-11 * np.random.default_rng(0).normal(size=300))
        >>> result = fp.fit(curve, layer, bead, ["layers[0].young"])
        >>> from flatpunch.fits import Normal
        >>> ellipsometry = {"layers[0].thickness": Normal(2e-6, 5e-8)}
        >>> found = result.posterior(draws=2000, priors=ellipsometry)
        >>> low, high = found.interval("layers[0].young")
        >>> low < 5e3 < high
        True
        """
        return draw(self, draws, priors, seed, progress)

    def _about(self) -> str:
        deepest, noise = text(float(self.depth.max()), "m"), text(self.noise, "N")
        return f"{self.curve.name}: {int(self.used.sum())} points, deepest {deepest}, noise {noise}"

    def table(self) -> Rows:
        """The table: a row for each fitted value, and for the pull-off force that they imply."""
        if self.parts:
            title = f"{len(self.results)} curves, one sample; they agree with probability {self.agreement:.2g}"
            free = {name: self.estimates[name] for name in self.problem.free}
            return Rows(title, rows_of(free, self.problem.numbers), self.settings.level, self.notes)
        rows = rows_of(self.estimates, self.problem.numbers)
        if self.pull_off is not None:
            rows = (*rows, Row.of(BESIDE[PULL_OFF], self.pull_off))
        return Rows(self._about(), rows, self.settings.level, self.notes, self.read)

    def summary(self) -> str:
        """The result in words."""
        lines = [self.table().text()]
        for result in self.parts:
            about = Rows(result._about(), (), notes=result.notes, read=result.read).text()
            lines += [f"  {line}" for line in about.splitlines()]
        return "\n".join(lines)

    def _line_(self) -> str:
        numbers = self.problem.numbers
        found = ", ".join(f"{n}={text(self[n], unit_of(numbers[n]))}" for n in self.shared) or "nothing fitted"
        if self.parts:
            return f"FitResult({len(self.results)} curves: {found})"
        return f"FitResult({self.curve.name!r}: {found}, {int(self.used.sum())} points)"

    def rows(self) -> list[Plain]:
        """One line of a table for each curve: values, standard errors, intervals, noise, notes."""
        if self.parts:
            return [{k: v for k, v in each.row().items() if k not in ("ok", "reason")} for each in self.results]
        line: Plain = {"curve": self.curve.name, "ok": True, "reason": "", **self.table().record()}
        line |= {"deepest": float(self.depth.max()), "noise": self.noise, "points": int(self.used.sum())}
        if self.read:
            line["read"] = "; ".join(self.read)
        return [line | {"notes": " ".join(self.notes)}]

    def row(self) -> Plain:
        """The line of the curve."""
        self._only("row")
        return self.rows()[0]

    def to_csv(self) -> str:
        """The lines of the curves as CSV text; units are in the titles."""
        numbers = {name.partition(OF)[0]: each for name, each in self.problem.numbers.items()}
        return csv_of(self.rows(), units_in(self.rows(), numbers))

    def dataset(self) -> xr.Dataset:
        """Curves, fitted forces and estimates, for a file."""
        results, points = self.results, [each.curve.depth.size for each in self.results]
        columns: dict[str, tuple[str, str, list[Any]]] = {
            "depth": ("m", "indentation depth", [r.depth for r in results]),
            "force": ("N", "measured force", [r.curve.force for r in results]),
            "fitted": ("N", "fitted force", [r.force for r in results]),
            "used": ("", "whether the point was fitted", [r.used for r in results]),
        }
        data: Plain = {
            name: ("point", np.concatenate(parts), {**({"units": unit} if unit else {}), "long_name": words})
            for name, (unit, words, parts) in columns.items()
        }
        if len(results) > 1:
            data["curve"] = (
                "point",
                np.repeat([r.curve.name for r in results], points),
                {"long_name": "name of the curve"},
            )
        for each in ("value", "stderr", "low", "high", "start"):
            data[each] = ("parameter", [getattr(e, each) for e in self.estimates.values()])
        data["correlation"] = (("parameter", "with"), self.correlation)
        names = list(self.estimates)
        each_sample = [_sample(r) for r in results]
        sample = {key: json.dumps([s[key] for s in each_sample]) for key in each_sample[0]}
        attributes = {
            "title": f"Fit of {', '.join(r.curve.name for r in results)}",
            "units": ", ".join(f"{name} [{unit_of(self.problem.numbers[name])}]" for name in names),
            "noise": [r.noise for r in results] if len(results) > 1 else self.noise,
            "notes": "\n".join(dict.fromkeys(note for r in (self, *results) for note in r.notes)),
            "read": "\n".join(line for r in results for line in r.read),
            **(each_sample[0] if len(results) == 1 else sample),
            "flatpunch_version": __version__,
        }
        coordinates = {"point": np.arange(sum(points)), "parameter": names, "with": names}
        return xr.Dataset(data, coordinates, attributes)

    def save(self, path: str | Path) -> Path:
        """Write the result whole or not at all: the lines of the curves as .csv, everything as .nc."""
        return saved(path, self.to_csv, self.dataset)


def _sample(result: Fitted) -> dict[str, str | float]:
    model = result.objective.model
    sample = model.sample.replaced(result.values)
    found: dict[str, str | float] = {
        "method": method_of(method_for(sample.indenter, model.method)).name,
        "medium": json.dumps(record(sample.medium)),
        "indenter": json.dumps(record(sample.indenter)),
    }
    for name, value in sample.physics.given.items():
        found[name] = value if isinstance(value, (float, str)) else json.dumps(record(value))
    return found
