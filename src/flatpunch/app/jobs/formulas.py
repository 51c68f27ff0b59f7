"""The jobs *Correct* and *Compare formulas*: published formulas, beside or against the exact contact of a sample.

A reported half-space modulus is turned into that of the layer.
"""

from __future__ import annotations

import pickle
from collections.abc import Mapping

import numpy as np
import xarray as xr

from flatpunch._support.paths import Plain
from flatpunch.app.form import FormError, case_text
from flatpunch.app.jobs.common import CALLED, case_of, explained, file_bytes, plain, short
from flatpunch.app.jobs.press import is_long
from flatpunch.contact import method_of
from flatpunch.files import describe
from flatpunch.files.cases import parsed
from flatpunch.fits.case import FitCase, fit_case_from
from flatpunch.fits.fitting import forget_models
from flatpunch.fits.half_space.correction import Correction, correct
from flatpunch.fits.half_space.formulas import compare_case, comparison_csv, comparison_table

COLUMNS = ("formula", "modulus of the layer", "deviation from exact; remark")


def correct_modulus(fields: Mapping[str, str], run: bool) -> Plain:
    """Return the modulus of the layer behind a reported one."""
    try:
        case = _case(fields)
        if not run and case.settings.method != "auto" and method_of(case.settings.method).name in ("bem", "refined"):
            return {"long": "This method takes boundary element solutions."}
        forget_models()
        found = correct(medium=case.medium, indenter=case.indenter, method=case.settings.method, **case.correct)
        return {**shown(found), "kept": pickle.dumps(found)}
    except Exception as error:
        # what `correct` refuses is about its arguments, which the form has in one table
        return explained(error, fields, dict.fromkeys(("reported", "depth", "model", "over"), "correct"))


def shown(found: Correction) -> Plain:
    """Return what the page shows of a correction."""
    rows = [[row.name, row.value, row.note] for row in found.table().rows]
    return {
        "young": found.young,
        "reported": found.reported,
        "factor": found.factor,
        "sensitivity": plain(found.sensitivity),
        "columns": COLUMNS,
        "rows": rows,
        "depth": plain(found.depth),
        "apparent": plain(found.apparent),
        "summary": str(found),
        "notes": list(found.notes),
    }


def correct_file(fields: Mapping[str, str], kept: bytes, kind: str) -> bytes:
    """Return a correction as a file."""
    from flatpunch.fits.pictures import correction_figure

    found: Correction = pickle.loads(kept)
    return file_bytes(kind, found.dataset, found.to_csv, lambda: correction_figure(found, title=_case(fields).title))


def _case(fields: Mapping[str, str]) -> FitCase:
    case = fit_case_from(parsed(case_text(fields, "correct"), CALLED), CALLED)
    if not case.correct:
        raise FormError(
            "correct.reported is missing; write the modulus that was reported, such as '8 kPa'.", "correct.reported"
        )
    return case


def compare(fields: Mapping[str, str], run: bool) -> Plain:
    """Compare the formulas at the steps of a form."""
    try:
        case = case_of(fields, "compare")
        about = list(describe(case))
        if not run and is_long(case):
            return {"about": about, "long": True}
        found = compare_case(case)
    except Exception as error:
        return explained(error, fields)
    forces, table = found["formula_force"].values, comparison_table(found)
    return {
        "about": about,
        "columns": table.header,
        "rows": table.rows,
        "names": [str(name) for name in found["formula"].values],
        "depth": short(found["depth"].values),
        "factor": short(found["factor"].values),
        "factors": short(forces / forces[0]),
        "deviation": short(found["deviation"].values),
        "method": str(found.attrs["method"]),
        "notes": list(table.notes),
        "kept": pickle.dumps(found),
        "largest": short(np.nanmax(found["factor"].values)),
    }


def compare_file(fields: Mapping[str, str], kept: bytes, kind: str) -> bytes:
    """Return a comparison as a file."""
    from flatpunch.fits.pictures import comparison_figure

    found: xr.Dataset = pickle.loads(kept)
    title = fields.get("title", "")
    return file_bytes(kind, lambda: found, lambda: comparison_csv(found), lambda: comparison_figure(found, title=title))
