"""What a case asks for beyond its curve, at its last step: stresses with the first failure, as text and CSV, and partial slip."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import BadValue
from flatpunch._support.paths import Plain
from flatpunch.contact import indent, partial_slip
from flatpunch.files.cases import Case
from flatpunch.files.tables.stress import StressCase
from flatpunch.files.units import text
from flatpunch.indenters.profile import NotRising
from flatpunch.media import underlying
from flatpunch.punch import UnresolvedLayer
from flatpunch.stresses import CriticalLoad, Strength, critical_load, critical_loads, fields, peak_stresses

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Stresses:
    """Stresses of a case.

    Attributes
    ----------
    fields : xarray.Dataset
        What `flatpunch.stresses` returned at the points of the case.
    peaks : xarray.Dataset or None
        What `flatpunch.peak_stresses` returned at the last step; None for adhesive contacts, rollers and rounded punches.
    first : CriticalLoad or None
        The first failure; None if the case has no strengths, or if the search ended before one, as a note of `fields` says.
    loads : xarray.Dataset or None
        What `flatpunch.critical_loads` returned; None with `first`.
    contact : dict
        What `fields` took by name: the last step, method, friction and so on.
    strengths : tuple of Strength
        From the surface down.
    """

    fields: xr.Dataset
    peaks: xr.Dataset | None
    first: CriticalLoad | None
    loads: xr.Dataset | None
    contact: Plain
    strengths: tuple[Strength, ...]


def stresses(case: Case) -> Stresses:
    """Compute the stresses at the last step of a case, and its first failure if it has strengths.

    Without points in [stress] the section y = 0 is taken, three contact radii to either side.
    """
    if case.time is not None:
        raise ValueError(
            "stresses of histories of relaxing bodies are not computed; give a [control] instead of a [history]."
        )
    if case.physics.within is not None:
        raise ValueError(
            "stresses inside are those of JKR theory: leave range_of_action and strength out of the case. Forces, radii and "
            "pressures have them."
        )
    asked = case.stress or StressCase(None, None, None)
    contact = {case.control: float(case.values[-1]), "method": case.method, **asked.arguments}
    if case.physics.work_of_adhesion is not None:
        contact["work_of_adhesion"] = case.physics.work_of_adhesion
    reach, deep = _extent(case, contact)
    found = fields(case.medium, case.indenter, *asked.points(reach, deep), **contact)
    first, note = first_failure(case)
    if first is not None and case.physics.work_of_adhesion is not None:
        note = "First failure: that of a growing contact without adhesion."
    if note:
        found.attrs["notes"] = "\n".join([*str(found.attrs.get("notes", "")).splitlines(), note])
    loads = None
    if first is not None and case.stress is not None:
        loads = critical_loads(case.medium, case.indenter, **case.stress.critical(case.medium))
    return Stresses(found, _peaks(case, asked, found), first, loads, contact, asked.strengths)


def _peaks(case: Case, asked: StressCase, found: xr.Dataset) -> xr.Dataset | None:
    """Largest stresses at the depth of the fields; infinite at the rim of adhesive contacts, not searched under some tips."""
    if case.physics.work_of_adhesion is not None:
        return None
    try:
        return peak_stresses(
            case.medium,
            case.indenter,
            depth=float(found.attrs["depth"]),
            friction=asked.friction,
            direction=asked.direction,
            residual_stress=asked.residual_stress,
        )
    except NotRising:
        return None


def first_failure(case: Case) -> tuple[CriticalLoad | None, str]:
    """The first failure of a case, None if it has no strengths, and a note where the search ends before one.

    What else is known of the case is not lost then.
    """
    if case.stress is None or not case.stress.judged:
        return None, ""
    try:
        return critical_load(case.medium, case.indenter, **case.stress.critical(case.medium)), ""
    except UnresolvedLayer as end:
        return None, f"First failure: {end}"
    except NotRising:
        return (
            None,
            "Largest stresses and the first failure are not searched under this tip: see the points of the result.",
        )


def _extent(case: Case, contact: Plain) -> tuple[float, float]:
    """Half-width and depth of the section that is shown where the case names none."""
    known = {name: contact[name] for name in (case.control, "method", "work_of_adhesion") if name in contact}
    radius = float(indent(case.medium, case.indenter, **known)["radius"].values[0])
    if not radius > 0:
        raise ValueError(
            "the last step has no contact, so there are no stresses to show. Give a larger depth or force."
        )
    body = underlying(case.medium).single
    thickness = body.thickness if body else 0.0
    deep = max(2.5 * radius, min(1.5 * thickness, 10 * radius))
    if body and body.base.rigid:
        deep = min(deep, thickness)
    return 3 * radius, deep


def stress_csv(result: xr.Dataset) -> str:
    """Return what `fields` returned as CSV, a line for each point."""
    import pandas as pd

    columns = {f"{name} [m]": result[name].values.ravel() for name in ("x", "y", "z")}
    columns |= {
        f"stress_{name} [Pa]": result["stress"].sel(component=name).values.ravel()
        for name in result["component"].values
    }
    columns |= {
        f"displacement_{name} [m]": result["displacement"].sel(axis=name).values.ravel()
        for name in result["axis"].values
    }
    columns |= {f"{name} [Pa]": result[name].values.ravel() for name in ("von_mises", "max_shear", "hydrostatic")}
    columns["layer"] = result["layer"].values.ravel()
    return str(pd.DataFrame(columns).to_csv(index=False, lineterminator="\n"))


def first_failure_lines(first: CriticalLoad) -> list[str]:
    """Say which failure comes first, and how far the others are."""
    two = any(name.startswith(("upper", "lower")) for name in first.margins)
    where = f"layer {first.layer + 1}" + (f" of the {first.body} body" if two else "")
    if first.force == 0:
        return [f"First failure: {first.kind} in {where} at the first touch: the tip is sharp."]
    if math.isinf(first.force):
        return ["No failure up to the largest contact of this tip."]
    at = f"x = {text(first.place[0], 'm')}, z = {text(first.place[2], 'm')}"
    margins = ", ".join(
        f"{in_words(name)}: {value:.3g}" for name, value in sorted(first.margins.items(), key=lambda item: item[1])
    )
    return [
        f"First failure: {first.kind} in {where} at {at}, force {text(first.force, 'N')}, depth "
        f"{text(first.depth, 'm')}, contact radius {text(first.radius, 'm')}.",
        f"Strength over stress there: {margins}.",
        *([f"Estimated relative error of that stress: {first.error:.1g}."] if first.error > 1e-3 else []),
        *(f"At that load: {note}" for note in first.notes),
    ]


def in_words(criterion: str) -> str:
    """Name of a criterion with the layer counted from one, as in all texts: "layers[1].yield" is "yield of layer 2"."""
    found = re.fullmatch(r"(?:(upper|lower)\.)?layers\[(\d+)\]\.(.*)", criterion)
    assert found is not None
    body = f" of the {found[1]} body" if found[1] else ""
    return f"{found[3]} of layer {int(found[2]) + 1}{body}"


def load_lines(loads: xr.Dataset) -> list[str]:
    """Say at which load each criterion of `critical_loads` is reached by itself, the first of them first."""
    forces = loads["force"].values
    if forces.size < 2:
        return []
    names = loads["criterion"].values
    order = np.argsort(np.where(np.isnan(forces), np.inf, forces), kind="stable")
    each = [f"{in_words(str(names[i]))}: {_load(float(forces[i]))}" for i in order]
    return ["Load of each criterion by itself: " + ", ".join(each) + "."]


def _load(force: float) -> str:
    return "never" if math.isinf(force) else "not known" if math.isnan(force) else text(force, "N")


def stress_rows(found: Stresses) -> list[list[str]]:
    """Table of the largest stresses in each layer and at the interface below it, with their places, under `STRESS_COLUMNS`.

    Adhesive contacts have no rows: their stresses are infinite at the rim.
    """
    peaks = found.peaks
    if peaks is None:
        return []
    bodies = peaks["body"].values if "body" in peaks else None
    below = peaks["interface_body"].values if "interface_body" in peaks else None
    faces = {
        (None if below is None else str(below[n]), int(i)): n for n, i in enumerate(peaks["interface"].values.tolist())
    }
    rows = []
    for n, i in enumerate(peaks["layer"].values.tolist()):
        body = None if bodies is None else str(bodies[n])
        row = [(f"{body} " if body else "") + str(i + 1)]
        for name in ("von_mises", "tension"):
            x, _, z = (text(float(each), "m") for each in peaks[f"{name}_place"].values[n])
            shown = _stress(float(peaks[name].values[n]))
            row += [shown, "" if shown == _NONE else f"{x}, {z}"]
        face = faces.get((body, i))
        for name in ("interface_tension", "interface_shear"):
            row.append("" if face is None else _stress(float(peaks[name].values[face])))
        rows.append(row)
    return rows


_NONE = "none"
"""Where the largest tension is a compression."""


def _stress(value: float) -> str:
    return "infinite" if math.isinf(value) else text(value, "Pa") if value >= 0 else _NONE


STRESS_COLUMNS = (
    "layer",
    "von Mises",
    "at x, z",
    "tension",
    "at x, z",
    "interface tension",
    "interface shear",
)
"""Headings of `stress_rows`, largest values each; the last two are tractions on the interface below the layer."""


def slipping(case: Case) -> xr.Dataset:
    """Pull the tip of a case along the surface, under the normal force of its last step.

    Where [slip] prescribes nothing along the surface, from full stick until the whole contact slides.
    """
    if case.slip is None:
        raise ValueError('the case has no table [slip]; write one with the coefficient of friction, "friction = 0.3".')
    last: Plain = {case.control: float(case.values[-1])}
    given = case.slip
    if len(given) == 1:
        radius = indent(case.medium, case.indenter, method="exact", angles=1, **last)["radius"].values
        given = {**given, "stick_radius": radius * np.linspace(1, 0, 41)}
    try:
        return partial_slip(case.medium, case.indenter, **last, **given)
    except BadValue as error:
        place = "slip." if error.field.partition("[")[0] in given else ""
        raise BadValue(f"{place}{error.field}", error.value, error.text) from None
