"""A design as a problem of optimisation with exact derivatives, and its search on SciPy's optimisers: starts and limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy

from flatpunch._support.checks import Array
from flatpunch._support.paths import Plain
from flatpunch._support.progress import Report
from flatpunch.contact.curve import Control
from flatpunch.contact.default import Method
from flatpunch.designs.statement import LargestLoad, Limit, Quantity, Target, Variables
from flatpunch.sensitivities.gradient import gradients
from flatpunch.stresses import critical_load

LARGEST = float(np.log(1e50))
"""Logarithm in the place of an infinite critical load."""


@dataclass(eq=False)
class Problem:
    """Evaluations of targets and limits along a search.

    Attributes
    ----------
    variables : Variables
        What is varied.
    method : Method
        Contact method.
    evaluations : int
        Contacts or critical loads solved so far.
    refusal : str
        Why the last vector could not be evaluated, if it could not.
    limits : dict of bytes to tuple of str
        Why contacts are not valid, for the vectors at which some are not.
    """

    variables: Variables
    method: Method
    evaluations: int = 0
    refusal: str = ""
    limits: dict[bytes, tuple[str, ...]] = field(default_factory=dict)
    _known: dict[tuple[str | bytes, ...], object] = field(default_factory=dict)

    def quantity(self, u: Array, control: Control, quantity: Quantity) -> tuple[Array, Array]:
        """Values of a quantity, shape (n,), and derivatives of their logarithms by u, shape (n, variables)."""

        def solved() -> tuple[Array, Array]:
            medium, indenter = self.variables.case(u)
            self.evaluations += control.values.size
            found = gradients(medium, indenter, control, self.method, self.variables.renewed(medium, indenter))
            value = np.array([getattr(each.contact, quantity) for each in found])
            # derivatives at what is prescribed
            at_force = control.name == "force" and quantity != "depth"
            slope = np.array([getattr(each, f"{quantity}_at_force" if at_force else quantity) for each in found])
            if not all(each.valid for each in found):
                self.limits[u.tobytes()] = tuple(dict.fromkeys(each.notes for each in found if not each.valid))
            return value, self.variables.by_u(slope / value[:, None], u)

        # by content: targets and their controls come and go
        key = (control.name, control.values.tobytes(), quantity, u.tobytes())
        result: tuple[Array, Array] = self._once(key, solved)
        return result

    def residuals(self, u: Array, target: Target) -> tuple[Array, Array]:
        """Relative deviations ln(found/prescribed) and their derivatives; large ones where nothing can be solved."""
        try:
            value, slope = self.quantity(u, target.control, target.quantity)
        except ValueError as error:
            self.refusal = str(error)
            # residual where none can be computed, such as beyond the reach of a tip: the search then takes a shorter step
            return np.full(target.value.size, 1e3), np.zeros((target.value.size, u.size))
        return np.log(value / target.value), slope

    def margins(self, u: Array, limit: Limit) -> tuple[Array, Array]:
        """How far a limit is kept, >= 0 where it is, as logarithms, and derivatives by u."""
        value, slope = self.quantity(u, limit.control, limit.quantity)
        margins, slopes = [], []
        if limit.minimum is not None:
            margins.append(np.log(value[0] / limit.minimum))
            slopes.append(slope[0])
        if limit.maximum is not None:
            margins.append(np.log(limit.maximum / value[0]))
            slopes.append(-slope[0])
        return np.array(margins), np.array(slopes)

    def load(self, u: Array, aim: LargestLoad) -> float:
        """Logarithm of the critical load."""

        def solved() -> float:
            medium, indenter = self.variables.case(u)
            self.evaluations += 1
            first = critical_load(
                medium, indenter, aim.strengths, friction=aim.friction, residual_stress=aim.residual_stress
            )
            limiting = (
                f"The load is limited by {first.kind} of layer {first.layer + 1}." if first.force < np.inf else ""
            )
            self.limits[u.tobytes()] = (*filter(None, [limiting]), *first.notes)
            if first.force == 0:
                return -np.inf
            return float(np.log(first.force)) if np.isfinite(first.force) else LARGEST

        result: float = self._once(("load", u.tobytes()), solved)
        return result

    def _once(self, key: tuple[str | bytes, ...], solve: Callable[[], object]) -> Any:
        if key not in self._known:
            self._known[key] = solve()
        return self._known[key]


_STEPS = 60
"""Most iterations from one start, and evaluations of a load for each number."""

_ACCURATE = 1e-8
"""Misfit, its change, and the change of the vector over its range at which a search ends."""


ROUNDING = 1e-6
"""Relative differences that are rounding of a search: violated limits, distances from bounds, effects of a number."""

ALIKE = 1e-3
"""Relative difference below which values count as met, and distance over the range below which two minima are one."""


@dataclass(frozen=True, eq=False)
class End:
    """Where one start ended: the vector, the cost, and the largest relative violation of a limit with its place."""

    u: Array
    cost: float
    violation: float
    limit: Limit | None


def starts(problem: Problem, count: int) -> list[Array]:
    """The case itself, and further vectors spread over the bounds."""
    variables = problem.variables
    first = variables.internal(variables.start)
    if count == 1:
        return [first]
    low, high = variables.ranges
    sampler = scipy.stats.qmc.LatinHypercube(d=first.size, seed=0)
    return [first, *(low + sampler.random(count - 1) * (high - low))]


def search(
    problem: Problem, aim: Target | LargestLoad, limits: list[Limit], first: list[Array], report: Report
) -> list[End]:
    """Ends of all starts, the best first: those that keep the limits, by their cost."""
    found = []
    for i, u in enumerate(first):
        if isinstance(aim, LargestLoad):
            end = _by_loads(problem, aim, limits, u)
        elif limits:
            end = _with_limits(problem, aim, limits, u)
        else:
            end = _least_squares(problem, aim, u)
        found.append(_judged(problem, limits, end, _cost(problem, aim, end)))
        report(i + 1, len(first))
    return sorted(
        found,
        key=lambda each: (each.violation > ROUNDING, each.violation if each.violation > ROUNDING else 0.0, each.cost),
    )


def different(problem: Problem, ends: list[End]) -> list[End]:
    """Ends that differ from each other, the best of each."""
    width = np.diff(problem.variables.ranges, axis=0)[0]
    kept: list[End] = []
    for end in ends:
        if all(np.abs((end.u - other.u) / width).max() > ALIKE for other in kept):
            kept.append(end)
    return kept


def reachable(problem: Problem, target: Target, i: int, u: Array) -> tuple[float, float]:
    """Smallest and largest value of the quantity at one prescribed place that the bounds allow, searched from u."""
    one = Target(target.quantity, target.value[i], **{target.control.name: target.control.values[i]})
    ends = []
    for sign in (1.0, -1.0):

        def cost(v: Array, sign: float = sign) -> tuple[float, Array]:
            residual, slope = problem.residuals(v, one)
            return sign * float(residual[0]), sign * slope[0]

        result = scipy.optimize.minimize(
            cost, u, jac=True, method="L-BFGS-B", bounds=problem.variables.ranges.T, options={"maxiter": _STEPS}
        )
        ends.append(float(target.value[i] * np.exp(sign * result.fun)))
    return min(ends), max(ends)


def _least_squares(problem: Problem, aim: Target, u: Array) -> Array:
    low, high = problem.variables.ranges
    # the method wants a start inside the bounds
    inside = np.clip(u, low + 1e-6 * (high - low), high - 1e-6 * (high - low))

    def residuals(v: Array) -> Array:
        found = problem.residuals(v, aim)[0]
        if float(np.sqrt(np.mean(found**2))) < _ACCURATE:
            raise _Met(v.copy())
        return found

    try:
        result = _trusted(problem, aim, residuals, inside)
    except _Met as met:
        return met.u
    return _polished(problem, aim, result)


class _Met(Exception):
    """A vector that does all that is prescribed ends the search."""

    def __init__(self, u: Array) -> None:
        super().__init__()
        self.u = u


def _trusted(problem: Problem, aim: Target, residuals: Callable[[Array], Array], inside: Array) -> Array:
    low, high = problem.variables.ranges
    result = scipy.optimize.least_squares(
        residuals,
        inside,
        lambda v: problem.residuals(v, aim)[1],
        bounds=(low, high),
        x_scale=high - low,
        xtol=_ACCURATE,
        ftol=_ACCURATE,
        gtol=None,
        max_nfev=_STEPS,
    )
    return np.asarray(result.x)


def _polished(problem: Problem, aim: Target, u: Array) -> Array:
    """Entries that ended beside a bound are put on it where that is no worse: the interior method never reaches it."""
    low, high = problem.variables.ranges
    near = 1e-3 * (high - low)
    moved = np.where(u - low < near, low, np.where(high - u < near, high, u))
    return moved if _cost(problem, aim, moved) <= _cost(problem, aim, u) * (1 + 1e-9) else u


def _with_limits(problem: Problem, aim: Target, limits: list[Limit], u: Array) -> Array:
    low, high = problem.variables.ranges
    width = high - low

    def cost(x: Array) -> tuple[float, Array]:
        residual, slope = problem.residuals(low + x * width, aim)
        return float(np.mean(residual**2)), 2 * residual @ slope / residual.size * width

    def constraint(limit: Limit) -> Plain:
        return {
            "type": "ineq",
            "fun": lambda x: problem.margins(low + x * width, limit)[0],
            "jac": lambda x: problem.margins(low + x * width, limit)[1] * width,
        }

    result = scipy.optimize.minimize(
        cost,
        (u - low) / width,
        jac=True,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * u.size,
        constraints=[constraint(limit) for limit in limits],
        options={"maxiter": 2 * _STEPS, "ftol": _ACCURATE**2},
    )
    return np.asarray(low + np.clip(result.x, 0.0, 1.0) * width)


def _by_loads(problem: Problem, aim: LargestLoad, limits: list[Limit], u: Array) -> Array:
    """The load has kinks where another failure comes first, so no derivatives are used."""
    low, high = problem.variables.ranges
    width = high - low

    def margins(limit: Limit) -> Callable[[Array], Array]:
        return lambda x: problem.margins(low + np.clip(x, 0.0, 1.0) * width, limit)[0]

    constraints = [scipy.optimize.NonlinearConstraint(margins(limit), 0.0, np.inf) for limit in limits]
    # trust region over the range of the vector at which the search for a load ends: critical loads are accurate to 1e-4
    result = scipy.optimize.minimize(
        lambda x: -problem.load(low + np.clip(x, 0.0, 1.0) * width, aim),
        (u - low) / width,
        method="COBYQA",
        bounds=[(0.0, 1.0)] * u.size,
        constraints=constraints,
        options={"maxfev": _STEPS * (1 + u.size), "initial_tr_radius": 0.2, "final_tr_radius": 1e-4},
    )
    return np.asarray(low + np.clip(result.x, 0.0, 1.0) * width)


def _cost(problem: Problem, aim: Target | LargestLoad, u: Array) -> float:
    if isinstance(aim, LargestLoad):
        return -problem.load(u, aim)
    return float(np.sqrt(np.mean(problem.residuals(u, aim)[0] ** 2)))


def _judged(problem: Problem, limits: list[Limit], u: Array, cost: float) -> End:
    worst, where = 0.0, None
    for limit in limits:
        missing = -float(problem.margins(u, limit)[0].min())
        if missing > worst:
            worst, where = missing, limit
    return End(u, cost, worst, where)
