"""Contact on a grid at given depth: 0 <= p <= ceiling, gap >= 0 without pressure, <= 0 at the ceiling, zero between.

The outer loop guesses the contact: cells that carry pressure or overlap the indenter. The inner loop removes the gap error on
it by preconditioned conjugate gradients (conjugate.py). Pressures that came out negative are dropped, those above the ceiling
(a hardness; infinite otherwise) are cut, and the contact is guessed anew. The inner problem is linear and is solved to a
fraction of the error it began with, so that the conjugate directions survive many small changes of the contact; these stop the
classical method with one loop (Polonsky & Keer 1999) under stiff films. It yields a correction only, for which single precision
suffices at any tolerance. The outer loop works in the operator's own precision, and the residual it reports is that of the
pressure it returns. Its full steps are those of a semismooth Newton method, which may cycle. When the error stops falling, only
steps that lower the energy sum p (u/2 + f - d) are taken, of which there is one as long as any error is left.

Lengths in cells, pressures in E*. On a folded grid forces and stiffnesses are those of the whole contact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch.bem.grid import Cells, Namespace
from flatpunch.bem.operator.convolution import Operator
from flatpunch.bem.solver.conjugate import dot, largest, remove_gap

_MANY = 6
"""Iterations of one step above which the next ones extend displacements beyond the contact; 3 or 12 cost 10 % of the time."""

DROP = 0.03
"""Reduction of the gap error by the inner loop; at twice or half, solves take 5 % longer."""

PATIENCE = 10
"""Outer steps without progress after which only steps that lower the energy are taken; half is too soon for full ones."""


@dataclass(frozen=True, slots=True)
class State:
    """The state of a solution.

    Attributes
    ----------
    pressure, displacement : array, shape (ny, nx)
        Pressure [E*] and the displacement it causes [cells].
    contact : array of bool, shape (ny, nx)
        Where the pressure is positive.
    elastic : array of bool, shape (ny, nx)
        Where it is below the ceiling as well.
    depth, force : float
        Depth [cells], force [E* cells^2].
    gap_error : float
        Largest |gap| in contact over the depth; see `approach` for surfaces that repeat.
    penetration : float
        Largest penetration outside contact over the same.
    iterations : int
        Inner iterations.
    converged : bool
        Whether both errors are within the tolerance.
    """

    pressure: Cells
    displacement: Cells
    contact: Cells
    elastic: Cells
    depth: float
    force: float
    gap_error: float
    penetration: float
    iterations: int
    converged: bool


@dataclass(frozen=True, slots=True)
class Aim:
    """A force to be reached by changing the depth on the way.

    The force that closing the gap adds is known beforehand: by reciprocity it is the gap weighted by the pressure
    of a flat punch under the same contact, for which one from coarser cells will do.

    Attributes
    ----------
    force : float
        Force [E* cells^2].
    stiffness : float
        dF/dd to a few per cent [E* cells].
    punch : array, shape (ny, nx)
        Pressure under that punch per depth [E*/cell], whose force is `stiffness`.
    """

    force: float
    stiffness: float
    punch: Cells


@dataclass(frozen=True, slots=True)
class _Problem:
    """The body, the gap at first touch [cells], and the largest pressure [E*]."""

    operator: Operator
    height: Cells
    ceiling: float

    def within(self, pressure: Cells) -> Cells:
        """A pressure without its negative part and what exceeds the ceiling."""
        xp = self.operator.xp
        pressure = xp.where(pressure > 0, pressure, xp.zeros_like(pressure))
        return xp.where(pressure < self.ceiling, pressure, xp.full_like(pressure, self.ceiling))

    def elastic(self, pressure: Cells) -> Cells:
        return (pressure > 0) & (pressure < self.ceiling)


@dataclass(slots=True)
class _Trial:
    """A pressure with its displacement at one depth."""

    pressure: Cells
    displacement: Cells
    gap: Cells
    gap_error: float
    penetration: float


def solve_contact(
    operator: Operator,
    height: Cells,
    depth: float,
    *,
    start: Cells = None,
    inner: Operator | None = None,
    aim: Aim | None = None,
    tolerance: float = 1e-8,
    limit: int = 1000,
    ceiling: float = float("inf"),
) -> State:
    """Contact of one indenter at one depth [cells] > 0, or near it where a force is aimed at.

    `height` is the gap at first touch [cells], shape (ny, nx), infinite where the indenter has no surface; `start` a pressure
    to begin with; `inner` the operator in single precision, by default made here. Where a force cannot be met, `depth` is kept.
    `tolerance` is the largest gap error in contact and the largest penetration outside, relative to depth; `limit` that of
    inner iterations; `ceiling` the largest pressure [E*].
    """
    xp, problem = operator.xp, _Problem(operator, height, ceiling)
    inner = operator.single() if inner is None else inner
    iterations, best, waited, extended = 0, np.inf, 0, False
    zero = xp.zeros_like(height)
    # a start from coarser cells may reach beyond the end of the indenter
    now = _trial(problem, depth, problem.within(zero if start is None else xp.where(xp.isfinite(height), start, zero)))
    first_depth, slope, last = depth, 0.0 if aim is None else aim.stiffness, None
    while True:
        if aim is not None:
            closed = _closed_force(problem, aim, now)
            # the contact, and with it the stiffness, may have changed since the aim was taken
            if last is not None:
                gained, moved = closed - last[1], depth - last[0]
                slow = abs(aim.force - closed) > abs(aim.force - last[1]) / 2
                slope = gained / moved if slow and gained * moved > 0 else slope
            last, foreseen = (depth, closed), depth + (aim.force - closed) / slope
            if waited >= PATIENCE or foreseen <= 0:
                # stiff films respond to the rim of the contact, which coarse cells do not resolve
                aim, depth = None, first_depth
            else:
                depth = foreseen
            now = _judged(problem, depth, now.pressure, now.displacement)
        error, missing = max(now.gap_error, now.penetration), 0.0 if aim is None else _missing(operator, aim, now)
        if iterations >= limit or max(error, missing) <= tolerance:
            break
        best, waited = (error, 0) if error < best else (best, waited + 1)
        careful, contact = waited >= PATIENCE, problem.elastic(now.pressure)
        if not careful or now.penetration > now.gap_error:
            overlapping = (now.pressure == 0) & (now.gap < 0)
            # under a start with too small a load far more cells overlap than will touch
            touching = xp.count_nonzero(contact)
            if iterations or not touching or touching >= xp.count_nonzero(overlapping):
                contact = contact | overlapping
        contact = contact | _parting(problem, now)
        gap = xp.where(contact, now.gap, xp.zeros_like(now.gap))
        # the gap may be closed already where only the force is missing
        drop = _drop(tolerance, error)
        change, count = remove_gap(inner, contact, gap, drop, limit - iterations, extended=extended)
        extended |= count >= _MANY
        now = _advance(problem, depth, now, change, careful)
        iterations += max(count, 1)
    return State(
        pressure=now.pressure,
        displacement=now.displacement,
        contact=now.pressure > 0,
        elastic=problem.elastic(now.pressure),
        depth=depth,
        force=_force(operator, now.pressure),
        gap_error=now.gap_error,
        penetration=now.penetration,
        iterations=iterations,
        converged=error <= tolerance,
    )


def _drop(tolerance: float, error: float) -> float:
    """Factor by which the inner loop reduces the gap, to no less than a third of what the outer one needs."""
    enough = 0.3 * tolerance
    return max(DROP, enough / max(error, enough))


def _parting(problem: _Problem, now: _Trial) -> Cells:
    """Cells at the ceiling that have a gap, and so need less pressure."""
    return (now.pressure >= problem.ceiling) & (now.gap > 0)


def _advance(problem: _Problem, depth: float, now: _Trial, change: Cells, careful: bool) -> _Trial:
    """Take `change`, or if `careful` as much of it as lowers the energy."""
    xp = problem.operator.xp
    change = xp.astype(change, now.pressure.dtype)
    if not careful:
        return _trial(problem, depth, problem.within(now.pressure + change))
    energy = _energy(xp, now)
    # differences of energy are only known to the rounding of its sum
    rounding = 64 * float(xp.finfo(now.pressure.dtype).eps) * abs(energy)
    for tried in range(12):
        later = _trial(problem, depth, problem.within(now.pressure + 0.5**tried * change))
        better = max(later.gap_error, later.penetration) < max(now.gap_error, now.penetration)
        lower = _energy(xp, later) - energy
        if lower < -rounding or (lower <= rounding and better):
            return later
    return _descended(problem, depth, now, change)


def _descended(problem: _Problem, depth: float, now: _Trial, change: Cells) -> _Trial:
    """A step that is sure to lower the energy, as projecting part of a Newton step is not.

    In cells that overlap the pressure may grow without bound, so that they are loaded by what overlaps, as much as lowers the
    energy most. Where cells in contact are worse, `change` is of those alone and taken until the first of them is unloaded.
    """
    operator, xp = problem.operator, problem.operator.xp
    zero = xp.zeros_like(now.gap)
    if now.penetration > now.gap_error:
        change = -xp.where((now.pressure == 0) & (now.gap < 0), now.gap, zero)
        length = dot(xp, change, change) / dot(xp, change, operator.apply(change))
    else:
        room = xp.where(change < 0, now.pressure, problem.ceiling - now.pressure)
        steepness = xp.where(change != 0, xp.abs(change), xp.ones_like(zero))
        length = min(1.0, float(xp.min(xp.where(change != 0, room / steepness, xp.full_like(zero, xp.inf)))))
    return _trial(problem, depth, problem.within(now.pressure + length * change))


def _closed_force(problem: _Problem, aim: Aim, now: _Trial) -> float:
    operator, xp = problem.operator, problem.operator.xp
    contact = problem.elastic(now.pressure) | ((now.pressure == 0) & (now.gap < 0)) | _parting(problem, now)
    adds = -dot(xp, aim.punch, xp.where(contact, now.gap, xp.zeros_like(now.gap))) * operator.grid.copies
    return _force(operator, now.pressure) + adds


def _missing(operator: Operator, aim: Aim, now: _Trial) -> float:
    return abs(1 - _force(operator, now.pressure) / aim.force)


def _force(operator: Operator, pressure: Cells) -> float:
    """Force of a pressure, all copies of its cells counted."""
    return float(operator.xp.sum(pressure)) * operator.grid.copies


def _trial(problem: _Problem, depth: float, pressure: Cells) -> _Trial:
    return _judged(problem, depth, pressure, problem.operator.apply(pressure))


def _judged(problem: _Problem, depth: float, pressure: Cells, u: Cells) -> _Trial:
    xp = problem.operator.xp
    gap = u + (problem.height - depth)
    loaded = pressure > 0
    zero = xp.zeros_like(gap)
    scale = approach(problem.operator, problem.height, depth, u)
    # at the ceiling overlap is what yields
    gap_error = largest(xp, xp.where(loaded & ((pressure < problem.ceiling) | (gap > 0)), gap, zero)) / scale
    penetration = max(0.0, -float(xp.min(xp.where(loaded, zero, gap))) / scale)
    return _Trial(pressure, u, gap, gap_error, penetration)


def approach(operator: Operator, height: Cells, depth: float, displacement: Cells) -> float:
    """What errors of the gap are relative to [cells]: the depth, less the mean displacement of surfaces that repeat.

    A mean pressure that repeats moves a surface by C(0), any number on elastic bases; without it, approach is the decrease of
    the mean gap since first touch.
    """
    if not operator.repeats or not height.any():
        return depth
    return abs(depth - float(displacement.mean()))


def _energy(xp: Namespace, trial: _Trial) -> float:
    """Sum of p (u/2 + f - d), which is p (gap - u/2) where the indenter has a surface."""
    inside = xp.where(trial.pressure > 0, trial.gap, xp.zeros_like(trial.gap))
    return dot(xp, trial.pressure, inside - 0.5 * trial.displacement)


def punch_stiffness(
    operator: Operator, contact: Cells, tolerance: float = 1e-2, limit: int = 400
) -> tuple[Cells, float, float, int]:
    """Flat punch of the planform `contact`, shape (ny, nx), pressed in by one cell within `tolerance`.

    Returns pressure per depth [E*/cell], stiffness dF/dd [E* cells], deviation and iterations.
    """
    one = operator.xp.astype(contact, operator.spectrum.dtype)
    p, error, iterations = adhering(operator, contact, one, tolerance, limit)
    return p, _force(operator, p), error, iterations


def adhering(
    operator: Operator, contact: Cells, displacement: Cells, tolerance: float, limit: int
) -> tuple[Cells, float, int]:
    """Pressure [E*], tension included, that gives the cells of `contact` a displacement [cells], zero outside `contact`.

    `tolerance` is the largest deviation over the largest displacement. Returns pressure, deviation and iterations.
    """
    xp, dtype = operator.xp, operator.spectrum.dtype
    # a contact between the centres of cells has no cell
    one, scale = xp.astype(contact, dtype), largest(xp, displacement) or 1.0
    p, error, iterations = xp.zeros_like(one), 1.0, 0
    gap, inner, extended = -displacement, operator.single(), False
    while error > tolerance and iterations < limit:
        drop = _drop(tolerance, error)
        change, count = remove_gap(inner, contact, gap, drop, limit - iterations, extended=extended)
        extended |= count >= _MANY
        p = p + xp.astype(change, dtype)
        gap = operator.apply(p) * one - displacement
        latest = largest(xp, gap) / scale
        iterations += max(count, 1)
        if latest >= error and count == 0:
            break
        error = latest
    return p, error, iterations
