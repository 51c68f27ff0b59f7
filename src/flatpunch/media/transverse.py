"""Transversely isotropic layers and half-spaces, whose axis of symmetry is z: stiff along z or in the plane.

Columnar coatings, wood, tendon, graphite and stacks of thin layers are such bodies. Five constants describe one. They are kept as
engineering constants, which are finite for incompressible bodies too; `stiffnesses` gives the tensor. With E, nu in the plane,
E_z along the axis, nu_z the contraction in the plane under a stress along the axis, and G the shear modulus between both,

    e_xx = (s_xx - nu s_yy)/E - nu_z s_zz/E_z,    e_zz = (s_zz - nu_z (s_xx + s_yy))/E_z,    e_xz = s_xz/(2 G).

The strain energy is positive if E, E_z, G > 0, |nu| < 1 and 1 - nu - 2 nu_z^2 E/E_z >= 0, where zero is incompressible along z.

One such layer stands for many thin ones (Backus 1962): waves that are long against the layers see the mean of the field equations
over depth, of the coefficients of plane strain (`plane.Plane`), compliances of stresses that are continuous across faces as well
as stiffnesses of strains that are. Springs at the faces between layers add their softness.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf
from typing import Annotated, Any, NamedTuple, Self

import numpy as np

from flatpunch._support.checks import Array, BadValue, real, shown
from flatpunch._support.declared import a_pressure, a_ratio
from flatpunch._support.readable import quantity_of, readable
from flatpunch.media.material import YOUNG, AnyLayer, Homogeneous, Interface, Thickness
from flatpunch.media.plane import Plane, from_plane, plane_of, plane_slopes, slack_of
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
        return CONSTANTS

    @property
    def anisotropic(self) -> bool:
        return True

    @property
    def plane(self) -> Plane[float]:
        return plane_of(*self.constants, slack_of(*self.constants[:4]))

    def slopes_at(self, z: Array) -> dict[str, Plane[Any]]:
        return plane_slopes(self.constants)

    def times(self, factor: float) -> Self:
        moduli = {name: factor * getattr(self, name) for name in ("young_in_plane", "young_axial", "shear")}
        return replace(self, **moduli)

    def elasticity(self) -> tuple[str, str]:
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


_NODES = 32
"""Gauss nodes between breaks of a law of depth."""


def homogenised(layers: Iterable[AnyLayer]) -> TransverselyIsotropicLayer:
    """Transversely isotropic layer with the static response of a stack of thin layers to long waves.

    Stacks of hundreds of layers (superlattices, laminates, sedimentary rock) then cost as much as one layer. The layer is as
    thick as all of them together and has the lower face of the last one.

    Parameters
    ----------
    layers : sequence of Layer, GradedLayer and TransverselyIsotropicLayer
        From the surface down, bonded to each other or joined by an Interface. One period of a periodic stack gives the constants
        of the whole.

    Returns
    -------
    TransverselyIsotropicLayer

    Raises
    ------
    ValueError, TypeError
        If there are none, or one slides on the next or has a membrane between it and the next.

    See Also
    --------
    TransverselyIsotropicLayer : What it returns.
    Medium : Takes the layers themselves.

    Examples
    --------
    >>> pair = [fp.Layer(450e9, 0.2, 5e-9), fp.Layer(250e9, 0.3, 5e-9)]
    >>> coating = fp.homogenised(100 * pair)
    >>> print(f"{coating.young_in_plane / 1e9:.0f} GPa in the plane, {coating.young_axial / 1e9:.0f} GPa along z")
    351 GPa in the plane, 335 GPa along z

    Notes
    -----
    The response is that of the stack to waves that are long against a period; the error is of the first order in the wavenumber
    times the period, since the first layer is not the mean. The stiffness of a contact of radius a is off by a share of 0.05 to
    0.1 (moduli in a ratio of 1.8) to 0.6 (ratio 20) of the period over a; the page on media has the table. Stresses are means:
    s_zz, s_xz and s_yz are those in the stack, stresses along the layers differ from layer to layer.
    """
    stack = _checked(layers)
    thickness = sum(layer.thickness for layer in stack)
    total = sum(_integrated(layer) for layer in stack)
    for layer in stack[:-1]:
        along, across = layer.face.softness
        total = total + np.array(Plane(0.0, along, across, 0.0, 0.0))
    return TransverselyIsotropicLayer(
        *from_plane(Plane(*(np.asarray(total) / thickness).tolist())), thickness, stack[-1].bonded
    )


def _checked(layers: Iterable[AnyLayer]) -> list[AnyLayer]:
    if isinstance(layers, AnyLayer):
        raise TypeError("layers is one layer; give a list of layers.")
    try:
        stack = list(layers)
    except TypeError:
        raise TypeError(f"layers = {shown(layers)} must be a list of layers.") from None
    if not stack:
        raise ValueError("layers is empty; give one layer at least.")
    for i, layer in enumerate(stack):
        if not isinstance(layer, AnyLayer):
            raise TypeError(
                f"layers[{i}] = {shown(layer)} must be a Layer, a GradedLayer or a TransverselyIsotropicLayer."
            )
        if i + 1 < len(stack) and not layer.bonded:
            raise ValueError(
                f"layers[{i}] slides on the next one: the stack has no shear stiffness and bends layer by layer, which no single "
                "layer does. Give Medium the layers themselves, or the interface a shear stiffness."
            )
        if i + 1 < len(stack) and layer.face.membrane:
            raise ValueError(
                f"layers[{i}].bonded has a membrane: its tension and bending have no mean over the depth. Give Medium the layers "
                "themselves, or leave the membrane out."
            )
    return stack


def _integrated(layer: AnyLayer) -> Array:
    """Coefficients of a layer, integrated over its depth."""
    if not layer.varies:
        return layer.thickness * np.array(layer.plane)
    x, w = np.polynomial.legendre.leggauss(_NODES)
    total = np.zeros(len(Plane._fields))
    for low, high in pairwise([0.0, *layer.breaks, layer.thickness]):
        z = low + (high - low) * (1 + x) / 2
        total += (high - low) / 2 * np.array(layer.plane_at(z)) @ w
    return total
