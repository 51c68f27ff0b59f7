"""A layer kind of one file: the smallest that can be."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any

from flatpunch._support.checks import Array
from flatpunch._support.declared import a_pressure, in_case_files
from flatpunch._support.readable import readable
from flatpunch.media import AnyLayer, Interface, Isotropic
from flatpunch.media.material import Thickness
from flatpunch.media.plane import Plane, isotropic_slopes


@in_case_files("layers", "rubber")
@readable
@dataclass(frozen=True, slots=True)
class RubberLayer(Isotropic, AnyLayer):
    """Incompressible isotropic layer of a shear modulus [Pa] and a thickness [m]: E = 3 G, nu = 1/2."""

    shear: Annotated[float, a_pressure("shear modulus")]
    thickness: Thickness
    bonded: bool | Interface = True

    @property
    def numbers(self) -> tuple[str, ...]:
        return ("shear",)

    @property
    def young(self) -> float:
        return 3 * self.shear

    @property
    def poisson(self) -> float:
        return 0.5

    def slopes_at(self, z: Array) -> dict[str, Plane[Any]]:
        return {"shear": Plane(*(3 * each for each in isotropic_slopes(self.young, 0.5)["young"]))}

    def times(self, factor: float) -> RubberLayer:
        return replace(self, shear=factor * self.shear)
