from .critical import CriticalLoad, critical_load
from .fields import fields
from .loads import DiscLoad, PatchLoad
from .strength import Strength

__all__ = ["CriticalLoad", "DiscLoad", "PatchLoad", "Strength", "critical_load", "fields"]
