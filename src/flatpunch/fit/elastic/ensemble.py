"""Residuals of many parameter vectors at once, for samplers: the force of all of them from the same tables.

Two numbers of the calibration may differ between vectors as well. With kappa the true over the assumed spring constant and sigma
the same of the sensitivity, true forces are kappa sigma times and true deflections sigma times those of the curve: the force of
the model counts by 1/(kappa sigma), and a force bends the cantilever by sigma/k.
"""

from __future__ import annotations

from typing import TypeGuard

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.paths import Plain
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.least_squares.objective import Objective

_NEWTON = 8
"""Newton steps at most for the force behind a cantilever."""


def applies(objective: object) -> TypeGuard[Objective]:
    """Whether residuals can be had at once: elastic contacts without adhesion or memory, from a table."""
    if not isinstance(objective, Objective) or not isinstance(objective.model, ForwardModel):
        return False
    return objective.loaded is None and objective.model.tabulated


def residuals(objective: Objective, x: Array, spring_constant: Array, sensitivity: Array) -> Array:
    """Residuals over the force range, shape (vectors, n), as `Objective.evaluate` has them; see `applies`.

    For each vector x of internal parameters the calibration has factors, true over assumed, shape (vectors,).
    """
    count = len(objective.model.free)
    rest: Plain = dict(objective.held)
    for name, column in zip(objective.nuisance, x[:, count:].T, strict=True):
        offset, unit = objective.units[name]
        rest[name] = (offset + unit * column)[:, None]
    moving = objective.background(rest, objective.position, objective.speed)
    gain = (spring_constant * sensitivity)[:, None]
    give = np.zeros_like(gain) if objective.spring is None else sensitivity[:, None] / objective.spring
    depth = objective.position - give * (objective.force - moving) - rest["contact"]
    straight = np.broadcast_to(rest["baseline"] + moving - objective.force, depth.shape)
    found = _solved(objective, depth, straight, x[:, :count], gain, give)
    for weight in (objective.weight, None if objective.counts is None else np.sqrt(objective.counts)):
        if weight is not None:
            found *= weight
    return np.asarray(found / objective.frame.span)


def _solved(objective: Objective, depth: Array, straight: Array, theta: Array, gain: Array, give: Array) -> Array:
    """Residuals [N]: behind a cantilever the roots of r = straight + M(depth - give r)/gain, by Newton's method."""
    force, stiffness = forces(objective.model, depth, theta)
    found = np.asarray(straight + force / gain)
    if objective.spring is None:
        return found
    residual = found / (1 + stiffness * give / gain)
    for _ in range(_NEWTON):
        force, stiffness = forces(objective.model, depth - give * residual, theta)
        step = (straight + force / gain - residual) / (1 + stiffness * give / gain)
        residual = residual + step
        # Newton's method behind a cantilever ends with a step this small against the residuals
        if (np.abs(step).max(axis=1) < 1e-3 * np.sqrt(np.mean(residual**2, axis=1))).all():
            break
    return np.asarray(residual)


def forces(model: ForwardModel, depth: Array, theta: Array) -> tuple[Array, Array]:
    """Force [N] and stiffness [N/m] at depths of any sign, shape (vectors, n), for parameters of shape (vectors, free)."""
    force, stiffness = np.zeros_like(depth), np.zeros_like(depth)
    touching = np.flatnonzero((depth > 0).any(axis=0))
    if not touching.size:
        return force, stiffness
    some = slice(touching[0], touching[-1] + 1)
    inside = depth[:, some] > 0
    at = np.where(inside, depth[:, some], depth[:, some].max())
    value, slope = model.logarithms(np.log(at), theta)
    found = np.where(inside, np.exp(value), 0.0)
    force[:, some] = found
    stiffness[:, some] = found * slope / at
    return force, stiffness
