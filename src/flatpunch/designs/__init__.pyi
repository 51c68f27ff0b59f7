from .optimisation import design
from .result import Design, DesignedValue, Minimum
from .targets import LargestLoad, Limit, Target

__all__ = ["Design", "DesignedValue", "LargestLoad", "Limit", "Minimum", "Target", "design"]
