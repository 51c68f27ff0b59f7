"""Contacts that are no curve of a held elastic body: sticking ones, relaxing bodies, layers that lift off; for `indent`."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import Values, positive, shown, values
from flatpunch._support.record import record
from flatpunch.compliances import compliance
from flatpunch.contact.curve import Control, control_from
from flatpunch.contact.default import EXACT, LIFTS_OFF, Choice, Method, adhesive_method, asked_for, choose, solver_of
from flatpunch.contact.methods import BoundaryElements, Exact
from flatpunch.contact.result import outline_angles, result_of
from flatpunch.indenters.profile import Indenter, check_rising
from flatpunch.media import Body
from flatpunch.media.relaxation import Relaxation
from flatpunch.media.stack import LooseBody

if TYPE_CHECKING:
    import xarray as xr


def sticking(
    medium: Body,
    indenter: Indenter,
    given: dict[str, Values | None],
    work: float,
    range_of_action: float | None,
    method: Method | None,
    angles: int,
) -> xr.Dataset:
    """Adhesive contact (JKR); arguments as of `indent`."""
    from flatpunch.contact.adhesion import method as adhesive

    work = positive("work_of_adhesion", work, unit="J/m**2")
    ranges = {}
    if range_of_action is not None:
        ranges["range_of_action"] = range_of_action = positive("range_of_action", range_of_action, unit="m")
    chosen = adhesive_method(method, indenter)
    control = adhesive.adhesive_control(**given)
    phi = outline_angles(angles, control)
    curve = adhesive.solve(compliance(medium), indenter, control, phi, work, range_of_action)
    result = result_of(curve, phi, medium, indenter, control, asked_for(chosen, indenter))
    return result.assign_attrs(work_of_adhesion=work, **ranges)


def history(
    medium: Body,
    indenter: Indenter,
    given: dict[str, Values | None],
    time: Values | None,
    relaxation: Relaxation | Sequence[Relaxation | None] | None,
    method: Method | None,
    angles: int,
) -> xr.Dataset:
    """Viscoelastic contact: a history instead of a curve; arguments as of `indent`."""
    if time is None or not isinstance(relaxation, (list, tuple, Relaxation)):
        raise ValueError(
            "time and relaxation go together: times [s] with a depth or force each, and the relaxation of the medium, e.g. "
            f"Prony(weights, times). Got time = {shown(time)}, relaxation = {shown(relaxation)}."
        )
    if isinstance(method, BoundaryElements):
        raise ValueError("relaxation needs a whole elastic curve; choose a fast method or 'refined' instead of 'bem'.")
    from flatpunch.contact import viscoelastic

    control = viscoelastic.history_control(**given)
    phi = outline_angles(angles, control)
    times = values("time", time, minimum=-np.inf, unit="s")
    if not isinstance(relaxation, Relaxation):
        viscoelastic.check_history(control, times)
        stack, each = viscoelastic.check_each(medium, indenter, method, relaxation)
        curve = viscoelastic.solve_layered(stack, indenter, control, times, each, phi)
        result = result_of(curve, phi, medium, indenter, control, Choice(Exact(), EXACT, quick=True))
        return result.assign_attrs(relaxation=json.dumps(record(each)))
    if method is None:
        # judged at the largest depth or force, as if the body did not relax
        viscoelastic.check_medium(medium)
        check_rising(indenter)
        largest = Control(control.name, np.maximum(control.values.max(keepdims=True), 0.0))
        choice = choose(compliance(medium), indenter, largest, phi)
    else:
        choice = asked_for(method, indenter)
    solve = solver_of(choice.method, indenter).solve
    curve = viscoelastic.solve(medium, indenter, control, times, relaxation, phi, solve)
    result = result_of(curve, phi, medium, indenter, control, choice)
    return result.assign_attrs(relaxation=json.dumps(record(relaxation)))


def check_free_layer(indenter: Indenter, method: Method | None, others: Mapping[str, object]) -> None:
    """Refuse what is not solved on a layer that lifts off; `others` are arguments or tables of a case that are None if absent."""
    for name, value in others.items():
        if value is not None:
            raise ValueError(
                f"{name} does not go with a FreeLayer, whose contacts are solved at the surface, without adhesion and relaxation."
            )
    if not isinstance(method, Exact | None):
        raise ValueError(
            f"method = {method.name!r} takes the layer as held down by its base; on a FreeLayer leave it out."
        )
    if not indenter.round:
        raise ValueError(
            f"indenter = {type(indenter).__name__} is not round: a FreeLayer takes round tips and Cylinder. A layer that is held "
            "down, Layer(bonded=False), takes any."
        )


def on_free_layer(
    medium: LooseBody,
    indenter: Indenter,
    given: dict[str, Values | None],
    method: Method | None,
    angles: int,
    others: Mapping[str, object],
) -> xr.Dataset:
    """Contact on a layer that lifts off; arguments as of `indent`, with those that do not go with it as `others`."""
    from flatpunch.contact import receding

    check_free_layer(indenter, method, others)
    control = control_from(**given)
    phi = outline_angles(angles, control)
    curve = receding.solve(medium, indenter, control, phi)
    return result_of(curve, phi, medium, indenter, control, LIFTS_OFF)
