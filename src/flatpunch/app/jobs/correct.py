"""The job *Correct*: a reported half-space modulus turned into that of the layer, beside published formulas."""

from __future__ import annotations

import pickle
from collections.abc import Mapping

from flatpunch._support.paths import Plain
from flatpunch.app.form import FormError, case_text
from flatpunch.app.plain import plain
from flatpunch.app.problems import CALLED, explained
from flatpunch.app.saved import file_bytes
from flatpunch.contact import method_of
from flatpunch.files.cases import parsed
from flatpunch.fits.case import FitCase, fit_case_from
from flatpunch.fits.half_space.correction import Correction, correct
from flatpunch.fits.models import forget_models

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
