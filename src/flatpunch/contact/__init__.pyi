from .adhesion.loop import adhesion_loop
from .adhesion.pull_off import PullOff, pull_off
from .default import METHODS, Choice, Method, MethodName, default_choice, default_method, method_of
from .indentation import indent, pressure
from .methods import BoundaryElements, Exact, FirstOrder, FourthOrder, Refined, SecondOrder
from .slip.steps import partial_slip

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
    "partial_slip",
    "pressure",
    "pull_off",
]
