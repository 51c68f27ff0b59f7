"""The cylinder with a flat end as an indenter: the contact is always the end face."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import Control, Curve, first_failure
from flatpunch.contact.round.superposition import flat_pressure
from flatpunch.indenters.profile import Indenter
from flatpunch.punch.family import punch_family


def solve(kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
    """Force and depth in proportion, F = K d."""
    a = np.full_like(control.values, indenter.reach)
    stiffness = punch_stiffness(kernel, a)
    depth = _depth(control, stiffness)
    valid = np.ones(a.size, dtype=bool)
    if punch_family(kernel).lowest_pressure(a[:1] / kernel.length) < 0:
        valid[:] = depth <= 0
    return Curve(
        depth=depth,
        force=stiffness * depth,
        radius=a,
        area=np.pi * a**2,
        stiffness=stiffness,
        contour=np.repeat(a[:, None], phi.size, axis=1),
        valid=valid,
        notes=first_failure(
            ~valid, depth, "the pressure under the flat end is negative in part, so it lifts off there."
        ),
    )


def pressure(kernel: Kernel, indenter: Indenter, control: Control, r: Array) -> tuple[Array, Array]:
    """Pressure of the flat punch at distances r, and its error, shape (n,) each [Pa]."""
    a = np.full(1, indenter.reach)
    depth = float(_depth(control, punch_stiffness(kernel, a))[0])
    return flat_pressure(kernel, indenter.reach, depth, r)


def punch_stiffness(kernel: Kernel, radius: Array) -> Array:
    """K = 2 E* a Kbar at radii of shape (n,) [N/m]."""
    return np.asarray(2 * np.pi * kernel.modulus * radius * punch_family(kernel).at(radius / kernel.length).flat[:, 0])


def _depth(control: Control, stiffness: Array) -> Array:
    if control.name == "radius":
        raise ValueError(
            "radius cannot control a cylinder with a flat end: its contact radius never changes. Give depth or force."
        )
    return control.values if control.name == "depth" else control.values / stiffness
