"""From files of nanoindenters to points of depth, force and stiffness: continuous stiffness, or the unloading of load cycles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.reading import is_folder
from flatpunch.fit.films.oliver_pharr import Tip
from flatpunch.fit.films.unloading import unloadings
from flatpunch.fit.films.workbook import tip_in_workbook
from flatpunch.fit.measured.curve import FEWEST_STIFF, Curve, CurveError
from flatpunch.fit.measured.cycles import load_cycles
from flatpunch.fit.measured.files.readers import EXCEL, curves_in, read_curve
from flatpunch.fit.places import files_in


def film_curves(path: str | Path, reading: Mapping[str, Any]) -> list[Curve]:
    """Curves with a stiffness: every test of a file or folder with continuous stiffness, or one of the unloadings of all cycles.

    `reading` has arguments of `read_curve`. Tests that cannot be read or evaluated are left out; meta["notes"] of the first
    curve names them. CurveError if none is left.
    """
    curves: list[Curve] = []
    bad: list[str] = []
    for file in files_in(path) if is_folder(Path(path)) else [Path(path)]:
        try:
            chosen = reading.get("index")
            count = 1 if chosen is not None else curves_in(file, **reading)
            numbers = [chosen] if count == 1 else list(range(count))
        except CurveError as error:
            bad.append(str(error))
            continue
        for i in numbers:
            try:
                curve = read_curve(file, **{**reading, "index": i})
            except CurveError as error:
                bad.append(str(error))
                continue
            # instruments count force and depth from the surface
            curves.append(replace(curve, name=curve.meta.get("source", curve.name)))
    if not curves:
        raise CurveError(" ".join(bad) or f"{path}: no test.")
    along = [curve for curve in curves if continuous(curve)]
    if 2 * len(along) > len(curves):
        bad += [
            f"{curve.name}: no continuous stiffness, as the others have." for curve in curves if not continuous(curve)
        ]
    left_out = tuple(f"Left out: {reason}" for reason in bad)
    if 2 * len(along) > len(curves):
        found = [curve.taken(slice(0, int(np.argmax(curve.force)) + 1)) for curve in along]
        return [replace(found[0], meta={**found[0].meta, "notes": left_out}), *found[1:]]
    points = unloadings(curves, name=Path(path).name)
    read = tuple(line for c in curves for line in c.meta["read"])
    return [replace(points, meta={"read": read, "notes": (*left_out, *points.meta["notes"])})]


def continuous(curve: Curve) -> bool:
    """Whether a curve has a stiffness along its loading, not one of each unloading, which some instruments write beside it."""
    if curve.stiffness is None:
        return False
    loading = curve.stiffness[: int(np.argmax(curve.force)) + 1]
    return int(np.isfinite(loading).sum()) > max(len(load_cycles(curve)), FEWEST_STIFF - 1)


def film_tip(path: str | Path, film: Mapping[str, Any]) -> Tip:
    """The tip of a case, with the area function of the case or of the workbook; CurveError if neither has one."""
    rest = {name: film[name] for name in ("beta", "epsilon") if name in film}
    if film.get("coefficients"):
        return Tip.from_coefficients(film["coefficients"], **rest)
    books = [
        file for file in (files_in(path) if is_folder(Path(path)) else [Path(path)]) if file.suffix.lower() in EXCEL
    ]
    if books:
        return tip_in_workbook(books[0], **rest)
    raise CurveError(
        f"{path}: the tip's area function is missing. Write [film] area_coefficients = [24.56, ...] into the case file: "
        "A = C0 h^2 + C1 h + C2 h^(1/2) + ..., in nanometres."
    )
