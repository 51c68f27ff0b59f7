"""Flexibility and response of a stack of layers of all kinds: the one place where the way through a layer is chosen."""

from __future__ import annotations

from collections import Counter

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliances.graded import carry_through_graded
from flatpunch.compliances.layered import SATURATION, Depths, carry, half_space_flexibility, states_below
from flatpunch.compliances.transverse import Sheet, Solid
from flatpunch.media import AnyLayer, Interface, Stack
from flatpunch.media.plane import contact_modulus


def layered_response(medium: Stack, k: Array) -> Array:
    """Dimensionless response L(k) = E* k C(k)/2 of a stack at wavenumbers k > 0 [1/m], shape (n,).

    Of homogeneous layers the relative error is below 1e-12 for 1e-4 <= kh <= 50 (tests compare with multiprecision). A ValueError
    says that the constants of a graded layer leave their ranges between the depths at which it was checked.
    """
    if not medium.layers:
        return np.ones_like(k)
    top = medium.layers[0]
    response = np.ones_like(k)
    inside = np.full(k.shape, True) if top.varies else k * top.thickness < saturation(top)
    if inside.any():
        scale = top.rigidity
        flexibility = stack_flexibility(medium, k[inside], scale)
        response[inside] = -flexibility[1, 1] * (top.surface_modulus / (2 * scale))
    return response


def saturation(top: AnyLayer) -> float:
    """k h from which a surface layer hides what lies below it."""
    return SATURATION / Solid.of(top, 1.0).slowest if top.anisotropic and not top.varies else SATURATION


def stack_flexibility(medium: Stack, k: Array, scale: float) -> Array:
    """Flexibility H of the stack at its surface, times the shear modulus `scale`; shape (2, 2, n)."""
    order = np.argsort(k)
    flexibility = np.empty((2, 2, k.size))
    flexibility[..., order] = _sorted_flexibility(medium, k[order], scale)
    return flexibility


def _sorted_flexibility(medium: Stack, k: Array, scale: float) -> Array:
    """Flexibility of the stack at its surface for ascending wavenumbers, shape (2, 2, n)."""
    flexibility = half_space_flexibility(medium.base, scale, k.shape)
    # depth functions of a thickness are kept until its last layer
    left = Counter(layer.thickness for layer in medium.layers if layer.isotropic)
    known: dict[float, Depths] = {}
    for layer in reversed(medium.layers):
        flexibility = yielding(layer.face, flexibility, k, scale)
        if layer.isotropic:
            depths = known.pop(layer.thickness, None) or Depths.of(k * layer.thickness)
            carry(layer, flexibility, depths, scale)
            left[layer.thickness] -= 1
            if left[layer.thickness]:
                known[layer.thickness] = depths
        elif layer.varies:
            flexibility = carry_through_graded(layer, flexibility, k, scale)
        else:
            states = states_below(layer, flexibility)
            flexibility = Sheet(Solid.of(layer, scale), layer.thickness, k, states).flexibility
    return flexibility


def yielding(face: Interface, below: Array, k: Array, scale: float) -> Array:
    """Flexibility of what lies below a layer with that of the springs of its lower face, if there are any."""
    along, across = face.softness
    if not across and (not along or not face):
        return below
    below = below.copy()
    if face:
        below[0, 0] -= scale * along * k
    below[1, 1] -= scale * across * k
    return below


def long_wave_power(medium: Stack) -> int:
    """p of L ~ k^p at long waves: 0 on an elastic base, 3 if all is incompressible and sticks to a rigid one, else 1."""
    if not medium.base.rigid:
        return 0
    return 3 if all(_unyielding(layer) and _incompressible(layer) for layer in medium.layers) else 1


def _unyielding(layer: AnyLayer) -> bool:
    """Whether the lower face neither slides nor moves across itself."""
    return bool(layer.face) and layer.face.normal is None


def _incompressible(layer: AnyLayer) -> bool:
    return bool(np.all(layer.plane_at(layer.sampled_depths).oedometric == 0))


def smallest_and_largest_modulus(medium: Stack) -> tuple[float, float]:
    """Range of the plane-strain modulus over all layers and the base [Pa]."""
    found = []
    for part in medium.layers:
        if part.varies:
            moduli = contact_modulus(part.plane_at(part.sampled_depths))
            found += [float(moduli.min()), float(moduli.max())]
        else:
            found.append(part.surface_modulus)
    if not medium.base.rigid:
        found.append(medium.base.surface_modulus)
    found += spring_moduli(medium)
    return min(found), max(found)


def spring_moduli(medium: Stack) -> list[float]:
    """Stiffnesses of the interfaces times the thickness of all layers [Pa]."""
    springs = (value for layer in medium.layers for value in (layer.face.normal, layer.face.shear) if value)
    return [medium.thickness * value for value in springs]
