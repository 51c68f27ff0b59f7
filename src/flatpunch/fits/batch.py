"""Many curves with one case: in parallel, with progress; a bad curve becomes a record with its reason."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array, Values, mapping, numbers, shown
from flatpunch._support.declared import Number
from flatpunch._support.declared import Place as Record
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.readable import Table, readable
from flatpunch._support.threads import cores
from flatpunch.fits.fitting import Model, fit_model, model_of
from flatpunch.fits.measured.curve import Curve, check_curves
from flatpunch.fits.parameters.sample import BESIDE, Sample
from flatpunch.fits.parameters.settings import Free, FreeNames, Options, Settings, as_free, options_of
from flatpunch.fits.places import Place, Records, keys_of, listed, on_grid
from flatpunch.fits.report.findings import doubts
from flatpunch.fits.report.table import (
    Estimate,
    column,
    columns_of,
    csv_of,
    dataset_of,
    label,
    saved,
    unit_of,
    units_in,
)
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.parallel.calls import Missing, map_calls
from flatpunch.parallel.worker import processes

Placed = tuple[Curve | Place, Mapping[str, float]]
"""A curve, or where it is, with the values that are known of its place."""

_CHUNK = 16
"""Curves between two reports of progress, whose records are kept in one file."""
_PAUSE = 20.0
"""Seconds after which fewer curves are reported and kept as well: fits that take minutes are not to be lost."""
_SHOWN = 20
"""Curves that a batch shows as a table."""


@readable
@dataclass(frozen=True)
class Batch:
    """Results of many fits.

    Attributes
    ----------
    rows : tuple of dict
        One a curve, in the order of the input, those of a map line by line: "curve", where it comes from ("file", "index"), "ok",
        "reason", the columns of `FitResult.row`, and in a map the position, "row" and "column".

    See Also
    --------
    flatpunch.fit_batch : Makes it.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> depth = np.linspace(-200e-9, 400e-9, 121)
    >>> force = np.where(depth > 0, fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.maximum(depth, 1e-12)).force, 0.0)
    >>> curve = fp.Curve(depth=depth + 50e-9, force=force)
    >>> batch = fp.fit_batch([curve], gel, fp.Sphere(radius=5e-6), {"layers[0].young": fp.Free(2e3)}, workers=1)
    >>> print(len(batch.rows), batch.rows[0]["ok"])
    1 True
    """

    rows: tuple[Plain, ...]
    numbers: Mapping[str, Record] = field(default_factory=dict, repr=False, compare=False)

    def number(self, name: str) -> Record:
        """Declaration of a fitted value; one without a unit for other columns."""
        return {**BESIDE, **self.numbers}.get(name) or Record(name, np.nan, Number(name), None)

    def _line_(self) -> str:
        return f"Batch({len(self.rows)} curves, {len(self.failed)} left out)"

    def _table_(self) -> Table:
        fitted = [self.number(name) for name in self.fitted]
        rows = [
            (
                str(row["curve"]),
                *(text(float(row.get(each.path, np.nan)), unit_of(each)) for each in fitted),
                str(row["reason"]),
            )
            for row in self.rows[:_SHOWN]
        ]
        title = f"{len(self.rows)} curves, {len(self.failed)} left out" + (
            f"; the first {_SHOWN}" if len(self.rows) > _SHOWN else ""
        )
        return Table(title, ("curve", *map(label, fitted), "left out"), tuple(rows))

    @property
    def columns(self) -> list[str]:
        """All columns, in the order in which they first appear, notes last."""
        return columns_of(self.rows)

    @property
    def fitted(self) -> list[str]:
        """Columns of fitted values: those with an interval."""
        return [name.removesuffix(" low") for name in self.columns if name.endswith(" low")]

    @property
    def failed(self) -> tuple[Plain, ...]:
        """Records of the curves that could not be evaluated, or whose values cannot be trusted; the latter keep their values."""
        return tuple(row for row in self.rows if not row["ok"])

    def column(self, name: str) -> Any:
        """One column; nan where there is nothing."""
        return column(self.rows, name)

    def trusted(self, name: str) -> Array:
        """Values of a fitted parameter; nan for the curves that are left out."""
        values = np.asarray(self.column(name), dtype=float)
        return np.where([bool(row["ok"]) for row in self.rows], values, np.nan)

    def median(self, name: str, level: float = 0.95) -> Estimate:
        """Median of a fitted parameter over the curves that count, with its confidence interval.

        The interval ends at two of the values, by their rank: below the median are as many as tosses of a coin show heads. It
        holds for any distribution, and is infinite where the curves are too few. The standard error is nan.

        Examples
        --------
        >>> batch = fp.fits.Batch(tuple({"curve": f"{i}", "ok": True, "reason": "", "E": float(i)} for i in range(25)))
        >>> m = batch.median("E")
        >>> m.low, m.value, m.high
        (7.0, 12.0, 17.0)
        """
        values = self.trusted(name)
        values = np.sort(values[np.isfinite(values)])
        if not values.size:
            return Estimate(np.nan, np.nan, -np.inf, np.inf)
        from scipy.stats import binom

        # fewer than k of n values lie below the median with at most half of the probability that is left out
        k = int(binom.ppf((1 - level) / 2, values.size, 0.5))
        low, high = (values[k - 1], values[-k]) if k else (-np.inf, np.inf)
        return Estimate(float(np.median(values)), np.nan, float(low), float(high))

    def to_csv(self) -> str:
        """The table as CSV text; units are in the titles."""
        return csv_of(self.rows, units_in(self.rows, self.numbers))

    def dataset(self) -> xr.Dataset:
        """The table along `curve`."""
        return dataset_of(self.rows, "Fitted curves", units_in(self.rows, self.numbers))

    def save(self, path: str | Path) -> Path:
        """Write the table whole or not at all: .csv or .nc."""
        return saved(path, self.to_csv, self.dataset)


def fit_batch(
    curves: Iterable[Curve | str | Path],
    medium: Body,
    indenter: Indenter,
    free: FreeNames = (),
    *,
    values: Mapping[str, Values] | None = None,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
    reading: Plain | None = None,
    store: str | Path | None = None,
    **options: Unpack[Options],
) -> Batch:
    """Fit one case to many curves.

    Parameters
    ----------
    curves : iterable of Curve or path
        Curves, or files to be read; all curves of a force map.
    medium, indenter, free
        As for `fit`.
    values : mapping of str to array, shape (curves,), optional
        Known values [SI] that differ from curve to curve, in the order of the curves, by the names of
        `flatpunch.fits.parameter_names`: {"layers[0].thickness": [...]}.
    workers : int, optional
        Processes; one for each core if left out, at most one for 64 curves.
    progress : callable, optional
        Called with the number of curves done so far.
    reading : mapping, optional
        Keyword arguments of `read_curve` for paths.
    store : path, optional
        Folder in which records are kept as they are made. After an interruption the same call goes on from there; curves or a
        case that have changed since, and curves that could not be evaluated, are fitted again. Delete it when all is done.
    **options
        As for `fit`; quick unless `quick=False` is given.

    Returns
    -------
    Batch
        One record for each curve, good or bad.

    See Also
    --------
    fit : One curve.
    fit_together : Several curves of one sample.
    fits.Batch : What it returns.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> depth = np.linspace(-200e-9, 400e-9, 121)
    >>> force = np.where(depth > 0, fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.maximum(depth, 1e-12)).force, 0.0)
    >>> curve = fp.Curve(depth=depth + 50e-9, force=force)
    >>> tip, free = fp.Sphere(radius=5e-6), {"layers[0].young": fp.Free(2e3)}
    >>> batch = fp.fit_batch([curve, curve], gel, tip, free, workers=1)  # or paths of files
    >>> print([f"{row['layers[0].young'] / 1e3:.2f} kPa" for row in batch.rows])
    ['5.00 kPa', '5.00 kPa']
    """
    check_curves(curves)
    if reading is not None and not isinstance(reading, Mapping):
        raise TypeError(f"reading = {shown(reading)} must be a mapping of arguments of read_curve.")
    given: Options = {"quick": True, **options}
    physics, chosen = options_of(given)
    sample = Sample(medium, indenter, physics)
    rows: list[Plain] = []
    records = Records(store) if store is not None else None
    wanted, items = as_free(free), listed(curves, reading)
    places = placed(items, values, sample, wanted)
    for done in fit_rows(places, sample, wanted, chosen, reading, workers, records):
        rows.extend(done)
        if progress is not None:
            progress(len(rows))
    return Batch(tuple(on_grid(rows)), sample.numbers)


def placed(
    items: Sequence[Curve | Place], values: Mapping[str, Values] | None, sample: Sample, free: Mapping[str, Free]
) -> list[Placed]:
    """Curves with the values that are known of their places."""
    known = mapping("values", values, "{'layers[0].thickness': [1e-6, 2e-6]}")
    sample.check(known)
    columns = {}
    for name, given in known.items():
        if name in free:
            raise ValueError(f"values: {name} is fitted; leave it out of values, or out of free.")
        columns[name] = numbers(f"values[{name!r}]", given, sample.numbers[name].number.unit or "")
        if columns[name].shape != (len(items),):
            raise ValueError(
                f"values[{name!r}] has shape {columns[name].shape}; it needs one value for each of the {len(items)} curves."
            )
    return [(item, {name: float(column[i]) for name, column in columns.items()}) for i, item in enumerate(items)]


def fit_rows(
    items: Sequence[Placed],
    sample: Sample,
    free: Mapping[str, Free],
    settings: Settings,
    reading: Plain | None = None,
    workers: int | None = None,
    records: Records | None = None,
) -> Iterator[list[Plain]]:
    """Records of fits, chunk by chunk, in order; those kept in `records` are not made again. See `fit_batch`."""
    model_of(sample, free, settings.method).bounds(free)
    job = _Job(sample, free, settings, dict(reading or {}))
    keys = [None] * len(items) if records is None else keys_of(items, sample, free, settings, job.reading)
    known = {} if records is None else {i: records.known[key] for i, key in enumerate(keys) if key in records.known}
    missing = [i for i in range(len(items)) if i not in known]
    if records is not None:
        records.reused = len(known)
    fresh: list[int] = []
    place, kept = 0, time.monotonic()

    def keep() -> None:
        if records is not None:
            records.keep([keys[i] for i in fresh], [known[i] for i in fresh])
        fresh.clear()

    def ready() -> list[Plain]:
        nonlocal place
        start, place = place, next((i for i in range(place, len(items)) if i not in known), len(items))
        return [known[i] for i in range(start, place)]

    try:
        for made in _fitted(job, [items[i] for i in missing], workers):
            known |= {missing[i]: row for i, row in made}
            fresh.extend(missing[i] for i, _ in made)
            if len(fresh) >= _CHUNK or time.monotonic() - kept >= _PAUSE:
                keep()
                kept = time.monotonic()
                if rows := ready():
                    yield rows
    except KeyboardInterrupt:
        yield [known[i] for i in range(place, len(items)) if i in known]
        raise
    finally:
        # what was fitted is kept, whatever ends the run
        keep()
    if rows := ready():
        yield rows


def _fitted(job: _Job, items: Sequence[Placed], workers: int | None) -> Iterator[list[tuple[int, Plain]]]:
    """Records as they are made, here and in worker processes, each with the index of its item."""
    # starting a process takes as long as a few reports
    few = 1 + len(items) // (4 * _CHUNK)
    count = min(workers if workers is not None else min(cores(), few), len(items))
    team = processes(count - 1) if count > 1 else None
    for made in map_calls(job.one, items, team, here=job.one):
        yield [(i, job.lost(items[i], row) if isinstance(row, Missing) else row) for i, row in made]


@dataclass(frozen=True)
class _Job:
    """What every worker needs to know; models are made where they are used, as their tables hold functions."""

    sample: Sample
    free: Mapping[str, Free]
    settings: Settings
    reading: Plain

    @cached_property
    def _model(self) -> Model:
        return model_of(self.sample, self.free, self.settings.method)

    def one(self, placed: Placed) -> Plain:
        """The record of a curve: whatever is wrong with it must not cost the others."""
        item, values = placed
        origin, place = _origin(item), {}
        try:
            curve = item if isinstance(item, Curve) else replace(item.read(self.reading), name=origin["curve"])
            known = curve.meta.get("metadata", {})
            place = {key: float(known[key]) for key in ("position x", "position y") if known.get(key) is not None}
            model = model_of(self.sample.replaced(values), self.free, self.settings.method) if values else self._model
            result = fit_model(curve, model, self.free, self.settings, values)
        except Exception as error:
            ours = isinstance(error, (ValueError, TypeError, OSError))
            reason = str(error) if ours else f"{type(error).__name__}: {error}"
            return {**origin, "ok": False, "reason": reason, **place}
        reasons = doubts(result)
        doubtful = {"ok": False, "reason": f"{origin['curve']}: {'; '.join(reasons)}."} if reasons else {}
        return {**origin, **result.row(), **doubtful, **place}

    def lost(self, placed: Placed, missing: Missing) -> Plain:
        return {**_origin(placed[0]), "ok": False, "reason": missing.reason}


def _origin(item: Curve | Place) -> Plain:
    if isinstance(item, Curve):
        return {"curve": item.name}
    return {"curve": item.name, "file": item.path.name, "index": item.index or 0}
