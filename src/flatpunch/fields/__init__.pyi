from .fields import fields
from .loads import DiscLoad, PatchLoad

__all__ = ["DiscLoad", "PatchLoad", "fields"]
