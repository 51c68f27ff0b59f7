"""What varies over the depth of a layer in a case file: a named law, a table, or a formula in the depth z."""

from __future__ import annotations

import re
from abc import abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, create_model

from flatpunch._support.declared import arguments
from flatpunch.files import units
from flatpunch.files.tables.fields import Length, Number, Pressure, Table
from flatpunch.files.tables.made import fields_of
from flatpunch.media import DepthTable, Formula
from flatpunch.media.laws import LAWS, Law


class Profile(Table):
    """Something that varies over the depth of a layer."""

    def build(self, folder: Path) -> None:
        """Nothing yet: a profile is complete with its layer's thickness only."""

    @abstractmethod
    def over(self, thickness: float) -> Law | tuple[list[float], list[float]]:
        """Return the law, table or formula over `thickness` [m]."""


class NamedLaw(Profile):
    """Named law, whose fields are those of its class."""

    if TYPE_CHECKING:
        law: str
        exponent: float | None

    def build(self, folder: Path) -> None:
        """Check that the exponent is there if and only if the law has one, and the law by itself, for its messages."""
        if (self.exponent is None) == ("exponent" in arguments(LAWS[self.law])):
            raise ValueError("exponent belongs to law = 'power', and to that one only.")
        self.over(1.0)

    def over(self, thickness: float) -> Law | tuple[list[float], list[float]]:
        """Return the law."""
        made = LAWS[self.law]
        given = {name: getattr(self, name) for name in arguments(made) if name != "thickness"}
        return made(**given, thickness=thickness)


_OF_LAWS: dict[str, Any] = {"law": (Literal[tuple(LAWS)], ...)} | fields_of(list(LAWS.values()), skip={"thickness"})
if TYPE_CHECKING:
    LawTable = NamedLaw
else:
    LawTable = create_model("LawTable", __base__=NamedLaw, __module__=__name__, **_OF_LAWS)


class _DepthTable(Profile):
    depths: list[Length]
    values: list[float]

    def build(self, folder: Path) -> None:
        """Check the depths by themselves: messages should show them as they stand in the file."""
        if len(self.depths) == len(self.values):
            DepthTable(tuple(self.depths), tuple(self.values))

    def over(self, thickness: float) -> Law | tuple[list[float], list[float]]:
        """Return the pair (depths, values)."""
        return self.depths, self.values


class ModulusTable(_DepthTable):
    """{ depths, values }: moduli at depths."""

    values: list[Pressure]


class PoissonTable(_DepthTable):
    """{ depths, values }: Poisson ratios at depths."""

    values: list[Number]


def _unit(dimension: units.Dimension) -> BeforeValidator:
    return BeforeValidator(lambda name: units.to_si(f"1 {name}", dimension))


class FormulaTable(Profile):
    """{ formula, unit, depth_unit }: formula in the depth z, "2 + 8*z" with unit "GPa" and depth_unit "um"."""

    formula: str
    unit: Annotated[float, _unit(units.PRESSURE)] = 1.0
    depth_unit: Annotated[float, _unit(units.LENGTH)] = 1.0

    def build(self, folder: Path) -> None:
        """Read the formula by itself: messages should show the text as it stands in the file."""
        Formula(self.formula)

    def over(self, thickness: float) -> Law | tuple[list[float], list[float]]:
        """Return the formula in SI units: the units become factors in its text, so that a record of it is complete."""
        z = "z" if self.depth_unit == 1 else f"(z/{self.depth_unit!r})"
        text = re.sub(r"\bz\b", z, self.formula)
        return Formula(text if self.unit == 1 else f"{self.unit!r}*({text})")


def _kind_of_profile(value: object) -> str:
    if not isinstance(value, dict):
        return "one value"
    return "a formula" if "formula" in value else "a law" if "law" in value else "a table"


Modulus = Annotated[
    Annotated[Pressure, Tag("one value")]
    | Annotated[LawTable, Tag("a law")]
    | Annotated[ModulusTable, Tag("a table")]
    | Annotated[FormulaTable, Tag("a formula")],
    Discriminator(_kind_of_profile),
    Field(
        description="a pressure such as '5 kPa', or a table such as { law = 'linear', top = '5 kPa', bottom = '9 kPa' }"
    ),
]
Poisson = Annotated[
    Annotated[Number, Tag("one value")]
    | Annotated[PoissonTable, Tag("a table")]
    | Annotated[FormulaTable, Tag("a formula")],
    Discriminator(lambda value: "a table" if (kind := _kind_of_profile(value)) == "a law" else kind),
    Field(description="a number such as 0.3"),
]

OF_UNITS: dict[str, Any] = {"Pa": Modulus, "": Poisson}
"""Types of fields that take one value or something that varies, by the unit of their numbers."""
