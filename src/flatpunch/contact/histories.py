"""Contacts that are no curve of a held elastic body: sticking ones, relaxing bodies, layers that lift off; for `indent`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import Values, shown, values
from flatpunch._support.readable import record
from flatpunch.compliances import compliance
from flatpunch.contact.curve import Control, control_from
from flatpunch.contact.default import EXACT, LIFTS_OFF, Choice, Method, adhesive_method, asked_for, choose, solver_of
from flatpunch.contact.methods import BoundaryElements, Exact
from flatpunch.contact.physics import Physics
from flatpunch.contact.result import outline_angles, result_of
from flatpunch.indenters.profile import Indenter, check_rising
from flatpunch.media import Body
from flatpunch.media.relaxation import Relaxation
from flatpunch.media.stack import LooseBody

if TYPE_CHECKING:
    import xarray as xr


def control_with(physics: Physics, method: Method | None, indenter: Indenter, **given: Values | None) -> Control:
    """What is prescribed: depth and force of an adhesive contact may be negative."""
    if physics.work_of_adhesion is None:
        return control_from(**given)
    from flatpunch.contact.adhesion.method import adhesive_control

    adhesive_method(method, indenter)
    return adhesive_control(**given)


def sticking(
    medium: Body,
    indenter: Indenter,
    given: dict[str, Values | None],
    physics: Physics,
    method: Method | None,
    angles: int,
) -> xr.Dataset:
    """Adhesive contact (JKR); arguments as of `indent`."""
    from flatpunch.contact.adhesion.method import solve

    assert physics.work_of_adhesion is not None
    control = control_with(physics, method, indenter, **given)
    phi = outline_angles(angles, control)
    with physics.named():
        curve = solve(compliance(medium), indenter, control, phi, physics.work_of_adhesion, physics.within)
    choice = asked_for(adhesive_method(method, indenter), indenter)
    found = result_of(curve, phi, medium, indenter, control, choice).assign_attrs(physics.given)
    return found if physics.within is None else found.assign_attrs(range_of_action=physics.within)


def history(
    medium: Body,
    indenter: Indenter,
    given: dict[str, Values | None],
    time: Values | None,
    physics: Physics,
    method: Method | None,
    angles: int,
) -> xr.Dataset:
    """Viscoelastic contact: a history instead of a curve; arguments as of `indent`."""
    relaxation = physics.relaxation
    if time is None or not isinstance(relaxation, (tuple, Relaxation)):
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
            f"indenter = {type(indenter).__name__} is not round: a FreeLayer takes round tips and Cylinder, a flat punch. A "
            "layer that is held down, Layer(bonded=False), takes any."
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
