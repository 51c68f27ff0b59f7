"""Indenters: shapes f(r, phi) >= 0 over the point of first touch, one per file."""

from flatpunch.indenters.angles import angular_rule, harmonics
from flatpunch.indenters.area_function import AreaFunction
from flatpunch.indenters.cone import Cone
from flatpunch.indenters.cylinder import Cylinder
from flatpunch.indenters.ellipsoid import Ellipsoid, Spheroid
from flatpunch.indenters.facets import FacetedPyramid
from flatpunch.indenters.height_map import HeightMap
from flatpunch.indenters.paraboloid import EllipticParaboloid, Paraboloid
from flatpunch.indenters.power_law import AngularConstant, AngularTable, PowerLaw
from flatpunch.indenters.profile import Indenter
from flatpunch.indenters.pyramid import Pyramid
from flatpunch.indenters.radial_profile import RadialProfile
from flatpunch.indenters.rounded import Rounded
from flatpunch.indenters.sphere import Sphere
from flatpunch.indenters.standard import AfmPyramid, Berkovich, CubeCorner, Knoop, SpheroCone, Vickers
from flatpunch.indenters.star import Fall, first_fall
from flatpunch.indenters.superellipse import Superellipse
from flatpunch.indenters.tilted import Tilted
from flatpunch.indenters.truncated import Truncated

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
