"""Intervals by the likelihood profile, where the covariance is not enough.

The covariance is a parabola through the minimum. It fails where two parameters trade off along a curved valley, where a limit
cuts the valley, and where the sum of squares is flat. It is believed where it is narrow, and where the profile at both ends of
its interval has grown by what it says; otherwise the interval ends where the profile has grown by the threshold, with all
other parameters fitted anew within their limits.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.least_squares.joint import JointObjective
from flatpunch.fit.parameters.unknowns import Unknowns
from flatpunch.fit.report.estimate import Estimate, half_width
from flatpunch.fit.report.likelihood import ends_of, tilt_or_contact

if TYPE_CHECKING:
    from flatpunch.fit.report.joint import JointResult
    from flatpunch.fit.report.result import FitResult

_NARROW = 0.03
"""Standard error of an internal parameter (relative, for logarithms) above which intervals come from the profile."""


def by_profile(
    result: FitResult | JointResult, coarse: Unknowns | JointObjective | None = None, shared: Array | None = None
) -> dict[str, Estimate]:
    """Estimates with intervals by the profile where those by the covariance do not do, on block means of the curve if `coarse`.

    `shared` is covariance (p, p) of errors that all readings share, such as that of the calibration; the profile does not know
    of it.
    """
    estimates = dict(result.estimates)
    if result.settings.loss != "linear":
        return estimates
    free = result.objective.model.free
    if not getattr(result.objective.model, "tabulated", True):
        # each step of a profile would solve the contact many times: what exceeds a factor e says nothing
        errors = np.sqrt(np.diag(result.covariance))
        unknown = [name for name, error in zip(free, errors, strict=False) if not error < 1]
        return estimates | {name: replace(estimates[name], by="nothing") for name in unknown}
    cut = bool(result.minimum.at_bound.any()) or bool(len(result.undetermined)) or tilt_or_contact(result)
    for j, name in enumerate(free):
        error = float(np.sqrt(result.covariance[j, j]))
        if not cut and len(free) == 1 and np.isfinite(error) and error <= 10 * _NARROW:
            # one parameter of the sample has no valley; contact and baseline are linear enough
            continue
        if not cut and np.isfinite(error) and error <= _NARROW:
            continue
        low, high = ends_of(result, name, coarse)
        open_ends = [not np.isfinite(v) for v in (low, high)]
        # an interval that a limit cuts ends there; limits that nobody set are far away and end nothing
        # distance of a limit, in the internal parameter, below which it is the user's
        cuts = [
            limit[j] if abs(limit[j] - result.minimum.x[j]) < 12.0 else end
            for limit, end in zip(result.bounds, (low, high), strict=True)
        ]
        ends = [cut_ if is_open else end for cut_, is_open, end in zip(cuts, open_ends, (low, high), strict=True)]
        if shared is not None and shared[j, j] > 0:
            reach = half_width(result.settings.level, max(result.minimum.residual.size - len(result.names), 1))
            more = reach * float(np.sqrt(shared[j, j]))
            x = float(result.minimum.x[j])
            wider = [x + side * float(np.hypot(end - x, more)) for side, end in zip((-1, 1), ends, strict=True)]
            ends = [float(np.clip(end, result.bounds[0][j], result.bounds[1][j])) for end in wider]
        values = result.external(j, np.array(ends))
        by = "nothing" if all(open_ends) else "profile"
        estimates[name] = replace(estimates[name], low=float(values[0]), high=float(values[1]), by=by)
    return estimates
