"""What planned curves determine: standard errors of their parameters, in words and as a table."""

from __future__ import annotations

from dataclasses import dataclass

from flatpunch._support.checks import Array, shown
from flatpunch._support.readable import Table, readable, text_of
from flatpunch.fit.report.quantities import label, quantity, unit_of
from flatpunch.fit.report.table import Estimate, Row, Rows, correlation_of

WELL, POORLY = 0.1, 1.0
"""Largest relative standard error of a parameter that counts as determined, and smallest of one that does not."""


@readable
@dataclass(frozen=True, eq=False)
class Plan:
    """What a planned curve determines.

    Attributes
    ----------
    names : tuple of str
        The free parameters, then the contact point and the background that are fitted with them.
    values : ndarray, shape (parameters,)
        Their values [SI]; those of contact and background are zero.
    errors : ndarray, shape (parameters,)
        Standard errors [SI]; infinite where the curve says nothing.
    covariance : ndarray, shape (parameters, parameters)
        Of logarithms for moduli, lengths and slopes, of Poisson ratios, contact and background as they are.
    undetermined : ndarray, shape (n, parameters)
        Directions in which nothing changes.
    notes : tuple of str

    See Also
    --------
    flatpunch.fit.planned : Makes it.

    Examples
    --------
    >>> from flatpunch.fit import planned
    >>> layer = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], base=fp.RigidBase())
    >>> plan = planned(layer, fp.Sphere(5e-6), ["layers[0].young"], depth=5e-7, noise=2e-11)
    >>> print(plan.names[0], plan.errors[0] < 0.05 * plan.values[0])
    layers[0].young True
    """

    names: tuple[str, ...]
    values: Array
    errors: Array
    covariance: Array
    undetermined: Array
    text: str
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> float:
        """Standard error of a parameter [SI]."""
        if name not in self.names:
            raise ValueError(f"{shown(name)} is not part of this plan; it has {', '.join(self.names)}.")
        return float(self.errors[self.names.index(name)])

    @property
    def correlation(self) -> Array:
        """Correlations, shape (parameters, parameters)."""
        return correlation_of(self.covariance)

    def judgement(self, name: str) -> str:
        """How well a parameter is determined: "determined", "poorly determined" or "not determined"."""
        relative = self._relative(self.names.index(name))
        return "determined" if relative <= WELL else "poorly determined" if relative < POORLY else "not determined"

    def _relative(self, j: int) -> float:
        """Standard error over the value; of numbers without unit, which are of order one, the error itself."""
        return float(self.errors[j] / abs(self.values[j])) if unit_of(self.names[j]) else float(self.errors[j])

    def error_in_words(self, name: str) -> str:
        """Standard error, relative to the value if that has a unit; "not determined" where it says nothing."""
        if self.judgement(name) == "not determined":
            return "not determined"
        error = self._relative(self.names.index(name))
        return f"± {100 * error:.2g} %" if unit_of(name) else f"± {error:.2g}"

    def table(self) -> Rows:
        """The table: a row for each parameter; of contact and background the standard error alone."""
        rows = []
        for name, value, error in zip(self.names, self.values, self.errors, strict=True):
            said = f"± {quantity(float(error), unit_of(name))}"
            if value:
                said = ": ".join(dict.fromkeys((self.error_in_words(name), self.judgement(name))))
            rows.append(Row(name, Estimate(float(value), float(error), by="plan"), unit_of(name), said))
        return Rows(self.text, tuple(rows), notes=self.notes)

    def summary(self) -> str:
        """The plan in words."""
        return self.table().text()

    def _line_(self) -> str:
        """The free parameters."""
        found = ", ".join(
            f"{name} {self.judgement(name)}" for name, v in zip(self.names, self.values, strict=True) if v
        )
        return f"Plan({found})"

    def _table_(self) -> Table:
        """A row for each parameter."""
        return self.table().cells()


@readable
@dataclass(frozen=True, eq=False)
class PlanScan:
    """Plans over tips and depths.

    Attributes
    ----------
    tips : tuple of str
        Names of the tips.
    depths : tuple of float
        Largest depths [m].
    plans : dict
        (tip, depth) -> Plan; the reason in words where there is none.

    See Also
    --------
    flatpunch.fit.plan_scan : Makes it.

    Examples
    --------
    >>> from flatpunch.fit import plan_scan
    >>> gel = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], base=fp.RigidBase())
    >>> scan = plan_scan(gel, {"5 um": fp.Sphere(5e-6)}, ["layers[0].young"], depths=[5e-7], noise=2e-11)
    >>> scan.plans["5 um", 5e-7].judgement("layers[0].young")
    'determined'
    """

    tips: tuple[str, ...]
    depths: tuple[float, ...]
    plans: dict[tuple[str, float], Plan | str]

    def rows(self) -> list[tuple[str, ...]]:
        """Tip, depth and the standard error of each free parameter in words, a line for each tip and depth."""
        found: list[tuple[str, ...]] = []
        for (tip, depth), plan in self.plans.items():
            place = (tip, quantity(depth, "m"))
            if isinstance(plan, str):
                found.append((*place, plan))
            else:
                found.append((*place, *(plan.error_in_words(name) for name in self.names)))
        return found

    @property
    def names(self) -> tuple[str, ...]:
        """The free parameters."""
        plan = next((plan for plan in self.plans.values() if isinstance(plan, Plan)), None)
        return () if plan is None else tuple(n for n, v in zip(plan.names, plan.values, strict=True) if v)

    def summary(self) -> str:
        """The table as text."""
        return text_of(self)

    def _line_(self) -> str:
        """What was scanned."""
        return f"PlanScan({len(self.tips)} tips, {len(self.depths)} depths)"

    def _table_(self) -> Table:
        """A row for each tip and depth."""
        width = 2 + len(self.names)
        rows = tuple((*row, *[""] * (width - len(row))) for row in self.rows())
        return Table("Relative standard errors", ("tip", "depth", *map(label, self.names)), rows)
