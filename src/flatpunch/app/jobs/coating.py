"""The job *Coating*: stresses in section, the first failure, and its load over the thickness of the film."""

from __future__ import annotations

import math
import pickle
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array
from flatpunch._support.messages import message, problems
from flatpunch._support.paths import Plain
from flatpunch.app.form import FormError, case_text
from flatpunch.app.jobs.common import CALLED, case_of, explained, file_bytes, plain, short
from flatpunch.app.limits import DRAWN
from flatpunch.files import Case, CaseError
from flatpunch.files.analyses import (
    STRESS_COLUMNS,
    Stresses,
    first_failure_lines,
    in_words,
    load_lines,
    stress_csv,
    stress_rows,
    stresses,
)
from flatpunch.files.cases import parsed
from flatpunch.files.descriptions import spread
from flatpunch.files.units import text
from flatpunch.media import underlying
from flatpunch.stresses import Strength
from flatpunch.sweeps import sweep, table
from flatpunch.sweeps.axes import axes_of
from flatpunch.sweeps.picture import figure, is_map, map_figure
from flatpunch.sweeps.study import KINDS

QUANTITIES = ("von_mises", "principal", "max_shear", "hydrostatic", "xx", "zz", "xz", "utilisation")
"""What the section shows, in the order of the page's list: invariants, components, von Mises stress over yield stress."""


def coating(fields: Mapping[str, str], run: bool) -> Plain:
    """Compute the stresses at the last step of a form and its first failure; with "map" on, the map of first failures."""
    try:
        case = case_of(fields, "coating")
        if fields.get("map") == "on":
            return _study(fields, case, run)
        if not run and not case.indenter.round:
            return {"long": "The pressure of this tip comes from boundary elements."}
        found = stresses(case)
        return {**_shown(case, found), "kept": pickle.dumps((case, found, None))}
    except Exception as error:
        # what `fields` refuses is about its arguments, which are in [stress]
        return explained(error, fields, dict.fromkeys(("residual_stress", "friction"), "stress"))


def _shown(case: Case, found: Stresses) -> Plain:
    attrs = found.fields.attrs
    return {
        "title": case.title,
        "about": f"At force {text(attrs['force'], 'N')}, depth {text(attrs['depth'], 'm')}, friction {attrs['friction']:g}; "
        f"estimated error {attrs['stress_error']:.1g} of the size of the pressure.",
        "columns": STRESS_COLUMNS,
        "rows": stress_rows(found),
        "first": None if found.first is None else _first(found),
        "section": section(case, found, "von_mises"),
        "axis": _axis(found.fields),
        "judged": any(strength.yield_stress is not None for strength in found.strengths),
        "notes": str(attrs.get("notes", "")).splitlines(),
    }


def _first(found: Stresses) -> Plain:
    first = found.first
    assert first is not None
    return {
        "line": first_failure_lines(first)[0],
        "loads": "".join(load_lines(found.loads) if found.loads is not None else []),
        "force": plain(first.force),
        "margins": [
            [in_words(name), f"{value:.4g}" if math.isfinite(value) else "–"]
            for name, value in sorted(first.margins.items(), key=lambda item: item[1])
        ],
    }


def section(case: Case, found: Stresses, quantity: str) -> Plain | None:
    """Return one of `QUANTITIES` over the plane y = 0 as rows from the surface down; None where the points are no plane."""
    result = found.fields
    plane = _plane(result)
    if plane is None:
        return None
    x, z = plane
    across, down = (spread(axis.size, most) for axis, most in ((x, DRAWN.around), (z, DRAWN.map)))
    values = _values(found, quantity)[np.ix_(across, down)].T
    body = underlying(case.medium).single
    faces = np.cumsum([layer.thickness for layer in body.layers] if body else [])
    return {
        "x": [plain(float(x[0])), plain(float(x[-1]))],
        "z": [plain(float(z[0])), plain(float(z[-1]))],
        "values": short(values),
        "faces": plain(faces[faces < z[-1]]),
        "radius": plain(float(result.attrs["radius"])) if "radius" in result.attrs else None,
        "unit": "" if quantity == "utilisation" else "Pa",
    }


def _plane(result: xr.Dataset) -> tuple[Array, Array] | None:
    """Coordinates along x and z of points in a plane y = const; None for other points."""
    if result["von_mises"].ndim != 2 or min(result["von_mises"].shape) < 2:
        return None
    x, z = result["x"].values, result["z"].values
    flat = np.ptp(x, axis=1).max() == 0 and np.ptp(z, axis=0).max() == 0 and np.ptp(result["y"].values) == 0
    return (x[:, 0], z[0]) if flat else None


