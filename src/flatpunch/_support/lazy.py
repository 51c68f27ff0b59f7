"""Packages whose names are loaded when first asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module

import lazy_loader

from flatpunch._support.deprecation import warn_old


def names_of(
    package: str, file: str, moved: Mapping[str, tuple[str, str, str]] | None = None
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """Return __getattr__, __dir__ and __all__ of a package, whose stub (.pyi) beside the file says where names come from.

    Names that were moved warn: by name the package that has them now, the version of the move, and the one in which they go.
    """
    found, listed, names = lazy_loader.attach_stub(package, file)

    def found_or_moved(name: str) -> object:
        if name not in (moved or {}):
            return found(name)
        room, since, gone = (moved or {})[name]
        warn_old(f"{package}.{name}", since, gone, f"{room}.{name}", stacklevel=3)
        return getattr(import_module(room), name)

    return found_or_moved, listed, names
