"""Tables of a case file that describe the pressed body: layers from the surface down, and what lies below them.

The moduli and Poisson ratios of a layer are one value, a named law, a table over depth, or a formula in the depth z each;
any of the last three makes the layer a graded one.
"""

from __future__ import annotations

import re
from abc import abstractmethod
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag

from flatpunch._support.checks import BadValue
from flatpunch.files import units
from flatpunch.files.tables.fields import InterfaceStiffness, Length, Number, Pressure, Switch, Table
from flatpunch.media import (
    AnyLayer,
    Base,
    Body,
    DepthTable,
    ExponentialModulus,
    Formula,
    FreeLayer,
    GradedLayer,
    HalfSpace,
    Interface,
    Layer,
    LinearModulus,
    Medium,
    PowerLawHalfSpace,
    PowerModulus,
    RigidBase,
    Stack,
    TransverselyIsotropicHalfSpace,
    TransverselyIsotropicLayer,
    TwoBodies,
)
from flatpunch.media.laws import Law


class _Profile(Table):
    """Something that varies over the depth of a layer."""

    def build(self, folder: Path) -> None:
        """Nothing yet: a profile is complete with its layer's thickness only."""

    @abstractmethod
    def over(self, thickness: float) -> Law | tuple[list[float], list[float]]:
        """Return the law, table or formula over `thickness` [m]."""


class LawTable(_Profile):
    """{ law, top, bottom }: modulus at both faces and how it passes from one to the other."""

    law: Literal["linear", "exponential", "power"]
    top: Pressure
    bottom: Pressure
    exponent: Number | None = None

    def build(self, folder: Path) -> None:
        """Check that the exponent is there if and only if the law has one, and the law by itself, for its messages."""
        if (self.exponent is None) == (self.law == "power"):
            raise ValueError("exponent belongs to law = 'power', and to that one only.")
        self.over(1.0)

    def over(self, thickness: float) -> Law | tuple[list[float], list[float]]:
        """Return the law."""
        if self.law == "power":
            return PowerModulus(self.top, self.bottom, thickness, self.exponent or 0.0)
        return (LinearModulus if self.law == "linear" else ExponentialModulus)(self.top, self.bottom, thickness)


class _DepthTable(_Profile):
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


class FormulaTable(_Profile):
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


_FIVE = ("young", "poisson", "young_axial", "poisson_axial", "shear")


def _anisotropic(table: LayerTable | HalfSpaceTable) -> bool:
    """Whether it is a transversely isotropic material, which has the fields along z."""
    given = [getattr(table, name) is not None for name in _FIVE[2:]]
    if any(given) and not all(given):
        raise ValueError(
            "young_axial, poisson_axial and shear belong together: give all three for a transversely isotropic material, whose "
            "young and poisson are those of the plane."
        )
    return all(given)


class LayerTable(Table):
    """[[layers]]: one layer; repeat it from the free surface down."""

    young: Modulus
    poisson: Poisson
    thickness: Length
    bonded: Switch = True
    lifts_off: Switch | None = None
    interface_normal: InterfaceStiffness | None = None
    interface_shear: InterfaceStiffness | None = None
    young_axial: Modulus | None = None
    poisson_axial: Poisson | None = None
    shear: Modulus | None = None

    def build(self, folder: Path) -> AnyLayer:
        """Return the layer."""
        bonded, h, anisotropic = self._lower_face(), self.thickness, _anisotropic(self)
        given = [getattr(self, name) for name in _FIVE]
        if any(isinstance(each, _Profile) for each in given):
            young, poisson, *axial = (each.over(h) if isinstance(each, _Profile) else each for each in given)
            return GradedLayer(young, poisson, h, bonded, *axial)
        young, poisson, young_axial, poisson_axial, shear = given
        if anisotropic:
            return TransverselyIsotropicLayer(young, young_axial, poisson, poisson_axial, shear, h, bonded)
        return Layer(young, poisson, h, bonded)

    def _lower_face(self) -> bool | Interface:
        if self.interface_normal is None and self.interface_shear is None:
            return self.bonded
        if not self.bonded:
            raise ValueError(
                "interface_normal and interface_shear are springs of a bonded face; leave bonded out. interface_shear = '0 Pa/m' "
                "slides."
            )
        return Interface(self.interface_normal, self.interface_shear)


