# Names of the room and the files they come from; loaded when first asked for.

from .geometry.angle_rule import angular_rule, harmonics
from .measured.area_function import AreaFunction
from .measured.height_map import HeightMap
from .measured.radial_profile import RadialProfile
from .measured.rising import Fall, first_fall
from .profile import Indenter
from .shapes.cone import Cone
from .shapes.cylinder import Cylinder
from .shapes.ellipsoid import Ellipsoid, Spheroid
from .shapes.facets import FacetedPyramid
from .shapes.paraboloid import EllipticParaboloid, Paraboloid
from .shapes.power_law import AngularConstant, AngularTable, PowerLaw
from .shapes.pyramid import Pyramid
from .shapes.roller import Roller
from .shapes.rounded_punch import RoundedPunch
from .shapes.sphere import Sphere
from .shapes.superellipse import Superellipse
from .worn.rounded import Rounded
from .worn.standard import AfmPyramid, Berkovich, CubeCorner, Knoop, SpheroCone, Vickers
from .worn.tilted import Tilted
from .worn.truncated import Truncated

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
    "Roller",
    "Rounded",
    "RoundedPunch",
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
