"""Tables of a case file that describe the pressed body: layers from the surface down, and what lies below them.

The modulus and the Poisson ratio of a layer are one value, a named law, a table over depth, or a formula in the depth z;
any of the last three makes the layer a graded one.
"""

from __future__ import annotations

import re
from abc import abstractmethod
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag

from flatpunch.files import units
from flatpunch.files.tables.fields import Length, Number, Pressure, Switch, Table
from flatpunch.media import (
    ExponentialModulus,
    Formula,
    GradedLayer,
    HalfSpace,
    Layer,
    LinearModulus,
    Medium,
    PowerLawHalfSpace,
    PowerModulus,
    RigidBase,
    TwoBodies,
)


class _Profile(Table):
    """Something that varies over the depth of a layer."""

    def build(self, folder: Path) -> None:
        """Nothing yet: a profile is complete with its layer's thickness only."""

    @abstractmethod
    def over(self, thickness: float) -> Any:
        """Return the law, table or formula over `thickness` [m]."""


class LawTable(_Profile):
    """{ law, top, bottom }: modulus at both faces and how it passes from one to the other."""

    law: Literal["linear", "exponential", "power"]
    top: Pressure
    bottom: Pressure
    exponent: Number | None = None

    def build(self, folder: Path) -> None:
        """Check that the exponent is there if and only if the law has one."""
        if (self.exponent is None) == (self.law == "power"):
            raise ValueError("exponent belongs to law = 'power', and to that one only.")

    def over(self, thickness: float) -> Any:
        """Return the law."""
        if self.law == "power":
            return PowerModulus(self.top, self.bottom, thickness, self.exponent or 0.0)
        return (LinearModulus if self.law == "linear" else ExponentialModulus)(self.top, self.bottom, thickness)


class _DepthTable(_Profile):
    depths: list[Length]
    values: list[float]

    def over(self, thickness: float) -> Any:
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


class FormulaTable(_Profile):
    """{ formula, unit, depth_unit }: formula in the depth z, "2 + 8*z" with unit "GPa" and depth_unit "um"."""

    formula: str
    unit: Annotated[float, _unit(units.PRESSURE)] = 1.0
    depth_unit: Annotated[float, _unit(units.LENGTH)] = 1.0

    def build(self, folder: Path) -> None:
        """Read the formula by itself: messages should show the text as it stands in the file."""
        Formula(self.formula)

    def over(self, thickness: float) -> Any:
        """Return the formula in SI units: the units become factors in its text, so that a record of it is complete."""
        z = "z" if self.depth_unit == 1 else f"(z/{self.depth_unit!r})"
        text = re.sub(r"\bz\b", z, self.formula)
        return Formula(text if self.unit == 1 else f"{self.unit!r}*({text})")


def _kind_of_profile(value: Any) -> str:
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


class LayerTable(Table):
    """[[layers]]: one layer; repeat it from the free surface down."""

    young: Modulus
    poisson: Poisson
    thickness: Length
    bonded: Switch = True

    def build(self, folder: Path) -> Layer | GradedLayer:
        """Return the layer."""
        young, poisson = (
            value.over(self.thickness) if isinstance(value, _Profile) else value for value in (self.young, self.poisson)
        )
        if isinstance(young, float) and isinstance(poisson, float):
            return Layer(young, poisson, self.thickness, self.bonded)
        return GradedLayer(young, poisson, self.thickness, self.bonded)


class HalfSpaceTable(Table):
    """[base] kind = "half-space"."""

    section: ClassVar[str] = "base"
    kind: Literal["half-space"]
    young: Pressure
    poisson: Number

    def build(self, folder: Path) -> HalfSpace:
        """Return the half-space."""
        return HalfSpace(self.young, self.poisson)


class PowerLawTable(Table):
    """[base] kind = "power-law-half-space": E(z) = modulus (z/depth)^exponent; no layers on top."""

    section: ClassVar[str] = "base"
    kind: Literal["power-law-half-space"]
    modulus: Pressure
    depth: Length
    exponent: Number
    poisson: Number

    def build(self, folder: Path) -> PowerLawHalfSpace:
        """Return the half-space."""
        return PowerLawHalfSpace(self.modulus, self.depth, self.exponent, self.poisson)


class RigidTable(Table):
    """[base] kind = "rigid"."""

    section: ClassVar[str] = "base"
    kind: Literal["rigid"]

    def build(self, folder: Path) -> RigidBase:
        """Return the rigid base."""
        return RigidBase()


BaseTable = Annotated[
    HalfSpaceTable | PowerLawTable | RigidTable,
    Field(discriminator="kind", description="a table [base] such as kind = 'rigid'"),
]


class BodyTable(Table):
    """[upper] or [lower] of two bodies: layers on a base, each body from its own contact surface inwards."""

    layers: list[LayerTable] = Field(default=[])
    base: BaseTable

    def build(self, folder: Path) -> Any:
        """Return the body."""
        return stack(self.layers, self.base.built, allow_rigid=True)


def stack(layers: list[LayerTable], base: Any, *, allow_rigid: bool = False) -> Any:
    """Return layers on a base, or the base by itself where that is a body."""
    if not layers and (
        isinstance(base, (HalfSpace, PowerLawHalfSpace)) or (allow_rigid and isinstance(base, RigidBase))
    ):
        return base
    if isinstance(base, PowerLawHalfSpace):
        raise ValueError("layers on a power-law half-space are not solved; give graded layers on a half-space instead.")
    return Medium([table.built for table in layers], base=base)


def body(layers: list[LayerTable], base: Any, upper: BodyTable | None, lower: BodyTable | None) -> Any:
    """Return one body from layers and base, or two from upper and lower."""
    if (upper is None) != (lower is None) or (upper is None) == (base is None) or (upper is not None and layers):
        raise ValueError("give either one body ([[layers]] and [base]) or two ([upper] and [lower], each with a base).")
    if upper is not None and lower is not None:
        return TwoBodies(upper.built, lower.built)
    return stack(layers, base.built)
