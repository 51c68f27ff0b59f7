"""Contact of layered and graded elastic bodies with round and non-round indenters.

Press an ever larger flat punch step by step and any contact has been built: the rigid cylindrical flat punch on a medium is
all that has to be known of that medium. Everything is in consistent units, SI recommended.
"""

from flatpunch._validation import FlatpunchWarning
from flatpunch._version import __version__
from flatpunch.compliance import compliance
from flatpunch.contact import adhesion_loop, indent, pressure, pull_off
from flatpunch.files import load, read_case, save
from flatpunch.fit import Curve, CurveError, Free, fit, read_curve
from flatpunch.indenters import (
    Cone,
    Cylinder,
    EllipticParaboloid,
    Paraboloid,
    PowerLaw,
    Pyramid,
    RadialProfile,
    Sphere,
)
from flatpunch.media import (
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
from flatpunch.punch import flat_punch

__all__ = [
    "Cone",
    "Curve",
    "CurveError",
    "Cylinder",
    "DepthTable",
    "EllipticParaboloid",
    "ExponentialModulus",
    "FlatpunchWarning",
    "Formula",
    "Free",
    "GradedLayer",
    "HalfSpace",
    "Layer",
    "LinearModulus",
    "Medium",
    "Paraboloid",
    "PowerLaw",
    "PowerLawHalfSpace",
    "PowerLawRelaxation",
    "PowerModulus",
    "Prony",
    "Pyramid",
    "RadialProfile",
    "RigidBase",
    "Sphere",
    "StandardLinearSolid",
    "TwoBodies",
    "__version__",
    "adhesion_loop",
    "compliance",
    "fit",
    "flat_punch",
    "indent",
    "load",
    "pressure",
    "pull_off",
    "read_case",
    "read_curve",
    "save",
]
