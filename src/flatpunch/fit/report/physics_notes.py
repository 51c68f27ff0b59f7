"""What the contact theory says about its own limits at the fitted values, and how adhesion and relaxation met the data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from flatpunch.contact.limits import deepest as base_depth
from flatpunch.files.units import text
from flatpunch.fit.adhesion.model import AdhesiveModel
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.least_squares.objective import Objective
from flatpunch.fit.viscoelastic.model import HistoryModel
from flatpunch.fit.viscoelastic.objective import HistoryObjective
from flatpunch.indenters import Paraboloid
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body

NOTABLE = 0.01
"""Relative change of the force by the shape of the tip that is worth a note; few curves are calibrated better."""

_WHOLE = 17.0
"""Depth over radius at which the contact of a sphere is its equator, to rounding."""

if TYPE_CHECKING:
    from flatpunch.fit.report.result import FitResult


def limits_of_theory(result: FitResult) -> tuple[str, ...]:
    """Notes of the theory; those that take a cold solution for single fits only."""
    model, deepest = result.objective.model, float(result.depth.max())
    bottom = base_depth(_sample(model, result.values)[0])
    if deepest >= bottom:
        return (
            f"The deepest point, {text(deepest, 'm')}, is beyond the layers, {text(bottom, 'm')} thick on a rigid base: no tip "
            "gets there. Thickness, contact point or calibration are wrong; the fitted values mean nothing.",
        )
    if result.settings.quick or deepest <= 0:
        return ()
    notes = model.exact(deepest * np.geomspace(0.05, 1, 8), result.values)[1].splitlines()
    notes += _as_sphere(_sample(model, result.values)[1], deepest)
    if isinstance(model, AdhesiveModel):
        notes += _adhesion(result, model)
    if isinstance(model, HistoryModel):
        notes += _relaxation(result)
    return tuple(notes)


def _as_sphere(tip: Indenter, depth: float) -> list[str]:
    """Whether a sphere of the radius of a paraboloid needs another force: Sneddon's closed form for half-spaces."""
    if not isinstance(tip, Paraboloid):
        return []
    # notation: s = a/R, depth/R = s artanh(s), F/(E* R^2) = (1 + s^2) artanh(s) - s
    x = depth / tip.radius
    s = brentq(lambda s: s * np.arctanh(s) - x, 0.0, 1 - 1e-15) if x < _WHOLE else 1.0
    less = 1 - ((1 + s**2) * np.arctanh(s) - s) / (4 / 3 * x**1.5) if s < 1 else 0.0
    if less < NOTABLE:
        return []
    return [
        f"The tip is a paraboloid: at {text(depth, 'm')}, {x:.2g} of its radius, a sphere of this radius needs {100 * less:.1f} "
        "% less force on a half-space, and the modulus would be higher by about as much. If it is a sphere, write "
        "kind = 'sphere' (Python: Sphere)."
    ]


def _sample(model: ForwardModel | AdhesiveModel | HistoryModel, values: Mapping[str, float]) -> tuple[Body, Indenter]:
    """Medium and tip at the fitted values."""
    if isinstance(model, ForwardModel):
        return model.case(values)
    sample = model.sample.replaced(values)
    return sample.medium, sample.indenter


def _adhesion(result: FitResult, model: AdhesiveModel) -> list[str]:
    """Whether the tip held on for longer than the theory allows."""
    held = result.depth[result.used & _loaded(result)]
    limit = model.pull_off(result.minimum.x[: len(model.free)])[0]
    # pull-off of the model this share of the adhesive depth away from that of the data is worth a word
    if held.size and held.min() < limit - 0.05 * abs(limit):
        return [
            f"The tip held on down to {text(float(held.min()), 'm')}; at the fitted values it lets go at {text(limit, 'm')} at "
            "the latest. Something else than JKR adhesion holds it: tethers, a viscous sample, a meniscus."
        ]
    return []


def _loaded(result: FitResult) -> np.ndarray:
    mask = np.zeros(result.curve.depth.size, dtype=bool)
    assert isinstance(result.objective, Objective)
    mask[result.objective.part_loaded] = True
    return mask


def _relaxation(result: FitResult) -> list[str]:
    """Relaxation times that the curve is too short or too coarse for."""
    notes = []
    assert isinstance(result.objective, HistoryObjective)
    time = result.objective.time
    longest, shortest = float(np.ptp(time)), float(np.median(np.diff(time)))
    for name, estimate in result.estimates.items():
        if not name.startswith("relaxation.time"):
            continue
        if estimate.value > longest:
            notes.append(
                f"{name} = {text(estimate.value, 's')} is longer than the curve ({text(longest, 's')}): the slope of the "
                "relaxation is measured, not where it ends. Hold for longer, or fit a power law."
            )
        elif estimate.value < 2 * shortest:
            notes.append(
                f"{name} = {text(estimate.value, 's')} is hardly longer than the steps of the curve ({text(shortest, 's')}): "
                "faster relaxation cannot be distinguished from an elastic response."
            )
    return notes
