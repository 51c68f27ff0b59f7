# Names of the package and the parts they come from; loaded when first asked for.

from . import atlas as atlas
from . import bem as bem
from . import files as files
from . import indenters as indenters
from . import media as media
from ._support.checks import FlatpunchWarning
from ._version import __version__
from .compliance import compliance
from .contact import (
    BoundaryElements,
    FirstOrder,
    FourthOrder,
    Refined,
    SecondOrder,
    adhesion_loop,
    indent,
    pressure,
    pull_off,
)
from .design import Design, LargestLoad, Limit, Target, design
from .fields import CriticalLoad, DiscLoad, PatchLoad, Strength, critical_load, energy_by_depth, fields
from .files import load, read_case, read_height_map, save
from .fit import Curve, CurveError, Free, Measured, correct, fit, fit_batch, fit_together, plot_fit, read_curve
from .indenters import (
    AfmPyramid,
    AreaFunction,
    Berkovich,
    Cone,
    CubeCorner,
    Cylinder,
    Ellipsoid,
    EllipticParaboloid,
    FacetedPyramid,
    HeightMap,
    Knoop,
    Paraboloid,
    PowerLaw,
    Pyramid,
    RadialProfile,
    Rounded,
    Sphere,
    SpheroCone,
    Spheroid,
    Superellipse,
    Tilted,
    Truncated,
    Vickers,
)
from .media import (
    DepthTable,
    ExponentialModulus,
    Formula,
    GradedLayer,
    HalfSpace,
    Layer,
    LinearModulus,
    Medium,
    PowerLawHalfSpace,
    PowerLawRelaxation,
    PowerModulus,
    Prony,
    RigidBase,
    StandardLinearSolid,
    TwoBodies,
)
from .plots.curve import plot_curve
from .plots.design import plot_design
from .plots.fields import plot_fields
from .plots.indenter import plot_tip
from .plots.medium import plot_medium
from .plots.outline import plot_outline
from .plots.pressure import plot_pressure
from .plots.sensitivity import plot_sensitivity
from .punch import flat_punch
from .sensitivity import sensitivity
from .sweeps import sweep

__all__ = [
    "AfmPyramid",
    "AreaFunction",
    "Berkovich",
    "BoundaryElements",
    "Cone",
    "CriticalLoad",
    "CubeCorner",
    "Curve",
    "CurveError",
    "Cylinder",
    "DepthTable",
    "Design",
    "DiscLoad",
    "Ellipsoid",
    "EllipticParaboloid",
    "ExponentialModulus",
    "FacetedPyramid",
    "FirstOrder",
    "FlatpunchWarning",
    "Formula",
    "FourthOrder",
    "Free",
    "GradedLayer",
    "HalfSpace",
    "HeightMap",
    "Knoop",
    "LargestLoad",
    "Layer",
    "Limit",
    "LinearModulus",
    "Measured",
    "Medium",
    "Paraboloid",
    "PatchLoad",
    "PowerLaw",
    "PowerLawHalfSpace",
    "PowerLawRelaxation",
    "PowerModulus",
    "Prony",
    "Pyramid",
    "RadialProfile",
    "Refined",
    "RigidBase",
    "Rounded",
    "SecondOrder",
    "Sphere",
    "SpheroCone",
    "Spheroid",
    "StandardLinearSolid",
    "Strength",
    "Superellipse",
    "Target",
    "Tilted",
    "Truncated",
    "TwoBodies",
    "Vickers",
    "__version__",
    "adhesion_loop",
    "atlas",
    "compliance",
    "correct",
    "critical_load",
    "design",
    "energy_by_depth",
    "fields",
    "fit",
    "fit_batch",
    "fit_together",
    "flat_punch",
    "indent",
    "load",
    "plot_curve",
    "plot_design",
    "plot_fields",
    "plot_fit",
    "plot_medium",
    "plot_outline",
    "plot_pressure",
    "plot_sensitivity",
    "plot_tip",
    "pressure",
    "pull_off",
    "read_case",
    "read_curve",
    "read_height_map",
    "save",
    "sensitivity",
    "sweep",
]
