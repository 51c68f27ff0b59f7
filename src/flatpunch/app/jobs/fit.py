"""The job *Fit*: preview of a measured file, fit, drift over depth, all curves of a file. Called in worker processes."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.declared import Place
from flatpunch._support.messages import message
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.progress import reporting
from flatpunch.app.form import case_data, case_text
from flatpunch.app.jobs.common import CALLED, explained, file_bytes, plain, short
from flatpunch.app.limits import DRAWN
from flatpunch.app.store import Upload
from flatpunch.files.cases import parsed
from flatpunch.files.descriptions import spread
from flatpunch.files.tables.fields import validated
from flatpunch.fits.batch import Batch, Placed, fit_rows
from flatpunch.fits.case import DRIFTING, FitCase, drift, fit_case_from
from flatpunch.fits.cases import CurveTable
from flatpunch.fits.description import describe_fit
from flatpunch.fits.fitting import fit, forget_models
from flatpunch.fits.measured.columns import Table, chosen_columns
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.files.readers import EXCEL, TEXT, MissingColumn, curve_of, curves_in, read_curve, tables_in
from flatpunch.fits.places import listed, on_grid
from flatpunch.fits.reading import reading_of, traces
from flatpunch.fits.report.result import FitResult
from flatpunch.fits.report.table import label, unit_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_OF_TABLES = ("columns", "units", "spring_constant", "skip_nan", "flip")
"""Settings of reading that `curve_of` takes."""


NOTHING_TICKED = "nothing is looked for: tick “fit” under at least one value of the sample, such as its modulus."


def preview(fields: Mapping[str, str], upload: Upload) -> Plain:
    """Return what a file holds: its curves and columns, which is taken for what, the first rows, and the curve as it is read."""
    found: Plain = {"name": upload.name, "size": len(upload.content)}
    try:
        reading = validated(CurveTable, case_data(fields, "fit").get("curve", {}), CALLED).built
        with upload.written() as path:
            if path.suffix.lower() in (*TEXT, *EXCEL) and not reading.get("sensitivity"):
                # large files are read once
                tables = tables_in(path, **{name: reading[name] for name in ("columns", "decimal", "sheet")})
                found |= {"count": len(tables), **_columns(tables, reading)}
            else:
                tables = []
                found["count"] = curves_in(path, **reading)
            if len(tables) == 1 and not reading.get("index"):
                curve = curve_of(tables[0], path.stem, **{name: reading.get(name) for name in _OF_TABLES})
            else:
                curve = read_curve(path, **reading)
        seen = reading_of(curve, _whole_case(fields))
        return {
            **found,
            "points": curve.depth.size,
            "traces": [_drawn(*each) for each in traces(seen)],
            "read": list(seen.lines),
        }
    except CurveError as error:
        return {**found, **_unread(error)}
    except Exception as error:
        return {**found, **explained(error, fields, dict.fromkeys(CurveTable.model_fields, "curve"))}


def _whole_case(fields: Mapping[str, str]) -> FitCase | None:
    """The case of the form; None where it is not complete yet."""
    try:
        return _case(fields)
    except (TypeError, ValueError):
        # the check of the form, which runs with it, names what is wrong or missing beside its field
        return None


def _columns(tables: Sequence[Table], reading: Plain) -> Plain:
    """Columns of the curve that is read, or of the first one."""
    table = tables[min(reading.get("index", 0), len(tables) - 1)]
    try:
        roles = chosen_columns(table, reading["columns"])
    except CurveError:
        roles = {}
    return {
        "sources": [each.source for each in tables[: DRAWN.listed]],
        "columns": [[name, unit or "no unit"] for name, unit in zip(table.names, table.units, strict=True)],
        "roles": roles,
        "rows": [[str(cell)[:40] for cell in row] for row in table.rows[: DRAWN.rows]],
    }


def fit_curve(fields: Mapping[str, str], run: bool, upload: Upload) -> Plain:
    """Fit the curve of a file, or all its curves if the form says so."""
    try:
        if run and not _looked_for(case_data(fields, "fit")):
            return {"problems": [{"field": "upload", "text": NOTHING_TICKED}]}
        case = _case(fields)
        about = list(describe_fit(case))
        if not run:
            return {"about": about, "long": "Fit this case to the curve."}
        with upload.written() as path:
            if fields.get("all") == "on":
                return {"about": about, **_all(case, path)}
            curve = read_curve(path, **case.reading)
        return {"about": about, **_one(case, curve)}
    except CurveError as error:
        return _unread(error)
    except Exception as error:
        return explained(error, fields)


def _unread(error: CurveError) -> Plain:
    """What is wrong with a file, beside the field of the column that it misses."""
    if isinstance(error, MissingColumn):
        text = f"no column of {error.role} recognised: choose one of the file's columns here."
        return {"problems": [{"field": f"curve.columns.{error.role}", "text": text}]}
    return {"problems": [{"field": "upload", "text": str(error)}]}


def _looked_for(data: object) -> bool:
    """Whether a value of a case is written { fit = ... }."""
    if isinstance(data, list):
        return any(map(_looked_for, data))
    if not isinstance(data, dict):
        return False
    return ("fit" in data and not isinstance(data["fit"], dict)) or any(map(_looked_for, data.values()))


def _case(fields: Mapping[str, str]) -> FitCase:
    return fit_case_from(parsed(case_text(fields, "fit"), CALLED), CALLED)


def _one(case: FitCase, curve: Curve) -> Plain:
    result = _fitted(case, curve)
    return {
        "rows": [[row.label, row.value, row.stated, row.stderr] for row in result.table().rows],
        "values": {name: estimate.value for name, estimate in result.estimates.items()},
        "level": f"{100 * result.settings.level:g} %",
        "notes": list(result.notes),
        "summary": result.summary(),
        "picture": _picture(result),
        "drifts": DRIFTING in case.free,
        "kept": pickle.dumps((curve, None)),
    }


def _fitted(case: FitCase, curve: Curve) -> FitResult:
    forget_models()
    return fit(curve, case.medium, case.indenter, case.free, **case.arguments)


def _picture(result: FitResult) -> Plain:
    """Points, fit and residuals over depth, or over time where that is what was fitted."""
    over_time = result.objective.model.over_time
    along = result.curve.time if over_time and result.curve.time is not None else result.depth
    chosen = spread(along.size, DRAWN.points)
    order = chosen[np.argsort(along[chosen], kind="stable")]
    return {
        "along": ["time", "s"] if over_time else ["indentation depth", "m"],
        "x": short(along[order]),
        "force": short(result.curve.force[order]),
        "fitted": short(result.force[order]),
        "residual": short(np.where(result.used, result.residual, np.nan)[order]),
        "points": int(result.used.sum()),
        "left_out": int((~result.used).sum()),
    }


def _all(case: FitCase, path: Path) -> Plain:
    """Fit every curve of a file, one after the other, with progress."""
    places: list[Placed] = [(item, {}) for item in listed([path], case.reading)]
    rows: list[Plain] = []
    forget_models()
    with reporting("Fitting", None) as report:
        for done in fit_rows(places, case.sample, case.free, replace(case.settings, quick=True), case.reading, 1):
            rows.extend(done)
            report(len(rows), len(places))
    batch = Batch(tuple(on_grid(rows)), case.sample.numbers)
    numbers = [case.sample.numbers[name] for name in case.free]
    shown = [
        [
            str(row["curve"]),
            *(_number(row.get(each.path), each) for each in numbers),
            "yes" if row["ok"] else str(row["reason"]),
        ]
        for row in rows[: DRAWN.listed]
    ]
    good = len(rows) - len(batch.failed)
    return {
        "all": {
            "columns": ["curve", *map(label, numbers), "fitted"],
            "rows": shown,
            "caption": f"{good} of {len(rows)} curves fitted"
            + (f", the first {DRAWN.listed} shown" if len(rows) > DRAWN.listed else ""),
        },
        "notes": [],
        "kept": pickle.dumps((None, batch)),
    }


def _number(value: float | None, number: Place) -> str:
    return "–" if value is None else text(float(value), unit_of(number))


def _drawn(name: str, depth: Array, force: Array) -> Plain:
    chosen = spread(depth.size, DRAWN.points)
    return {"name": name, "depth": short(depth[chosen]), "force": short(force[chosen])}


def drift_over_depth(fields: Mapping[str, str], kept: bytes, step: int) -> Plain:
    """Return the modulus over the largest fitted depth, of the case and of a half-space."""
    try:
        curve, _ = pickle.loads(kept)
        layered, bulk = drift(curve, _case(fields))
    except Exception as error:
        return {"none": message(error)}

    def series(results: list[FitResult], name: str) -> Plain:
        estimates = [result.estimates[name] for result in results]
        return {
            "depth": [plain(float(result.depth.max())) for result in results],
            "value": plain([each.value for each in estimates]),
            "low": plain([each.low for each in estimates]),
            "high": plain([each.high for each in estimates]),
        }

    return {"layered": series(layered, DRIFTING), "half_space": series(bulk, "base.young")}


def fit_file(fields: Mapping[str, str], kept: bytes, kind: str) -> bytes:
    """Return a fit as a file."""
    curve, batch = pickle.loads(kept)
    case = _case(fields)
    result = None if batch is not None else _fitted(case, curve)
    table = batch if result is None else result

    def figure() -> Figure:
        from flatpunch.fits.distributions import map_figure
        from flatpunch.fits.pictures import fit_figure

        if result is None and not case.free:
            raise ValueError("there is no picture of fits in which nothing of the case is looked for.")
        return map_figure(batch, next(iter(case.free))) if result is None else fit_figure(result)

    return file_bytes(kind, table.dataset, table.to_csv, figure)
