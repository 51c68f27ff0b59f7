"""Bodies beside homogeneous half-spaces and stacks of layers.

A half-space whose modulus is a power of depth, E(z) = modulus (z/depth)^exponent; a layer that lies loosely on its base and lifts
off around the contact; two elastic bodies pressed together, whose surface displacements add in the contact.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf
from typing import Annotated

import numpy as np

from flatpunch._support.checks import Array, BadValue, shown
from flatpunch._support.declared import Checked, a_length, a_pressure, a_ratio, in_case_files
from flatpunch._support.readable import Table, quantity_of, readable, table_of
from flatpunch.media.bodies import Layer, Medium, RigidBase
from flatpunch.media.graded import CONTRAST
from flatpunch.media.material import (
    AnyLayer,
    Poisson,
    PowerLaw,
    Thickness,
    Young,
    plane_strain_modulus,
    young_and_poisson,
)
from flatpunch.media.plane import Plane, isotropic_plane, isotropic_slopes
from flatpunch.media.stack import Base, Body, LooseBody, Stack

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


@readable
@dataclass(frozen=True, slots=True)
class FreeLayer(LooseBody, Checked):
    """Layer that lies on a base without friction, adhesion and weight, so that it lifts off around the contact.

    Only `indent` takes it, for round tips and flat punches.

    Parameters
    ----------
    young : float
        Young's modulus E [Pa], > 0.
    poisson : float
        Poisson ratio [-], -1 < poisson <= 0.5.
    thickness : float
        Thickness h [m], > 0.
    base : RigidBase or HalfSpace
        What it lies on.

    Raises
    ------
    ValueError, TypeError
        If a value is outside its range; the message names it.

    See Also
    --------
    Layer : Held down by what it lies on: bonded, or sliding with ``bonded=False``.
    indent : Its result has `base_radius`, the radius of the contact with the base.

    Examples
    --------
    >>> sheet = fp.FreeLayer(young=1e6, poisson=0.5, thickness=1e-3)
    >>> contact = fp.indent(sheet, fp.Paraboloid(radius=5e-3), radius=1e-3)
    >>> print(f"{float(contact.base_radius[0]) * 1e3:.3f} mm on the base")
    1.455 mm on the base
    """

    young: Young
    poisson: Poisson
    thickness: Thickness
    base: Base = field(default_factory=RigidBase)

    def _together_(self) -> None:
        base: object = self.base
        if not isinstance(base, Base) or not (base.rigid or base.isotropic):
            raise TypeError(
                f"FreeLayer.base = {shown(self.base)} must be RigidBase() or HalfSpace(young=..., poisson=...)."
            )

    @classmethod
    def of(cls, layer: AnyLayer, base: Base) -> FreeLayer:
        """A layer of any kind that is isotropic and does not vary, and has no springs, lying loosely on a base.

        Raises
        ------
        ValueError
            If it is of another kind.
        """
        if not layer.isotropic or layer.bonded not in (True, False):
            raise ValueError(
                f"FreeLayer.of({shown(layer)}, ...) takes one homogeneous isotropic layer without springs, which alone is solved "
                "where it lifts off."
            )
        return cls(*young_and_poisson(layer), layer.thickness, base)

    @property
    def free(self) -> FreeLayer:
        """Itself."""
        return self

    @property
    def sides(self) -> tuple[tuple[str, Stack], ...]:
        """The layer on its base, held down."""
        return (("", self.held_down),)

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* of the layer [Pa]."""
        return plane_strain_modulus(self.young, self.poisson)

    @property
    def held_down(self) -> Medium:
        """The layer held down by its base, on which it slides."""
        return Medium([Layer(self.young, self.poisson, self.thickness, bonded=False)], base=self.base)


@readable
@dataclass(frozen=True, slots=True)
class TwoBodies(Body):
    """Two elastic bodies in contact; the gap between them is the indenter's, whichever of them is curved.

    Parameters
    ----------
    upper, lower : Medium, HalfSpace, TransverselyIsotropicHalfSpace, PowerLawHalfSpace or RigidBase
        The bodies, each described from its own contact surface inwards. One may be rigid. A power-law half-space goes with a
        rigid body, or with another one of the same exponent: their sum is again one of that exponent, which no other sum is.

    See Also
    --------
    Medium : Each of the two bodies may be one.
    indent : Press them together.

    Examples
    --------
    >>> steel = fp.HalfSpace(young=210e9, poisson=0.3)
    >>> pair = fp.TwoBodies(steel, steel)
    >>> print(f"{pair.surface_modulus / steel.surface_modulus:.3g}")
    0.5
    """

    upper: Stack
    lower: Stack

    def __post_init__(self) -> None:
        for name, body in self.sides:
            if not isinstance(body, Stack):
                raise TypeError(
                    f"TwoBodies.{name} = {shown(body)} must be a Medium, a HalfSpace, a PowerLawHalfSpace, or RigidBase() for a "
                    "rigid body."
                )
        if self.upper.rigid and self.lower.rigid:
            raise ValueError("TwoBodies.upper and TwoBodies.lower are both rigid, so nothing can deform.")
        exponents = {body.power_law.exponent if body.power_law else 0.0 for body in self.elastic}
        if len(exponents) > 1:
            raise ValueError(
                f"TwoBodies has bodies whose moduli grow with the exponents {sorted(exponents)} of depth. A power-law half-space "
                "pairs with one of its own exponent or with RigidBase(); give the other body's grading as GradedLayer."
            )

        moduli = [body.surface_modulus for body in self.elastic]
        if max(moduli) > CONTRAST * min(moduli):
            raise ValueError(
                f"TwoBodies has moduli of {moduli[0]:.3g} and {moduli[-1]:.3g} Pa; they may differ by a factor of "
                f"{CONTRAST:.0e}. Check the units; the far stiffer one is a RigidBase()."
            )

    def _table_(self) -> Table:
        tables = [(name, table_of(body)) for name, body in self.sides]
        width = max(len(row) for _, table in tables for row in (table.header, *table.rows))
        rows: list[tuple[str, ...]] = []
        for name, table in tables:
            inside = [row for row in (table.header, *table.rows) if row] or [(table.title,)]
            rows += [(name if i == 0 else "", *row, *[""] * (width - len(row))) for i, row in enumerate(inside)]
        return Table("TwoBodies", (), tuple(rows))

    @property
    def sides(self) -> tuple[tuple[str, Stack], ...]:
        """Both bodies with their names."""
        return (("upper", self.upper), ("lower", self.lower))

    @property
    def varies(self) -> bool:
        """Whether the constants of one of them vary with depth."""
        return any(body.varies for body in self.elastic)

    @property
    def anisotropic(self) -> bool:
        """Whether one of them is transversely isotropic, at least in part."""
        return any(body.anisotropic for body in self.elastic)

    @property
    def power_law(self) -> PowerLaw | None:
        """The first of them whose modulus is a power of depth."""
        return next((law for body in self.elastic if (law := body.power_law)), None)

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* of the pair [Pa], 1/E* = sum of both."""
        return 1 / sum(1 / body.surface_modulus for body in self.elastic)
