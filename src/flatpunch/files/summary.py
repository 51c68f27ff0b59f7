"""Results in short for people: about ten steps of a curve with readable units, and where a sticking contact is lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from flatpunch._support.checks import Indices
from flatpunch.contact import pull_off
from flatpunch.contact.curve import NOTABLE_FORCE, percent
from flatpunch.contact.default import EXACT
from flatpunch.files.cases import Case
from flatpunch.files.units import readable, text

_ROWS = 10
"""Steps that a table shows; of longer curves, as many at equal distances."""


@dataclass(frozen=True)
class CurveTable:
    """Heading and unit of each column, the rows as text, and which steps of how many they are."""

    columns: tuple[tuple[str, str], ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str


def spread(size: int, most: int) -> Indices:
    """Places of at most so many entries, first and last among them, at equal distances."""
    return np.unique(np.linspace(0, size - 1, min(most, size)).round().astype(int))


def curve_table(result: xr.Dataset) -> CurveTable:
    """Return evenly chosen steps of what `indent` returned."""
    steps = result.sizes["step"]
    chosen = spread(steps, _ROWS)
    units = {"depth": "m", "force": "N", "radius": "m", "area": "m^2"}
    if "base_radius" in result:
        units["base_radius"] = "m"
    # the stiffness of a sudden step, infinite under power laws, is of no use in a history
    units = {"time": "s", **units} if "time" in result else {**units, "stiffness": "N/m"}
    columns, shown = [], []
    for name, unit in units.items():
        values = result[name].values
        finite = np.abs(values[np.isfinite(values)])
        factor, prefixed = readable(float(finite.max()) if finite.size else 0.0, unit)
        columns.append((name.replace("_", " "), prefixed.replace("^2", "²")))
        shown.append([_four_digits(values[i] * factor) for i in chosen])
    if "force_error" in result and result.attrs["method_reason"] != EXACT:
        columns.append(("force error", "%"))
        shown.append([f"{100 * error:.2g}" for error in result["force_error"].values[chosen]])
    valid = result["valid"].values
    if not valid.all():
        columns.append(("theory", "holds"))
        shown.append(["yes" if valid[i] else "no" for i in chosen])
    caption = f"{len(chosen)} of {steps} steps, {_solved_by(result)}"
    return CurveTable(tuple(columns), tuple(zip(*shown, strict=True)), caption)


def _four_digits(value: float) -> str:
    """Four digits; areas up to the next prefix, a million times as much, without a power of ten; a dash for no value."""
    if np.isnan(value):
        return "-"
    digits = f"{value:.4g}"
    return f"{float(digits):.0f}" if 1e4 <= abs(value) < 1e6 else digits


def _solved_by(result: xr.Dataset) -> str:
    """The method, unless it is exact whatever its name."""
    return EXACT if result.attrs["method_reason"] == EXACT else f"method {result.attrs['method']}"


def pull_off_lines(case: Case) -> list[str]:
    """Say where a sticking contact is lost; nothing without adhesion."""
    if (work := case.physics.work_of_adhesion) is None:
        return []
    lost = pull_off(case.medium, case.indenter, work_of_adhesion=work, range_of_action=case.physics.range_of_action)
    lines = [
        f"Pull-off under prescribed {name}: {text(at.force, 'N')} at depth {text(at.depth, 'm')}, radius {text(at.radius, 'm')}"
        + (f"; force may be off by {percent(at.force_error)}" if at.force_error > NOTABLE_FORCE else "")
        for name, at in (("force", lost.force_minimum), ("depth", lost.depth_minimum))
    ]
    if lost.tabor is not None:
        lines.append(f"Tabor's parameter: {lost.tabor.parameter:.3g} ({lost.tabor.regime})")
    return lines
