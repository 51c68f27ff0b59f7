"""From files of nanoindenters to points of depth, force and stiffness: continuous stiffness, or the unloading of load cycles.

Workbooks keep the area function of the tip beside their tests.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.reading import is_folder
from flatpunch.fit.films.oliver_pharr import Tip
from flatpunch.fit.films.unloading import unloadings
from flatpunch.fit.measured.curve import FEWEST_STIFF, Curve, CurveError
from flatpunch.fit.measured.cycles import load_cycles
from flatpunch.fit.measured.files.excel import excel_sheets
from flatpunch.fit.measured.files.readers import EXCEL, curves_in, read_curve
from flatpunch.fit.places import files_in


def film_curves(path: str | Path, reading: Mapping[str, Any]) -> list[Curve]:
    """Curves with a stiffness: every test of a file or folder with continuous stiffness, or one of the unloadings of all cycles.

    `reading` has arguments of `read_curve`. Tests that cannot be read or evaluated are left out; meta["notes"] of the first
    curve names them. CurveError if none is left.
    """
    files = _files(path)
    curves: list[Curve] = []
    bad: list[str] = []
    for file in files:
        try:
            chosen = reading.get("index")
            numbers = range(curves_in(file, **reading)) if chosen is None else [chosen]
        except CurveError as error:
            bad.append(str(error))
            continue
        for i in numbers:
            try:
                curve = read_curve(file, **{**reading, "index": i if chosen is not None or len(numbers) > 1 else None})
            except CurveError as error:
                bad.append(str(error))
                continue
            # instruments count force and depth from the surface
            curves.append(replace(curve, name=curve.meta.get("source", curve.name)))
    if not curves:
        raise CurveError(" ".join(bad) or f"{path}: no test.")
    along = [curve for curve in curves if continuous(curve)]
    if several := 2 * len(along) > len(curves):
        bad += [f"{c.name}: no continuous stiffness, as the others have." for c in curves if not continuous(c)]
    left_out = tuple(f"Left out: {reason}" for reason in bad)
    if several:
        first, *more = map(loading, along)
        return [replace(first, meta={**first.meta, "notes": left_out}), *more]
    points = unloadings(curves, name=Path(path).resolve().name)
    read = tuple(line for c in curves for line in c.meta["read"])
    return [replace(points, meta={"read": read, "notes": (*left_out, *points.meta["notes"])})]


def loading(curve: Curve) -> Curve:
    """The readings up to the largest force."""
    return curve.taken(slice(0, int(np.argmax(curve.force)) + 1))


def continuous(curve: Curve) -> bool:
    """Whether a curve has a stiffness along its loading, not one of each unloading, which some instruments write beside it."""
    measured = None if curve.stiffness is None else loading(curve).stiffness
    return measured is not None and int(np.isfinite(measured).sum()) > max(len(load_cycles(curve)), FEWEST_STIFF - 1)


def _files(path: str | Path) -> list[Path]:
    """The files of a folder, or the file itself."""
    return files_in(path) if is_folder(Path(path)) else [Path(path)]


def film_tip(path: str | Path, film: Mapping[str, Any]) -> Tip:
    """The tip of a case, with the area function of the case or of the workbook; CurveError if neither has one."""
    rest = {name: film[name] for name in ("beta", "epsilon") if name in film}
    if film.get("coefficients"):
        return Tip.from_coefficients(film["coefficients"], **rest)
    for book in (file for file in _files(path) if file.suffix.lower() in EXCEL):
        return tip_in_workbook(book, **rest)
    raise CurveError(
        f"{path}: the tip's area function is missing. Write [film] area_coefficients = [24.56, ...] into the case file: "
        "A = C0 h^2 + C1 h + C2 h^(1/2) + ..., in nanometres."
    )


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
    return replace(loading(curve), name=f"{curve.name}, {test}")


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
