from .optimisation import Design, DesignedValue, Minimum, design
from .statement import LargestLoad, Limit, Target

__all__ = ["Design", "DesignedValue", "LargestLoad", "Limit", "Minimum", "Target", "design"]
