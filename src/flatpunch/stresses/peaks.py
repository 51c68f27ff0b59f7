"""`peak_stresses`: the largest stresses of every layer and interface under one contact, found by search.

The search is that of `critical_load` with strengths of 1 Pa: the largest values on a grid that follows the contact, faces, axis
and rim included, are refined place by place. Every local maximum of the grid that is not far below the largest is refined.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flatpunch._support.checks import Array, Values, real
from flatpunch._support.threads import one_blas_thread
from flatpunch.contact.curve import NOTABLE_FORCE, Control, percent
from flatpunch.contact.dataset import Attributes, Column, dataset
from flatpunch.contact.limits import deepest
from flatpunch.contact.round.mean_profile import mean_contact
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, Stack, underlying
from flatpunch.stresses.failure.events import Event, Judged, largest_of_each
from flatpunch.stresses.failure.on_cells import CellSearch
from flatpunch.stresses.failure.round import RoundSearch
from flatpunch.stresses.failure.strength import Strength
from flatpunch.stresses.failure.tips import counted_by
from flatpunch.stresses.points import AXES, checked_friction, of_case
from flatpunch.stresses.sources import contact_of, solved

BULK = {"yield": "von_mises", "tensile": "tension", "shear": "shear"}
INTERFACE = {"interface tension": "interface_tension", "interface shear": "interface_shear"}
"""Criteria of the search, and the names of the stresses in the result: of layers, and of interfaces."""

_WORDS = {
    "von_mises": "largest von Mises stress",
    "tension": "largest principal stress, positive in tension",
    "shear": "largest shear stress",
    "interface_tension": "largest normal tension",
    "interface_shear": "largest shear traction",
}


@one_blas_thread()
def peak_stresses(
    medium: Body,
    indenter: Indenter,
    *,
    depth: Values | None = None,
    force: Values | None = None,
    radius: Values | None = None,
    friction: float = 0.0,
    direction: float = 0.0,
    residual_stress: Sequence[object] | None = None,
) -> xr.Dataset:
    """Largest stresses in every layer and at every interface under one contact, and their places.

    Parameters
    ----------
    medium : Medium, HalfSpace, PowerLawHalfSpace or TwoBodies
        The elastic body, or two of them.
    indenter : Indenter
        What is pressed in.
    depth, force, radius : float
        Exactly one, as for `indent`.
    friction : float
        Coefficient of friction of a contact that slides.
    direction : float
        Polar angle of the traction on the body [rad].
    residual_stress : sequence of float, optional
        Biaxial stress of each layer (and the base) [Pa]; of two bodies a pair of such sequences or None.

    Returns
    -------
    xarray.Dataset
        Along `layer`, from the surface, the base last: von_mises, tension (largest principal stress) and shear (largest shear
        stress) [Pa], each with its place, such as von_mises_place(layer, axis) [m]; along `interface`, below the layer of the
        same number: interface_tension and interface_shear [Pa] with their places. Of two bodies the layers of the upper one come
        first; the coordinate `body` names them. Infinite at sharp edges of the tip. Attributes: force, depth,
        radius, notes (errors above 1 % among them), and
        `stress_error`, the relative error of the largest finite value of each kind, the largest of these.

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work.

    See Also
    --------
    fields : Stresses at points.
    critical_loads : The load at which each criterion is reached.

    Examples
    --------
    >>> film = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], base=fp.HalfSpace(210e9, 0.3))
    >>> peaks = fp.peak_stresses(film, fp.Sphere(50e-6), force=20e-3)
    >>> print([f"{value / 1e9:.2f} GPa" for value in peaks.von_mises.values])
    ['3.31 GPa', '1.51 GPa']
    """
    contact = contact_of(medium, indenter, {"depth": depth, "force": force, "radius": radius})
    friction, direction = checked_friction(friction), real("direction", direction, "rad")
    bodies = unit_strengths(underlying(medium), residual_stress)
    for body in bodies:
        body.check_surface()
    _, about = solved(contact)
    if not about["radius"] > 0:
        raise ValueError("there is no contact, so there are no stresses. Give a larger depth, force or radius.")
    kind = RoundSearch if indenter.round else CellSearch
    search = kind(bodies, contact.kernel, indenter, friction, deepest(medium))
    size = about["depth"] if indenter.flat else about["radius"]
    if not indenter.round:
        (size,) = mean_contact(contact.kernel, counted_by(indenter), Control("depth", np.array([about["depth"]])))[
            1
        ].radius
    size = float(size)
    starts = search.maxima(size)
    refined = search.refined([each for each in starts if each.utilisation < np.inf], size)
    best = largest_of_each([*(each for each in starts if np.isinf(each.utilisation)), *refined])
    largest: dict[str, Event] = {}
    for each in best.values():
        if 0 < each.utilisation < np.inf and each.utilisation > getattr(largest.get(each.kind), "utilisation", 0.0):
            largest[each.kind] = each
    errors = {kind: search.error(each, size) for kind, each in largest.items()}
    names = BULK | INTERFACE
    poor = [f"{_WORDS[names[kind]]} by up to {percent(off)}" for kind, off in errors.items() if off > NOTABLE_FORCE]
    notes = [*filter(None, [about["notes"]]), *([f"Expected to be off: {'; '.join(poor)}."] if poor else [])]
    columns, coordinates = columns_of(bodies, best, direction)
    attributes = {
        "title": "Largest stresses computed by flatpunch",
        **{name: about[name] for name in ("force", "depth", "radius", "method")},
        "notes": "\n".join(notes),
        "friction": friction,
        "direction": direction,
        "stress_error": max(errors.values(), default=0.0),
        **of_case(medium, indenter),
    }
    return dataset(columns, coordinates, attributes)


def unit_strengths(medium: Body, residual: Any) -> tuple[Judged, ...]:
    """Each body with strengths of 1 Pa, so that stresses over strengths are stresses."""
    body = medium.single
    if not body:
        pair = (None, None) if residual is None else residual
        if len(pair) != 2:
            raise TypeError(
                "residual_stress must be a pair for two bodies: that of the upper and of the lower one, or None."
            )
        named = zip(medium.sides, pair, strict=True)
        return tuple(Judged.of(side, _units(side), own, name) for (name, side), own in named if not side.rigid)
    return (Judged.of(body, _units(body), residual),)


def _units(body: Stack) -> tuple[Strength, ...]:
    bulk = Strength(yield_stress=1.0, tensile=1.0, shear=1.0)
    layer = replace(bulk, interface_tension=1.0, interface_shear=1.0)
    return (layer,) * len(body.layers) + (Strength() if body.base.rigid else bulk,)


def columns_of(
    bodies: tuple[Judged, ...], best: dict[tuple[str, int, str], Event], direction: float
) -> tuple[dict[str, Column], dict[str, tuple[NDArray[np.generic], Attributes]]]:
    """Columns and coordinates of the largest stresses; places are turned by `direction` [rad]."""
    layers = [(each.name, i) for each in bodies for i in each.watched]
    interfaces = [(each.name, i) for each in bodies for i in each.watched if each.strengths[i].of_interface]
    columns: dict[str, Column] = {}
    turn = np.array([[np.cos(direction), -np.sin(direction)], [np.sin(direction), np.cos(direction)]])
    for names, dim, rows in ((BULK, "layer", layers), (INTERFACE, "interface", interfaces)):
        for kind, name in names.items():
            found = [best[kind, i, body] for body, i in rows]
            places: Array = np.array([each.place for each in found]).reshape(-1, 3)
            places[:, :2] = places[:, :2] @ turn.T
            values = np.array([each.utilisation for each in found])
            columns[name] = ((dim,), values, {"units": "Pa", "long_name": _WORDS[name]})
            columns[f"{name}_place"] = (
                (dim, "axis"),
                places,
                {"units": "m", "long_name": f"place of the {_WORDS[name]}"},
            )
    coordinates: dict[str, tuple[NDArray[np.generic], Attributes]] = {
        "layer": (
            np.array([i for _, i in layers]),
            {"long_name": "layer from the surface inwards; the base comes last"},
        ),
        "interface": (
            np.array([i for _, i in interfaces], dtype=int),
            {"long_name": "interface below the layer of that number"},
        ),
        "axis": (np.array(AXES), {"long_name": "direction"}),
    }
    if len(bodies) > 1:
        columns["body"] = (("layer",), np.array([body for body, _ in layers]), {"long_name": "body of the layer"})
        columns["interface_body"] = (("interface",), np.array([body for body, _ in interfaces]), {"long_name": "body"})
    return columns, coordinates
