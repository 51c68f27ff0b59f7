"""What a planned curve determines, of one tip and depth or of several: numbers, judgements, tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flatpunch._support.checks import Array, shown
from flatpunch._support.declared import Place
from flatpunch._support.prefixes import text
from flatpunch._support.readable import Table, readable, text_of
from flatpunch.fits.report.table import Estimate, Row, Rows, Tabled, correlation_of, label, unit_of

WELL, POORLY = 0.1, 1.0
"""Largest relative standard error of a parameter that counts as determined, and smallest of one that does not."""


@readable
@dataclass(frozen=True, eq=False)
class Plan(Tabled):
    """What a planned curve determines.

    Attributes
    ----------
    numbers : mapping of str to Place
        The free parameters with their declarations, then the contact point and the background that are fitted with them.
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
    flatpunch.fits.planned : Makes it.

    Examples
    --------
    >>> from flatpunch.fits import planned
    >>> layer = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], base=fp.RigidBase())
    >>> plan = planned(layer, fp.Sphere(5e-6), ["layers[0].young"], depth=5e-7, noise=2e-11)
    >>> print(plan.names[0], plan.errors[0] < 0.05 * plan.values[0])
    layers[0].young True
    """

    numbers: Mapping[str, Place]
    values: Array
    errors: Array
    covariance: Array
    undetermined: Array
    text: str
    notes: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(self.numbers)

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
        return (
            float(self.errors[j] / abs(self.values[j]))
            if unit_of(self.numbers[self.names[j]])
            else float(self.errors[j])
        )

    def error_in_words(self, name: str) -> str:
        """Standard error, relative to the value if that has a unit; "not determined" where it says nothing."""
        if self.judgement(name) == "not determined":
            return "not determined"
        error = self._relative(self.names.index(name))
        return f"± {100 * error:.2g} %" if unit_of(self.numbers[name]) else f"± {error:.2g}"

    def table(self) -> Rows:
        """The table: a row for each parameter; of contact and background the standard error alone."""
        rows = []
        for (name, number), value, error in zip(self.numbers.items(), self.values, self.errors, strict=True):
            said = f"± {text(float(error), unit_of(number))}"
            if value:
                said = ": ".join(dict.fromkeys((self.error_in_words(name), self.judgement(name))))
            rows.append(Row.of(number, Estimate(float(value), float(error), by="plan"), said))
        return Rows(self.text, tuple(rows), notes=self.notes)

    def _line_(self) -> str:
        found = ", ".join(
            f"{name} {self.judgement(name)}" for name, v in zip(self.names, self.values, strict=True) if v
        )
        return f"Plan({found})"


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
    flatpunch.fits.plan_scan : Makes it.

    Examples
    --------
    >>> from flatpunch.fits import plan_scan
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
        return [
            (tip, text(depth, "m"), *([plan] if isinstance(plan, str) else map(plan.error_in_words, self.names)))
            for (tip, depth), plan in self.plans.items()
        ]

    @property
    def names(self) -> tuple[str, ...]:
        """The free parameters."""
        return tuple(each.path for each in self.numbers)

    @property
    def numbers(self) -> tuple[Place, ...]:
        """Their declarations."""
        plan = next((plan for plan in self.plans.values() if isinstance(plan, Plan)), None)
        return () if plan is None else tuple(n for n, v in zip(plan.numbers.values(), plan.values, strict=True) if v)

    def summary(self) -> str:
        """The table as text."""
        return text_of(self)

    def _line_(self) -> str:
        return f"PlanScan({len(self.tips)} tips, {len(self.depths)} depths)"

    def _table_(self) -> Table:
        width = 2 + len(self.names)
        rows = tuple((*row, *[""] * (width - len(row))) for row in self.rows())
        return Table("Relative standard errors", ("tip", "depth", *map(label, self.numbers)), rows)
