"""Depth sensitivity: how much of a force comes from which depth (T15.6).

d ln F/d ln E(z) per length is the energy density that the contact pressure and the flat punch's have in common, in planes of
constant depth, over F; its integral over the whole body is one. Shallow depths need large wavenumbers; groups share them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch._support.prefixes import text
from flatpunch.compliances.stack import attenuation, interfaces
from flatpunch.media import Body
from flatpunch.sensitivities.gradient import Gradient
from flatpunch.sensitivities.spectrum import energy_shares
from flatpunch.stresses.bodies import Located, located

_SHALLOWEST, _FIRST = 0.01, 0.03
"""Depths over the contact radius: the smallest that is computed, and the first where none are given."""


@dataclass(frozen=True, slots=True)
class DepthSensitivity:
    """Depths [m], the layer of each, and d ln F/d ln E(z) per length [1/m], shape (contacts, depths)."""

    z: Array
    layer: Indices
    values: Array


def depth_sensitivity(medium: Body, found: list[Gradient], wanted: Array | None) -> DepthSensitivity:
    """Depth sensitivity of contacts at given depths, z < 0 being in the upper of two bodies, or at some in each layer."""
    widest = max(each.contact.radius for each in found)
    if wanted is None:
        places = list(_chosen(medium, min(each.contact.radius for each in found), widest))
    else:
        _check_shallow(wanted, widest)
        places = located(medium, wanted, "below")
    z = np.concatenate([-at.depth if at.upper else at.depth for at in places])
    layer = np.concatenate([at.layer for at in places])
    rows = [np.concatenate([_of_contact(each, at) for at in places]) for each in found]
    order = np.lexsort((layer, z))
    return DepthSensitivity(z[order], layer[order], np.array(rows)[:, order])


def _of_contact(gradient: Gradient, at: Located) -> Array:
    assert gradient.spectrum is not None
    found = np.empty(at.depth.size)
    order = np.argsort(at.depth)
    while order.size:
        nearest = at.depth[order[0]]
        reached = float(attenuation(at.body, at.depth[order[:1]])[0])
        # ratio of depths that share their wavenumbers
        group = order[at.depth[order] <= 3.0 * nearest]
        # wavenumber times the depth at which the energy of a wave has fallen to exp(-36)
        spectrum = gradient.spectrum(18.0 * gradient.contact.radius / reached)
        found[group] = energy_shares(at.body, spectrum, at.depth[group], at.layer[group]) / gradient.contact.force
        order = order[group.size :]
    return found


def _check_shallow(z: Array, radius: float) -> None:
    shallow = np.abs(z) < _SHALLOWEST * radius
    if shallow.any():
        i = int(np.argmax(shallow))
        raise ValueError(
            f"z[{i}] = {text(float(z[i]), 'm')} is less than {_SHALLOWEST:g} of the contact radius "
            f"{text(float(radius), 'm')}. There the depth "
            "sensitivity would need too many wavenumbers; it changes little from that depth to the surface. Give larger depths."
        )


def _chosen(medium: Body, narrowest: float, widest: float) -> Iterator[Located]:
    """Depths in each layer, both faces included, of each body."""
    for name, body in medium.sides:
        if body.rigid:
            continue
        faces = interfaces(body)
        ends = [float(face) for face in faces]
        if not body.base.rigid:
            # contact radii down to which depths are chosen where none are given
            ends.append(max(10.0 * widest, 2 * (ends[-1] if ends else 0.0)))
        first = min(_FIRST * narrowest, ends[0] / 2)
        first = max(first, _SHALLOWEST * widest)
        # depths between interfaces that are chosen in all
        count = 2 + 48 // len(ends)
        depths, layers = [], []
        for i, (start, end) in enumerate(zip([0.0, *ends[:-1]], ends, strict=True)):
            if end > first:
                depths.append(np.geomspace(max(start, first), end, count))
                layers.append(np.full(count, i))
        depth = np.concatenate(depths)
        yield Located(body, np.arange(depth.size), depth, np.concatenate(layers), name == "upper")
