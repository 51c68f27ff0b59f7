"""A layer that lies loosely on its base and lifts off around the contact."""

from __future__ import annotations

from dataclasses import dataclass, field

from flatpunch._support.checks import shown
from flatpunch._support.numbers import Checked
from flatpunch._support.readable import readable
from flatpunch.media.bodies import Layer, Medium, RigidBase
from flatpunch.media.material import AnyLayer, Poisson, Thickness, Young, plane_strain_modulus, young_and_poisson
from flatpunch.media.stack import Base, LooseBody, Stack


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
        if not _carries(self.base):
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


def _carries(base: object) -> bool:
    """Whether it is a base that a loose layer may lie on."""
    return isinstance(base, Base) and bool(base.rigid or base.isotropic)
