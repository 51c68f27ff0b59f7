"""`design`: media and tips that do what is prescribed, on SciPy's optimisers with exact derivatives; what a design found."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flatpunch._support.checks import Array, listed, refused_overflow, shown, whole
from flatpunch._support.progress import Report, reporting
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.contact.default import Method, MethodName
from flatpunch.contact.methods import BoundaryElements
from flatpunch.designs.search import ALIKE, LARGEST, ROUNDING, End, Problem, different, reachable, search, starts
from flatpunch.designs.statement import UNITS, LargestLoad, Limit, Target, Variables, variables
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, underlying
from flatpunch.sensitivities.derivatives import derivable


@dataclass(frozen=True, slots=True)
class DesignedValue:
    """One varied number: its value in the case, the one found, its bounds [SI], and which bound it is at.

    Attributes
    ----------
    name, unit : str
    start, found, low, high : float
    at_bound : {"", "low", "high"}
    """

    name: str
    unit: str
    start: float
    found: float
    low: float
    high: float
    at_bound: Literal["", "low", "high"]


@dataclass(frozen=True, slots=True)
class Minimum:
    """Where one of the starts ended: its misfit, or the largest load [N], and the values in the order of the table."""

    misfit: float | None
    load: float | None
    values: tuple[float, ...]


@readable
@dataclass(frozen=True, eq=False)
class Design:
    """A designed medium and tip.

    Attributes
    ----------
    medium, indenter : object
        With the values found.
    values : tuple of DesignedValue
        The table of start, found values and active bounds.
    quantity, control : str
        What was prescribed, and at which quantity; "critical load" and "" for the largest load.
    at, wanted, achieved, before : ndarray, shape (n,)
        Depths or forces, prescribed values, those of the design and those of the case before [SI].
    misfit : float
        Root of the mean square of the deviations, ln(achieved/wanted); zero for the largest load.
    minima : tuple of Minimum
        Different ends of the starts, the best first.
    notes : tuple of str
        What a user should know: bounds that stop the design, ranges that no values reach, minima that differ.
    evaluations : int
        Number of contacts or critical loads solved.

    See Also
    --------
    flatpunch.design : Makes it.
    flatpunch.plot_design : The picture.

    Examples
    --------
    >>> film = fp.Layer(young=2e9, poisson=0.4, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=70e9, poisson=0.22))
    >>> wanted = fp.Target("stiffness", 50e3, force=2e-3)
    >>> found = fp.design(film, fp.Sphere(radius=20e-6), vary={"layers[0].young": (1e9, 9e9)}, objective=wanted)
    >>> print(f"{found.medium.layers[0].young / 1e9:.2f} GPa, misfit below 1e-6: {found.misfit < 1e-6}")
    3.64 GPa, misfit below 1e-6: True
    """

    medium: Body
    indenter: Indenter
    values: tuple[DesignedValue, ...]
    quantity: str
    control: str
    at: Array
    wanted: Array
    achieved: Array
    before: Array
    misfit: float
    minima: tuple[Minimum, ...]
    notes: tuple[str, ...]
    evaluations: int

    def __getitem__(self, name: str) -> float:
        """Return the value found for a varied number [SI]."""
        for each in self.values:
            if each.name == name:
                return each.found
        raise KeyError(name)


@one_blas_thread()
@refused_overflow()
def design(
    medium: Body,
    indenter: Indenter,
    *,
    vary: Mapping[str, tuple[float, float]],
    objective: Target | LargestLoad,
    limits: Sequence[Limit] = (),
    starts: int = 4,
    method: MethodName | Method | None = None,
    progress: bool | Report | None = None,
) -> Design:
    """Find the numbers of a medium and a tip that give a prescribed contact, or the largest load before failure.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The body, with the values of the first start.
    indenter : Indenter
        The tip, likewise.
    vary : mapping of str to (float, float)
        Names of the numbers to vary, as in `sensitivity`, with their bounds [SI]. A list by its name stands for its entries:
        "layers[0].young" for the nodes of a tabulated grading. "indenter.slopes" varies the heights of a RadialProfile by the
        slopes between its radii, which keeps it ascending.
    objective : Target or LargestLoad
        What is prescribed: one value, a whole curve, or the largest critical load.
    limits : sequence of Limit
        Bounds on quantities of the contact.
    starts : int
        Number of starts: the case itself, and others spread over the bounds.
    method : str or method, optional
        As for `sensitivity`. "bem" knows force and depth only.
    progress : bool or callable, optional
        True shows a bar; a function is called with (starts done, starts in all).

    Returns
    -------
    Design
        Medium and tip, the table of start, found values and active bounds, what is achieved, and notes: which range of a curve
        cannot be reached, and whether the starts ended in different minima.

    Raises
    ------
    ValueError, TypeError
        On bad input; if a number has no effect on what is designed; if no values keep the limits.

    See Also
    --------
    Target, Limit, LargestLoad : What is wanted.
    plot_design : The picture.
    sensitivity : Which value changes what.

    Examples
    --------
    >>> import flatpunch as fp
    >>> film = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(70e9, 0.22))
    >>> wanted = fp.Target("stiffness", 50e3, force=2e-3)
    >>> found = fp.design(film, fp.Sphere(20e-6), vary={"layers[0].young": (1e9, 9e9)}, objective=wanted)
    >>> print(f"{found.achieved[0] / 1e3:.4f} kN/m")
    50.0000 kN/m
    """
    check_indenter(indenter)
    if not isinstance(objective, (Target, LargestLoad)):
        raise TypeError(
            f"objective = {shown(objective)} must be a Target(quantity, value, depth=... or force=...) or LargestLoad(strengths)."
        )
    kept = listed("limits", limits, Limit, "Limit(quantity, minimum=, maximum=, depth=, force=)")
    _check_together(kept)
    count = whole("starts", starts, 1, "It is the number of starts of the search.", most=1000)
    chosen = derivable(method, indenter)
    problem = Problem(variables(underlying(medium), indenter, vary), chosen)
    if isinstance(chosen, BoundaryElements):
        _check_cells(objective, kept)
    before = _first(problem, objective, kept)
    with reporting("Design", progress) as report:
        ends = search(problem, objective, kept, _starts(problem, count), report)
    best = ends[0]
    if best.limit is not None and best.violation > ALIKE:
        raise ValueError(_infeasible(problem, best))
    return _result(problem, objective, kept, ends, before)


_starts = starts


def _check_cells(objective: Target | LargestLoad, limits: list[Limit]) -> None:
    asked = [each.quantity for each in (objective, *limits) if isinstance(each, (Target, Limit))]
    wrong = [quantity for quantity in asked if quantity in ("stiffness", "radius")]
    if wrong:
        raise ValueError(
            f"{wrong[0]} is not designed with boundary elements, whose derivatives are those of force and depth. Prescribe one "
            "of these, or choose method='first-order'."
        )


def _check_together(limits: list[Limit]) -> None:
    for one, other in itertools.permutations(limits, 2):
        alike = (one.quantity, one.control.name, float(one.control.values[0])) == (
            other.quantity,
            other.control.name,
            float(other.control.values[0]),
        )
        if alike and one.minimum is not None and other.maximum is not None and one.minimum > other.maximum:
            raise ValueError(f"limits: {one.text} and {other.text} exclude each other.")


def _first(problem: Problem, objective: Target | LargestLoad, limits: list[Limit]) -> Array:
    """What the case gives before the design; refuses what has no effect."""
    u = problem.variables.internal(problem.variables.start)
    if isinstance(objective, LargestLoad):
        load = problem.load(u, objective)
        if load >= LARGEST:
            raise ValueError(
                "objective: nothing fails in this case up to the largest contact of its tip, so that there is no load to raise. "
                "Check the units of the strengths, or give a case and bounds in which something fails."
            )
        if not np.isfinite(load):
            raise ValueError(
                "objective: the critical load of this case is zero, as a sharp tip fails at the first touch. Round the tip."
            )
        effect = np.array([_effect(problem, objective, u, i) for i in range(u.size)])
        value = np.array([np.exp(load)])
    else:
        value, slope = problem.quantity(u, objective.control, objective.quantity)
        effect = np.abs(slope).max(axis=0)
    for limit in limits:
        effect = np.maximum(effect, np.abs(problem.margins(u, limit)[1]).max(axis=0))
    idle = (effect < ROUNDING) & ~problem.variables.listed
    if idle.any():
        name = problem.variables.names[int(np.argmax(idle))]
        raise ValueError(
            f"vary: {name} has no effect on what is designed at the start (logarithmic derivative {float(effect[idle][0]):.1g}). "
            "Leave it out."
        )
    return value


def _effect(problem: Problem, objective: LargestLoad, u: Array, i: int) -> float:
    """Change of the logarithm of the load over a tenth of the range of one number."""
    low, high = problem.variables.ranges
    moved = u.copy()
    moved[i] += 0.1 * (high[i] - low[i]) * (1 if u[i] < (low[i] + high[i]) / 2 else -1)
    return abs(problem.load(moved, objective) - problem.load(u, objective))


def _infeasible(problem: Problem, end: End) -> str:
    limit = end.limit
    assert limit is not None
    value = float(problem.quantity(end.u, limit.control, limit.quantity)[0][0])
    at = ", ".join(
        f"{name} = {number:.4g}"
        for name, number in zip(problem.variables.names, problem.variables.external(end.u), strict=True)
    )
    return (
        f"limits: no values within the bounds keep {limit.text}; the nearest found has {limit.quantity} = {value:.6g} "
        f"{UNITS[limit.quantity]} ({shown(at)}). Widen the bounds of vary, or the limit."
    )


def _result(
    problem: Problem, objective: Target | LargestLoad, limits: list[Limit], ends: list[End], before: Array
) -> Design:
    best, spread = ends[0], problem.variables
    minima = different(problem, ends)
    medium, indenter = spread.case(best.u)
    notes: list[str] = []
    quantity, control, at, wanted = "critical load", "", np.zeros(0), np.zeros(0)
    value, misfit = np.array([np.exp(-best.cost)]), 0.0
    if isinstance(objective, Target):
        value, slope = problem.quantity(best.u, objective.control, objective.quantity)
        quantity, control = str(objective.quantity), str(objective.control.name)
        at, wanted, misfit = objective.control.values, objective.value, best.cost
        notes += _unmet(problem, objective, limits, best, value)
        notes += _undetermined(spread, slope)
    elif best.cost <= -LARGEST:
        value = np.full(1, np.inf)
        notes.append("With the values found nothing fails up to the largest contact of the tip.")
    notes += [line for text in problem.limits.get(best.u.tobytes(), ()) for line in text.splitlines()]
    notes += _minima(objective, ends, minima)
    return Design(
        medium,
        indenter,
        _table(spread, best.u),
        quantity,
        control,
        at,
        wanted,
        value,
        before,
        misfit,
        tuple(_minimum(objective, end, spread) for end in minima),
        tuple(notes),
        problem.evaluations,
    )


def _table(spread: Variables, u: Array) -> tuple[DesignedValue, ...]:
    low, high = spread.ranges
    near = ROUNDING * (high - low)
    found = spread.external(u)
    rows = []
    for i, name in enumerate(spread.names):
        bound: Literal["", "low", "high"] = (
            "low" if u[i] - low[i] < near[i] else "high" if high[i] - u[i] < near[i] else ""
        )
        ends = float(spread.low[i]), float(spread.high[i])
        rows.append(DesignedValue(name, spread.units[i], float(spread.start[i]), float(found[i]), *ends, bound))
    return tuple(rows)


def _unmet(problem: Problem, target: Target, limits: list[Limit], best: End, value: Array) -> list[str]:
    """Notes on missed prescribed values: the deviation of each, and whether any values within the bounds reach it."""
    deviation = value / target.value - 1
    missed = np.flatnonzero(np.abs(deviation) > ALIKE)
    if not missed.size:
        return []
    name, unit = target.control.name, UNITS[target.control.name]
    worst = int(missed[np.argmax(np.abs(deviation[missed]))])
    places = target.control.values
    notes = [
        f"The {target.quantity} misses what is prescribed by up to {100 * abs(deviation[worst]):.3g} % (at {name} = "
        f"{places[worst]:.4g} {unit}); it is met to {100 * ALIKE:g} % at {places.size - missed.size} of {places.size} places."
    ]
    # places that are not met for which the reachable range is searched: the worst ones
    order = missed[np.argsort(-np.abs(deviation[missed]))][:6]
    for i in sorted(order):
        low, high = reachable(problem, target, int(i), best.u)
        if not low * (1 - ALIKE) <= target.value[i] <= high * (1 + ALIKE):
            notes.append(
                f"At {name} = {places[i]:.4g} {unit} the bounds allow a {target.quantity} from {low:.4g} to {high:.4g} "
                f"{UNITS[target.quantity]}; {target.value[i]:.4g} is impossible."
            )
    if len(notes) == 1:
        stopped = [limit.text for limit in limits if problem.margins(best.u, limit)[0].min() < ALIKE]
        if stopped:
            notes.append(f"What stops it is the limit {', and '.join(stopped)}.")
        elif places.size > 1:
            notes.append("Each of these places could be met by itself, but not all together.")
    return notes


def _undetermined(spread: Variables, slope: Array) -> list[str]:
    strength = np.linalg.svd(slope * np.diff(spread.ranges, axis=0)[0], compute_uv=False)
    rank = int(np.count_nonzero(strength > ROUNDING * strength[0]))
    if rank >= len(spread.names):
        return []
    plural = "s" * (rank > 1)
    return [
        f"What is prescribed determines {rank} combination{plural} of the {len(spread.names)} numbers: other designs do the "
        "same. Prescribe more, or vary less."
    ]


def _minimum(objective: Target | LargestLoad, end: End, spread: Variables) -> Minimum:
    misfit, load = (None, math.exp(-end.cost)) if isinstance(objective, LargestLoad) else (end.cost, None)
    return Minimum(misfit, load, tuple(spread.external(end.u).tolist()))


def _minima(objective: Target | LargestLoad, ends: list[End], minima: list[End]) -> list[str]:
    if len(minima) < 2:
        return []
    equal = [end for end in minima if end.cost <= ends[0].cost + ALIKE]
    worse = len(ends) - sum(end.cost <= ends[0].cost + ALIKE for end in ends)
    notes = []
    if len(equal) > 1:
        notes.append(f"{len(equal)} different designs, found from {len(ends)} starts, are equally good; see `minima`.")
    if worse:
        what = "a smaller load" if isinstance(objective, LargestLoad) else "a larger misfit"
        notes.append(f"{worse} of {len(ends)} starts ended in another minimum with {what}; see `minima`.")
    return notes
