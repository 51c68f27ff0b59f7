"""Indenters: shapes f(r, phi) >= 0 over the point of first touch, one per file."""

from flatpunch.indenters.angles import angular_rule, harmonics
from flatpunch.indenters.cone import Cone
from flatpunch.indenters.cylinder import Cylinder
from flatpunch.indenters.paraboloid import EllipticParaboloid, Paraboloid
from flatpunch.indenters.power_law import AngularConstant, AngularTable, PowerLaw
from flatpunch.indenters.profile import Indenter
from flatpunch.indenters.pyramid import Pyramid
from flatpunch.indenters.radial_profile import RadialProfile
from flatpunch.indenters.sphere import Sphere

__all__ = [
    "AngularConstant",
    "AngularTable",
    "Cone",
    "Cylinder",
    "EllipticParaboloid",
    "Indenter",
    "Paraboloid",
    "PowerLaw",
    "Pyramid",
    "RadialProfile",
    "Sphere",
    "angular_rule",
    "harmonics",
]
