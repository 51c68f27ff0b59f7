"""The jobs *Press* and *Slip*: solve a case, or pull its tip along the surface at its last step. Called in worker processes.

They return plain numbers for the page, and files to keep.
"""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Mapping
from dataclasses import asdict

import numpy as np
import xarray as xr

from flatpunch._support.checks import FlatpunchWarning
from flatpunch._support.paths import Plain
from flatpunch.app.jobs.common import case_of, explained, file_bytes, plain, short
from flatpunch.app.limits import DRAWN, LIMITS
from flatpunch.contact import default_choice, indent, method_of, pressure
from flatpunch.contact.dataset import outlines
from flatpunch.contact.default import EXACT
from flatpunch.contact.slip.steps import loading_and_cycle
from flatpunch.files import Case, describe
from flatpunch.files.analyses import slipping
from flatpunch.files.descriptions import curve_table, pull_off_lines, spread
from flatpunch.files.results import to_csv
from flatpunch.files.units import text
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, Material, underlying
from flatpunch.media.plane import from_plane
from flatpunch.numerics.extents import ROOM, covered


def sketch(medium: Body, indenter: Indenter, radius: float, depth: float) -> Plain | None:
    """Return layers, base and the section of the tip along x; None for two bodies, which have no one surface.

    Largest contact radius and depth [m] set the scale where there are no layers.
    """
    sides = underlying(medium).sides
    if len(sides) > 1:
        return None
    ((_, body),) = sides
    half = min(3 * radius, float(indenter.reach))
    x = np.linspace(-half, half, DRAWN.around)
    height = np.asarray(indenter.height(np.abs(x), np.where(x < 0, np.pi, 0.0)))
    return {
        "layers": [
            {"thickness": layer.thickness, "label": _stiffness(layer), "bonded": bool(layer.face)}
            for layer in body.layers
        ],
        "base": _stiffness(body.base),
        "tip": {"x": short(x), "height": short(height)},
        "radius": plain(radius),
        "depth": plain(depth),
    }


def _stiffness(part: Material) -> str:
    """Young's moduli in words, from one face to the other where they vary."""
    if part.rigid:
        return "rigid"
    if part.power_law:
        return type(part).__name__
    young, axial, *_ = from_plane(part.plane_at(part.sampled_depths))
    moduli = (
        [(young, " in plane"), (axial, " axial")] if part.anisotropic else [(part.young_at(part.sampled_depths), "")]
    )
    pairs = ((dict.fromkeys(text(float(ends[j]), "Pa") for j in (0, -1)), word) for ends, word in moduli)
    return "E = " + ", ".join(f"{' to '.join(pair)}{word}" for pair, word in pairs)


def press(fields: Mapping[str, str], run: bool) -> Plain:
    """Solve the case of a form; with "about", what would be solved."""
    try:
        case = case_of(fields)
        about = list(describe(case))
        if not run and is_long(case):
            return {"about": about, "long": True}
        return {"about": about, **_solved(case)}
    except Exception as error:
        return explained(error, fields)


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
    if case.method is None and case.physics.work_of_adhesion is None:
        return not default_choice(case.indenter, case.medium, **{case.control: case.values}).quick
    return case.indenter.exponent is None or (case.method is not None and method_of(case.method).name == "refined")


def _solved(case: Case) -> Plain:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", FlatpunchWarning)
        result = indent(case.medium, case.indenter, **case.arguments)
        leaving = pull_off_lines(case)
    notes = [*str(result.attrs.get("notes", "")).splitlines(), *(str(each.message) for each in caught)]
    return {
        **shown(case, result),
        "notes": list(dict.fromkeys(notes)),
        "leaving": leaving,
        "kept": pickle.dumps((case, result)),
    }


def shown(case: Case, result: xr.Dataset) -> Plain:
    """Return what the page draws and writes of a result."""
    chosen = spread(result.sizes["step"], DRAWN.steps)
    names = (
        "time",
        "depth",
        "force",
        "radius",
        "area",
        "stiffness",
        "force_error",
        "contour_error",
        "strain_factor",
        "valid",
    )
    curve = {name: plain(result[name].values[chosen]) for name in names if name in result}
    around = np.arange(0, result.sizes["phi"], max(1, result.sizes["phi"] // DRAWN.around))
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
        "contour": short(outlines(result)[np.ix_(chosen, around)]),
        "table": asdict(curve_table(result)),
        "sketch": sketch(
            case.medium, case.indenter, float(result["radius"].values[last]), float(result["depth"].values[last])
        ),
    }


def pressure_map(fields: Mapping[str, str], kept: bytes, step: int) -> Plain:
    """Return the pressure under a contact as a map, and along x; `step` is one of those that the page draws."""
    try:
        case, result = pickle.loads(kept)
        chosen = spread(result.sizes["step"], DRAWN.steps)
        at = int(chosen[min(max(step, 0), chosen.size - 1)])
        if "relaxation" in result.attrs:
            return {"none": "There is no map of pressure for histories of relaxing bodies."}
        largest = float(np.nanmax(outlines(result)[at]))
        if not largest > 0:
            return {"none": "This step has no contact with an outline."}
        return _pressure(case, result, at, ROOM * largest)
    except ValueError as error:
        return {"none": str(error)}


def _pressure(case: Case, result: xr.Dataset, at: int, half: float) -> Plain:
    x = np.linspace(-half, half, DRAWN.map)
    control: Plain = {case.control: float(result[case.control].values[at])}
    field, error = pressure(
        case.medium,
        case.indenter,
        x[None, :],
        x[:, None],
        method=result.attrs["method"],
        work_of_adhesion=case.physics.work_of_adhesion,
        range_of_action=case.physics.within,
        return_error=True,
        **control,
    )
    inside = field[(field != 0) & np.isfinite(field)]
    return {
        "half": half,
        "values": short(np.where(field == 0, np.nan, field)),
        "top": plain(covered(field[field != 0])[0]),
        "bottom": plain(float(inside.min()) if inside.size else 0.0),
        "mean": plain(float(result["force"].values[at] / result["area"].values[at])),
        "error": plain(float(np.median(np.abs(error[field != 0])))) if inside.size else 0.0,
    }


def press_file(fields: Mapping[str, str], kept: bytes, kind: str) -> bytes:
    """Return a result, that of the tab *Slip* too, as a file."""
    from flatpunch.plots.result import figure

    case, result = pickle.loads(kept)
    return file_bytes(
        kind,
        lambda: result,
        lambda: to_csv(result, outlines=False),
        lambda: figure(result, case.medium, case.indenter, title=case.title),
    )


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


def slip(fields: Mapping[str, str], run: bool) -> Plain:
    """Pull the tip of a form along the surface."""
    try:
        case = case_of(fields, "slip")
        if not run and any(getattr(given, "size", 1) > DRAWN.steps for given in (case.slip or {}).values()):
            return {"long": f"More than {DRAWN.steps} steps along the surface are prescribed."}
        result = slipping(case)
    except Exception as error:
        return explained(error, fields)
    first, cycle = loading_and_cycle(result)
    return {
        "title": case.title,
        "first": short(first),
        "cycle": short(cycle),
        "table": asdict(curve_table(result)),
        "notes": str(result.attrs["notes"]).splitlines(),
        "kept": pickle.dumps((case, result)),
    }
