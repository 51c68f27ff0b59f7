"""Kinds of layers, bases, tips and relaxations in case files, and the constructors of each; a kind of one's own is one more."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, Literal, NamedTuple, TypeVar, get_args

T = TypeVar("T", bound=Callable[..., Any])

Section = Literal["layers", "base", "indenter", "relaxation"]
Wear = Literal["", "tilts", "wears"]


class Kind(NamedTuple):
    """How case files give a kind.

    Attributes
    ----------
    ways : tuple of callable
        Constructors; a file gives the declared arguments of one of them.
    wear : {"", "tilts", "wears"}
        Whether a tip may be tilted, or also rounded and cut off.
    """

    ways: tuple[Callable[..., Any], ...]
    wear: Wear


KINDS: dict[Section, dict[str, Kind]] = {section: {} for section in get_args(Section)}
"""Kinds of each table of case files by their names there; the usual layers have none."""


def in_case_files(section: Section, kind: str | None = None, *ways: str, wear: Wear = "") -> Callable[[T], T]:
    """Make a class, or a function that makes an object, a kind in case files and on the page.

    Parameters
    ----------
    section : {"layers", "base", "indenter", "relaxation"}
        Table of the case file. The fields are the declared arguments; layers have those of their lower face besides, and take
        `bonded`.
    kind : str, optional
        Its name there; by default that in Python: "afm-pyramid".
    *ways : str
        Names of its constructors, empty for the class itself, which is the only one by default.
    wear : {"", "tilts", "wears"}
        Whether a tip may be tilted, or also rounded and cut off.
    """

    def marked(made: T) -> T:
        name = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", made.__name__).lower() if kind is None else kind
        KINDS[section][name] = Kind(tuple(getattr(made, way) if way else made for way in ways or ("",)), wear)
        return made

    return marked
