"""Rows of a table for plain curves that are fitted side by side; what has anything to judge is left to the fit of one curve.

The judgements are those of `flatpunch.fit.elastic.setup`, on the safe side: a curve that comes near one of them is left.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.contact.limits import deepest as base_depth
from flatpunch.fit.elastic.background import tilt_note, waves
from flatpunch.fit.elastic.many import Found, at_once
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.elastic.plastic import HARD, IMPRINT, depth_reached
from flatpunch.fit.elastic.setup import SAFE
from flatpunch.fit.measured.curve import FEWEST, Curve
from flatpunch.fit.measured.signal import CLEAR, DIP, memory_of
from flatpunch.fit.models import bounds
from flatpunch.fit.parameters.settings import Free, Settings
from flatpunch.fit.report.estimate import half_width
from flatpunch.fit.report.findings import TIMES, WIDE
from flatpunch.fit.report.memory import correlated
from flatpunch.fit.report.result import read_lines
from flatpunch.fit.search import MISFIT

_NEAR = 0.7
"""Share of a threshold from which a curve is judged by the fit of one curve."""


def plain_rows(
    curves: Sequence[Curve], model: ForwardModel, free: Mapping[str, Free], settings: Settings
) -> list[dict[str, Any] | None]:
    """Rows as of `FitResult.row`; None for curves that must be fitted one by one.

    Parameters
    ----------
    curves : sequence of Curve
    model, free, settings
        A case for which `flatpunch.fit.elastic.many.supported` holds.
    """
    limits = bounds(model, free)
    # a modulus changes no thickness
    bottom = base_depth(model.medium)
    rows: list[dict[str, Any] | None] = []
    for curve, found in zip(curves, at_once(curves, model, settings), strict=True):
        plain = found is not None and limits[0][0] < found.x[0] < limits[1][0]
        rows.append(_row(curve, found, model, settings, bottom) if found is not None and plain else None)
    return rows


def _row(curve: Curve, found: Found, model: ForwardModel, settings: Settings, bottom: float) -> dict[str, Any] | None:
    data, residual, n = found.data, found.residual, found.residual.size
    young, contact = float(np.exp(found.x[0])), float(found.x[1])
    names = [
        model.free[0],
        "contact",
        *(["baseline"] if found.x.size > 2 else []),
        *(["tilt"] if found.x.size > 3 else []),
    ]
    level, tilt = ([*found.x[2:], 0.0, 0.0])[:2]
    spring = data.curve.spring_constant or np.inf
    along = tilt * (data.position - data.position.min())
    inside = data.mean + (tilt * (data.mean - data.position.min()) - data.level) / spring - contact
    deepest = float((data.position + (along - data.force) / spring).max()) - contact
    if inside[0] >= 0 or deepest >= _NEAR * bottom:
        return None
    begin = int(np.argmax(inside >= (1 - SAFE) * inside[0]))
    safe, touching = int(data.edges[begin]), int(data.edges[int(np.argmax(inside >= 0))])
    over = data.force - level - along
    noise = float(np.sqrt(residual[:safe] @ residual[:safe] / max(safe, 1)))
    pressed = residual[touching:]
    cost = float(residual @ residual)
    correlation = float(residual[1:] @ residual[:-1]) / max(cost, 1e-300)
    error = np.sqrt(found.variances * (cost / (n - found.x.size)))
    if (
        safe < FEWEST
        or _unusual(data.level - level, over, (begin, safe), found, noise)
        or float(pressed @ pressed) > (_NEAR * TIMES * noise) ** 2 * pressed.size
        or not error[0] < _NEAR * WIDE
        or memory_of(pressed) > _NEAR * MISFIT
        or (young > _NEAR * HARD and _imprint(curve, found, level, tilt))
    ):
        return None
    notes = correlated(correlation, n)
    if settings.baseline == "constant":
        notes = tilt_note(data.mean[:begin], data.level[:begin], deepest, float(over.max())) + notes
    values = [young, contact, level, tilt]
    reach = half_width(settings.level, n - found.x.size) * error
    row: dict[str, Any] = {"curve": curve.name, "ok": True, "reason": ""}
    for j, name in enumerate(names):
        ends = young * np.exp([-reach[0], reach[0]]) if j == 0 else values[j] + np.array([-1, 1]) * reach[j]
        row[name] = float(values[j])
        row[f"{name} stderr"] = float(error[j] * (young if j == 0 else 1.0))
        row[f"{name} low"], row[f"{name} high"] = float(ends[0]), float(ends[1])
    row |= {"deepest": deepest, "noise": float(np.sqrt(cost / (n - found.x.size))), "points": n}
    read = read_lines(data.curve, n)
    if read:
        row["read"] = "; ".join(read)
    return {**row, "notes": " ".join(notes)}


def _imprint(curve: Curve, found: Found, level: float, tilt: float) -> bool:
    """Whether a retract may end short of where the contact began."""
    n, data = found.residual.size, found.data
    if curve.depth.size - n <= FEWEST:
        return False
    back = curve.taken(slice(n, None))
    rise, first = float(np.ptp(data.force)), float(data.position.min())
    down, up = (depth_reached(c.depth, c.force - level - tilt * (c.position - first), rise) for c in (data.curve, back))
    return up - down > _NEAR * IMPRINT * (float(curve.depth.max()) - float(found.x[1]))


def _unusual(levels: Array, over: Array, before: tuple[int, int], found: Found, noise: float) -> bool:
    """Whether the force comes near one of the judgements: no rise, steps of the converter, a dip, saturation, a wave."""
    begin, safe = before
    rise = float(over.max())
    if rise * _NEAR < CLEAR * noise or np.count_nonzero(found.data.force[1:200] == found.data.force[:199]) > 60:
        return True
    if -float(over[safe:].min()) > max(0.85 * CLEAR * noise, _NEAR * DIP * rise):
        return True
    measured, fitted = (float(c[-1] - c[-5]) for c in (found.data.level, found.fitted))
    if measured < 0.5 * fitted or begin < 8:
        return True
    position, force = found.data.mean[:begin], levels[:begin]
    position, force = position - position.sum() / begin, force - force.sum() / begin
    slope = float(position @ force) / max(float(position @ position), 1e-300)
    return waves(force - slope * position, _NEAR * rise)