class HalfSpaceTable(Table):
    """[base] kind = "half-space"."""

    section: ClassVar[str] = "base"
    kind: Literal["half-space"]
    young: Pressure
    poisson: Number
    young_axial: Pressure | None = None
    poisson_axial: Number | None = None
    shear: Pressure | None = None

    def build(self, folder: Path) -> Base:
        """Return the half-space."""
        if not _anisotropic(self):
            return HalfSpace(self.young, self.poisson)
        young, poisson, axial, poisson_axial, shear = (getattr(self, name) for name in _FIVE)
        return TransverselyIsotropicHalfSpace(young, axial, poisson, poisson_axial, shear)


class PowerLawTable(Table):
    """[base] kind = "power-law-half-space": E(z) = modulus (z/depth)^exponent; no layers on top."""

    describes: ClassVar[type] = PowerLawHalfSpace
    section: ClassVar[str] = "base"
    kind: Literal["power-law-half-space"]
    modulus: Pressure
    depth: Length
    exponent: Number
    poisson: Number


class RigidTable(Table):
    """[base] kind = "rigid"."""

    describes: ClassVar[type] = RigidBase
    section: ClassVar[str] = "base"
    kind: Literal["rigid"]


BaseTable = Annotated[
    HalfSpaceTable | PowerLawTable | RigidTable,
    Field(discriminator="kind", description="a table [base] such as kind = 'rigid'"),
]


class BodyTable(Table):
    """[upper] or [lower] of two bodies: layers on a base, each body from its own contact surface inwards."""

    layers: list[LayerTable] = Field(default=[])
    base: BaseTable

    def build(self, folder: Path) -> Stack:
        """Return the body."""
        base = self.base.built
        return base if base.rigid and not self.layers else stack(self.layers, base)


def stack(layers: list[LayerTable], base: Base) -> Stack:
    """Return layers on a base, or the base by itself where that is a body."""
    if not layers and not base.rigid:
        return base
    if any(table.lifts_off for table in layers):
        raise _lifts_off(layers, "goes with neither two bodies, fits, rough surfaces nor other programs; leave it out.")
    if base.power_law:
        raise ValueError("layers on a power-law half-space are not solved; give graded layers on a half-space instead.")
    return Medium([table.built for table in layers], base=base)


def body(
    layers: list[LayerTable],
    base: HalfSpaceTable | PowerLawTable | RigidTable | None,
    upper: BodyTable | None,
    lower: BodyTable | None,
) -> Body:
    """Return one body from layers and base, or two from upper and lower; all layers are held down."""
    if (upper is None) != (lower is None) or (upper is None) == (base is None) or (upper is not None and layers):
        raise ValueError("give either one body ([[layers]] and [base]) or two ([upper] and [lower], each with a base).")
    if upper is not None and lower is not None:
        return TwoBodies(upper.built, lower.built)
    assert base is not None
    return stack(layers, base.built)


def pressed(
    layers: list[LayerTable],
    base: HalfSpaceTable | PowerLawTable | RigidTable | None,
    upper: BodyTable | None,
    lower: BodyTable | None,
) -> Body:
    """Return what `body` does, or the layer that lifts off."""
    if base is None or upper is not None or lower is not None or not any(table.lifts_off for table in layers):
        return body(layers, base, upper, lower)
    layer, below = layers[0].built, base.built
    plain = layer.isotropic and layer.bonded in (True, False)
    if len(layers) > 1 or not plain or not (below.rigid or below.isotropic):
        raise _lifts_off(
            layers,
            "is solved for one homogeneous isotropic layer without springs, on a rigid base or a half-space of that kind.",
        )
    return FreeLayer.of(layer, below)


def _lifts_off(layers: list[LayerTable], why_not: str) -> BadValue:
    """Error of the first layer that lifts off."""
    at = next(i for i, table in enumerate(layers) if table.lifts_off)
    return BadValue(f"layers[{at}].lifts_off", "true", why_not)


class MaterialTable(Table):
    """[material]: law of the whole sample at large strains."""

    finite_strain: Literal["neo-hookean"]

    def build(self, folder: Path) -> str:
        """Return the law."""
        return self.finite_strain
