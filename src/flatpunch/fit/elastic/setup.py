"""From a curve and a model to a least-squares problem: which part of the curve, which points, limits, where to start."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.least_squares.minimum import minimise
from flatpunch.fit.least_squares.objective import Objective, contact_range, scanned
from flatpunch.fit.least_squares.setup import Setup, cut, enough, held, with_nuisance
from flatpunch.fit.measured.curve import Curve, approach, check_signal
from flatpunch.fit.parameters.settings import Settings
from flatpunch.fit.parameters.unknowns import frame_of

_SCANNED, _BINS = 100, 400
"""Points to which a curve is averaged for the search of the contact point, and for the first descent."""


def elastic_setup(curve: Curve, model: ForwardModel, limits: tuple[Array, Array], settings: Settings) -> Setup:
    """The approach of a curve against a model without adhesion."""
    part = approach(cut(curve, settings))
    keep, notes = check_signal(part, settings.adhesion)
    used = part.taken(keep) if not keep.all() else part
    objective = Objective(
        model=model,
        depth=used.depth,
        force=used.force,
        nuisance=settings.nuisance,
        held=held(settings),
        frame=frame_of(used.depth, used.force),
        spring=used.spring_constant,
    )
    enough(curve, objective)
    low, high, _ = contact_range(used.depth, used.force)
    slack = high - low
    lower, upper = with_nuisance(objective, limits, (low - slack, high + slack / 3))
    return Setup(part, keep, objective, lower, upper, lambda: _start(objective, lower, upper), notes)


def _start(objective: Objective, lower: Array, upper: Array) -> Array:
    """Scan the contact point, then descend on block means."""
    low, high, first = contact_range(objective.depth, objective.force)
    coarse = objective.binned(_BINS, first)
    model = objective.model
    moduli = [j for j, free in enumerate(model.free) if free.endswith("young")]
    start = np.clip(scanned(objective.binned(_SCANNED, first), model.start(), moduli, (low, high)), lower, upper)
    if coarse.depth.size < objective.depth.size:
        start = minimise(coarse.evaluate, start, lower, upper, settled=0.05).x
    return start
