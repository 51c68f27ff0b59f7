"""Tables of case files for bodies that relax: [relaxation], one for each `kind`, made of the classes."""

from __future__ import annotations

from functools import reduce
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field

from flatpunch.files.tables.fields import Table
from flatpunch.files.tables.made import table_of
from flatpunch.media import PowerLawRelaxation, Prony, StandardLinearSolid

_SERIES = {"prony": Prony, "standard-linear-solid": StandardLinearSolid}
_ALL = _SERIES | {"power-law": PowerLawRelaxation}
_TABLES = {kind: table_of(kind, "relaxation", [made]) for kind, made in _ALL.items()}


class ElasticTable(Table):
    """What does not relax, in a list of bodies."""

    section: ClassVar[str] = "relaxation"
    kind: Literal["elastic"]

    def build(self, folder: Path) -> None:
        """Return nothing: no relaxation."""


if TYPE_CHECKING:
    _BodyTable = Table
    RelaxationTable = Table
else:
    _BodyTable = Annotated[reduce(or_, [*map(_TABLES.get, _SERIES), ElasticTable]), Field(discriminator="kind")]
    RelaxationTable = Annotated[
        reduce(or_, _TABLES.values()),
        Field(discriminator="kind", description="a table [relaxation] with its kind"),
    ]


class EachTable(Table):
    """One relaxation for each layer from the surface down, then for the base if it is elastic."""

    section: ClassVar[str] = "relaxation"
    kind: Literal["each"]
    bodies: list[_BodyTable]

    def build(self, folder: Path) -> tuple[Prony | StandardLinearSolid | None, ...]:
        """Return the entries that `indent` takes."""
        return tuple(entry.built for entry in self.bodies)


if TYPE_CHECKING:
    CaseRelaxationTable = Table
else:
    CaseRelaxationTable = Annotated[
        reduce(or_, [*_TABLES.values(), EachTable]),
        Field(discriminator="kind", description="a table [relaxation] with its kind"),
    ]
"""Contacts take lists for layers that relax each in its own way; fits take one relaxation."""
