"""Transversely isotropic layers and half-spaces, whose axis of symmetry is z: stiff along z or in the plane.

Columnar coatings, wood, tendon, graphite and stacks of thin layers are such bodies. Five constants describe one. They are kept as
engineering constants, which are finite for incompressible bodies too; `stiffnesses` gives the tensor. With E, nu in the plane,
E_z along the axis, nu_z the contraction in the plane under a stress along the axis, and G the shear modulus between both,

    e_xx = (s_xx - nu s_yy)/E - nu_z s_zz/E_z,    e_zz = (s_zz - nu_z (s_xx + s_yy))/E_z,    e_xz = s_xz/(2 G).

The strain energy is positive if E, E_z, G > 0, |nu| < 1 and 1 - nu - 2 nu_z^2 E/E_z >= 0, where zero is incompressible along z.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Annotated, Any, NamedTuple, Self

from flatpunch._support.checks import Array, BadValue, real, shown
from flatpunch._support.numbers import a_pressure, a_ratio
from flatpunch._support.readable import quantity_of, readable
from flatpunch.media.interface import Interface
from flatpunch.media.material import YOUNG, AnyLayer, Homogeneous, Thickness
from flatpunch.media.plane import Plane, plane_of, plane_slopes, slack_of
from flatpunch.media.stack import Base

CONSTANTS = ("young_in_plane", "young_axial", "poisson_in_plane", "poisson_axial", "shear")
"""Names of the five elastic constants."""

AxialYoung = Annotated[float, a_pressure("Young's modulus along z")]
AxialPoisson = Annotated[float, a_ratio("Poisson ratio along z")]
Shear = Annotated[float, a_pressure("shear modulus along z")]


class Stiffnesses(NamedTuple):
    """Stiffnesses of a transversely isotropic body [Pa], z = 3 its axis; C66 = (C11 - C12)/2."""

    c11: float
    c12: float
    c13: float
    c33: float
    c44: float

    @property
    def c66(self) -> float:
        """Shear modulus in the plane [Pa]."""
        return (self.c11 - self.c12) / 2


@dataclass(frozen=True, slots=True)
class _Constants(Homogeneous):
    """The five constants, which are checked, and what follows from them."""

    group = ("young", YOUNG)
    young_in_plane: Annotated[float, a_pressure("Young's modulus in the plane")]
    young_axial: AxialYoung
    poisson_in_plane: Annotated[
        float,
        a_ratio("Poisson ratio in the plane", above=-1.0, below=1.0, outside="must lie in -1 < poisson_in_plane < 1."),
    ]
    poisson_axial: AxialPoisson
    shear: Shear

    def _together_(self) -> None:
        nu, nu_axial, ratio = self.poisson_in_plane, self.poisson_axial, self.young_in_plane / self.young_axial
        if slack_of(self.young_in_plane, self.young_axial, nu, nu_axial) < 0:
            raise BadValue(
                f"{type(self).__name__}.poisson_axial",
                f"{nu_axial:g}",
                "makes the body unstable: its square must not exceed (1 - poisson_in_plane)/2 young_axial/young_in_plane = "
                f"{(1 - nu) / 2 / ratio:.4g}. If it is the contraction along z under a stress in the plane, give "
                f"{nu_axial / ratio:.4g}, its product with young_axial/young_in_plane.",
            )

    @property
    def stiffnesses(self) -> Stiffnesses:
        """C11, C12, C13, C33, C44 [Pa]; infinite where the body is incompressible."""
        q, shear, soft, stiff, across = self.plane
        c33 = 1 / soft if soft else inf
        c13 = q * c33
        c11 = stiff + q * c13
        return Stiffnesses(c11, c11 - 2 * across, c13, c33, 1 / shear)

    @property
    def young(self) -> float:
        """Young's modulus in the plane [Pa]. A fit that varies `young` takes both other moduli along, at their ratios."""
        return self.young_in_plane

    @property
    def constants(self) -> tuple[float, float, float, float, float]:
        """The five constants in the order of their names, `numbers`."""
        return self.young_in_plane, self.young_axial, self.poisson_in_plane, self.poisson_axial, self.shear

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the five elastic constants."""
        return CONSTANTS

    @property
    def anisotropic(self) -> bool:
        """True."""
        return True

    @property
    def plane(self) -> Plane[float]:
        """Coefficients of plane strain."""
        return plane_of(*self.constants, slack_of(*self.constants[:4]))

    def slopes_at(self, z: Array) -> dict[str, Plane[Any]]:
        """Derivatives of the coefficients by each of the five constants."""
        return plane_slopes(self.constants)

    def times(self, factor: float) -> Self:
        """The same with all moduli multiplied by a factor."""
        moduli = {name: factor * getattr(self, name) for name in ("young_in_plane", "young_axial", "shear")}
        return replace(self, **moduli)

    def elasticity(self) -> tuple[str, str]:
        """Moduli and Poisson ratios in words."""
        return summary(self.constants)


@readable
@dataclass(frozen=True, slots=True)
class TransverselyIsotropicHalfSpace(_Constants, Base):
    """Homogeneous half-space that is transversely isotropic about z; a body by itself or the base under layers.

    Parameters
    ----------
    young_in_plane, young_axial : float
        Young's moduli along the surface and along z [Pa], > 0.
    poisson_in_plane : float
        Poisson ratio in the plane [-]: contraction along y under a stress along x.
    poisson_axial : float
        Contraction in the plane under a stress along z [-].
    shear : float
        Shear modulus between the plane and z, C44 [Pa], > 0.

    Raises
    ------
    ValueError, TypeError
        If the constants are outside their ranges or the body would not be stable.

    See Also
    --------
    TransverselyIsotropicLayer : A layer.
    HalfSpace : An isotropic one.

    Examples
    --------
    >>> graphite = fp.TransverselyIsotropicHalfSpace.from_stiffnesses(1060e9, 180e9, 15e9, 36.5e9, 4.5e9)
    >>> print(f"{graphite.surface_modulus / 1e9:.1f} GPa")
    25.0 GPa
    """

    @classmethod
    def from_stiffnesses(
        cls, c11: float, c12: float, c13: float, c33: float, c44: float
    ) -> TransverselyIsotropicHalfSpace:
        """Half-space with the stiffnesses C11, C12, C13, C33 and C44 [Pa]."""
        return cls(*_engineering(cls.__name__, Stiffnesses(c11, c12, c13, c33, c44)))


@readable
@dataclass(frozen=True, slots=True)
class TransverselyIsotropicLayer(_Constants, AnyLayer):
    """Homogeneous layer that is transversely isotropic about z.

    Parameters
    ----------
    young_in_plane, young_axial : float
        Young's moduli along the surface and along z [Pa], > 0.
    poisson_in_plane : float
        Poisson ratio in the plane [-]: contraction along y under a stress along x.
    poisson_axial : float
        Contraction in the plane under a stress along z [-].
    shear : float
        Shear modulus between the plane and z, C44 [Pa], > 0.
    thickness : float
        Thickness h [m], > 0.
    bonded : bool or Interface
        Whether the lower face sticks to what lies below; otherwise it slides without friction (no lift-off), or yields like
        the springs of an Interface.

    Raises
    ------
    ValueError, TypeError
        If the constants are outside their ranges or the body would not be stable.

    See Also
    --------
    TransverselyIsotropicHalfSpace : A base.
    Layer : An isotropic one.

    Examples
    --------
    >>> columns = fp.TransverselyIsotropicLayer(250e9, 400e9, 0.25, 0.2, 110e9, thickness=2e-6)
    >>> coated = fp.Medium([columns], base=fp.HalfSpace(210e9, 0.3))
    >>> print(f"{columns.surface_modulus / 1e9:.0f} GPa")
    344 GPa
    """

    thickness: Thickness
    bonded: bool | Interface = True

    @classmethod
    def from_stiffnesses(
        cls,
        c11: float,
        c12: float,
        c13: float,
        c33: float,
        c44: float,
        thickness: float,
        bonded: bool | Interface = True,
    ) -> TransverselyIsotropicLayer:
        """Layer with the stiffnesses C11, C12, C13, C33 and C44 [Pa]."""
        return cls(*_engineering(cls.__name__, Stiffnesses(c11, c12, c13, c33, c44)), thickness, bonded)


def summary(constants: Sequence[object]) -> tuple[str, str]:
    """Moduli and Poisson ratios, numbers or laws of depth, in words."""
    young, young_axial, poisson, poisson_axial, shear = constants
    plane, axial, between = (quantity_of(value, "Pa") for value in (young, young_axial, shear))
    ratios = [quantity_of(value, "") for value in (poisson, poisson_axial)]
    return f"{plane} in plane, {axial} axial, shear {between}", f"{ratios[0]}, axial {ratios[1]}"


def _engineering(kind: str, given: Stiffnesses) -> tuple[float, float, float, float, float]:
    """Engineering constants of stiffnesses, which are checked."""
    c11, c12, c13, c33, c44 = (
        real(f"{kind}.{name}", value, "Pa") for name, value in zip(given._fields, given, strict=True)
    )
    bulk = c11 + c12
    if not (c11 > abs(c12) and c33 > 0 and c44 > 0 and bulk * c33 > 2 * c13 * c13):
        raise ValueError(
            f"{kind} with c11 = {shown(c11)}, c12 = {shown(c12)}, c13 = {shown(c13)}, c33 = {shown(c33)}, c44 = {shown(c44)} is "
            "not stable: c11 > |c12|, c33 > 0, c44 > 0 and (c11 + c12) c33 > 2 c13^2 must hold. The axis of symmetry is z = 3."
        )
    determinant = bulk * c33 - 2 * c13 * c13
    young = (c11 - c12) * determinant / (c11 * c33 - c13 * c13)
    return young, determinant / bulk, (c12 * c33 - c13 * c13) / (c11 * c33 - c13 * c13), c13 / bulk, c44
