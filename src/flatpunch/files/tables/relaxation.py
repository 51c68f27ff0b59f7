"""Tables of a case file for bodies that relax: [relaxation], one model per `kind`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from flatpunch.files.tables.fields import Number, Table, Time
from flatpunch.media import PowerLawRelaxation, Prony, StandardLinearSolid


class PronyTable(Table):
    """psi(t) = equilibrium + sum_j weights_j exp(-t/times_j)."""

    section: ClassVar[str] = "relaxation"
    kind: Literal["prony"]
    weights: list[Number]
    times: list[Time]
    equilibrium: Number | None = None

    def build(self, folder: Path) -> Any:
        """Return the relaxation function."""
        return Prony(self.weights, self.times, self.equilibrium)


class StandardLinearSolidTable(Table):
    """psi(t) = equilibrium + (1 - equilibrium) exp(-t/time)."""

    section: ClassVar[str] = "relaxation"
    kind: Literal["standard-linear-solid"]
    equilibrium: Number
    time: Time

    def build(self, folder: Path) -> Any:
        """Return the relaxation function."""
        return StandardLinearSolid(self.equilibrium, self.time)


class PowerLawRelaxationTable(Table):
    """psi(t) = (t/time)^-exponent."""

    section: ClassVar[str] = "relaxation"
    kind: Literal["power-law"]
    exponent: Number
    time: Time

    def build(self, folder: Path) -> Any:
        """Return the relaxation function."""
        return PowerLawRelaxation(self.exponent, self.time)


RelaxationTable = Annotated[
    PronyTable | StandardLinearSolidTable | PowerLawRelaxationTable,
    Field(discriminator="kind", description="a table [relaxation] with its kind"),
]
