"""Losses that outliers disturb less: iteratively reweighted least squares, and the spread of what comes out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flatpunch._support.checks import TINY, Array
from flatpunch.fit.least_squares.minimum import Minimum, minimise
from flatpunch.fit.measured.signal import spread_of
from flatpunch.fit.parameters.settings import Loss
from flatpunch.fit.parameters.unknowns import Unknowns


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
