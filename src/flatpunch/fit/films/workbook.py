"""Workbooks of nanoindenters: tests with continuous stiffness, and the area function that is kept with them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch.fit.films.oliver_pharr import Tip
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.files.excel import excel_sheets
from flatpunch.fit.measured.files.readers import read_curve


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

    See Also
    --------
    flatpunch.fit.tip_in_workbook : The area function beside the tests.
    flatpunch.read_curve : Other files.

    Examples
    --------
    >>> from openpyxl import Workbook
    >>> book = Workbook()
    >>> sheet = book.active
    >>> sheet.title = "Test 001"
    >>> sheet.append(["Displacement (nm)", "Load (mN)", "Harmonic stiffness (N/m)"])
    >>> for h in range(1, 101):
    ...     sheet.append([10 * h, 1e-3 * h**2, 200 * h])
    >>> results = book.create_sheet("Results")
    >>> results.append(["Area Coefficient 1", "Area Coefficient 2"])
    >>> results.append([24.5, 500.0])
    >>> book.save("tests.xlsx")
    >>> from flatpunch.fit import read_nanoindentation
    >>> curve = read_nanoindentation("tests.xlsx", "Test 001")
    >>> print(f"{curve.force.max() * 1e3:.0f} mN, {curve.stiffness.max() / 1e3:.0f} mN/um")
    10 mN, 20 mN/um
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

    See Also
    --------
    flatpunch.fit.read_nanoindentation : The tests of the workbook.
    flatpunch.fit.Tip : From coefficients.

    Examples
    --------
    >>> from openpyxl import Workbook
    >>> book = Workbook()
    >>> sheet = book.active
    >>> sheet.title = "Test 001"
    >>> sheet.append(["Displacement (nm)", "Load (mN)", "Harmonic stiffness (N/m)"])
    >>> for h in range(1, 101):
    ...     sheet.append([10 * h, 1e-3 * h**2, 200 * h])
    >>> results = book.create_sheet("Results")
    >>> results.append(["Area Coefficient 1", "Area Coefficient 2"])
    >>> results.append([24.5, 500.0])
    >>> book.save("tests.xlsx")
    >>> from flatpunch.fit import tip_in_workbook
    >>> print(f"{float(tip_in_workbook('tests.xlsx').area(np.array(100e-9))) * 1e12:.3f} um^2")
    0.295 um^2
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
