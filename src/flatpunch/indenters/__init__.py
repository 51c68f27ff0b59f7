"""Indenters: shapes f(r, phi) >= 0 over the point of first touch, one per file."""

from flatpunch.indenters.geometry.angle_rule import angular_rule, harmonics
from flatpunch.indenters.measured.area_function import AreaFunction
from flatpunch.indenters.measured.height_map import HeightMap
from flatpunch.indenters.measured.radial_profile import RadialProfile
from flatpunch.indenters.measured.rising import Fall, first_fall
from flatpunch.indenters.profile import Indenter
from flatpunch.indenters.shapes.cone import Cone
from flatpunch.indenters.shapes.cylinder import Cylinder
from flatpunch.indenters.shapes.ellipsoid import Ellipsoid, Spheroid
from flatpunch.indenters.shapes.facets import FacetedPyramid
from flatpunch.indenters.shapes.paraboloid import EllipticParaboloid, Paraboloid
from flatpunch.indenters.shapes.power_law import AngularConstant, AngularTable, PowerLaw
from flatpunch.indenters.shapes.pyramid import Pyramid
from flatpunch.indenters.shapes.sphere import Sphere
from flatpunch.indenters.shapes.superellipse import Superellipse
from flatpunch.indenters.worn.rounded import Rounded
from flatpunch.indenters.worn.standard import AfmPyramid, Berkovich, CubeCorner, Knoop, SpheroCone, Vickers
from flatpunch.indenters.worn.tilted import Tilted
from flatpunch.indenters.worn.truncated import Truncated

__all__ = [
    "AfmPyramid",
    "AngularConstant",
    "AngularTable",
    "AreaFunction",
    "Berkovich",
    "Cone",
    "CubeCorner",
    "Cylinder",
    "Ellipsoid",
    "EllipticParaboloid",
    "FacetedPyramid",
    "Fall",
    "HeightMap",
    "Indenter",
    "Knoop",
    "Paraboloid",
    "PowerLaw",
    "Pyramid",
    "RadialProfile",
    "Rounded",
    "Sphere",
    "SpheroCone",
    "Spheroid",
    "Superellipse",
    "Tilted",
    "Truncated",
    "Vickers",
    "angular_rule",
    "first_fall",
    "harmonics",
]
