"""Packages whose names are loaded when first asked for."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

import lazy_loader


def names_of(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return __getattr__, __dir__ and __all__ of a package, whose stub (.pyi) beside the file says where names come from.

    A function stays what its name means in the package when the module of the same name is loaded, which Python would bind there.
    """
    found, listed, names = lazy_loader.attach_stub(package, file)

    class Package(ModuleType):
        def __setattr__(self, name: str, value: Any) -> None:
            if not (name in names and isinstance(value, ModuleType)):
                super().__setattr__(name, value)

    sys.modules[package].__class__ = Package
    return found, listed, names
