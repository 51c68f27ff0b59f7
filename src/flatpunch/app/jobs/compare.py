"""The job *Compare formulas*: published thin-layer and substrate formulas against the exact contact of a sample."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from typing import Any

import numpy as np

from flatpunch._support.messages import message
from flatpunch.app.jobs.press import is_long
from flatpunch.app.plain import case_of, explained, short
from flatpunch.app.saved import netcdf_bytes, picture_bytes
from flatpunch.files import describe
from flatpunch.fit.half_space.comparison import (
    compare_case,
    comparison_columns,
    comparison_csv,
    comparison_rows,
)


def compare(fields: Mapping[str, str], run: bool) -> dict[str, Any]:
    """Compare the formulas at the steps of a form.

    Parameters
    ----------
    fields : mapping
        The form.
    run : bool
        Whether to solve a case that takes more than about a second; otherwise it is only checked.
    """
    try:
        case = case_of(fields, "compare")
        about = list(describe(case))
        if not run and is_long(case):
            return {"about": about, "long": True}
        found = compare_case(case)
    except Exception as error:
        return explained(error, fields, message(error))
    forces = found["formula_force"].values
    return {
        "about": about,
        "columns": comparison_columns(found),
        "rows": comparison_rows(found),
        "names": [str(name) for name in found["formula"].values],
        "depth": short(found["depth"].values),
        "factor": short(found["factor"].values),
        "factors": short(forces / forces[0]),
        "deviation": short(found["deviation"].values),
        "method": str(found.attrs["method"]),
        "notes": found.attrs["notes"].splitlines(),
        "kept": pickle.dumps(found),
        "largest": short(np.nanmax(found["factor"].values)),
    }


def compare_file(fields: Mapping[str, str], kept: bytes, kind: str) -> bytes:
    """Return a comparison as a file, the same that the command line writes.

    Parameters
    ----------
    fields : mapping
        The form.
    kept : bytes
        What `compare` kept.
    kind : {"nc", "csv", "png", "svg"}
    """
    found = pickle.loads(kept)
    if kind == "nc":
        return netcdf_bytes(found)
    if kind == "csv":
        return comparison_csv(found).encode("utf-8")
    from flatpunch.fit.half_space.pictures import comparison_figure

    return picture_bytes(comparison_figure(found, title=fields.get("title", "")), kind)
