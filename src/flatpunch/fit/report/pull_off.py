"""The pull-off force that a fit of an adhesive curve implies: the largest tension of the contact."""

from __future__ import annotations

import math

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.adhesion.model import AdhesiveModel
from flatpunch.fit.report.estimate import Estimate


def pull_off_force(model: object, x: Array, spread: Array, reach: float) -> Estimate | None:
    """Pull-off force [N], positive, with the interval that the fitted parameters imply; None without adhesion.

    Where the force is smallest it does not change with the depth: its derivatives by the parameters are those at this depth. x
    and `spread` are the internal parameters, those of the model first, and their covariance; `reach` is in standard errors.
    """
    if not isinstance(model, AdhesiveModel):
        return None
    count = len(model.free)
    theta = x[:count]
    ends, points = (model.pull_off(theta)[0], 0.0), 200
    # the grid once more between the neighbours of its smallest force
    for _ in range(2):
        depth = np.linspace(*ends, points)
        force, _, by_theta = model.evaluate(depth, theta)
        at = int(np.argmin(force))
        ends = float(depth[max(at - 1, 0)]), float(depth[min(at + 1, points - 1)])
    value = max(-float(force[at]), 0.0)
    by = by_theta[:, at]
    error = math.sqrt(max(float(by @ spread[:count, :count] @ by), 0.0))
    return Estimate(value, error, max(value - reach * error, 0.0), value + reach * error)
