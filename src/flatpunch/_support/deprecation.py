"""Old names for one more version: every use of one warns with the new name and the version in which the old one goes."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

Thing = TypeVar("Thing", bound=Callable[..., Any])


def warn_old(name: str, since: str, gone: str, instead: str, stacklevel: int) -> None:
    """Warn of the use of an old name, at the line that many calls above."""
    text = f"{name} is deprecated since flatpunch {since} and goes in {gone}: use {instead}."
    warnings.warn(text, DeprecationWarning, stacklevel=stacklevel)


def deprecated(
    since: str, gone: str, instead: str, keywords: Mapping[str, Callable[[Any], Mapping[str, Any]]] | None = None
) -> Callable[[Thing], Thing]:
    """Decorate a function or class that has a better successor `instead` `since` a version, and is `gone` in a later one.

    With `keywords` only old keywords are deprecated: each with the function that makes the new ones of its value.
    """

    def decorate(thing: Thing) -> Thing:
        # a class stays itself, for isinstance and pickles: its constructor warns. Types cannot say "a function
        # or a class, returned as what it is", hence what is not checked here and below
        made = thing.__init__ if isinstance(thing, type) else thing  # type: ignore[misc]

        @functools.wraps(made)
        def warned(*args: Any, **given: Any) -> Any:
            old = [name for name in keywords or () if name in given]
            if old or keywords is None:
                subject = f"{thing.__name__}({old[0]}=...)" if old else thing.__name__
                warn_old(subject, since, gone, instead, stacklevel=3)
            for name in old:
                given |= (keywords or {})[name](given.pop(name))
            return made(*args, **given)

        if isinstance(thing, type):
            # assigned to one class, whose subclasses may have other arguments
            thing.__init__ = warned  # type: ignore[misc]
            return thing
        # `wraps` gives it the signature of the function, which its type does not say
        return warned  # type: ignore[return-value]

    return decorate
