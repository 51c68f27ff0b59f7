"""Tables of a case file that describe the pressed body: layers from the surface down, and what lies below them.

A table for each kind of layer and base is made of its constructor (`_support.case_kinds`). The moduli and Poisson ratios of a
layer without a kind are one value each, or vary over its depth (`laws`).
"""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, cast

from pydantic import Field

from flatpunch._support.checks import BadValue
from flatpunch.files.tables.fields import Switch, Table
from flatpunch.files.tables.laws import OF_UNITS, Profile
from flatpunch.files.tables.made import Made, chosen, fields_of, kinds_in
from flatpunch.media import AnyLayer, Base, Body, FreeLayer, Interface, Medium, Stack, TwoBodies


class LayerTable(Made):
    """[[layers]]: one layer; repeat it from the free surface down."""

    beside: ClassVar[dict[str, Any]] = {
        "bonded": (Annotated[Switch, Field(title="Lower face")], True),
        "lifts_off": (Switch | None, None),
        **{f"interface_{name}": field for name, field in fields_of([Interface]).items()},
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
        springs = {name: self.value(f"interface_{name}") for name in ("normal", "shear")}
        if all(each is None for each in springs.values()):
            return bool(self.value("bonded"))
        if not self.value("bonded"):
            raise ValueError(
                "interface_normal and interface_shear are springs of a bonded face; leave bonded out. interface_shear = '0 Pa/m' "
                "slides."
            )
        return Interface(**springs)


LAYER_KINDS = functools.partial(kinds_in, "layers", {"": LayerTable})
BASE_KINDS = functools.partial(kinds_in, "base", {"": Made})
"""Functions that return the tables of the kinds by their names."""

Layers = list[Annotated[LayerTable, chosen(LAYER_KINDS)]]
BaseTable = Annotated[Made, chosen(BASE_KINDS), Field(description="a table [base] such as kind = 'rigid'")]


class BodyTable(Table):
    """[upper] or [lower] of two bodies: layers on a base, each body from its own contact surface inwards."""

    layers: Layers = Field(default=[])
    base: BaseTable

    def build(self, folder: Path) -> Stack:
        """Return the body."""
        base = self.base.built
        return base if base.rigid and not self.layers else stack(self.layers, base)


class SampleTable(Table):
    """One body, or two that are pressed together."""

    layers: Layers = Field(default=[])
    base: BaseTable | None = None
    upper: BodyTable | None = None
    lower: BodyTable | None = None

    def body(self) -> Body:
        """Return one body from layers and base, or two from upper and lower; all layers are held down."""
        one, upper, lower = self.base is not None, self.upper, self.lower
        if (upper is None) != (lower is None) or (upper is None) != one or (upper is not None and self.layers):
            raise ValueError(
                "give either one body ([[layers]] and [base]) or two ([upper] and [lower], each with a base)."
            )
        if upper is not None and lower is not None:
            return TwoBodies(upper.built, lower.built)
        return stack(self.layers, cast("Made", self.base).built)

    def pressed(self) -> Body:
        """Return what `body` does, or the layer that lifts off."""
        layers = self.layers
        if self.base is None or self.upper or self.lower or not any(table.value("lifts_off") for table in layers):
            return self.body()
        layer, below = layers[0].built, self.base.built
        plain = layer.isotropic and layer.bonded in (True, False)
        if len(layers) > 1 or not plain or not (below.rigid or below.isotropic):
            raise _lifts_off(
                layers,
                "is solved for one homogeneous isotropic layer without springs, on a rigid base or a half-space of that kind.",
            )
        return FreeLayer.of(layer, below)


def stack(layers: Layers, base: Base) -> Stack:
    """Return layers on a base, or the base by itself where that is a body."""
    if not layers and not base.rigid:
        return base
    if any(table.value("lifts_off") for table in layers):
        raise _lifts_off(layers, "goes with neither two bodies, fits, rough surfaces nor other programs; leave it out.")
    if base.power_law:
        raise ValueError("layers on a power-law half-space are not solved; give graded layers on a half-space instead.")
    return Medium([table.built for table in layers], base=base)


def _lifts_off(layers: Layers, why_not: str) -> BadValue:
    """Error of the first layer that lifts off."""
    at = next(i for i, table in enumerate(layers) if table.value("lifts_off"))
    return BadValue(f"layers[{at}].lifts_off", "true", why_not)


class MaterialTable(Table):
    """[material]: law of the whole sample at large strains."""

    finite_strain: Literal["neo-hookean"]

    def build(self, folder: Path) -> str:
        """Return the law."""
        return self.finite_strain
