"""From files of nanoindenters to points of depth, force and stiffness: continuous stiffness, or the unloading of load cycles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch.fit.films.oliver_pharr import Tip
from flatpunch.fit.films.unloading import unloadings
from flatpunch.fit.films.workbook import tip_in_workbook
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.readers import EXCEL, curves_in, read_curve


def film_curves(path: str | Path, reading: Mapping[str, Any]) -> list[Curve]:
    """Curves with a stiffness: every test of a file with continuous stiffness, or one of the unloadings of all its cycles.

    Parameters
    ----------
    path : path
        The file.
    reading : mapping
        Keyword arguments of `read_curve`.

    Raises
    ------
    CurveError
        If a test has neither a stiffness nor an unloading.
    """
    chosen = reading.get("index")
    numbers = [chosen] if chosen is not None else list(range(curves_in(path, **reading)))
    curves = []
    for i in numbers:
        curve = read_curve(path, **{**reading, "index": i if len(numbers) > 1 else chosen})
        # instruments count force and depth from the surface
        curves.append(replace(curve, name=curve.meta["source"]))
    if all(curve.stiffness is not None for curve in curves):
        return [curve.taken(slice(0, int(np.argmax(curve.force)) + 1)) for curve in curves]
    points = unloadings(curves, name=Path(path).name)
    return [replace(points, meta={**points.meta, "read": tuple(line for c in curves for line in c.meta["read"])})]


def film_tip(path: str | Path, film: Mapping[str, Any]) -> Tip:
    """The tip of a case, with the area function of the case or of the workbook.

    Raises
    ------
    CurveError
        If neither has one.
    """
    rest = {name: film[name] for name in ("beta", "epsilon") if name in film}
    if film.get("coefficients"):
        return Tip.from_coefficients(film["coefficients"], **rest)
    if Path(path).suffix.lower() in EXCEL:
        return tip_in_workbook(path, **rest)
    raise CurveError(
        f"{path}: the tip's area function is missing. Write [film] area_coefficients = [24.56, ...] into the case file: "
        "A = C0 h^2 + C1 h + C2 h^(1/2) + ..., in nanometres."
    )
