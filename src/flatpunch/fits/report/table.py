"""Numbers of a fit for people: labels and units, rows of values with intervals, and the tables and files made of them."""

from __future__ import annotations

import csv
import io
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array
from flatpunch._support.declared import Place
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.readable import Table, readable
from flatpunch._support.whole_file import sealed
from flatpunch._version import __version__
from flatpunch.files.results import netcdf, write
from flatpunch.fits.parameters.sample import BESIDE, OF
from flatpunch.fits.parameters.settings import Settings


def label(number: Place) -> str:
    """A number in the words of the field: "E of layer 1" for "layers[0].young"."""
    path, _, curve = number.path.partition(OF)
    if curve:
        return f"{label(number._replace(path=path))} ({curve})"
    word, (owner, _, last) = number.number.what, path.rpartition(".")
    if place := re.search(r"\[(\d+)\]$", last):
        word = f"{word} {int(place[1]) + 1}"
    side = f"{path.partition('.')[0]} " if path.startswith(("upper.", "lower.")) else ""
    if layer := re.search(r"layers\[(\d+)\]", owner):
        return f"{word} of {side}layer {int(layer[1]) + 1}"
    if owner.endswith("base"):
        return f"{word} of {side}base"
    return f"tip {word}" if path.startswith("indenter.") else word


def unit_of(number: Place) -> str:
    """SI unit, empty without one."""
    return number.number.unit or ""


def between(low: float | None, high: float | None, unit: str) -> str:
    """Limits as the end of a sentence; empty if both are open."""
    if low is None and high is None:
        return ""
    low_text, high_text = ("any" if limit is None else text(limit, unit) for limit in (low, high))
    return f", between {low_text} and {high_text}"


def axis_label(number: Place, unit: str) -> str:
    """Label of an axis of a number."""
    return f"{label(number)} ({unit})" if unit else label(number)


LEVEL = Settings().level
"""Confidence level of intervals where none is asked for."""
_TEXTS = ("curve", "file", "reason", "notes", "read")
"""Columns of records that hold text."""


@readable
@dataclass(frozen=True, slots=True)
class Estimate:
    """One fitted value, SI.

    Attributes
    ----------
    value, stderr : float
        Best value and its standard error.
    low, high : float
        Confidence interval, from the covariance symmetric in the logarithm for moduli, lengths and slopes. Infinite or zero (or
        on a limit) on a side on which the data do not end it.
    start : float
        Where the search began.
    at_bound : bool
        Whether the value is on a limit.
    by : "covariance", "profile", "draws" or "nothing"
        Where the interval comes from: the likelihood profile where the covariance is not enough; "nothing" where the data do
        not determine the parameter.

    See Also
    --------
    flatpunch.fits.FitResult : Holds one for each parameter.
    flatpunch.fits.Profile : The likelihood behind wide intervals.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> depth = np.linspace(-200e-9, 400e-9, 121)
    >>> force = np.where(depth > 0, fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.maximum(depth, 1e-12)).force, 0.0)
    >>> curve = fp.Curve(depth=depth + 50e-9, force=force)
    >>> result = fp.fit(curve, gel, fp.Sphere(radius=5e-6), {"layers[0].young": fp.Free(2e3)})
    >>> young = result.estimates["layers[0].young"]
    >>> print(f"{young.value / 1e3:.2f} kPa, interval contains the value: {young.low <= young.value <= young.high}")
    5.00 kPa, interval contains the value: True
    """

    value: float
    stderr: float
    low: float = float("nan")
    high: float = float("nan")
    start: float = float("nan")
    at_bound: bool = False
    by: str = "covariance"

    @property
    def determined(self) -> bool:
        """Whether the data end the interval on both sides."""
        return bool(np.isfinite(self.low) and np.isfinite(self.high) and self.by != "nothing")


@lru_cache(maxsize=1024)
def half_width(level: float, freedom: int) -> float:
    """Half width of a two-sided interval in standard errors."""
    from scipy.stats import t as student

    return float(student.ppf((1 + level) / 2, freedom))


def correlation_of(covariance: Array) -> Array:
    """Correlations of a covariance (p, p); nan where a variance is zero or infinite."""
    scale = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(covariance / scale[:, None] / scale)


@dataclass(frozen=True, slots=True)
class Row:
    """One line of a table: an estimate by its name, with its SI unit and its name in words. An interval of nan is none."""

    name: str
    estimate: Estimate
    unit: str
    note: str = ""
    words: str = ""

    @property
    def label(self) -> str:
        """Its name in words."""
        return self.words or self.name

    @classmethod
    def of(cls, number: Place, estimate: Estimate, note: str = "") -> Row:
        """The line of a number of a fit."""
        return cls(number.path, estimate, unit_of(number), note, label(number))

    @property
    def value(self) -> str:
        """Value in words: a bound, or no number, where the data do not end its interval."""
        e, unit = self.estimate, self.unit
        if np.isnan(e.value) or e.by == "nothing":
            return "not determined"
        if np.isnan(e.low):
            return text(e.value, unit) if e.value else ""
        below, above = np.isfinite(e.low) and e.low != 0, np.isfinite(e.high)
        if not (below or above):
            return "not determined"
        if not above:
            return f"> {text(e.low, unit)}"
        return f"< {text(e.high, unit)}" if not below and e.by == "profile" else text(e.value, unit)

    @property
    def stderr(self) -> str:
        """Standard error in words."""
        error = self.estimate.stderr
        return "" if np.isnan(error) else text(error, self.unit)

    @property
    def interval(self) -> str:
        """Interval in words."""
        e, unit = self.estimate, self.unit
        if e.by == "nothing":
            return "any value (not determined by the data)"
        if np.isnan(e.low):
            return ""
        if self.name == "contact" and e.by != "draws" and np.isfinite(e.stderr):
            # far from its own zero an interval would need many digits
            return f"± {text((e.high - e.low) / 2, unit)}"
        return f"{text(e.low, unit)} .. {text(e.high, unit)}"

    @property
    def stated(self) -> str:
        """Interval, or that the value is on a limit, which the covariance knows nothing of."""
        return "at its limit" if self.estimate.at_bound and self.estimate.by == "covariance" else self.interval


