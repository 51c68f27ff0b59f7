"""Contact stiffness from unloading: P = B (h - h_f)^m over the upper part of the unloading curve (Oliver and Pharr)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from flatpunch._support.checks import Array, BadValue, Flags
from flatpunch._support.readable import readable
from flatpunch.fit.least_squares.minimum import covariance
from flatpunch.fit.measured.curve import FEWEST, FEWEST_STIFF, Curve, CurveError
from flatpunch.fit.measured.cycles import load_cycles

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
    flatpunch.fit.unloading : Makes it.

    Examples
    --------
    >>> h = np.concatenate([np.linspace(0, 1e-6, 200), np.linspace(1e-6, 0.6e-6, 200)])
    >>> p = np.concatenate([1e-2 * (h[:200] / 1e-6) ** 2, 1e-2 * ((h[200:] - 0.6e-6) / 0.4e-6) ** 1.5])
    >>> cycle = fp.Curve(depth=h, force=p)
    >>> from flatpunch.fit import unloading
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


def unloading(curve: Curve, *, upper: float = 0.98, lower: float = 0.5) -> Unloading:
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
    flatpunch.fit.unloadings : Many cycles.
    flatpunch.fit.Unloading : What it returns.

    Examples
    --------
    >>> h = np.concatenate([np.linspace(0, 1e-6, 200), np.linspace(1e-6, 0.6e-6, 200)])
    >>> p = np.concatenate([1e-2 * (h[:200] / 1e-6) ** 2, 1e-2 * ((h[200:] - 0.6e-6) / 0.4e-6) ** 1.5])
    >>> cycle = fp.Curve(depth=h, force=p)
    >>> from flatpunch.fit import unloading
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
    first = max(float(np.polyfit(x, y, 1)[0]), 1e-3)
    found = least_squares_fit(
        lambda v: np.exp(v[0]) * np.maximum(x - v[1], 1e-9) ** v[2] - y,
        np.array([1.5 * np.log(first / 1.5), 1 - 1.5 / first, 1.5]),
        (np.array([-50.0, -10.0, EXPONENTS[0]]), np.array([50.0, float(x.min()) - 1e-6, EXPONENTS[1]])),
        x.size,
    )
    b, final, m = found.x
    gap = 1 - final
    stiffness = float(np.exp(b) * m * gap ** (m - 1))
    # ln S = b + ln m + (m - 1) ln gap
    by = np.array([1.0, -(m - 1) / gap, 1 / m + np.log(gap)])
    error = stiffness * float(np.sqrt(max(by @ found.covariance @ by, 0.0)))
    unit, doubt = force / depth, 2 * float(np.sqrt(found.covariance[2, 2]))
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


class Found(NamedTuple):
    """A least-squares fit: values, their covariance, residuals, which values are on a limit, and the rms misfit."""

    x: Array
    covariance: Array
    residual: Array
    at_bound: Flags
    misfit: float


def least_squares_fit(
    residual: Callable[[Array], Array], start: Array, limits: tuple[Array, Array], count: int
) -> Found:
    """Least squares of residuals of order one, of which `count` are readings, from a start within limits."""
    start = np.clip(start, limits[0] + 1e-9, limits[1] - 1e-9)
    found = least_squares(
        residual, start, jac="3-point", bounds=limits, method="dogbox", xtol=1e-12, ftol=1e-14, gtol=1e-12
    )
    at_bound = found.active_mask != 0
    variance = 2 * found.cost / max(count - start.size, 1)
    spread = covariance(found.jac.T @ found.jac, ~at_bound, variance)[0]
    return Found(found.x, spread, found.fun, at_bound, float(np.sqrt(2 * found.cost / count)))


def unloadings(curves: Iterable[Curve], *, upper: float = 0.98, lower: float = 0.5, name: str = "unloadings") -> Curve:
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
    flatpunch.fit.unloading : One cycle.
    flatpunch.fit.fit_film : Takes the points.

    Examples
    --------
    >>> h = np.concatenate([np.linspace(0, 1e-6, 200), np.linspace(1e-6, 0.6e-6, 200)])
    >>> p = np.concatenate([1e-2 * (h[:200] / 1e-6) ** 2, 1e-2 * ((h[200:] - 0.6e-6) / 0.4e-6) ** 1.5])
    >>> cycle = fp.Curve(depth=h, force=p)
    >>> from flatpunch.fit import unloadings
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
            least = max(lower, 1.05 * float(curve.force[end]) / float(curve.force[peak]))
            try:
                if least >= upper:
                    raise CurveError(
                        f"{label}: the force is taken back to {least / 1.05:.0%} of its largest value only."
                    )
                one = unloading(replace(curve.taken(slice(begin, end + 1)), name=label), upper=upper, lower=least)
            except CurveError as error:
                bad.append(str(error))
                continue
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
