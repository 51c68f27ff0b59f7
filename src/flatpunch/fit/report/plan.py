"""What a planned curve determines: standard errors of its parameters, in words and as a table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, shown
from flatpunch._support.readable import Table, readable
from flatpunch.fit.report.quantities import label, quantity, unit_of

WELL, POORLY = 0.1, 1.0
"""Largest relative standard error of a parameter that counts as determined, and smallest of one that does not."""

TANGLED = 0.98
"""Correlation above which two parameters count as hardly distinguished, if their intervals are wide as well."""


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
        scale = np.sqrt(np.diag(self.covariance))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.covariance / scale[:, None] / scale)

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
        j = self.names.index(name)
        return f"± {100 * self._relative(j):.2g} %" if unit_of(name) else f"± {self.errors[j]:.2g}"

    def lines(self) -> list[str]:
        """The free parameters with their standard errors, one a line, then the notes."""
        found = [self.text]
        for j, name in enumerate(self.names):
            unit = unit_of(name)
            if not self.values[j]:
                found.append(f"{label(name)}: ± {quantity(float(self.errors[j]), unit)}")
                continue
            error = self.error_in_words(name)
            judged = self.judgement(name)
            said = judged if error == judged else f"{error}: {judged}"
            found.append(
                f"{label(name)} {quantity(float(self.values[j]), unit)}{': ' if error == judged else ' '}{said}"
            )
        return [*found, *self.notes]

    def summary(self) -> str:
        """The plan in words."""
        return "\n  ".join(self.lines())

    def _line_(self) -> str:
        """The free parameters."""
        found = ", ".join(
            f"{name} {self.judgement(name)}" for name, v in zip(self.names, self.values, strict=True) if v
        )
        return f"Plan({found})"

    def _table_(self) -> Table:
        """A row for each parameter."""
        rows = tuple(
            (
                label(name),
                quantity(float(value), unit_of(name)) if value else "",
                quantity(float(error), unit_of(name)),
                self.judgement(name) if value else "",
            )
            for name, value, error in zip(self.names, self.values, self.errors, strict=True)
        )
        return Table(self.text, ("", "value", "standard error", ""), rows, self.notes)
