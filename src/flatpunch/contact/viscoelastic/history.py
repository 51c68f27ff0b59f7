"""Viscoelastic contact for a history of depth or force: checks, choice of the solution, and the result as a curve.

C(k) of a body whose layers all relax alike is the elastic one over psi, at every wavenumber; so is everything built from
it. On an elastic substrate that is not so: the shape of C(k) itself changes with time. Layers that relax each in its own way are
checked here as well, and solved in `layered`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from flatpunch._support.checks import Array, BadValue, shown, values
from flatpunch.compliances import compliance
from flatpunch.contact.curve import Control, Curve, few
from flatpunch.contact.viscoelastic.depth_history import Response, force_of_depth
from flatpunch.contact.viscoelastic.elastic import Column, ElasticCurve, Solve, elastic_curve
from flatpunch.contact.viscoelastic.force_history import depth_of_force, most_elastic_force
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, Material, Medium, Prony, Stack, StandardLinearSolid, underlying
from flatpunch.media.relaxation import Relaxation


def solve(
    medium: Body,
    indenter: Indenter,
    control: Control,
    time: Array,
    relaxation: Relaxation,
    phi: Array,
    method: Solve,
) -> Curve:
    """Follow a history.

    Parameters
    ----------
    medium : HalfSpace, PowerLawHalfSpace, or Medium on a RigidBase
        The body; its moduli times psi(t) are those that relax.
    indenter : Indenter
        The indenter.
    control : Control
        Depths [m] (any sign; the surface is at 0) or forces [N] at the given times, linear in between. A first value that is not
        zero is a sudden step.
    time : ndarray, shape (n,)
        Times [s], ascending.
    relaxation : Relaxation
        psi(t).
    phi : ndarray, shape (p,)
        Polar angles of the outline [rad].
    method : callable
        `solve` of an elastic contact method.

    Returns
    -------
    Curve
        With the extra arrays `time` [s], `contact_depth` [m], the depth of the elastic contact of the same extent, and
        `force_error`: the error of the elastic curve plus that of the history.
    """
    check_medium(medium)
    check_history(control, time)
    kernel = compliance(medium)
    if not (control.values > 0).any():
        raise BadValue(control.name, "", "is nowhere positive, so there is never a contact.")
    if control.name == "depth":
        elastic = elastic_curve(method, kernel, indenter, float(control.values.max()), phi)
        response = force_of_depth(time, control.values, relaxation, elastic)
        if control.values[0] > 0:
            # the series represents psi for times of one step and more
            response.force[0] = float(relaxation(np.zeros(1))[0]) * elastic.force(control.values[:1])[0]
    else:
        most = Control("force", np.array([most_elastic_force(time, control.values, relaxation)]))
        # depth of the elastic curve over the largest one that a force is expected to reach: the steps there may be coarse
        deepest = 1.01 * float(method(kernel, indenter, most, phi[:1]).depth[0])
        elastic = elastic_curve(method, kernel, indenter, deepest, phi)
        response = depth_of_force(time, control.values, relaxation, elastic, deepest)
    curve = _curve(time, response, elastic, relaxation, phi)
    return replace(curve, notes=(*curve.notes, *_of_springs(medium)))


def _of_springs(medium: Body) -> tuple[str, ...]:
    faces = [layer.face for _, body in medium.sides for layer in body.layers]
    if not any(face.normal or face.shear or face.membrane for face in faces):
        return ()
    return (
        "The springs and membranes of the interfaces relax like the layers: one relaxation multiplies the whole response. A list "
        "of one for each layer, relaxation=[...], keeps them elastic.",
    )


def check_medium(medium: Body) -> None:
    """Refuse bodies whose compliance changes its shape with time."""
    medium = underlying(medium)
    stack = medium.single
    alike = stack and (stack.base.rigid or not stack.layers)
    if not alike:
        raise ValueError(
            f"relaxation goes with a half-space or with layers on a RigidBase, not with this {type(medium).__name__}: on an "
            "elastic substrate (or against an elastic body) part of the system does not relax, so that the shape of its "
            "compliance changes with time and neither Lee-Radok nor Ting holds. Take a rigid base where the substrate is much "
            "stiffer, or give a relaxation for each layer and the base: relaxation=[Prony(...), None]."
        )


def check_history(control: Control, time: Array) -> None:
    """Times ascending, one value each."""
    if time.size < 2 or time.size != control.values.size:
        raise ValueError(
            f"time has {time.size} values and {control.name} {control.values.size}; a history needs two or more times and as "
            "many values."
        )
    if (np.diff(time) <= 0).any():
        i = int(np.argmax(np.diff(time) <= 0))
        raise BadValue(f"time[{i + 1}]", f"{time[i + 1]:.6g} s", f"must be after time[{i}] = {time[i]:.6g} s.")


def history_control(*, depth: object, force: object, radius: object) -> Control:
    """Depth or force of a history; depths may be negative (not yet in contact), forces not."""
    if radius is not None or (depth is None) == (force is None):
        raise ValueError("Give exactly one of depth and force with time and relaxation: its value at each time.")
    if force is None:
        return Control("depth", few("depth", values("depth", depth, minimum=-np.inf, unit="m")))
    return Control("force", few("force", values("force", force, unit="N")))


def _curve(time: Array, response: Response, elastic: ElasticCurve, relaxation: Relaxation, phi: Array) -> Curve:
    contact = response.contact
    radius, area, stiffness = elastic.at(contact, Column.RADIUS, Column.AREA, Column.STIFFNESS)
    first = float(relaxation(np.zeros(1))[0])
    notes = elastic.notes
    if not np.isfinite(first):
        notes += ("The stiffness is infinite: this relaxation has no instantaneous modulus.",)
    with np.errstate(invalid="ignore"):
        stiffness = np.where(contact > 0, stiffness * first, 0.0)
    force_error, contour_error = elastic.errors(np.maximum.accumulate(contact))
    largest = float(np.max(response.force, where=np.isfinite(response.force), initial=0.0))
    numerical = response.error / np.where(response.force > 0, response.force, largest)
    worst = float(response.error.max()) / largest
    # numerical error over the largest force above which there is a note
    if worst > 1e-3:
        notes += (
            f"The numerical error of the history reaches {worst:.2g} of the largest force: see force_error, and give more times.",
        )
    extra: dict[str, tuple[tuple[str, ...], Array, str, str]] = {
        "time": (("step",), time, "s", "time"),
        "contact_depth": (("step",), contact, "m", "depth of the elastic contact of the same extent"),
        "force_error": (("step",), force_error + numerical, "1", "estimated relative error of the force"),
    }
    if elastic.shape is not None:
        extra["contour_error"] = (
            ("step",),
            contour_error,
            "1",
            "estimated error of the outline a(phi) over the mean radius",
        )
    return Curve(
        depth=response.depth,
        force=response.force,
        radius=radius,
        area=area,
        stiffness=stiffness,
        contour=elastic.contour(contact, radius, phi.size),
        valid=contact < elastic.sound,
        notes=notes,
        extra=extra,
    )


M = TypeVar("M", bound=Material)

Relaxations = tuple[Prony | None, ...]


def relaxations(medium: Stack, given: Sequence[object]) -> Relaxations:
    """One Prony series or None for each layer and the base, checked."""
    rigid = medium.base.rigid
    count = len(medium.layers) + (0 if rigid else 1)
    entries = list(given)
    if len(entries) != count:
        raise ValueError(
            f"relaxation has {len(entries)} entries for {len(medium.layers)} layers and {'a rigid' if rigid else 'an elastic'} "
            f"base; give {count}, layers from the surface down{'' if rigid else ', then the base'}, None for what is elastic."
        )
    found: list[Prony | None] = []
    for i, entry in enumerate(entries):
        if isinstance(entry, StandardLinearSolid):
            entry = entry.prony
        if entry is not None and not isinstance(entry, Prony):
            raise TypeError(
                f"relaxation[{i}] = {shown(entry)} must be a Prony series, a StandardLinearSolid or None: layers of different "
                "relaxation are solved with exponentials."
            )
        if entry is not None and medium.parts[i].varies:
            raise TypeError(
                f"relaxation[{i}] belongs to a GradedLayer, which is elastic here; give it as homogeneous layers."
            )
        found.append(entry)
    if all(entry is None for entry in found):
        raise ValueError("relaxation has no entry but None, so that nothing relaxes; leave time and relaxation out.")
    return tuple(found)


def check_each(medium: Body, indenter: Indenter, method: Any, given: Sequence[object]) -> tuple[Stack, Relaxations]:
    """The stack, and the relaxations of each layer and the base, refused where they are not solved."""
    if method is not None and method.name != "exact":
        raise ValueError("method is not chosen with one relaxation for each layer, which is solved for round tips.")
    stack = medium.single
    if not stack or not stack.layers:
        raise TypeError(
            f"relaxation is a list, which goes with a Medium: one entry for each layer and the base. medium = {shown(medium)}."
        )
    if not indenter.round:
        raise ValueError(
            f"indenter = {type(indenter).__name__} is not round, and relaxation for each layer is solved for round tips; give "
            "one relaxation of the whole, or a round tip."
        )
    return stack, relaxations(stack, given)


def with_moduli(medium: Stack, factors: Sequence[float]) -> Medium:
    """The medium with the moduli of each layer and the base multiplied."""
    layers = [_times(layer, factor) for layer, factor in zip(medium.layers, factors, strict=False)]
    base = medium.base if medium.base.rigid else _times(medium.base, factors[-1])
    return Medium(layers, base, medium.membrane)


def _times(part: M, factor: float) -> M:
    return part if factor == 1 else part.times(factor)
