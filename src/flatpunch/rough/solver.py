"""Contact of a rough surface at a depth or a force, on one grid.

At a depth this is the active set of boundary elements (`bem.solver.active_set`). At a force the depth follows within that solve:
a loose solution gives the stiffness of the flat punch under the contact, and with it the force that closing the gap will add.
Where that fails, as under stiff films or where cells yield, the depth is found by Newton's method with that stiffness, and by
bisection where that is slow.

Lengths are in cells, pressures in units of E*.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.bem.operator.convolution import Operator
from flatpunch.bem.solver.active_set import Aim, State, approach, punch_stiffness, solve_contact

LOOSE = 0.03
"""Gap error over the depth of the first solution at a force, as the inner loop reduces it once."""

COARSE = 1e-3
"""Tolerance on wider cells, from which finer ones begin."""

_ONE = 4
"""Cells that one of twice the width is spread to."""

_NEWTON = 100
"""Most solutions towards one force; two are usual, seven under films a hundred times stiffer, sixty where cells yield at 1e-7 of
the modulus."""


@dataclass(frozen=True, slots=True)
class Level:
    """A surface on a body.

    Operators in double and single precision, gap at first touch [cells], the same on wider cells, and the largest pressure [E*].
    """

    operator: Operator
    inner: Operator
    height: Array
    coarser: Level | None = None
    hardness: float = float("inf")

    def energy(self, pressure: Array, depth: float = 0.0) -> float:
        """Sum of p (u/2 + f - d): of two pressures with equal force, or at equal depth, the lower one is nearer."""
        return float(np.vdot(pressure, self.operator.apply(pressure) / 2 + (self.height - depth)))


@dataclass(frozen=True, slots=True)
class Solved:
    """A contact: the state of the solver, the relative error of the force, and whether all errors are within the tolerance."""

    state: State
    force_error: float
    converged: bool


def at_depth(level: Level, depth: float, tolerance: float, limit: int, before: Array | None = None) -> Solved:
    """Contact at a depth [cells], from wider cells or from the pressure of another depth."""
    start = None
    if level.coarser is not None:
        start = _spread(at_depth(level.coarser, depth / 2, max(tolerance, COARSE), limit).state.pressure)
        start = (
            min((start, before), key=lambda pressure: level.energy(pressure, depth)) if before is not None else start
        )
    elif before is not None and level.energy(before, depth) < 0:
        start = before
    state = solve_contact(
        level.operator,
        level.height,
        depth,
        start=start,
        inner=level.inner,
        tolerance=tolerance,
        limit=limit,
        ceiling=level.hardness,
    )
    return Solved(state, 0.0, state.converged)


def at_force(level: Level, force: float, tolerance: float, limit: int, before: Array | None = None) -> Solved:
    """Contact at a force [E* cells^2], from wider cells or from the pressure of another force."""
    operator, inner, height = level.operator, level.inner, level.height
    if lowest := float(height.min()):
        # on wider cells: depths of small forces are no rounding of the lowest height
        height = height - lowest
    if level.coarser is None:
        start = first_pressure(operator, height, force)
    else:
        start = _spread(at_force(level.coarser, force / 4, max(tolerance, COARSE), limit).state.pressure)
        start *= force / start.sum()
    if level.coarser is None or np.count_nonzero(start) <= _ONE:
        start = min((start, _lone(height, force)), key=level.energy)
    if before is not None and before.any():
        start = min((start, before * (force / before.sum())), key=level.energy)
    depth = float(np.vdot(start, operator.apply(start) + height)) / force
    aim, wanted, follows, left = None, LOOSE, True, limit
    bounds, last = [0.0, float("inf")], float("inf")
    for _ in range(_NEWTON):
        state = solve_contact(
            operator,
            height,
            depth,
            start=start,
            inner=inner,
            aim=aim,
            tolerance=wanted,
            limit=left,
            ceiling=level.hardness,
        )
        missing, left = 1 - state.force / force, left - state.iterations
        if left <= 0 or (abs(missing) <= tolerance and wanted <= tolerance):
            break
        follows &= aim is None or state.depth != depth
        punch, stiffness, _, _ = punch_stiffness(inner, state.elastic if state.elastic.any() else state.contact)
        scale = approach(operator, height, state.depth, state.displacement)
        # a gap adds stiffness times the gap to the force
        wanted = tolerance * min(1.0, force / (stiffness * scale))
        start, depth = state.pressure, state.depth
        aim = Aim(force, stiffness, punch) if follows else None
        if not follows:
            # where cells yield the force grows in steps, which its slope does not foresee
            bounds[missing < 0] = depth
            slow, last = abs(missing) > abs(last) / 2, missing
            depth = depth + missing * force / stiffness if stiffness else np.inf
            if slow or not bounds[0] < depth < bounds[1]:
                depth = sum(bounds) / 2 if np.isfinite(bounds[1]) else max(depth, 2 * state.depth)
    return Solved(state, abs(missing), state.converged and abs(missing) <= tolerance)


def _lone(height: Array, force: float) -> Array:
    """Pressure on the highest cell alone, which the smallest forces load."""
    pressure = np.zeros(height.shape)
    pressure.flat[np.argmin(height)] = force
    return pressure


def _spread(coarse: Array) -> Array:
    """Values of cells twice as wide on the finer ones."""
    return np.repeat(np.repeat(coarse, 2, axis=0), 2, axis=1)


def first_pressure(operator: Operator, height: Array, force: float) -> Array:
    """Pressure to begin with: what full contact would need, without its tension and with the right force."""
    wanted = -operator.precondition(height)
    # below the largest one, so that small forces are no rounding of it
    wanted -= wanted.max()
    steps = np.sort(wanted.ravel())[::-1]
    # the level above which the pressures sum up to the force
    levels = (np.cumsum(steps) - force) / np.arange(1, steps.size + 1)
    loaded = int(np.count_nonzero(steps > levels))
    return np.asarray(np.maximum(wanted - levels[loaded - 1], 0.0))