def _values(found: Stresses, quantity: str) -> Array:
    result = found.fields
    if quantity == "utilisation":
        limits = [strength.yield_stress or math.nan for strength in found.strengths]
        layer = result["layer"].values
        limits += [math.nan] * max(0, int(layer.max()) + 1 - len(limits))
        return np.asarray(result["von_mises"].values / np.array(limits)[layer])
    if quantity == "principal":
        return np.asarray(result["principal"].values[0])
    return np.asarray(result[quantity] if quantity in result else result["stress"].sel(component=quantity))


def _axis(result: xr.Dataset) -> Plain | None:
    plane = _plane(result)
    if plane is None:
        return None
    x, z = plane
    at = int(np.argmin(np.abs(x)))
    stress = result["stress"].values[:, at]
    names = [str(name) for name in result["component"].values]
    return {"z": short(z), **{name: short(stress[names.index(name)]) for name in ("xx", "zz")}}


def quantity_map(fields: Mapping[str, str], kept: bytes, step: int) -> Plain:
    """Return another quantity of the section; `step` is its place in `QUANTITIES`."""
    case, found, _ = pickle.loads(kept)
    return section(case, found, QUANTITIES[min(step, len(QUANTITIES) - 1)]) or {"none": "These points are no section."}


def _study(fields: Mapping[str, str], case: Case, run: bool) -> Plain:
    """Load of the first failure over one or two values of the case."""
    source = case_text(fields, "coating")
    data = parsed(source, CALLED)
    varied = data.pop("vary", {})
    if len(varied) not in (1, 2):
        raise FormError(
            "vary.layers.0.thickness is missing; the map takes one or two ranges such as '0.5 um:20 um:16:log'.",
            "vary.layers.0.thickness",
        )
    if case.stress is None or all(strength == Strength() for strength in case.stress.strengths):
        raise FormError(
            "the map shows the first failure: give a strength of a layer or of the base, such as a yield stress."
        )
    try:
        axes_of(data, varied)
        if not run:
            return {"long": "The map solves one case for each point."}
        found = sweep(replace(case, source=(CALLED, source)), workers=1)
    except ValueError as error:
        # what is wrong with a range is said of the path, which is the name of its field
        (place, _), *_ = problems(error)
        named = place if place in varied else next(iter(varied)) if isinstance(error, CaseError) else ""
        return {"problems": [{"field": f"vary.{named}" if named else "", "text": message(error)}]}
    return {"study": _drawn(found), "notes": [], "kept": pickle.dumps((case, None, found))}


def _drawn(found: xr.Dataset) -> Plain:
    names = [str(name) for name in found["status"].dims]
    first = found.isel(step=0) if "step" in found.dims else found
    if "critical_force" not in found:
        raise ValueError(str(found["reason"].values.ravel()[0]))
    kind, layer = first["critical_kind"].values, first["critical_layer"].values
    places = [
        f"{KINDS[int(k)]}, layer {int(i) + 1}" if math.isfinite(k) else "not solved"
        for k, i in zip(kind.ravel(), layer.ravel(), strict=True)
    ]
    failed = [str(reason) for reason in found["reason"].values.ravel() if reason]
    return {
        "names": names,
        "values": [plain(found[name].values) for name in names],
        "units": [str(found[name].attrs.get("units", "")) for name in names],
        "force": plain(first["critical_force"].values),
        "places": np.array(places, dtype=object).reshape(kind.shape).tolist(),
        "caption": f"{kind.size - len(failed)} of {kind.size} points solved"
        + (f"; first reason: {failed[0]}" if failed else ""),
    }


def coating_file(fields: Mapping[str, str], kept: bytes, kind: str) -> bytes:
    """Return stresses, or the map, as a file."""
    from flatpunch.plots import fields as pictures

    case, found, study = pickle.loads(kept)
    if study is None:
        about = {"strengths": found.strengths, "title": case.title}
        return file_bytes(
            kind,
            lambda: found.fields,
            lambda: stress_csv(found.fields),
            lambda: pictures.figure(found.fields, case.medium, case.indenter, found.contact, **about),
        )
    return file_bytes(
        kind,
        lambda: study,
        lambda: str(table(study).to_csv(index=False, lineterminator="\n")),
        lambda: map_figure(study) if is_map(study, "critical_force") else figure(study, quantity="critical_force"),
    )
