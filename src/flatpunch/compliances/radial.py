"""The four functions of the wavenumber that make up the surface compliance under tractions of all directions.

With l along the wave and t across it, u = C t has C = [[a, 0, i d], [0, c, 0], [-i d, 0, n]].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliances.kernel import compliance
from flatpunch.compliances.power_law import power_law_waves
from flatpunch.compliances.response import surface_flexibility
from flatpunch.media import Body
from flatpunch.media.material import PowerLaw


class Radial(NamedTuple):
    """Entries n, a, c and d at wavenumbers [m/Pa], or their inverses [Pa/m]."""

    normal: Array
    along: Array
    across: Array
    coupling: Array


def radial_compliance(body: Body, k: Array) -> Radial:
    """The four functions at wavenumbers k > 0, shape (n,) each."""
    stack = body.single
    if not stack:
        return _of_pair(body, k)
    if law := stack.power_law:
        return _of_power_law(stack, law, k)
    along, across = surface_flexibility(stack, k)
    return Radial(-along[1, 1] / k, -along[0, 0] / k, -across / k, along[0, 1] / k)


def _of_pair(pair: Body, k: Array) -> Radial:
    total = Radial(*np.zeros((4, k.size)))
    for name, body in reversed(pair.sides):
        sign = -1 if name == "upper" else 1
        if not body.rigid:
            n, a, c, d = radial_compliance(body, k)
            # the upper body's z runs the other way, which turns the sign of the coupling
            total = Radial(total.normal + n, total.along + a, total.across + c, total.coupling + sign * d)
    return total


def _of_power_law(body: Body, law: PowerLaw, k: Array) -> Radial:
    if law.exponent >= 1:
        raise ValueError(
            f"medium has a modulus that vanishes at the surface like z^{law.exponent:g}: under shear tractions its displacement "
            "is infinite. `normal_compliance` exists."
        )
    with np.errstate(all="ignore"):  # stresses along the surface may be infinite; displacements are not
        waves = power_law_waves(law, k, np.zeros(1))
    normal, shear, across = (each[..., 0] for each in (waves.normal, waves.shear, waves.transverse))
    return Radial(np.asarray(compliance(body)(k)), -shear[0] / k, -across[0] / k, -normal[0] / k)
