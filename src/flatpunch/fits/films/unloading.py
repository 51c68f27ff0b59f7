"""Points of depth, force and stiffness from the files of nanoindenters: continuous stiffness, or the unloading of load cycles.

After Oliver and Pharr the upper part of an unloading is P = B (h - h_f)^m, whose slope at the largest depth is the stiffness.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, BadValue
from flatpunch._support.readable import readable
from flatpunch._support.reading import is_folder
from flatpunch.fits.films.oliver_pharr import Tip
from flatpunch.fits.least_squares.minimum import Minimum, covariance, differences, minimise
from flatpunch.fits.measured.curve import FEWEST, FEWEST_STIFF, Curve, CurveError
from flatpunch.fits.measured.cycles import TURN, load_cycles
from flatpunch.fits.measured.files.contents import excel_sheets
from flatpunch.fits.measured.files.readers import EXCEL, curves_in, read_curve
from flatpunch.fits.places import files_in

FAR, _STEP = 1e9, 1e-6
"""Longest step of a search, so that none is cut; step of differences, also that which ends a search, in standard errors."""
HELD = 0.98
"""Share of the largest force above which it is held."""
EXPONENTS = (0.8, 4.0)
"""Exponents of unloadings that are tried; a flat end has 1, a cone 2."""


@readable
@dataclass(frozen=True, slots=True)
class Unloading:
    """One unloading.

    Attributes
    ----------
    depth, force : float
        h [m] and P [N] where unloading begins.
    stiffness, stderr : float
        S = dP/dh there, and its standard error [N/m].
    exponent : float
        m [-]; between 1 (flat end) and 2 (cone).
    final_depth : float
        h_f [m].
    notes : tuple of str
        Why the power law does not describe this unloading: its exponent is outside 1 to 2, or on the limit of the search.

    See Also
    --------
    flatpunch.fits.unloading : Makes it.

    Examples
    --------
    >>> h = np.concatenate([np.linspace(0, 1e-6, 200), np.linspace(1e-6, 0.6e-6, 200)])
    >>> p = np.concatenate([1e-2 * (h[:200] / 1e-6) ** 2, 1e-2 * ((h[200:] - 0.6e-6) / 0.4e-6) ** 1.5])
    >>> cycle = fp.Curve(depth=h, force=p)
    >>> from flatpunch.fits import unloading
    >>> print(f"{unloading(cycle).final_depth * 1e9:.0f} nm")
    600 nm
    """

    depth: float
    force: float
    stiffness: float
    stderr: float
    exponent: float
    final_depth: float
    notes: tuple[str, ...] = ()


def unloading(curve: Curve, *, upper: float = HELD, lower: float = 0.5) -> Unloading:
    """Fit the unloading of a load cycle.

    Parameters
    ----------
    curve : Curve
        Depth and force of the whole cycle; unloading begins at the largest depth that is reached near the largest force.
    upper, lower : float
        Part of it that is fitted, over the force at which it begins; the top is left out because creep distorts it.

    Returns
    -------
    Unloading

    Raises
    ------
    CurveError
        If there is no unloading, or too little of it.

    See Also
    --------
    flatpunch.fits.unloadings : Many cycles.
    flatpunch.fits.Unloading : What it returns.

    Examples
    --------
    >>> h = np.concatenate([np.linspace(0, 1e-6, 200), np.linspace(1e-6, 0.6e-6, 200)])
    >>> p = np.concatenate([1e-2 * (h[:200] / 1e-6) ** 2, 1e-2 * ((h[200:] - 0.6e-6) / 0.4e-6) ** 1.5])
    >>> cycle = fp.Curve(depth=h, force=p)
    >>> from flatpunch.fits import unloading
    >>> found = unloading(cycle)
    >>> print(f"{found.stiffness:.0f} N/m, exponent {found.exponent:.2f}")
    37500 N/m, exponent 1.50
    """
    _check_part(lower, upper)
    top = float(curve.force.max())
    # during a hold the depth creeps on: unloading begins where it is largest
    held = np.flatnonzero(curve.force >= HELD * top)
    begin = int(held[np.argmax(curve.depth[held])])
    below = np.flatnonzero(curve.force[begin:] < lower * top)
    h, p = (column[begin:][: below[0] if below.size else None] for column in (curve.depth, curve.force))
    chosen = (p <= upper * top) & (p >= lower * top)
    if not below.size or chosen.sum() < FEWEST:
        raise CurveError(
            f"{curve.name}: {int(chosen.sum())} points of unloading between {lower:g} and {upper:g} of the largest force; "
            f"{FEWEST} are needed, down to the lower one. Is the whole cycle in the file?"
        )
    depth, force = float(h[0]), float(p[0])
    x, y = h[chosen] / depth, p[chosen] / force
    # notation: y = exp(b) (x - f)^m, f the final depth over the largest
    first, like = max(float(np.polyfit(x, y, 1)[0]), 1e-3), 3 / 2
    found, spread = least_squares_fit(
        lambda v: np.exp(v[0]) * np.maximum(x - v[1], 1e-9) ** v[2] - y,
        np.array([like * np.log(first / like), 1 - like / first, like]),
        (np.array([-np.inf, -np.inf, EXPONENTS[0]]), np.array([np.inf, float(x.min()) - 1e-6, EXPONENTS[1]])),
        x.size,
    )
    b, final, m = found.x
    gap = 1 - final
    stiffness = float(np.exp(b) * m * gap ** (m - 1))
    # ln S = b + ln m + (m - 1) ln gap
    by = np.array([1.0, -(m - 1) / gap, 1 / m + np.log(gap)])
    error = stiffness * float(np.sqrt(max(by @ spread @ by, 0.0)))
    unit, doubt = force / depth, 2 * float(np.sqrt(spread[2, 2]))
    notes: tuple[str, ...] = ()
    if found.at_bound[2] or not 1 - doubt <= m <= 2 + doubt:
        where = f"on the limit of the search ({m:.1f})" if found.at_bound[2] else f"{m:.2f}"
        notes = (
            f"the exponent of the unloading is {where}; a flat end has 1, a cone 2. Creep, drift or a tail shapes the unloading: "
            "the stiffness is uncertain by more than its standard error. Hold longer, or choose another part (upper, lower).",
        )
    return Unloading(depth, force, stiffness * unit, error * unit, float(m), float(final) * depth, notes)


def _check_part(lower: float, upper: float) -> None:
    if not 0 < lower < upper <= 1:
        raise BadValue("lower", repr(lower), f"and upper = {upper!r} must satisfy 0 < lower < upper <= 1.")


@contextmanager
def _left_out(bad: list[str]) -> Iterator[None]:
    """What cannot be read or evaluated is noted, and costs nothing else."""
    try:
        yield
    except CurveError as error:
        bad.append(str(error))


def least_squares_fit(
    residual: Callable[[Array], Array], start: Array, limits: tuple[Array, Array], count: int
) -> tuple[Minimum, Array]:
    """Least squares of residuals of order one, of which `count` are readings, from a start within limits, and the covariance."""
    found = minimise(
        lambda x: (residual(x), differences(residual, x, _STEP, limits)), start, *limits, settled=_STEP, longest=FAR
    )
    return found, covariance(found.normal, ~found.at_bound, found.cost / max(count - start.size, 1))[0]


def unloadings(curves: Iterable[Curve], *, upper: float = HELD, lower: float = 0.5, name: str = "unloadings") -> Curve:
    """One point (depth, force, stiffness) for each of many load cycles, for `fit_film`.

    Parameters
    ----------
    curves : iterable of Curve
        Whole cycles to different depths, or records of many cycles each.
    upper, lower : float
        As for `unloading`; where a cycle is taken back less far, `lower` is where it ends.
    name : str
        Of the result.

    Returns
    -------
    Curve
        meta["notes"] names tests that are left out because they cannot be evaluated, and unloadings whose exponent is odd.

    Raises
    ------
    CurveError
        If there are too few unloadings.

    See Also
    --------
    flatpunch.fits.unloading : One cycle.
    flatpunch.fits.fit_film : Takes the points.

    Examples
    --------
    >>> h = np.concatenate([np.linspace(0, 1e-6, 200), np.linspace(1e-6, 0.6e-6, 200)])
    >>> p = np.concatenate([1e-2 * (h[:200] / 1e-6) ** 2, 1e-2 * ((h[200:] - 0.6e-6) / 0.4e-6) ** 1.5])
    >>> cycle = fp.Curve(depth=h, force=p)
    >>> from flatpunch.fits import unloadings
    >>> points = unloadings([fp.Curve(depth=size * h, force=size**2 * p) for size in np.linspace(0.5, 2, 12)])
    >>> print(points.stiffness[[0, -1]].round())
    [18750. 75000.]
    """
    _check_part(lower, upper)
    found: list[Unloading] = []
    odd: list[str] = []
    bad: list[str] = []
    for curve in curves:
        cycles = load_cycles(curve)
        if not cycles:
            bad.append(f"{curve.name}: the force is never taken back by a tenth of its largest value; no unloading.")
        for number, (begin, peak, end) in enumerate(cycles):
            label = curve.name if len(cycles) == 1 else f"{curve.name}, cycle {number + 1}"
            # noise at the end of a partial unloading must not hide that it got there
            lowest = float(curve.force[end]) / float(curve.force[peak])
            least = max(lower, (1 + TURN) * lowest)
            with _left_out(bad):
                if least >= upper:
                    raise CurveError(f"{label}: the force falls to {lowest:.0%} of its largest value only.")
                one = unloading(replace(curve.taken(slice(begin, end + 1)), name=label), upper=upper, lower=least)
                found.append(one)
                odd += [f"{label}: {note}" for note in one.notes]
    if len(found) < FEWEST_STIFF:
        plural = "s" if len(found) != 1 else ""
        what = (
            f"{name}: {len(found)} unloading{plural} found. A film's modulus follows from the stiffness at several depths: "
            f"{FEWEST_STIFF} or more load cycles, or continuous stiffness, are needed."
        )
        raise CurveError(" ".join([what, *bad]))
    found.sort(key=lambda point: point.depth)
    depth, force, stiffness = np.array([(p.depth, p.force, p.stiffness) for p in found]).T
    more = f" So are {len(odd) - 1} more of {len(found)} unloadings." if len(odd) > 1 else ""
    notes = (*(f"Left out: {reason}" for reason in bad), *(f"{first}{more}" for first in odd[:1]))
    return Curve(depth, force, stiffness=stiffness, name=name, meta={"notes": notes})


def film_curves(path: str | Path, reading: Mapping[str, Any]) -> list[Curve]:
    """Curves with a stiffness: every test of a file or folder with continuous stiffness, or one of the unloadings of all cycles.

    `reading` has arguments of `read_curve`. Tests that cannot be read or evaluated are left out; meta["notes"] of the first
    curve names them. CurveError if none is left.
    """
    curves: list[Curve] = []
    bad: list[str] = []
    chosen = reading.get("index")
    for file in _files(path):
        numbers: Sequence[int | None] = ()
        with _left_out(bad):
            count = 1 if chosen is not None else curves_in(file, **reading)
            numbers = [chosen] if count == 1 else range(count)
        for i in numbers:
            with _left_out(bad):
                curve = read_curve(file, **{**reading, "index": i})
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
    return files_in(path) if is_folder(Path(path)) else [Path(path)]


def film_tip(path: str | Path, film: Mapping[str, Any]) -> Tip:
    """The tip of a case, with the area function of the case or of the workbook; CurveError if neither has one."""
    rest = {name: film[name] for name in ("beta", "epsilon") if name in film}
    if film.get("area_coefficients"):
        return Tip.from_coefficients(film["area_coefficients"], **rest)
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
    flatpunch.fits.tip_in_workbook : The area function beside the tests.
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
    >>> book.save("tests.xlsx")
    >>> from flatpunch.fits import read_nanoindentation
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
    flatpunch.fits.read_nanoindentation : The tests of the workbook.
    flatpunch.fits.Tip : From coefficients.

    Examples
    --------
    >>> from openpyxl import Workbook
    >>> book = Workbook()
    >>> book.active.append(["Area Coefficient 1", "Area Coefficient 2"])
    >>> book.active.append([24.5, 500.0])
    >>> book.save("tests.xlsx")
    >>> from flatpunch.fits import tip_in_workbook
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
