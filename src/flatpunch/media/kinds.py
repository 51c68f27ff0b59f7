"""Kinds of layers and bases in case files, and the constructor of each; a kind of one's own is one more."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, TypeVar

T = TypeVar("T", bound=Callable[..., Any])

Section = Literal["layers", "base"]

KINDS: dict[Section, dict[str, Callable[..., Any]]] = {"layers": {}, "base": {}}
"""Constructors by the kind that a case file gives; layers may have none."""


def in_case_files(section: Section, kind: str = "") -> Callable[[T], T]:
    """Make a class, or a function that makes an object, a kind of layer or base in case files and on the page.

    Its declared arguments are the fields of the table; layers have those of their lower face besides, and take `bonded`.

    Parameters
    ----------
    section : {"layers", "base"}
        Table of the case file.
    kind : str
        Its name there, "half-space".

    Examples
    --------
    >>> from flatpunch.media.kinds import KINDS
    >>> sorted(KINDS["base"])
    ['half-space', 'power-law-half-space', 'rigid']
    """

    def marked(made: T) -> T:
        KINDS[section][kind] = made
        return made

    return marked
