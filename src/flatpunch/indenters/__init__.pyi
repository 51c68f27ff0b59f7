# Names of the room and the files they come from; loaded when first asked for. A new tip needs a line here, and no other.

from .geometry.angle_rule import angular_rule as angular_rule
from .geometry.angle_rule import harmonics as harmonics
from .measured.area_function import AreaFunction as AreaFunction
from .measured.height_map import HeightMap as HeightMap
from .measured.radial_profile import RadialProfile as RadialProfile
from .measured.rising import Fall as Fall
from .measured.rising import first_fall as first_fall
from .profile import Indenter as Indenter
from .shapes.cone import Cone as Cone
from .shapes.cylinder import Cylinder as Cylinder
from .shapes.ellipsoid import Ellipsoid as Ellipsoid
from .shapes.ellipsoid import Spheroid as Spheroid
from .shapes.facets import FacetedPyramid as FacetedPyramid
from .shapes.paraboloid import EllipticParaboloid as EllipticParaboloid
from .shapes.paraboloid import Paraboloid as Paraboloid
from .shapes.power_law import AngularConstant as AngularConstant
from .shapes.power_law import AngularTable as AngularTable
from .shapes.power_law import PowerLaw as PowerLaw
from .shapes.pyramid import Pyramid as Pyramid
from .shapes.roller import Roller as Roller
from .shapes.rounded_punch import RoundedPunch as RoundedPunch
from .shapes.sphere import Sphere as Sphere
from .shapes.superellipse import Superellipse as Superellipse
from .worn.rounded import Rounded as Rounded
from .worn.standard import (
    AfmPyramid as AfmPyramid,
)
from .worn.standard import (
    Berkovich as Berkovich,
)
from .worn.standard import (
    CubeCorner as CubeCorner,
)
from .worn.standard import (
    Knoop as Knoop,
)
from .worn.standard import (
    SpheroCone as SpheroCone,
)
from .worn.standard import (
    Vickers as Vickers,
)
from .worn.tilted import Tilted as Tilted
from .worn.truncated import Truncated as Truncated

__all__: list[str]
