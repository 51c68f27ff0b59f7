"""Workbooks of nanoindenters: tests with continuous stiffness, and the area function that is kept with them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch.fit.films.oliver_pharr import Tip
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.excel import excel_sheets
from flatpunch.fit.measured.readers import read_curve


def read_nanoindentation(path: str | Path, test: str) -> Curve:
    """Read one test of a nanoindentation workbook with columns of displacement, load and harmonic stiffness.

    Parameters
    ----------
    path : path
        .xls or .xlsx.
    test : str
        Sheet, such as "Test 001".

    Returns
    -------
    Curve
        The loading part, with NaN where there is no stiffness.
    """
    curve = read_curve(path, sheet=test, skip_nan=False)
    if curve.stiffness is None:
        raise CurveError(f"{curve.name}, {test}: no column of contact stiffness.")
    end = int(np.argmax(curve.force)) + 1
    return replace(curve.taken(slice(0, end)), name=f"{curve.name}, {test}")


def tip_in_workbook(path: str | Path, **rest: Any) -> Tip:
    """Tip with the area coefficients that an Agilent/Keysight workbook keeps in its sheet of results.

    Parameters
    ----------
    path : path
        The workbook.
    **rest
        Further fields of `Tip`.
    """
    for rows in excel_sheets(Path(path)).values():
        titles = [str(cell) for cell in rows[0]] if rows else []
        places = [i for i, title in enumerate(titles) if title.startswith("Area Coefficient")]
        for row in rows[1:]:
            numbers = [row[i] for i in places if isinstance(row[i], (int, float))]
            if places and len(numbers) == len(places):
                return Tip.from_coefficients(numbers, **rest)
    raise CurveError(
        f"{path}: no columns 'Area Coefficient 1', ... in any sheet. Give the area function: Tip(area=...)."
    )