@dataclass(frozen=True, slots=True)
class Rows:
    """A result as a table.

    Attributes
    ----------
    title : str
    rows : tuple of Row
    level : float
        Confidence level of the intervals.
    notes, read : tuple of str
        Sentences below the rows, and lines above them about the origin of the data.
    value : str
        Title of the column of values.
    """

    title: str
    rows: tuple[Row, ...]
    level: float = LEVEL
    notes: tuple[str, ...] = ()
    read: tuple[str, ...] = ()
    value: str = "value"

    def text(self) -> str:
        """The table as text for the terminal."""
        width = max([24, *(len(row.label) for row in self.rows)])
        lines = [self.title, *(f"  Read {line}" for line in self.read)]
        for row in self.rows:
            said = row.stated
            if said and said == row.interval:
                said = f"{self._level} {'' if said[0] == '±' else 'in '}{said}"
            said = "   ".join(filter(None, (said, row.note)))
            lines.append(f"  {row.label:<{width}} {row.value:>12}   {said}".rstrip())
        return "\n".join([*lines, *(f"  Note: {note}" for note in self.notes)])

    def cells(self) -> Table:
        """The table as cells, without columns that are empty."""
        header = ("", self.value, "standard error", f"{self._level} interval", "note")
        cells = [(row.label, row.value, row.stderr, row.stated, row.note) for row in self.rows]
        used = [i for i in range(len(header)) if any(row[i] for row in cells)]
        rows = tuple(tuple(row[i] for i in used) for row in cells)
        return Table(self.title, tuple(header[i] for i in used), rows, self.notes)

    def csv(self) -> str:
        """The table as CSV in SI units, to the last digit."""
        names = ("name", "value", "low", "high", "unit", "note")
        rows = ((r.name, r.estimate.value, r.estimate.low, r.estimate.high, r.unit, r.note) for r in self.rows)
        return csv_of([dict(zip(names, row, strict=True)) for row in rows], {})

    def record(self) -> Plain:
        """The numbers in one line of a table of many results."""
        line: Plain = {}
        for name, e in ((row.name, row.estimate) for row in self.rows):
            line |= {name: e.value, f"{name} stderr": e.stderr, f"{name} low": e.low, f"{name} high": e.high}
        return line

    @property
    def _level(self) -> str:
        return f"{100 * self.level:g} %"


class Tabled(ABC):
    """A result that has a table of its own, in the forms in which it is shown."""

    __slots__ = ()

    @abstractmethod
    def table(self) -> Rows:
        """The table."""

    def summary(self) -> str:
        """The table as text."""
        return self.table().text()

    def to_csv(self) -> str:
        """The table as CSV text, in SI units."""
        return self.table().csv()

    def _table_(self) -> Table:
        return self.table().cells()


def rows_of(estimates: Mapping[str, Estimate], numbers: Mapping[str, Place]) -> tuple[Row, ...]:
    """A row for each estimate."""
    return tuple(Row.of(numbers[name], estimate) for name, estimate in estimates.items())


def columns_of(records: Iterable[Plain]) -> list[str]:
    """All columns, in the order in which they first appear, notes last."""
    names = dict.fromkeys(name for row in records for name in row)
    return [name for name in names if name != "notes"] + ["notes"] * ("notes" in names)


def column(records: Sequence[Plain], name: str) -> Array:
    """One column; nan where there is nothing."""
    return np.array([row.get(name, float("nan")) for row in records])


def units_in(records: Sequence[Plain], numbers: Mapping[str, Place]) -> dict[str, str]:
    """SI units of columns, "" where they have none: of "layers[0].young low" that of the modulus."""
    known, names = {**BESIDE, **numbers}, columns_of(records)
    found = {name: known.get(re.sub(r" (stderr|low|high)$", "", name)) for name in names}
    return {name: "" if number is None else unit_of(number) for name, number in found.items()}


def csv_of(records: Sequence[Plain], units: Mapping[str, str]) -> str:
    """Records as CSV text; units are in the titles."""
    names, out = columns_of(records), io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([f"{name} [{unit}]" if (unit := units.get(name)) else name for name in names])
    writer.writerows([row.get(name, "") for name in names] for row in records)
    return out.getvalue()


def dataset_of(records: Sequence[Plain], title: str, units: Mapping[str, str]) -> xr.Dataset:
    """Records along `curve`."""
    data: Plain = {}
    for name in columns_of(records):
        if name != "curve":
            texts = name in _TEXTS
            values = [str(row.get(name, "")) for row in records] if texts else column(records, name)
            data[name] = ("curve", values, {"units": unit} if (unit := units.get(name)) else {})
    names = [str(row["curve"]) for row in records]
    return xr.Dataset(data, {"curve": names}, {"title": title, "flatpunch_version": __version__})


def saved(path: str | Path, text: Callable[[], str], data: Callable[[], xr.Dataset]) -> Path:
    """Write a table whole or not at all: text as .csv, data as .nc."""
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in (".csv", ".nc"):
        raise ValueError(f"{path}: a table is kept as .csv or .nc.")
    write(path, text().encode("utf-8") if kind == ".csv" else sealed(netcdf(data())))
    return path
