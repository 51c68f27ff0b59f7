"""What a least-squares problem needs: data, unknowns, bounds and starts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, Flags, real
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.parameters.settings import Settings

LOOSE = 10.0
"""Limits of baseline and tilt, in units of the force range."""


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
    again : callable, optional
        x at the minimum -> the problem with other points left out, or None if it is settled.
    notes : tuple of str
    """

    part: Curve
    used: Flags
    objective: Any
    lower: Array
    upper: Array
    start: Callable[[], Array]
    notes: tuple[str, ...] = ()
    again: Callable[[Array], Setup | None] | None = None


def held(settings: Settings) -> dict[str, float]:
    """Contact point, baseline and tilt where they are not fitted."""
    return {
        "contact": 0.0 if settings.contact == "free" else float(settings.contact),
        "baseline": 0.0,
        "tilt": 0.0,
    }


def enough(curve: Curve, objective: Any) -> None:
    """Refuse more parameters than points."""
    count = len(objective.names)
    if objective.depth.size <= count:
        raise CurveError(f"{curve.name}: {objective.depth.size} points cannot determine {count} parameters.")


def with_nuisance(objective: Any, limits: tuple[Array, Array], contact: tuple[float, float]) -> tuple[Array, Array]:
    """Limits of the free parameters, and of contact [m], baseline and tilt behind them."""
    offset, unit = objective.scales()["contact"]
    loose: Mapping[str, tuple[float, float]] = {
        "contact": ((contact[0] - offset) / unit, (contact[1] - offset) / unit),
        "baseline": (-LOOSE, LOOSE),
        "tilt": (-LOOSE, LOOSE),
    }
    return (
        np.append(limits[0], [loose[name][0] for name in objective.nuisance]),
        np.append(limits[1], [loose[name][1] for name in objective.nuisance]),
    )


def cut(curve: Curve, settings: Settings) -> Curve:
    """The curve before it first reaches `force_to` or `depth_to`."""
    end = curve.depth.size
    for name, column, limit in (
        ("force_to", curve.force, settings.force_to),
        ("depth_to", curve.depth, settings.depth_to),
    ):
        if limit is not None:
            beyond = column > real(name, limit)
            if beyond.any():
                end = min(end, int(np.argmax(beyond)))
    return curve if end == curve.depth.size else curve.taken(slice(0, end))
