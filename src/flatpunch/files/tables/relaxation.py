"""Tables of case files for bodies that relax: [relaxation], one for each `kind`, made of the classes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from flatpunch._support.declared import KINDS
from flatpunch.files.tables.fields import Table
from flatpunch.files.tables.made import Made, chosen, kinds_in
from flatpunch.media import Prony, StandardLinearSolid


class ElasticTable(Table):
    """What does not relax, in a list of bodies."""

    section: ClassVar[str] = "relaxation"
    kind: Literal["elastic"]

    def build(self, folder: Path) -> None:
        """Return nothing: no relaxation."""


def _of_one() -> dict[str, type[Table]]:
    """Series first, as they are defined."""
    found = kinds_in("relaxation", {"": Made})
    return {kind: found[kind] for kind in KINDS["relaxation"]}


def _of_body() -> dict[str, type[Table]]:
    """Bodies of a list have no power law."""
    return {kind: table for kind, table in _of_one().items() if kind != "power-law"} | {"elastic": ElasticTable}


class EachTable(Table):
    """One relaxation for each layer from the surface down, then for the base if it is elastic."""

    section: ClassVar[str] = "relaxation"
    kind: Literal["each"]
    bodies: list[Annotated[Table, chosen(_of_body)]]

    def build(self, folder: Path) -> tuple[Prony | StandardLinearSolid | None, ...]:
        """Return the entries that `indent` takes."""
        return tuple(entry.built for entry in self.bodies)


_NEEDED = "a table [relaxation] with its kind"
RelaxationTable = Annotated[Table, chosen(_of_one), Field(description=_NEEDED)]
CaseRelaxationTable = Annotated[Table, chosen(lambda: _of_one() | {"each": EachTable}), Field(description=_NEEDED)]
"""Contacts take lists for layers that relax each in its own way; fits take one relaxation."""
