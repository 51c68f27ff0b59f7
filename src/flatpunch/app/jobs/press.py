"""The job *Press*: solve a case, as plain numbers for the page and as files to keep. Called in worker processes."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array, FlatpunchWarning, Indices
from flatpunch._support.messages import message
from flatpunch.app.limits import DRAWN, LIMITS
from flatpunch.app.plain import case_of, explained, plain, short
from flatpunch.app.saved import netcdf_bytes, picture_bytes
from flatpunch.app.sketch import sketch
from flatpunch.contact import default_choice, indent, method_of, pressure
from flatpunch.contact.default import EXACT
from flatpunch.files import Case, describe
from flatpunch.files.results import to_csv
from flatpunch.files.summary import curve_table, pull_off_lines


def press(fields: Mapping[str, str], run: bool) -> dict[str, Any]:
    """Solve the case of a form.

    Parameters
    ----------
    fields : mapping
        The form.
    run : bool
        Whether to solve a case that takes more than about a second; otherwise it is only checked.

    Returns
    -------
    dict
        "problems" with the form; or "about", what would be solved; and with it, once solved, what the page shows, and the result
        itself as bytes in "kept".
    """
    try:
        case = case_of(fields)
        about = list(describe(case))
        if not run and is_long(case):
            return {"about": about, "long": True}
        return {"about": about, **_solved(case)}
    except Exception as error:
        return explained(error, fields, message(error))


def is_long(case: Case) -> bool:
    """Whether solving takes boundary element solutions, or very many steps."""
    if case.values.size > LIMITS.quick:
        return True
    if case.method is not None and method_of(case.method).name == "bem":
        return True
    if case.indenter.round:
        return False
    if case.time is not None:
        return True
    if case.method is None and case.work_of_adhesion is None:
        return not default_choice(case.indenter, case.medium, **{case.control: case.values}).quick
    return case.indenter.exponent is None or (case.method is not None and method_of(case.method).name == "refined")


def _solved(case: Case) -> dict[str, Any]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", FlatpunchWarning)
        result = indent(case.medium, case.indenter, **case.arguments)
        leaving = pull_off_lines(case)
    notes = [*str(result.attrs.get("notes", "")).splitlines(), *(str(each.message) for each in caught)]
    return {
        **shown(case, result),
        "notes": list(dict.fromkeys(notes)),
        "leaving": leaving,
        "kept": pickle.dumps(result),
    }


def shown(case: Case, result: xr.Dataset) -> dict[str, Any]:
    """Return what the page draws and writes of a result."""
    chosen = _drawn(result)
    names = ("time", "depth", "force", "radius", "area", "stiffness", "force_error", "contour_error", "valid")
    curve = {name: plain(result[name].values[chosen]) for name in names if name in result}
    around = np.arange(0, result.sizes["phi"], max(1, result.sizes["phi"] // DRAWN.angles))
    table = curve_table(result)
    last = int(np.argmax(np.nan_to_num(result["radius"].values)))
    return {
        "title": case.title,
        "curve": curve,
        "control": case.control,
        "exact": result.attrs.get("method_reason") == EXACT,
        "method": str(result.attrs["method"]),
        "reason": str(result.attrs.get("method_reason", "")),
        "round": bool(case.indenter.round),
        "phi": short(result["phi"].values[around]),
        "contour": short(result["contour"].values[np.ix_(chosen, around)]),
        "table": {"columns": table.columns, "rows": table.rows, "caption": table.caption},
        "sketch": sketch(
            case.medium, case.indenter, float(result["radius"].values[last]), float(result["depth"].values[last])
        ),
    }


def _drawn(result: xr.Dataset) -> Indices:
    """Steps that the page draws."""
    steps = result.sizes["step"]
    return np.unique(np.linspace(0, steps - 1, min(DRAWN.steps, steps)).round().astype(int))


def pressure_map(fields: Mapping[str, str], kept: bytes, step: int) -> dict[str, Any]:
    """Return the pressure under a contact as a map, and along x.

    Parameters
    ----------
    fields : mapping
        The form.
    kept : bytes
        What `press` kept.
    step : int
        Which of the steps that the page draws.
    """
    try:
        case, result = case_of(fields), pickle.loads(kept)
        chosen = _drawn(result)
        at = int(chosen[min(max(step, 0), chosen.size - 1)])
        if "relaxation" in result.attrs:
            return {"none": "There is no map of pressure for histories of relaxing bodies."}
        largest = float(np.nanmax(result["contour"].values[at]))
        if not largest > 0:
            return {"none": "This step has no contact with an outline."}
        return _pressure(case, result, at, 1.25 * largest)
    except ValueError as error:
        return {"none": str(error)}


def _pressure(case: Case, result: xr.Dataset, at: int, half: float) -> dict[str, Any]:
    x = np.linspace(-half, half, DRAWN.map)
    control: dict[str, Any] = {case.control: float(result[case.control].values[at])}
    field, error = pressure(
        case.medium,
        case.indenter,
        x[None, :],
        x[:, None],
        method=result.attrs["method"],
        work_of_adhesion=case.work_of_adhesion,
        return_error=True,
        **control,
    )
    inside = field[(field != 0) & np.isfinite(field)]
    return {
        "half": half,
        "values": short(np.where(field == 0, np.nan, field)),
        "top": plain(_top(inside)),
        "bottom": plain(float(inside.min()) if inside.size else 0.0),
        "mean": plain(float(result["force"].values[at] / result["area"].values[at])),
        "error": plain(float(np.median(np.abs(error[field != 0])))) if inside.size else 0.0,
    }


def _top(inside: Array) -> float:
    """Upper end of the colours: the largest pressure unless it is infinite at an edge or an apex."""
    if not inside.size:
        return 1.0
    largest, quantile = float(inside.max()), float(np.quantile(inside, 0.995))
    return largest if largest < 1.1 * quantile else quantile


def press_file(fields: Mapping[str, str], kept: bytes, kind: str) -> bytes:
    """Return a result as a file, the same that the command line writes.

    Parameters
    ----------
    fields : mapping
        The form.
    kept : bytes
        What `press` kept.
    kind : {"nc", "csv", "png", "svg"}
    """
    result = pickle.loads(kept)
    if kind == "nc":
        return netcdf_bytes(result)
    if kind == "csv":
        return to_csv(result, outlines=False).encode("utf-8")
    from flatpunch.plots import result as pictures

    case = case_of(fields)
    drawn = pictures.figure(result, case.medium, case.indenter, title=case.title)
    return picture_bytes(drawn, kind)


def warm_up() -> None:
    """Solve the smallest case, which loads all that most cases need."""
    press(
        {
            "base.kind": "rigid",
            "layers.0.young": "1 Pa",
            "layers.0.poisson": "0.3",
            "layers.0.thickness": "1 m",
            "indenter.kind": "sphere",
            "indenter.radius": "1 m",
            "control.quantity": "depth",
            "control.values": "1 mm",
        },
        True,
    )
