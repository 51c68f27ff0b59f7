from .adhesion.loop import adhesion_loop
from .adhesion.pull_off import PullOff, pull_off
from .indent import default_method, indent, pressure
from .methods import METHODS, BoundaryElements, FirstOrder, FourthOrder, Method, Refined, SecondOrder, method_of

__all__ = [
    "METHODS",
    "BoundaryElements",
    "FirstOrder",
    "FourthOrder",
    "Method",
    "PullOff",
    "Refined",
    "SecondOrder",
    "adhesion_loop",
    "default_method",
    "indent",
    "method_of",
    "pressure",
    "pull_off",
]
