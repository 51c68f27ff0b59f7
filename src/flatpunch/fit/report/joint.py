"""What a joint fit of several curves found: shared and own values, one fit for each curve, and whether they agree."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flatpunch._support.paths import Plain
from flatpunch._support.progress import Report
from flatpunch._support.readable import Table, readable
from flatpunch.files.results import write
from flatpunch.fit.least_squares.joint import JointObjective
from flatpunch.fit.parameters.priors import Prior
from flatpunch.fit.report.estimate import interval_text, value_text
from flatpunch.fit.report.likelihood import Fitted
from flatpunch.fit.report.posterior import Posterior
from flatpunch.fit.report.quantities import label, quantity, unit_of
from flatpunch.fit.report.result import FitResult
from flatpunch.fit.report.sampling import draw


@readable
@dataclass(frozen=True, eq=False, kw_only=True)
class JointResult(Fitted):
    """Several curves fitted together.

    Attributes
    ----------
    estimates : dict
        By name: shared parameters; those of one curve, contact points and backgrounds as "name @ curve".
    shared : tuple of str
        Parameters that all curves share.
    results : tuple of FitResult
        One for each curve, with the joint values: for pictures, residuals and tables.
    covariance : ndarray
        Of the internal parameters, in the order of `names`.
    excess : tuple of (float, int)
        For each curve, the fall of its sum of squares over its noise when it is fitted alone, and its number of parameters.
    notes : tuple of str
        What to know before using the numbers.
    unseen : ndarray, optional
        The part of `covariance` from a tilt of the baseline that the data do not exclude.

    See Also
    --------
    flatpunch.fit_together : Makes it.
    flatpunch.fit.FitResult : The part of one curve.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> depth = np.linspace(-200e-9, 400e-9, 121)
    >>> force = np.where(depth > 0, fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.maximum(depth, 1e-12)).force, 0.0)
    >>> curve = fp.Curve(depth=depth + 50e-9, force=force)
    >>> again = fp.Curve(depth=curve.depth, force=curve.force + 2e-12, name="again")
    >>> result = fp.fit_together([curve, again], gel, fp.Sphere(radius=5e-6), free=["layers[0].young"])
    >>> print(f"{result['layers[0].young'] / 1e3:.2f} kPa from {len(result.results)} curves")
    5.00 kPa from 2 curves
    """

    objective: JointObjective
    shared: tuple[str, ...]
    results: tuple[FitResult, ...] = ()
    excess: tuple[tuple[float, int], ...] = ()

    def _line_(self) -> str:
        """The shared values."""
        found = ", ".join(f"{name}={quantity(self[name], unit_of(name))}" for name in self.shared)
        return f"JointResult({len(self.results)} curves: {found or 'nothing shared'})"

    def _table_(self) -> Table:
        """A row for each fitted value."""
        return self._rows_of(f"Joint fit of {len(self.results)} curves")

    @property
    def variance(self) -> float:
        """Of the residuals, each over the noise of its curve."""
        return 1.0

    @property
    def agreement(self) -> float:
        """Probability that curves of one sample differ by their noise as much as these do; small where they do not agree."""
        from scipy.stats import f as fisher

        fall, parameters = (sum(values) for values in zip(*self.excess, strict=True))
        more = int(parameters) - len(self.objective.free)
        freedom = max(self.minimum.residual.size - len(self.names) - more, 1)
        return float(fisher.sf(fall / more, more, freedom)) if more else 1.0

    def posterior(
        self,
        draws: int = 10_000,
        priors: Mapping[str, Prior] | None = None,
        *,
        seed: int = 0,
        progress: bool | Report | None = None,
    ) -> Posterior:
        """Draw from the posterior of all parameters of all curves, see `FitResult.posterior`; priors of fitted ones only."""
        return draw(self, [each.curve for each in self.results], draws, priors, seed, progress)

    def rows(self) -> list[Plain]:
        """A line for each curve: shared and own values with intervals, noise, notes."""
        return [result.row() for result in self.results]

    def to_csv(self) -> str:
        """The lines as CSV text; units are in the titles."""
        rows = self.rows()
        columns = list(dict.fromkeys(name for row in rows for name in row if name not in ("ok", "reason")))
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow([_title(name) for name in columns])
        writer.writerows([row.get(name, "") for name in columns] for row in rows)
        return out.getvalue()

    def save(self, path: str | Path) -> Path:
        """Write the table, .csv, whole or not at all."""
        path = Path(path)
        if path.suffix.lower() != ".csv":
            raise ValueError(f"{path}: the table of a joint fit is kept as .csv.")
        write(path, self.to_csv().encode("utf-8"))
        return path

    def summary(self) -> str:
        """The result in words."""
        level = f"{100 * self.settings.level:g} %"
        lines = [f"{len(self.results)} curves, one sample; they agree with probability {self.agreement:.2g}"]
        for name in self.objective.free:
            e = self.estimates[name]
            stated = "at its limit" if e.at_bound and e.by == "covariance" else f"{level} in {interval_text(e, name)}"
            lines.append(f"  {label(name):<34} {value_text(e, name):>12}   {stated}")
        for result in self.results:
            deepest, noise = quantity(float(result.depth.max()), "m"), quantity(result.noise, "N")
            lines.append(f"  {result.curve.name}: {int(result.used.sum())} points, deepest {deepest}, noise {noise}")
            lines += [f"    Read {line}" for line in result.read]
            lines += [f"    Note: {note}" for note in result.notes]
        return "\n".join([*lines, *(f"  Note: {note}" for note in self.notes)])


def _title(name: str) -> str:
    bare = name.split(" ")[0]
    units = {"deepest": "m", "noise": "N"}
    try:
        unit = units.get(bare) or unit_of(bare)
    except KeyError:
        unit = ""
    return f"{name} [{unit}]" if unit else name
