from .adhesion.loop import adhesion_loop
from .adhesion.pull_off import PullOff, pull_off
from .default import Choice, default_choice, default_method
from .indent import indent, pressure
from .methods import (
    METHODS,
    BoundaryElements,
    Exact,
    FirstOrder,
    FourthOrder,
    Method,
    MethodName,
    Refined,
    SecondOrder,
    method_of,
)

__all__ = [
    "METHODS",
    "BoundaryElements",
    "Choice",
    "Exact",
    "FirstOrder",
    "FourthOrder",
    "Method",
    "MethodName",
    "PullOff",
    "Refined",
    "SecondOrder",
    "adhesion_loop",
    "default_choice",
    "default_method",
    "indent",
    "method_of",
    "pressure",
    "pull_off",
]
