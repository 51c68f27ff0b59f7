"""Tables of a case file that describe the pressed body: layers from the surface down, what lies below them, and how they relax.

A table for each kind of layer, base and relaxation is made of its constructor (`_support.declared`). Moduli and Poisson ratios of
a layer without a kind are one value each, or vary over its depth: by a named law, a table, or a formula in the depth z.
"""

from __future__ import annotations

import functools
import re
from abc import abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, cast

from pydantic import BeforeValidator, Discriminator, Field, Tag, create_model

from flatpunch._support.checks import BadValue
from flatpunch._support.declared import KINDS, arguments
from flatpunch.files import units
from flatpunch.files.tables.fields import Length, Number, Pressure, Switch, Table
from flatpunch.files.tables.made import Made, chosen, fields_of, kinds_in, table_of
from flatpunch.media import (
    AnyLayer,
    Base,
    Body,
    DepthTable,
    Formula,
    FreeLayer,
    Interface,
    Medium,
    Membrane,
    Prony,
    Stack,
    StandardLinearSolid,
    TwoBodies,
)
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


class LayerTable(Made):
    """[[layers]]: one layer; repeat it from the free surface down."""

    beside: ClassVar[dict[str, Any]] = {
        "bonded": (Annotated[Switch, Field(title="Lower face")], True),
        "lifts_off": (Switch | None, None),
        **{f"interface_{name}": field for name, field in fields_of([Interface]).items()},
        **{f"membrane_{name}": field for name, field in fields_of([Membrane], may=arguments(Membrane)).items()},
    }
    laws: ClassVar[dict[str, Any]] = OF_UNITS

    def value(self, name: str) -> Any:
        """Value of a field; what varies over the depth is complete with the thickness."""
        value = getattr(self, name)
        return value.over(self.value("thickness")) if isinstance(value, Profile) else value

    def build(self, folder: Path) -> AnyLayer:
        """Return the layer."""
        layer: AnyLayer = self.made(bonded=self._lower_face())
        return layer

    def _lower_face(self) -> bool | Interface:
        springs, membrane = (
            {name: value for name in arguments(made) if (value := self.value(f"{of}_{name}")) is not None}
            for of, made in (("interface", Interface), ("membrane", Membrane))
        )
        if not springs and not membrane:
            return bool(self.value("bonded"))
        if springs and not self.value("bonded"):
            raise ValueError(
                "interface_normal and interface_shear are springs of a bonded face; leave bonded out. interface_shear = '0 Pa/m' "
                "slides."
            )
        if not self.value("bonded"):
            springs = {"shear": 0.0}
        return Interface(**springs, membrane=Membrane(**membrane) if membrane else None)


LAYER_KINDS = functools.partial(kinds_in, "layers", {"": LayerTable})
BASE_KINDS = functools.partial(kinds_in, "base", {"": Made})
"""Functions that return the tables of the kinds by their names."""

Layers = list[Annotated[LayerTable, chosen(LAYER_KINDS)]]
BaseTable = Annotated[Made, chosen(BASE_KINDS), Field(description="a table [base] such as kind = 'rigid'")]


if TYPE_CHECKING:
    MembraneTable = Made
else:
    MembraneTable = table_of("", "membrane", [Membrane])


class BodyTable(Table):
    """[upper] or [lower] of two bodies: layers on a base, each body from its own contact surface inwards."""

    layers: Layers = Field(default=[])
    base: BaseTable
    membrane: MembraneTable | None = None

    def build(self, folder: Path) -> Stack:
        """Return the body."""
        base = self.base.built
        return base if base.rigid and not self.layers else stack(self.layers, base, self.membrane)


class SampleTable(Table):
    """One body, or two that are pressed together."""

    layers: Layers = Field(default=[])
    base: BaseTable | None = None
    membrane: MembraneTable | None = None
    upper: BodyTable | None = None
    lower: BodyTable | None = None

    def body(self) -> Body:
        """Return one body from layers and base, or two from upper and lower; all layers are held down."""
        one, upper, lower = self.base is not None, self.upper, self.lower
        if (
            (upper is None) != (lower is None)
            or (upper is None) != one
            or (upper is not None and (self.layers or self.membrane))
        ):
            raise ValueError(
                "give either one body ([[layers]] and [base]) or two ([upper] and [lower], each with a base)."
            )
        if upper is not None and lower is not None:
            return TwoBodies(upper.built, lower.built)
        return stack(self.layers, cast("Made", self.base).built, self.membrane)

    def pressed(self) -> Body:
        """Return what `body` does, or the layer that lifts off."""
        layers = self.layers
        if self.base is None or self.upper or self.lower or not any(table.value("lifts_off") for table in layers):
            return self.body()
        layer, below = layers[0].built, self.base.built
        plain = layer.isotropic and layer.bonded in (True, False)
        if len(layers) > 1 or not plain or self.membrane or not (below.rigid or below.isotropic):
            raise _lifts_off(
                layers,
                "is solved for one homogeneous isotropic layer without springs and membranes, on a rigid base or a half-space of "
                "that kind.",
            )
        return FreeLayer.of(layer, below)


def stack(layers: Layers, base: Base, membrane: Made | None = None) -> Stack:
    """Return layers on a base and the membrane on them, or the base by itself where that is a body."""
    if not layers and not base.rigid and membrane is None:
        return base
    if any(table.value("lifts_off") for table in layers):
        raise _lifts_off(layers, "goes with neither two bodies, fits, rough surfaces nor other programs; leave it out.")
    if base.power_law:
        raise ValueError(
            "membranes and layers on a power-law half-space are not solved; give graded layers on a half-space instead."
        )
    return Medium([table.built for table in layers], base, membrane.built if membrane else None)


def _lifts_off(layers: Layers, why_not: str) -> BadValue:
    at = next(i for i, table in enumerate(layers) if table.value("lifts_off"))
    return BadValue(f"layers[{at}].lifts_off", "true", why_not)


class MaterialTable(Table):
    """[material]: law of the whole sample at large strains."""

    finite_strain: Literal["neo-hookean"]

    def build(self, folder: Path) -> str:
        """Return the law."""
        return self.finite_strain


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
