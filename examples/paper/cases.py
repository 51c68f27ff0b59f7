"""What the paper's case studies are about, in dimensionless form.

Layer thickness h = 1 and E* = 1 throughout, so every number below is a number of thicknesses and moduli. An elastic layer on
a rigid base is determined by kh alone when it slides, and by the Poisson ratio too when it is bonded (1/2 here). The
slopes of a power-law indenter scale out: depth is in units of (B h^2) for f = A x^2 + B y^2 and of (h tan alpha) for pyramids.
"""

from __future__ import annotations

import math
from typing import Literal

from flatpunch.compliances import Kernel, compliance
from flatpunch.indenters import EllipticParaboloid, Pyramid
from flatpunch.indenters.profile import Indenter
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase

Body = Literal["unbonded", "bonded", "half-space"]
Shape = Literal["ellipse", "pyramid"]

LAYERS: tuple[Body, Body] = ("unbonded", "bonded")
TITLES = {"unbonded": "unbonded layer", "bonded": "bonded incompressible layer", "half-space": "half-space"}

_POISSON = 0.5
"""All bodies of the paper are incompressible."""


def medium(body: Body) -> Medium | HalfSpace:
    """One of the paper's bodies, E* = 1, thickness 1."""
    if body == "half-space":
        return HalfSpace(1 - _POISSON**2, _POISSON)
    return Medium([Layer(1 - _POISSON**2, _POISSON, 1.0, bonded=body == "bonded")], base=RigidBase())


def kernel(body: Body) -> Kernel:
    """Compliance of one of the bodies."""
    return compliance(medium(body))


def indenter(shape: Shape, eccentricity: float = 0.0) -> Indenter:
    """f = (1 - e_g^2) x^2 + y^2 (paper (24), (25)), or a square pyramid with tan(alpha) = 1."""
    if shape == "pyramid":
        return Pyramid(sides=4, inclination=math.pi / 4)
    return EllipticParaboloid(1 - eccentricity**2, 1.0)
