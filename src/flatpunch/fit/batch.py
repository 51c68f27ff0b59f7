"""Many curves with one case: in parallel, with progress; a bad curve becomes a record with its reason."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from flatpunch._version import __version__
from flatpunch.files.results import whole_file
from flatpunch.fit.curve import Curve
from flatpunch.fit.fitting import fit_model, model_of
from flatpunch.fit.forward import ForwardModel
from flatpunch.fit.readers import AFM, EXCEL, TEXT, read_curve
from flatpunch.fit.report import unit_of
from flatpunch.fit.settings import Free, Settings, as_free

_CHUNK = 16
_TEXTS = ("curve", "reason", "notes")


@dataclass(frozen=True)
class Batch:
    """Results of many fits.

    Attributes
    ----------
    rows : tuple of dict
        One a curve, in the order of the input: "curve", "ok", "reason", and the columns of `FitResult.row`.
    """

    rows: tuple[Mapping[str, Any], ...]

    @property
    def columns(self) -> list[str]:
        """All columns, in the order in which they first appear, notes last."""
        names = dict.fromkeys(name for row in self.rows for name in row)
        names.pop("notes", None)
        return [*names, "notes"]

    @property
    def failed(self) -> tuple[Mapping[str, Any], ...]:
        """Records of the curves that could not be evaluated."""
        return tuple(row for row in self.rows if not row["ok"])

    def column(self, name: str) -> Any:
        """One column; nan where there is nothing."""
        return np.array([row.get(name, float("nan")) for row in self.rows])

    def to_csv(self) -> str:
        """The table as CSV text; units are in the titles."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow([_title(name) for name in self.columns])
        for row in self.rows:
            writer.writerow([row.get(name, "") for name in self.columns])
        return out.getvalue()

    def dataset(self) -> xr.Dataset:
        """The table along `curve`."""
        data: dict[str, Any] = {}
        for name in self.columns:
            if name == "curve":
                continue
            values = [str(row.get(name, "")) for row in self.rows] if name in _TEXTS else self.column(name)
            data[name] = ("curve", values, {"units": _unit(name)} if _unit(name) else {})
        names = [str(row["curve"]) for row in self.rows]
        return xr.Dataset(data, {"curve": names}, {"title": "Fitted curves", "flatpunch_version": __version__})

    def save(self, path: str | Path) -> Path:
        """Write the table whole or not at all: .csv or .nc."""
        path = Path(path)
        if path.suffix.lower() not in (".csv", ".nc"):
            raise ValueError(f"{path}: a table is kept as .csv or .nc.")
        with whole_file(path) as temporary:
            if path.suffix.lower() == ".csv":
                temporary.write_text(self.to_csv(), encoding="utf-8")
            else:
                self.dataset().to_netcdf(temporary, engine="h5netcdf")
        return path


def _unit(name: str) -> str:
    bare = name.split(" ")[0]
    if bare in ("deepest", "noise"):
        return {"deepest": "m", "noise": "N"}[bare]
    try:
        return unit_of(bare)
    except KeyError:
        return ""


def _title(name: str) -> str:
    return f"{name} [{_unit(name)}]" if _unit(name) else name


def fit_batch(
    curves: Iterable[Any],
    medium: Any,
    indenter: Any,
    free: Any = (),
    *,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
    reading: Mapping[str, Any] | None = None,
    **settings: Any,
) -> Batch:
    """Fit one case to many curves.

    Parameters
    ----------
    curves : iterable of Curve or path
        Curves, or files to be read.
    medium, indenter, free
        As for `fit`.
    workers : int, optional
        Processes; one for each core if left out, at most one for 64 curves.
    progress : callable, optional
        Called with the number of curves done so far.
    reading : mapping, optional
        Keyword arguments of `read_curve` for paths.
    **settings
        As for `fit`; the engine is the fast one unless named.

    Returns
    -------
    Batch
        One record for each curve, good or bad.
    """
    chosen = Settings(**{"engine": "normal-equations", **settings})
    wanted = as_free(free)
    start = tuple(sorted((name, f.start) for name, f in wanted.items() if f.start is not None))
    model = model_of(medium, indenter, tuple(wanted), start, chosen.method)
    job = _Job(model, wanted, chosen, dict(reading or {}))
    items = list(curves)
    count = workers if workers is not None else min(os.cpu_count() or 1, 1 + len(items) // 64)
    rows: list[dict[str, Any]] = []
    for done in _done(job, items, count):
        rows.extend(done)
        if progress is not None:
            progress(len(rows))
    return Batch(tuple(rows))


def _done(job: _Job, items: Sequence[Any], workers: int) -> Iterator[list[dict[str, Any]]]:
    """Records, chunk by chunk, in order. The first chunk is done here: its tables are inherited where processes fork."""
    chunks = (items[i : i + _CHUNK] for i in range(0, len(items), _CHUNK))
    first = next(chunks, ())
    if first:
        yield job.run(first)
    if workers <= 1:
        yield from map(job.run, chunks)
        return
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(job.run, chunks)


@dataclass(frozen=True)
class _Job:
    """What every worker needs to know."""

    model: ForwardModel
    free: Mapping[str, Free]
    settings: Settings
    reading: Mapping[str, Any]

    def run(self, items: Sequence[Any]) -> list[dict[str, Any]]:
        return [self._one(item) for item in items]

    def _one(self, item: Any) -> dict[str, Any]:
        name = item.name if isinstance(item, Curve) else str(item)
        try:
            curve = item if isinstance(item, Curve) else replace(read_curve(item, **self.reading), name=Path(item).name)
            row = fit_model(curve, self.model, self.free, self.settings).row()
        except Exception as error:
            # whatever is wrong with one curve must not cost the others
            known = isinstance(error, (ValueError, TypeError, OSError))
            return {"curve": name, "ok": False, "reason": str(error) if known else f"{type(error).__name__}: {error}"}
        for axis in ("x", "y"):
            position = curve.meta.get("metadata", {}).get(f"position {axis}")
            if position is not None:
                row[f"position {axis}"] = float(position)
        return row

    def __reduce__(self) -> Any:
        # tables are made anew in each process that does not inherit them; solvers hold functions that cannot travel
        parts = (self.model.medium, self.model.indenter, self.model.free, self.model.method)
        return _job, (*parts, dict(self.free), self.settings, dict(self.reading))


def _job(
    medium: Any, indenter: Any, names: tuple[str, ...], method: str, free: Any, settings: Any, reading: Any
) -> _Job:
    return _Job(model_of(medium, indenter, names, (), method), free, settings, reading)


def files_in(folder: str | Path) -> list[Path]:
    """Files of a folder that can be read as curves, in order."""
    folder = Path(folder)
    found = sorted(p for p in folder.iterdir() if p.suffix.lower() in (*TEXT, *EXCEL, *AFM, ".zip") and p.is_file())
    if not found:
        raise ValueError(f"{folder}: no files of curves ({', '.join((*TEXT, *EXCEL, *AFM))}).")
    return found
