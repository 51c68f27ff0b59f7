"""Contact stiffness from unloading: P = B (h - h_f)^m over the upper part of the unloading curve (Oliver and Pharr)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import Array, BadValue
from flatpunch._support.readable import readable
from flatpunch.fit.least_squares.minimum import covariance, minimise
from flatpunch.fit.measured.curve import FEWEST, FEWEST_STIFF, Curve, CurveError
from flatpunch.fit.measured.cycles import load_cycles


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
    if not 0 < lower < upper <= 1:
        raise BadValue("lower", repr(lower), f"and upper = {upper!r} must satisfy 0 < lower < upper <= 1.")
    top = float(curve.force.max())
    # during a hold the depth creeps on: unloading begins where it is largest
    held = np.flatnonzero(curve.force >= 0.98 * top)
    begin = int(held[np.argmax(curve.depth[held])])
    rest = curve.force[begin:]
    below = np.flatnonzero(rest < lower * top)
    end = begin + (int(below[0]) if below.size else rest.size)
    h, p = curve.depth[begin:end], curve.force[begin:end]
    chosen = (p <= upper * top) & (p >= lower * top)
    if not below.size or chosen.sum() < FEWEST:
        raise CurveError(
            f"{curve.name}: {int(chosen.sum())} points of unloading between {lower:g} and {upper:g} of the largest force; "
            f"{FEWEST} are needed, down to the lower one. Is the whole cycle in the file?"
        )
    depth, force = float(h[0]), float(p[0])
    h, p = h[chosen], p[chosen]
    # notation: x = (ln B', h_f/h, m) with P/P_max = B' ((h - h_f)/h_max)^m

    def evaluate(x: Array) -> tuple[Array, Array]:
        gap = np.maximum(h / depth - x[1], 1e-9)
        model = np.exp(x[0]) * gap ** x[2]
        rows = np.array([model, -x[2] * model / gap, model * np.log(gap)])
        return model - p / force, rows

    slope = float(np.polyfit(h / depth, p / force, 1)[0])
    start = np.array([1.5 * np.log(max(slope / 1.5, 1e-3)), 1 - 1.5 / max(slope, 1e-3), 1.5])
    limit = float(h.min() / depth) - 1e-6
    lowest, highest = 0.8, 4.0
    found = minimise(evaluate, start, np.array([-50.0, -10.0, lowest]), np.array([50.0, limit, highest]))
    if not found.converged:
        raise CurveError(f"{curve.name}: the unloading does not follow a power law.")
    b, final, m = found.x
    gap = 1 - final
    stiffness = float(np.exp(b) * m * gap ** (m - 1))
    # ln S = b + ln m + (m - 1) ln gap
    by = np.array([1.0, -(m - 1) / gap, 1 / m + np.log(gap)])
    spread = covariance(found.normal, ~found.at_bound, found.cost / max(p.size - 3, 1))[0]
    error = stiffness * float(np.sqrt(max(by @ spread @ by, 0.0)))
    unit = force / depth
    notes: tuple[str, ...] = ()
    if found.at_bound[2] or not 1 - 2 * np.sqrt(spread[2, 2]) <= m <= 2 + 2 * np.sqrt(spread[2, 2]):
        where = f"on the limit of the search ({m:.1f})" if found.at_bound[2] else f"{m:.2f}"
        notes = (
            f"the exponent of the unloading is {where}; a flat end has 1, a cone 2. Creep, drift or a tail shapes the unloading: "
            "the stiffness is uncertain by more than its standard error. Hold longer, or choose another part (upper, lower).",
        )
    return Unloading(depth, force, stiffness * unit, error * unit, float(m), float(final) * depth, notes)


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
    found: list[Unloading] = []
    odd: list[str] = []
    bad: list[str] = []
    for curve in curves:
        cycles = load_cycles(curve)
        if not cycles:
            bad.append(f"{curve.name}: the force is never taken back by a tenth of its largest value; no unloading.")
        for number, (begin, peak, end) in enumerate(cycles):
            one = curve.taken(slice(begin, end + 1))
            label = curve.name if len(cycles) == 1 else f"{curve.name}, cycle {number + 1}"
            # noise at the end of a partial unloading must not hide that it got there
            least = max(lower, 1.05 * float(one.force[-1]) / float(curve.force[peak]))
            try:
                found.append(unloading(replace(one, name=label), upper=upper, lower=least))
            except CurveError as error:
                bad.append(str(error))
                continue
            odd += [f"{label}: {note}" for note in found[-1].notes]
    if len(found) < FEWEST_STIFF:
        plural = "s" if len(found) != 1 else ""
        what = (
            f"{name}: {len(found)} unloading{plural} found. A film's modulus follows from the stiffness at several depths: "
            f"{FEWEST_STIFF} or more load cycles, or continuous stiffness, are needed."
        )
        raise CurveError(" ".join([what, *bad]))
    found.sort(key=lambda point: point.depth)
    depth, force, stiffness = (np.array([getattr(p, key) for p in found]) for key in ("depth", "force", "stiffness"))
    notes = (*(f"Left out: {reason}" for reason in bad), *_listed(odd, len(found)))
    return Curve(depth, force, stiffness=stiffness, name=name, meta={"notes": notes})


def _listed(odd: list[str], count: int) -> tuple[str, ...]:
    """One line about all unloadings whose exponent is odd."""
    if not odd:
        return ()
    more = f" So are {len(odd) - 1} more of {count} unloadings." if len(odd) > 1 else ""
    return (f"{odd[0]}{more}",)
