"""The job *Compare formulas*: published thin-layer and substrate formulas against the exact contact of a sample."""

from __future__ import annotations

import pickle
from collections.abc import Mapping

import numpy as np
import xarray as xr

from flatpunch._support.paths import Plain
from flatpunch.app.jobs.press import is_long
from flatpunch.app.plain import case_of, short
from flatpunch.app.problems import explained
from flatpunch.app.saved import file_bytes
from flatpunch.files import describe
from flatpunch.fits.half_space.formulas import compare_case, comparison_csv, comparison_table


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
