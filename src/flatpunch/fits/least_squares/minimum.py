"""The search for least squares: trials to begin with, Levenberg-Marquardt on the normal equations, with bounds by projection.

Two parameters that trade off along a bent valley make straight steps climb its sides. A step that does not improve is therefore
tried once more along the parabola that the refused residuals r(x + v) determine: with r'' v v = 2 (r(x + v) - r(x) - J v), the
step becomes v - (J^T J)^-1 J^T r'' v v/2 (geodesic acceleration, Transtrum and Sethna 2012).

Few parameters, many points, derivatives at hand, all unknowns of order one: then the normal equations lose nothing and an
iteration costs one evaluation. lmfit finds the same minimum (a test compares them) at several times the cost per curve.
Losses that outliers disturb less are minimised by reweighting the squares again and again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np

from flatpunch._support.checks import ROUNDING, TINY, Array, Flags, Indices
from flatpunch.fits.measured.signal import spread_of
from flatpunch.fits.parameters.settings import Loss
from flatpunch.fits.parameters.unknowns import Unknowns

CONTACTS = 24
"""Contact points that are tried."""
RATIOS = 9
"""Values of a ratio that are tried, over a decade either way of the first guess; more cost time only."""


def tried(
    objective: Unknowns,
    thetas: Iterable[Array],
    between: tuple[float, float],
    force: Callable[[Array, Array], Array],
    scaled: Sequence[int],
) -> list[Array]:
    """The best trial of each of `thetas`, the best first, with contact points between two, if these are free.

    At each trial the force of the contact counts by a factor, and the background is fitted: both are linear.

    Parameters
    ----------
    objective : Unknowns
        Readings and background.
    thetas : iterable of ndarray, shape (free,)
        Internal parameters.
    between : tuple of float
        First and last contact point [m].
    force : callable
        (theta, contact points of shape (m,)) -> force of the contact [N], shape (m, n).
    scaled : sequence of int
        Places of the parameters that are in proportion to the force together; empty where there are none.
    """
    place, held = objective.position, objective.held
    span, level, (origin, width) = objective.frame.span, objective.frame.level, objective.units["contact"]
    free, linear = "contact" in objective.nuisance, [name for name in objective.nuisance if name != "contact"]
    contacts = (
        np.linspace(*between, CONTACTS if between[0] < between[1] else 1) if free else np.array([held["contact"]])
    )
    columns = [objective.column(name) for name in linear]
    known = (level if "baseline" in linear else held["baseline"]) + objective.background(held, place, objective.speed)
    data = (objective.force - known) / span
    root, found = np.sqrt(1.0 if objective.counts is None else objective.counts), []
    for theta in thetas:
        trials = []
        for contact, row in zip(contacts, force(theta, contacts) / span, strict=True):
            wanted = root * (data if scaled else data - row)
            rows = root * np.reshape([*columns, *([row] if scaled else [])], (-1, data.size))
            best = np.linalg.lstsq(rows.T, wanted, rcond=None)[0]
            left = wanted - best @ rows
            x = np.concatenate([theta, np.zeros(len(objective.nuisance))])
            if scaled:
                x[list(scaled)] += np.log(max(best[-1], TINY))
            values = dict(zip(linear, best, strict=False)) | {"contact": (contact - origin) / width}
            x[theta.size :] = [values[name] for name in objective.nuisance]
            trials.append((float(left @ left) if not scaled or best[-1] > 0 else np.inf, x))
        found.append(min(trials, key=itemgetter(0)))
    return [x for _, x in sorted(found, key=itemgetter(0))]


Evaluate = Callable[[Array], tuple[Array, Array]]

_DAMPING = (ROUNDING, 1e10)
"""Smallest and largest damping; beyond the largest no step improves."""
SETTLED = 1e-4
"""A step this small against the standard errors ends the search."""
ROUGH = 1e-2
"""The same of one search among several, and where each step solves the contact."""
LEAST = 1e-10
"""Root mean square by which a step that ends the search changes residuals, which are of order one; models are no more exact."""
SOON = 1e-3
"""A step this small, once taken, ends the search in batches; half or twice as much moves E by less than 2e-4 standard errors."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where the search ended.

    Attributes
    ----------
    x : ndarray, shape (p,)
        Parameters.
    residual : ndarray, shape (n,)
    normal : ndarray, shape (p, p)
        J J^T at x.
    converged : bool
    at_bound : ndarray of bool, shape (p,)
    evaluations : int
    """

    x: Array
    residual: Array
    normal: Array
    converged: bool
    at_bound: Flags
    evaluations: int

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.residual @ self.residual)


def minimise(
    evaluate: Evaluate,
    start: Array,
    lower: Array,
    upper: Array,
    fixed: Flags | None = None,
    settled: float = SETTLED,
    longest: float = 1.0,
    steps: int = 200,
) -> Minimum:
    """Least squares of residuals (n,), given with derivatives (p, n), from a start within bounds; `fixed` parameters stay.

    It stops at a step of `settled` standard errors. `longest` is the largest change of a parameter in one step; internal
    parameters are logarithms, so 1 is a factor e. Ten `steps` are usual, twenty where a valley bends, 170 have been seen in one
    that hardly ends.
    """
    x = np.clip(start, lower, upper)
    frozen = np.zeros(x.size, dtype=bool) if fixed is None else fixed
    residual, jacobian = evaluate(x)
    cost, damping, evaluations = float(residual @ residual), 1e-6, 1
    normal, gradient = jacobian @ jacobian.T, jacobian @ residual
    converged = False
    for _ in range(steps):
        pushed = ((x <= lower) & (gradient > 0)) | ((x >= upper) & (gradient < 0))
        live = np.flatnonzero(~(frozen | pushed))
        if not live.size:
            converged = True
            break
        ends = (lower - x, upper - x)
        # what is left to go: the undamped step v, which changes the residuals by v^T N v, in standard errors; data without
        # noise leave residuals at rounding, and steps that change them by less are the last ones as well
        whole = _within(normal, gradient, live, ends, _DAMPING[0])
        change, variance = float(whole @ normal @ whole), cost / max(residual.size - live.size, 1)
        if change < max(settled**2 * variance, LEAST**2 * residual.size):
            # directions without any information may be far to go
            whole *= min(1.0, longest / max(float(np.abs(whole).max()), TINY))
            last = _tried(evaluate, x + whole, jacobian)
            evaluations += 1
            if not _larger(last[0], cost):
                x, (residual, jacobian) = x + whole, last
            converged = True
            break
        moved = _within(normal, gradient, live, ends, damping)
        moved *= min(1.0, longest / float(np.abs(moved).max()))
        trial = x + moved
        new_residual, new_jacobian = _tried(evaluate, trial, jacobian)
        evaluations += 1
        if _larger(new_residual, cost) and np.isfinite(new_residual).all():
            # the valley bends: its curvature along the step is that of the refused residuals
            bend = 2 * (new_residual - residual - moved @ jacobian)
            aside = _within(normal, jacobian @ bend / 2, live, (ends[0] - moved, ends[1] - moved), damping)
            if np.abs(aside).max() < np.abs(moved).max():
                trial = trial + aside
                new_residual, new_jacobian = _tried(evaluate, trial, jacobian)
                evaluations += 1
        if not _larger(new_residual, cost):
            x, residual, jacobian, cost = trial, new_residual, new_jacobian, float(new_residual @ new_residual)
            normal, gradient = jacobian @ jacobian.T, jacobian @ residual
            damping = max(damping / 10, _DAMPING[0])
        elif damping > _DAMPING[1]:
            # no step improves
            converged = True
            break
        else:
            damping = max(damping * 10, 1e-5)
    else:
        # curved models close in by a constant factor a step; a hundred times the last step is close enough
        converged = change < (100 * settled) ** 2 * variance
    at_bound = (x <= lower) | (x >= upper)
    return Minimum(x, residual, jacobian @ jacobian.T, converged, at_bound & ~frozen, evaluations)


def differences(
    residuals: Callable[[Array], Array], x: Array, step: float, limits: tuple[Array, Array] | None = None
) -> Array:
    """Derivatives (p, n) of residuals (n,) by central differences, one-sided at limits."""
    ends = [x + step * np.eye(x.size), x - step * np.eye(x.size)]
    if limits is not None:
        ends = [np.clip(end, *limits) for end in ends]
    way = np.diag(ends[0] - ends[1])
    return np.array([residuals(up) - residuals(down) for up, down in zip(*ends, strict=True)]) / way[:, None]


def _tried(evaluate: Evaluate, x: Array, like: Array) -> tuple[Array, Array]:
    """Residuals and derivatives at a trial step; NaN where the model does not exist, such as beyond the end of a tip's shape."""
    try:
        return evaluate(x)
    except ValueError:
        return np.full(like.shape[1], np.nan), np.full(like.shape, np.nan)


