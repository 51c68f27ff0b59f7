"""Tables of a case file for bodies that relax: [relaxation], one model per `kind`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from flatpunch.files.tables.fields import Number, Table, Time
from flatpunch.media import PowerLawRelaxation, Prony, StandardLinearSolid


class PronyTable(Table):
    """psi(t) = equilibrium + sum_j weights_j exp(-t/times_j)."""

    describes: ClassVar[type] = Prony
    section: ClassVar[str] = "relaxation"
    kind: Literal["prony"]
    weights: list[Number]
    times: list[Time]
    equilibrium: Number | None = None


class StandardLinearSolidTable(Table):
    """psi(t) = equilibrium + (1 - equilibrium) exp(-t/time)."""

    describes: ClassVar[type] = StandardLinearSolid
    section: ClassVar[str] = "relaxation"
    kind: Literal["standard-linear-solid"]
    equilibrium: Number
    time: Time


class PowerLawRelaxationTable(Table):
    """psi(t) = (t/time)^-exponent."""

    describes: ClassVar[type] = PowerLawRelaxation
    section: ClassVar[str] = "relaxation"
    kind: Literal["power-law"]
    exponent: Number
    time: Time


class ElasticTable(Table):
    """What does not relax, in a list of bodies."""

    section: ClassVar[str] = "relaxation"
    kind: Literal["elastic"]

    def build(self, folder: Path) -> None:
        """Return nothing: no relaxation."""


class EachTable(Table):
    """One relaxation for each layer from the surface down, then for the base if it is elastic."""

    section: ClassVar[str] = "relaxation"
    kind: Literal["each"]
    bodies: list[Annotated[PronyTable | StandardLinearSolidTable | ElasticTable, Field(discriminator="kind")]]

    def build(self, folder: Path) -> tuple[Prony | StandardLinearSolid | None, ...]:
        """Return the entries that `indent` takes."""
        return tuple(entry.built for entry in self.bodies)


RelaxationTable = Annotated[
    PronyTable | StandardLinearSolidTable | PowerLawRelaxationTable,
    Field(discriminator="kind", description="a table [relaxation] with its kind"),
]

CaseRelaxationTable = Annotated[
    PronyTable | StandardLinearSolidTable | PowerLawRelaxationTable | EachTable,
    Field(discriminator="kind", description="a table [relaxation] with its kind"),
]
"""Contacts take lists for layers that relax each in its own way; fits take one relaxation."""
