from .critical import CriticalLoad, critical_load
from .energy import energy_by_depth
from .fields import fields
from .loads import DiscLoad, PatchLoad
from .strength import Strength

__all__ = ["CriticalLoad", "DiscLoad", "PatchLoad", "Strength", "critical_load", "energy_by_depth", "fields"]