def _within(normal: Array, gradient: Array, live: Indices, ends: tuple[Array, Array], damping: float) -> Array:
    """Step of the live parameters between its ends: those that would leave stop there, and the others follow."""
    step, held = np.zeros_like(gradient), np.zeros(gradient.size, dtype=bool)
    for _ in range(live.size):
        rest = live[~held[live]]
        step[rest] = -_solved(
            normal[np.ix_(rest, rest)], gradient[rest] + normal[np.ix_(rest, live)] @ (step * held)[live], damping
        )
        beyond = rest[(step[rest] < ends[0][rest]) | (step[rest] > ends[1][rest])]
        step = np.clip(step, *ends)
        held[beyond] = True
        if not beyond.size or held[live].all():
            break
    return step


def _larger(residual: Array, cost: float) -> bool:
    return not float(residual @ residual) < cost


def _solved(normal: Array, gradient: Array, damping: float) -> Array:
    """(N + damping diag N)^-1 g in variables scaled to unit diagonal; the least-norm solution if N is singular."""
    unit = 1 / np.sqrt(np.maximum(np.diag(normal), TINY))
    scaled = normal * unit[:, None] * unit
    scaled[np.diag_indices_from(scaled)] += damping
    try:
        return np.asarray(unit * np.linalg.solve(scaled, unit * gradient))
    except np.linalg.LinAlgError:
        return np.asarray(unit * np.linalg.lstsq(scaled, unit * gradient, rcond=ROUNDING)[0])


