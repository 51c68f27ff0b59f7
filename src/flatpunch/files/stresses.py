"""Stresses of a case with a table [stress]: the fields at its last step, its first failure, and the fields as CSV."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flatpunch.contact import indent
from flatpunch.fields import CriticalLoad, Strength, critical_load, fields
from flatpunch.files.cases import Case
from flatpunch.files.tables.stress import StressCase
from flatpunch.files.units import text
from flatpunch.media import Medium, RigidBase, underlying
from flatpunch.punch import UnresolvedLayer

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Stresses:
    """Stresses of a case.

    Attributes
    ----------
    fields : xarray.Dataset
        What `flatpunch.fields` returned at the points of the case.
    first : CriticalLoad or None
        The first failure; None if the case has no strengths, or if the search ended before one, as a note of `fields` says.
    contact : dict
        What `fields` took by name: the last step, method, friction and so on.
    strengths : tuple of Strength
        From the surface down.
    """

    fields: xr.Dataset
    first: CriticalLoad | None
    contact: dict[str, Any]
    strengths: tuple[Strength, ...]


def stresses(case: Case) -> Stresses:
    """Compute the stresses at the last step of a case, and its first failure if it has strengths.

    Parameters
    ----------
    case : Case
        What `read_case` returned. Without points in [stress] the section y = 0 is taken, three contact radii to either side.

    Raises
    ------
    ValueError, TypeError
        As for `fields` and `critical_load`, and for cases with a history.
    """
    if case.time is not None:
        raise ValueError(
            "stresses of histories of relaxing bodies are not computed; give a [control] instead of a [history]."
        )
    asked = case.stress or StressCase(None, None, None)
    contact = {case.control: float(case.values[-1]), "method": case.method, **asked.arguments}
    if case.work_of_adhesion is not None:
        contact["work_of_adhesion"] = case.work_of_adhesion
    reach, deep = _extent(case, contact)
    found = fields(case.medium, case.indenter, *asked.points(reach, deep), **contact)
    first, note = first_failure(case)
    if first is not None and case.work_of_adhesion is not None:
        note = "First failure: that of a growing contact without adhesion."
    if note:
        found.attrs["notes"] = "\n".join([*str(found.attrs.get("notes", "")).splitlines(), note])
    return Stresses(found, first, contact, asked.strengths)


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


def _extent(case: Case, contact: dict[str, Any]) -> tuple[float, float]:
    """Half-width and depth of the section that is shown where the case names none."""
    known = {name: contact[name] for name in (case.control, "method", "work_of_adhesion") if name in contact}
    radius = float(indent(case.medium, case.indenter, **known)["radius"].values[0])
    if not radius > 0:
        raise ValueError(
            "the last step has no contact, so there are no stresses to show. Give a larger depth or force."
        )
    body = underlying(case.medium)
    thickness = body.thickness if isinstance(body, Medium) else 0.0
    deep = max(2.5 * radius, min(1.5 * thickness, 10 * radius))
    if isinstance(body, Medium) and isinstance(body.base, RigidBase):
        deep = min(deep, thickness)
    return 3 * radius, deep


def stress_csv(result: xr.Dataset) -> str:
    """Return fields as CSV, a line for each point.

    Parameters
    ----------
    result : xarray.Dataset
        What `fields` returned.
    """
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
    """Say which failure comes first, and how far the others are.

    Parameters
    ----------
    first : CriticalLoad
        What `critical_load` returned.
    """
    two = any(name.startswith(("upper", "lower")) for name in first.margins)
    where = f"layer {first.layer + 1}" + (f" of the {first.body} body" if two else "")
    if first.force == 0:
        return [f"First failure: {first.kind} in {where} at the first touch: the tip is sharp."]
    if math.isinf(first.force):
        return ["No failure up to the largest contact of this tip."]
    at = f"x = {text(first.place[0], 'm')}, z = {text(first.place[2], 'm')}"
    margins = ", ".join(
        f"{name} {value:.3g}" for name, value in sorted(first.margins.items(), key=lambda item: item[1])
    )
    return [
        f"First failure: {first.kind} in {where} at {at}, force {text(first.force, 'N')}, depth "
        f"{text(first.depth, 'm')}, contact radius {text(first.radius, 'm')}.",
        f"Strength over stress there: {margins}.",
        *([f"Estimated relative error of that stress: {first.error:.1g}."] if first.error > 1e-3 else []),
        *(f"At that load: {note}" for note in first.notes),
    ]


def stress_rows(result: xr.Dataset) -> list[list[str]]:
    """Table of the largest von Mises stress and the largest tension in each layer, with their places, under `STRESS_COLUMNS`.

    Parameters
    ----------
    result : xarray.Dataset
        What `fields` returned.
    """
    import numpy as np

    layer = result["layer"].values.ravel()
    x, z = result["x"].values.ravel(), result["z"].values.ravel()
    rows = []
    for i in np.unique(layer):
        here = np.flatnonzero(layer == i)
        row = [str(int(i) + 1)]
        for values in (result["von_mises"].values.ravel(), result["principal"].values[0].ravel()):
            worst = here[int(np.argmax(values[here]))]
            row += [text(float(values[worst]), "Pa"), text(float(x[worst]), "m"), text(float(z[worst]), "m")]
        rows.append(row)
    return rows


STRESS_COLUMNS = ("layer", "largest von Mises", "at x", "at z", "largest tension", "at x", "at z")
"""Headings of `stress_rows`."""
