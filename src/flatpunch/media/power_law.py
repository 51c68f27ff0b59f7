"""Half-space whose modulus is a power of depth, E(z) = modulus (z/depth)^exponent."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import Annotated

import numpy as np

from flatpunch._support.case_kinds import in_case_files
from flatpunch._support.checks import Array, BadValue
from flatpunch._support.numbers import a_length, a_pressure, a_ratio
from flatpunch._support.readable import quantity_of, readable
from flatpunch.media.material import Poisson, plane_strain_modulus
from flatpunch.media.plane import Plane, isotropic_plane, isotropic_slopes
from flatpunch.media.stack import Base

_EXPONENT = a_ratio(
    "exponent",
    above=-0.5,
    most=1.0,
    example="0.3",
    shared=True,
    outside="must lie in -0.5 < exponent < 1 (or be 1 with poisson = 0.5, the Gibson soil). From 1 on a point load sinks in "
    "without bound; give such a body a GradedLayer with a modulus > 0 at z = 0.",
)


@in_case_files("base", "power-law-half-space")
@readable
@dataclass(frozen=True, slots=True)
class PowerLawHalfSpace(Base):
    """Half-space with Young's modulus E(z) = modulus (z/depth)^exponent.

    Parameters
    ----------
    modulus : float
        Young's modulus at z = depth [Pa], > 0.
    depth : float
        Reference depth [m], > 0; the medium's own length l.
    exponent : float
        k of the grading [-], -0.5 < exponent < 1; 1 is allowed for poisson = 0.5 only (the Gibson soil).
    poisson : float
        Poisson ratio nu [-], -1 < poisson <= 0.5. For these exponents every such value leaves the exponents of
        the decaying fields real, (1 + k)(1 - k nu/(1 - nu)) >= 0.

    See Also
    --------
    PowerModulus : The same law in a layer.
    HalfSpace : The homogeneous body.

    Examples
    --------
    >>> fp.PowerLawHalfSpace(modulus=1e9, depth=1e-6, exponent=0.3, poisson=0.3)
    PowerLawHalfSpace(modulus=1e+09, depth=1e-06, exponent=0.3, poisson=0.3)
    """

    modulus: Annotated[float, a_pressure("Young's modulus at the depth")]
    depth: Annotated[float, a_length("depth of the modulus")]
    exponent: Annotated[float, _EXPONENT]
    poisson: Poisson

    def _together_(self) -> None:
        if self.exponent == 1 and self.poisson != 0.5:
            raise BadValue("PowerLawHalfSpace.exponent", repr(self.exponent), _EXPONENT.outside)

    @property
    def surface_modulus(self) -> float:
        """E* = modulus/(1 - nu^2) [Pa], the convention of this medium."""
        return plane_strain_modulus(self.modulus, self.poisson)

    @property
    def length(self) -> float:
        """Own length l [m]: the reference depth."""
        return self.depth

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of its numbers."""
        return ("modulus", "depth", "exponent", "poisson")

    @property
    def varies(self) -> bool:
        """True."""
        return True

    @property
    def power_law(self) -> PowerLawHalfSpace:
        """Itself."""
        return self

    @property
    def softest(self) -> float:
        """Infinite: the modulus vanishes at the surface, or at infinite depth [1/Pa]."""
        return inf

    def young_at(self, z: Array) -> Array:
        """Young's modulus at depths z [Pa]."""
        return np.asarray(self.modulus * (z / self.depth) ** self.exponent)

    def plane_at(self, z: Array) -> Plane[Array]:
        """Coefficients of plane strain at depths z > 0 [m], of the shape of z."""
        return isotropic_plane(self.young_at(z), np.full(np.shape(z), self.poisson))

    def slopes_at(self, z: Array) -> dict[str, Plane[Array]]:
        """Derivatives of the coefficients at depths z > 0 by each of `numbers`."""
        young = self.young_at(z)
        by = isotropic_slopes(young, np.full(np.shape(z), self.poisson))
        change = {
            "modulus": young / self.modulus,
            "depth": -self.exponent * young / self.depth,
            "exponent": young * np.log(z / self.depth),
        }
        found = {name: Plane(*(each * rate for each in by["young"])) for name, rate in change.items()}
        return {**found, "poisson": by["poisson"]}

    def times(self, factor: float) -> PowerLawHalfSpace:
        """The same with all moduli multiplied by a factor."""
        return replace(self, modulus=factor * self.modulus)

    def elasticity(self) -> tuple[str, str]:
        """Modulus and Poisson ratio in words."""
        return quantity_of(self.modulus, "Pa"), quantity_of(self.poisson, "")
