# Names of the room and the files they come from; loaded when first asked for. A new tip needs a line here, and no other.

from .geometry.angles import angular_rule as angular_rule
from .geometry.angles import harmonics as harmonics
from .measured.area_function import AreaFunction as AreaFunction
from .measured.height_grid import Fall as Fall
from .measured.height_grid import first_fall as first_fall
from .measured.height_map import HeightMap as HeightMap
from .measured.radial_profile import RadialProfile as RadialProfile
from .profile import Indenter as Indenter
from .shapes.pointed import Cone as Cone
from .shapes.pointed import FacetedPyramid as FacetedPyramid
from .shapes.pointed import Pyramid as Pyramid
from .shapes.power_law import AngularConstant as AngularConstant
from .shapes.power_law import AngularTable as AngularTable
from .shapes.power_law import PowerLaw as PowerLaw
from .shapes.power_law import Superellipse as Superellipse
from .shapes.punches import Cylinder as Cylinder
from .shapes.punches import Roller as Roller
from .shapes.punches import RoundedPunch as RoundedPunch
from .shapes.smooth import Ellipsoid as Ellipsoid
from .shapes.smooth import EllipticParaboloid as EllipticParaboloid
from .shapes.smooth import Paraboloid as Paraboloid
from .shapes.smooth import Sphere as Sphere
from .shapes.smooth import Spheroid as Spheroid
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
