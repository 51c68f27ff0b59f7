from .adhesion.loop import adhesion_loop
from .adhesion.pull_off import PullOff, pull_off
from .indent import METHODS, default_method, indent, pressure

__all__ = ["METHODS", "PullOff", "adhesion_loop", "default_method", "indent", "pressure", "pull_off"]
