from .energy import energy_by_depth
from .failure.critical_load import CriticalLoad, critical_load
from .failure.strength import Strength
from .fields import fields
from .loads import DiscLoad, PatchLoad

__all__ = ["CriticalLoad", "DiscLoad", "PatchLoad", "Strength", "critical_load", "energy_by_depth", "fields"]