def covariance(normal: Array, free: Flags, variance: float) -> tuple[Array, Array]:
    """Covariance (p, p) of the free parameters, zero rows for others, and the directions (k, p) that the data do not determine.

    Directions whose information is below 1e-12 of the rest (in variables scaled to unit diagonal) count as undetermined; their
    variance is infinite.
    """
    p = normal.shape[0]
    result = np.zeros((p, p))
    live = np.flatnonzero(free)
    part = normal[np.ix_(live, live)]
    unit = 1 / np.sqrt(np.maximum(np.diag(part), TINY))
    values, vectors = np.linalg.eigh(part * unit[:, None] * unit)
    weak = values < ROUNDING * max(values.max(initial=0.0), TINY)
    inverse = (vectors[:, ~weak] / values[~weak]) @ vectors[:, ~weak].T
    result[np.ix_(live, live)] = variance * inverse * unit[:, None] * unit
    undetermined = np.zeros((int(weak.sum()), p))
    undetermined[:, live] = (vectors[:, weak] * unit[:, None]).T
    for row in undetermined:
        row /= np.abs(row).max()
        hit = np.flatnonzero(np.abs(row) > 1e-6)
        result[hit, hit] = np.inf
    return result, undetermined


def influence(loss: Loss, r: Array) -> tuple[Array, Array]:
    """Derivative psi of a loss over the residual in units of its scale, and the derivative of psi."""
    if loss == "soft_l1":
        root = np.sqrt(1 + r * r)
        return r / root, root**-3
    if loss == "huber":
        return np.clip(r, -1, 1), (np.abs(r) <= 1).astype(float)
    if loss == "cauchy":
        bottom = 1 + r * r
        return r / bottom, (1 - r * r) / bottom**2
    return r, np.ones_like(r)


def robust_scale(residual: Array) -> float:
    """Spread of residuals without regard to outliers."""
    return max(spread_of(residual - np.median(residual)), TINY)


def reweighted(objective: Unknowns, found: Minimum, lower: Array, upper: Array, loss: Loss) -> Minimum:
    """Iteratively reweighted least squares, the scale from the residuals of the step before."""
    base = np.ones_like(found.residual) if objective.weight is None else objective.weight
    x, count = found.x, found.evaluations
    for _ in range(30):
        residual = objective.evaluate(x)[0]
        r = residual / robust_scale(residual)
        psi = influence(loss, r)[0]
        weights = np.sqrt(np.where(np.abs(r) > 1e-8, psi / np.where(r == 0, 1, r), 1.0))
        step = minimise(replace(objective, weight=base * weights).evaluate, x, lower, upper)
        count += step.evaluations
        moved = step.x - x
        x = step.x
        if float(moved @ step.normal @ moved) < 1e-8 * step.cost / residual.size:
            break
    residual, jacobian = objective.evaluate(x)
    return Minimum(x, residual, jacobian @ jacobian.T, step.converged, step.at_bound, count)


def noise_variance(found: Minimum, count: int, loss: Loss) -> tuple[float, float]:
    """Variance of the noise, and how much larger the variance of a robust estimate is (Huber's formula)."""
    freedom = max(found.residual.size - count, 1)
    if loss == "linear":
        return found.cost / freedom, 1.0
    scale = robust_scale(found.residual)
    psi, bend = influence(loss, found.residual / scale)
    return scale**2, float(np.mean(psi**2) / np.mean(bend) ** 2) * found.residual.size / freedom
