"""Oliver-Pharr moduli of films: the stiffness of the contact, by its depth and the area function of the tip.

The software computed E* = S/(2 beta a), pi a^2 = A(h_c), with the compliance of the tip taken out. A film on a base has the
stiffness S = 2 beta a E* Kbar(a/t) of a flat punch of radius a: the film sought is that whose E* Kbar is the reported modulus.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch.compliance import compliance
from flatpunch.fit.half_space import published
from flatpunch.fit.half_space.formulas import layer_on_top
from flatpunch.fit.parameters.scaling import replaced
from flatpunch.indenters import AreaFunction
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, HalfSpace, Medium
from flatpunch.punch.family import punch_family

_ANGLES = 3600
"""Polar angles of a section; the area of a Berkovich tip is right to 1e-6."""


def section_radius(indenter: Indenter, depth: Array) -> Array:
    """Radius [m] of the circle with the area of a tip's section at distances from the apex [m]."""
    if isinstance(indenter, AreaFunction):
        return np.asarray(np.sqrt(indenter.area(depth) / np.pi))
    phi = np.arange(_ANGLES, dtype=np.float64) * (2 * np.pi / _ANGLES)
    low, high = np.zeros((depth.size, _ANGLES)), np.full((depth.size, _ANGLES), float(depth.max()))
    # no tip is wider than a metre
    while (lower := indenter.height(high, phi) < depth[:, None]).any() and high.max() < 1:
        high = np.where(lower, 2 * high, high)
    # bisection to the last digit
    for _ in range(53):
        middle = (low + high) / 2
        inside = indenter.height(middle, phi) < depth[:, None]
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return np.asarray(np.sqrt((high**2).mean(axis=1)))


def punch_modulus(medium: Body, radius: Array) -> Array:
    """Plane-strain modulus of the half-space on which flat punches of `radius` [m] have the same stiffness [Pa], shape (n,)."""
    kernel = compliance(medium)
    return np.asarray(medium.surface_modulus * np.pi * punch_family(kernel).flat(radius / kernel.length)[:, 0])


def apparent_modulus(medium: Medium, young: float, radius: Array) -> Array:
    """Plane-strain modulus that the software reports for a top layer of this Young's modulus [Pa]."""
    return punch_modulus(replaced(medium, None, {"layers[0].young": young})[0], radius)


def area_laws(medium: Medium, radius: float) -> dict[str, Callable[[float], float]]:
    """Published equivalent moduli over the film's Young's modulus, for one layer on a half-space [Pa]."""
    base, top = medium.base, layer_on_top(medium)[1]
    if len(medium.layers) != 1 or not isinstance(base, HalfSpace):
        return {}
    nu, t, substrate = top.poisson, top.thickness, base.surface_modulus
    a, star = np.array([radius]), 1 / (1 - nu**2)
    return {
        "Gao": lambda young: float(published.gao(a / t, young * star, substrate, nu)[0]),
        "Perriot-Barthel": lambda young: float(published.perriot_barthel(a / t, young * star, substrate)[0]),
        "Bec": lambda young: float(published.bec(a, young * star, substrate, t)[0]),
    }


def remark(radius: float) -> str:
    """What was assumed."""
    return (
        f"Oliver and Pharr: the depth is that of the contact, where the tip has the area of a circle of {text(radius, 'm')}. The "
        " reported modulus is that of the sample, the tip's own compliance taken out."
    )
