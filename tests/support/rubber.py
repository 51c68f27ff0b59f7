"""A layer kind of one file, registered nowhere: the smallest that can be."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from flatpunch._support.checks import Array, positive
from flatpunch._support.readable import readable
from flatpunch.media import AnyLayer, Interface, Isotropic
from flatpunch.media.interface import lower_face
from flatpunch.media.plane import Plane, isotropic_slopes


@readable
@dataclass(frozen=True, slots=True)
class RubberLayer(Isotropic, AnyLayer):
    """Incompressible isotropic layer of a shear modulus [Pa] and a thickness [m]: E = 3 G, nu = 1/2."""

    shear: float
    thickness: float
    bonded: bool | Interface = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "shear", positive("RubberLayer.shear", self.shear, unit="Pa"))
        object.__setattr__(self, "thickness", positive("RubberLayer.thickness", self.thickness, unit="m"))
        object.__setattr__(self, "bonded", lower_face("RubberLayer.bonded", self.bonded))

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
