from .energy import energy_by_depth
from .failure.critical_load import CriticalLoad, critical_load, critical_loads
from .failure.shakedown import ShakedownLoad, shakedown_load
from .failure.strength import Strength
from .loads import DiscLoad, PatchLoad
from .peaks import peak_stresses
from .points import fields
from .repeating import rough_stresses

__all__ = [
    "CriticalLoad",
    "DiscLoad",
    "PatchLoad",
    "ShakedownLoad",
    "Strength",
    "critical_load",
    "critical_loads",
    "energy_by_depth",
    "fields",
    "peak_stresses",
    "rough_stresses",
    "shakedown_load",
]
