"""What a least-squares problem needs: data, unknowns, bounds and starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Flags, real
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.parameters.settings import Settings
from flatpunch.fit.parameters.unknowns import Unknowns


@dataclass(frozen=True, eq=False)
class Setup:
    """A least-squares problem.

    Attributes
    ----------
    part : Curve
        What is shown of the curve.
    used : ndarray of bool
        Which of its points are fitted.
    objective : Objective or HistoryObjective
        Residuals.
    lower, upper : ndarray
        Limits of all of x.
    start : callable
        () -> x to descend from.
    settings : Settings
        With the background that was chosen.
    coarse : Objective, optional
        The same problem on block means with the same minimum, at a fraction of the cost.
    other : Objective, optional
        The same problem over another background that the data allow; what it moves widens the intervals.
    again : callable, optional
        x at the minimum -> the problem with other points left out, or None if it is settled.
    notes : tuple of str
    reached : float, optional
        Deepest reading of the approach, fitted or not [m].
    tilted : bool
        Whether the readings before the contact show a tilt where the user has not asked for one.
    doubtful : bool
        Whether the user left the baseline open, and a constant describes these readings.
    """

    part: Curve
    used: Flags
    objective: Unknowns
    lower: Array
    upper: Array
    start: Callable[[], Array]
    settings: Settings
    notes: tuple[str, ...] = ()
    reached: float | None = None
    coarse: Unknowns | None = None
    other: Unknowns | None = None
    again: Callable[[Array], Setup | None] | None = None
    tilted: bool = False
    doubtful: bool = False


def enough(curve: Curve, objective: Unknowns) -> None:
    """Refuse more parameters than points."""
    count = len(objective.names)
    if objective.depth.size <= count:
        raise CurveError(f"{curve.name}: {objective.depth.size} points cannot determine {count} parameters.")


def with_nuisance(
    objective: Unknowns, limits: tuple[Array, Array], contact: tuple[float, float]
) -> tuple[Array, Array]:
    """Limits of the free parameters, of the contact point [m], and none for the background."""
    offset, unit = objective.units["contact"]
    bounds = {"contact": ((contact[0] - offset) / unit, (contact[1] - offset) / unit)}
    ends = [bounds.get(name, (-np.inf, np.inf)) for name in objective.nuisance]
    return np.append(limits[0], [low for low, _ in ends]), np.append(limits[1], [high for _, high in ends])


def cut(curve: Curve, settings: Settings, depth_sign: float = 1.0, force_sign: float = 1.0) -> Curve:
    """The curve before it first reaches `force_to` or `depth_to`, given on the user's own axes (signs of turned ones)."""
    end = curve.depth.size
    for name, column, sign in (("force_to", curve.force, force_sign), ("depth_to", curve.depth, depth_sign)):
        limit = getattr(settings, name)
        if limit is not None:
            beyond = column > sign * real(name, limit)
            if beyond.any():
                end = min(end, int(np.argmax(beyond)))
    return curve if end == curve.depth.size else curve.taken(slice(0, end))
