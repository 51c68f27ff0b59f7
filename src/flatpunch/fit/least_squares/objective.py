"""Residuals of a curve against the forward model, and their derivatives.

    r = w (b + t (z - z_1) + M(z - z0; theta) - F)

z0 contact point, b baseline, t its tilt. Behind a cantilever of stiffness k the noise of F has moved the tip by -noise/k as
well: known exactly is the piezo's position z + F/k. There r is the difference to the force that the model has at that position,

    r = b + t (z - z_1) + M(z - r/k - z0; theta) - F,

solved point by point by Newton's method, dr = dM/(1 + M'/k).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.fit.measured.curve import Curve
from flatpunch.fit.parameters.unknowns import Unknowns

_NEWTON = 8
_SETTLED = 1e-2
"""Newton's method behind a cantilever ends with a step this small against the residuals; the next would be its square."""
_STEEPEST = 0.25
"""Least 1 + M'/k that is let through; data closer to the instability are left out of the fit in the end."""


@dataclass(frozen=True, eq=False)
class Objective(Unknowns):
    """Least-squares problem in x, see `Unknowns`.

    Points are in contact where their depth is positive, unless `loaded` says which are (indices): adhesive contacts hold on
    to negative depths. `part_loaded` is the same over all points of the curve that is shown.
    """

    depth: Array
    force: Array
    weight: Array | None = None
    spring: float | None = None
    loaded: Indices | None = None
    part_loaded: Indices | None = None
    _before: dict[int, Array] = field(default_factory=dict, repr=False)

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Residuals, shape (n,), and derivatives, shape (parameters, n), both over the force range."""
        theta, rest = self.split(x)
        origin, width, span = self.frame
        depth = self.depth - rest["contact"]
        straight = rest["baseline"] + rest["tilt"] * (self.depth - origin) - self.force
        residual, block, stiffness, by_theta = self._residual(depth, straight, theta)
        jacobian = np.zeros((x.size, depth.size))
        count = theta.size
        jacobian[:count, block] = by_theta / span
        for j, name in enumerate(self.nuisance, start=count):
            if name == "contact":
                jacobian[j, block] = stiffness * (-width / span)
            elif name == "baseline":
                jacobian[j] = 1.0
            else:
                jacobian[j] = (self.depth - origin) / width
        if self.spring is not None:
            jacobian[:, block] /= self._give(stiffness)
        residual = residual / span
        if self.weight is not None:
            residual *= self.weight
            jacobian *= self.weight
        return residual, jacobian

    def _residual(self, depth: Array, straight: Array, theta: Array) -> tuple[Array, Any, Array, Array]:
        """Residual [N], the points in contact, and stiffness and derivatives of M there."""
        # the residuals of the evaluation before are where Newton's method starts
        residual = np.zeros_like(depth) if self.spring is None else self._before.get(depth.size, np.zeros_like(depth))
        at = depth if self.spring is None else depth - residual / self.spring
        fresh = not residual.any()
        for turn in range(_NEWTON):
            block = _touching(at) if self.loaded is None else self.loaded
            force, stiffness, by_theta = self.model.evaluate(at[block], theta)
            miss = straight - residual
            miss[block] += force
            if self.spring is None:
                return miss, block, stiffness, by_theta
            step = miss.copy()
            step[block] /= self._give(stiffness)
            residual = residual + step
            at = depth - residual / self.spring
            # what is left is of second order but of one sign: it must vanish beside the error of a mean
            left = miss - step if fresh and turn == 0 else step
            if np.abs(left).max() < _SETTLED * np.sqrt(np.mean(residual**2)):
                break
        if np.abs(residual).max() < self.frame[2]:
            self._before[depth.size] = residual
        else:
            # lost on a trial beyond an instability: nothing to start the next evaluation from
            self._before.pop(depth.size, None)
        return residual, block, stiffness, by_theta

    def _give(self, stiffness: Array) -> Array:
        """How much faster the piezo moves than the tip; it must not turn round where adhesion is about to let go."""
        assert self.spring is not None
        give = 1 + stiffness / self.spring
        return give if self.loaded is None else np.asarray(np.maximum(give, _STEEPEST))

    def over(self, curve: Curve, x: Array) -> Array:
        """Fitted force at all points of the curve that is shown [N]."""
        theta, rest = self.split(x)
        inside = curve.depth - rest["contact"]
        touching = inside > 0 if self.part_loaded is None else self.part_loaded
        result = rest["baseline"] + rest["tilt"] * (curve.depth - self.frame[0])
        if inside[touching].size:
            result[touching] += self.model.evaluate(inside[touching], theta)[0]
        return np.asarray(result)

    def binned(self, count: int, first: int = 0) -> Objective:
        """The same problem on block means from point `first` on: enough to get close, at a fraction of the cost."""
        depth, force = self.depth[first:], self.force[first:]
        size = depth.size // count
        if size >= 2:
            cut = size * (depth.size // size)
            depth, force = (a[-cut:].reshape(-1, size).mean(axis=1) for a in (depth, force))
        return replace(self, depth=depth, force=force, weight=None)


def contact_range(depth: Array, force: Array) -> tuple[float, float, int]:
    """Where the contact can begin, and the first point that matters for finding it.

    From a tenth of the force to its maximum the depth grows by 54 % to 90 % of all of it when the force goes like d to d^3
    (flat end to ball on a thin layer); the contact is looked for between 2.5 and 0.9 times that stretch before the end.
    """
    window = max(force.size // 200, 1)
    smooth = np.convolve(force, np.full(window, 1 / window), "same")
    base = float(np.median(force[: max(force.size // 10, 4)]))
    top = float(force[-max(window, 3) :].mean())
    below = np.flatnonzero(smooth < base + 0.1 * (top - base))
    tenth = float(depth[int(below[-1])]) if below.size else float(depth[0])
    end = float(depth.max())
    low, high = end - 2.5 * (end - tenth), end - 0.9 * (end - tenth)
    before = np.flatnonzero(depth < low - (end - tenth))
    return low, high, int(before[-1]) if before.size else 0


def _touching(depth: Array) -> Any:
    """Points in contact: a slice where they are one stretch to the end, as a mask costs as much as the model."""
    inside = depth > 0
    start = int(np.argmax(inside)) if inside.any() else depth.size
    return slice(start, None) if inside[start:].all() else np.flatnonzero(inside)


def scanned(
    objective: Objective, theta: Array, moduli: Sequence[int], between: tuple[float, float], candidates: int = 32
) -> Array:
    """Starting x: for each of many contact points the best amplitude and baseline, by linear least squares.

    Parameters
    ----------
    objective : Objective
        On few points.
    theta : ndarray
        Starting parameters, internal.
    moduli : sequence of int
        Which of them are moduli; the amplitude goes into them.
    between : tuple of float
        Range of contact points [m].
    candidates : int
        Number of contact points tried.
    """
    origin, width, span = objective.frame
    free = "contact" in objective.nuisance
    tried = np.linspace(*between, candidates) if free else np.array([objective.held["contact"]])
    inside = objective.depth - tried[:, None]
    model = np.zeros_like(inside)
    touching = inside > 0
    if touching.any():
        model[touching] = objective.model.evaluate(inside[touching], theta)[0] / span
    data = (objective.force - objective.held.get("baseline", 0.0)) / span
    if "baseline" in objective.nuisance:
        centred = model - model.mean(axis=1, keepdims=True)
        amplitude = centred @ (data - data.mean()) / np.maximum(np.sum(centred**2, axis=1), 1e-300)
    else:
        amplitude = model @ data / np.maximum(np.sum(model**2, axis=1), 1e-300)
    if not moduli:
        amplitude = np.ones_like(amplitude)
    amplitude = np.maximum(amplitude, 1e-12)
    baseline = (data - amplitude[:, None] * model).mean(axis=1) if "baseline" in objective.nuisance else 0.0 * amplitude
    misfit = np.sum((data - amplitude[:, None] * model - baseline[:, None]) ** 2, axis=1)
    # at least three points in contact, or any of them fits the last one perfectly
    misfit[touching.sum(axis=1) < 3] = np.inf
    best = int(np.argmin(misfit))
    start = theta.copy()
    for j in moduli:
        start[j] += np.log(amplitude[best]) / len(moduli)
    rest = {"contact": (tried[best] - origin) / width, "baseline": baseline[best], "tilt": 0.0}
    return np.concatenate([start, [rest[name] for name in objective.nuisance]])
