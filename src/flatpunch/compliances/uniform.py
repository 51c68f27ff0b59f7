"""Compliance C(0) under a uniform pressure: that of uniaxial strain on a rigid base, infinite on an elastic one.

On a rigid base C(0) = sum of thickness (1 + nu)(1 - 2 nu)/((1 - nu) E), thickness/C33 where a layer is transversely isotropic,
bonded or sliding, and of 1/stiffness of interfaces with springs; it is zero where all layers are incompressible. A half-space
sinks without limit.
"""

from __future__ import annotations

from scipy.integrate import quad

from flatpunch.media import AnyLayer, Body


def uniform_compliance(medium: Body) -> float:
    """C(0) [m/Pa] of a body; infinite on elastic bases and half-spaces."""
    if not all(body.base.rigid for body in medium.elastic):
        return float("inf")
    layers = [layer for body in medium.elastic for layer in body.layers]
    return sum(layer.face.softness[1] for layer in layers) + sum(_squeezed(layer) for layer in layers)


def _squeezed(layer: AnyLayer) -> float:
    """Shortening of a layer per pressure [m/Pa]; its sides do not move."""
    if layer.varies:
        return float(quad(lambda z: float(layer.plane_at(z).oedometric), 0.0, layer.thickness)[0])
    return layer.thickness * layer.plane.oedometric
