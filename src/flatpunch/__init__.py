"""Contact of layered and graded elastic bodies with round and non-round indenters.

Press an ever larger flat punch step by step and any contact has been built: the rigid cylindrical flat punch on a medium is
all that has to be known of that medium. Everything is in consistent units, SI recommended.
"""

import sys
from types import ModuleType
from typing import Any

import lazy_loader

# the stub __init__.pyi says where names come from; each part is loaded when one of its names is first asked for
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


class _Package(ModuleType):
    """The package, in which `compliance` and `fit` stay functions when the parts of the same names are loaded."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in {"compliance", "fit"} and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
