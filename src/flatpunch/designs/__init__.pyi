from .optimisation import Design, DesignedValue, Minimum, design
from .targets import LargestLoad, Limit, Target

__all__ = ["Design", "DesignedValue", "LargestLoad", "Limit", "Minimum", "Target", "design"]
