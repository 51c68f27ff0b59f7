"""Homogeneous layers, bases, and the stack made of layers of all kinds.

z points into the material, the free surface is z = 0, and layers are listed from the surface down. All objects
are frozen, validated once, and hashable, so that solutions can be cached by the medium they belong to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import islice
from math import inf, nan
from typing import Annotated, Any, TypeVar

import numpy as np

from flatpunch._support.checks import LAYERS, Array, BadValue, instance, shown
from flatpunch._support.declared import in_case_files
from flatpunch._support.prefixes import text
from flatpunch._support.readable import Table, quantity_of, readable
from flatpunch.media import graded, transverse
from flatpunch.media.graded import CONTRAST, GradedLayer
from flatpunch.media.material import (
    ORDER,
    POISSON,
    YOUNG,
    AnyLayer,
    Interface,
    Isotropic,
    Poisson,
    Thickness,
    Young,
    in_words,
)
from flatpunch.media.membrane import Membrane
from flatpunch.media.plane import Plane
from flatpunch.media.stack import Base, Stack
from flatpunch.media.transverse import TransverselyIsotropicHalfSpace, TransverselyIsotropicLayer

T = TypeVar("T")


@readable
@dataclass(frozen=True, slots=True)
class Layer(Isotropic, AnyLayer):
    """Homogeneous isotropic elastic layer.

    Parameters
    ----------
    young : float
        Young's modulus E [Pa], > 0.
    poisson : float
        Poisson ratio [-], -1 < poisson <= 0.5. 0.5 is incompressible and allowed.
    thickness : float
        Thickness h [m], > 0.
    bonded : bool or Interface
        Whether the lower face sticks to what lies below; otherwise it slides without friction (no lift-off), or yields like
        the springs of an Interface.

    Raises
    ------
    ValueError, TypeError
        If a value is outside its range; the message names it.

    See Also
    --------
    GradedLayer : Moduli that vary with depth.
    Medium : Layers on a base.

    Examples
    --------
    >>> fp.Layer(young=5e3, poisson=0.5, thickness=1e-6)
    Layer(young=5000, poisson=0.5, thickness=1e-06, bonded=True)
    """

    young: Young
    poisson: Poisson
    thickness: Thickness
    bonded: bool | Interface = True

    def times(self, factor: float) -> Layer:
        """The same with Young's modulus multiplied by a factor."""
        return replace(self, young=factor * self.young)


@readable
@dataclass(frozen=True, slots=True)
class HalfSpace(Isotropic, Base):
    """Homogeneous isotropic elastic half-space; a body by itself or the base under layers.

    Parameters
    ----------
    young : float
        Young's modulus E [Pa], > 0.
    poisson : float
        Poisson ratio [-], -1 < poisson <= 0.5.

    See Also
    --------
    Medium : With layers on top.
    PowerLawHalfSpace : A modulus that is a power of depth.

    Examples
    --------
    >>> fp.HalfSpace(young=70e9, poisson=0.22).surface_modulus > 70e9
    True
    """

    young: Young
    poisson: Poisson

    def times(self, factor: float) -> HalfSpace:
        """The same with Young's modulus multiplied by a factor."""
        return replace(self, young=factor * self.young)


@in_case_files("base", "rigid")
@readable
@dataclass(frozen=True, slots=True)
class RigidBase(Base):
    """Rigid foundation. The lowest layer sticks to it or slides on it, as that layer's `bonded` says.

    See Also
    --------
    Medium : What rests on it.
    HalfSpace : An elastic base.

    Examples
    --------
    >>> fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1e-6)], base=fp.RigidBase()).thickness
    1e-06
    """

    @property
    def rigid(self) -> bool:
        """True."""
        return True

    @property
    def plane(self) -> Plane[float]:
        """Coefficients of plane strain: no number."""
        return Plane(nan, nan, nan, nan, nan)

    @property
    def surface_modulus(self) -> float:
        """Infinite [Pa]."""
        return inf

    def plane_at(self, z: Array) -> Plane[Array]:
        """No number at any depth: a rigid body has no stresses."""
        return Plane(*(np.full(np.shape(z), nan) for _ in Plane._fields))

    def slopes_at(self, z: Array) -> dict[str, Plane[Any]]:
        """Empty: it has no constants."""
        return {}

    def times(self, factor: float) -> RigidBase:
        """Itself."""
        return self

    def elasticity(self) -> tuple[str, str]:
        """Rigid."""
        return "rigid", ""


@readable
@dataclass(frozen=True, slots=True)
class Medium(Stack):
    """Stack of layers on a base.

    Parameters
    ----------
    layers : sequence of Layer, GradedLayer and TransverselyIsotropicLayer
        From the free surface down. Empty only on an elastic base.
    base : HalfSpace, TransverselyIsotropicHalfSpace or RigidBase
        What lies below the lowest layer.
    membrane : Membrane, optional
        What lies on the surface: its tension, in-plane stiffness and bending stiffness; by default there is none. Contacts are
        then solved by boundary elements, and surfaces may be rough; all else takes the membrane below a layer of any thickness.

    See Also
    --------
    Layer, GradedLayer : What it is made of.
    plot_medium : The picture.

    Examples
    --------
    >>> print(fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1e-6)], base=fp.RigidBase()))
    Medium, from the surface down
               young  poisson  thickness  lower face
      layer 1  5 kPa  0.5      1 µm       bonded
      base     rigid
    """

    layers: tuple[AnyLayer, ...]
    base: Base
    membrane: Membrane | None = None

    def __init__(
        self, layers: Iterable[AnyLayer] = (), base: Base | None = None, membrane: Membrane | None = None
    ) -> None:
        object.__setattr__(self, "layers", _as_layers(layers))
        if not isinstance(base, Base) or base.power_law:
            raise TypeError(
                f"Medium.base = {shown(base)} must be HalfSpace(young=..., poisson=...), a TransverselyIsotropicHalfSpace or "
                "RigidBase(): it is what lies below all layers."
            )
        object.__setattr__(self, "base", base)
        instance("Medium.membrane", membrane, (Membrane, type(None)), "a Membrane(tension=...), or None")
        object.__setattr__(self, "membrane", membrane)
        _check_contrast(self.layers, base)
        if not self.layers and base.rigid:
            raise ValueError(
                "Medium.layers is empty on a rigid base, so nothing can deform. "
                "Add a Layer, or use a HalfSpace as base."
            )

    @property
    def varies(self) -> bool:
        """Whether a layer is graded."""
        return any(layer.varies for layer in self.layers)

    @property
    def anisotropic(self) -> bool:
        """Whether a layer or the base is transversely isotropic."""
        return any(part.anisotropic for part in self.parts)

    @property
    def isotropic(self) -> tuple[float, float] | None:
        """Shear modulus [Pa] and Poisson ratio of an isotropic base without layers and membrane."""
        return None if self.layers or self.membrane else self.base.isotropic

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* of the material at z = 0 [Pa]."""
        return self.parts[0].surface_modulus

    @property
    def length(self) -> float:
        """Own length l [m] with beta = a/l: thickness of the top layer, infinite without layers."""
        return self.layers[0].thickness if self.layers else inf

    def _table_(self) -> Table:
        rows = [
            (f"layer {i + 1}", *layer.elasticity(), quantity_of(layer.thickness, "m"), in_words(layer.bonded))
            for i, layer in enumerate(self.layers)
        ]
        rows.append(("base", *self.base.elasticity(), "" if self.base.rigid else "half-space", ""))
        if self.membrane:
            rows.insert(0, ("surface", "", "", "", self.membrane.in_words()))
        return Table("Medium, from the surface down", ("", "young", "poisson", "thickness", "lower face"), tuple(rows))


@in_case_files("layers", "")
def layer(
    young: graded.YoungLaw,
    poisson: graded.PoissonLaw,
    thickness: Thickness,
    bonded: bool | Interface = True,
    young_axial: graded.AxialYoungLaw = None,
    poisson_axial: graded.AxialPoissonLaw = None,
    shear: graded.ShearLaw = None,
) -> AnyLayer:
    """The simplest layer of two or five constants: homogeneous where all of them are numbers."""
    given: dict[str, Any] = {"young": young, "poisson": poisson}
    given |= _along_z(young_axial=young_axial, poisson_axial=poisson_axial, shear=shear)
    if not all(isinstance(each, (int, float)) for each in given.values()):
        return GradedLayer(thickness=thickness, bonded=bonded, **given)
    if shear is None:
        return Layer(**given, thickness=thickness, bonded=bonded)
    return _in_plane(TransverselyIsotropicLayer, **given, thickness=thickness, bonded=bonded)


@in_case_files("base", "half-space")
def half_space(
    young: Annotated[float, replace(YOUNG, example="70 GPa")],
    poisson: Annotated[float, replace(POISSON, example="0.22")],
    young_axial: transverse.AxialYoung | None = None,
    poisson_axial: transverse.AxialPoisson | None = None,
    shear: transverse.Shear | None = None,
) -> Base:
    """Half-space of two constants, or of the five of a transversely isotropic one."""
    given = {"young": young, "poisson": poisson}
    given |= _along_z(young_axial=young_axial, poisson_axial=poisson_axial, shear=shear)
    return HalfSpace(**given) if shear is None else _in_plane(TransverselyIsotropicHalfSpace, **given)


def _along_z(**constants: Any) -> dict[str, Any]:
    """The constants along z, of which there are all or none."""
    given = {name: value for name, value in constants.items() if value is not None}
    if given and len(given) < len(constants):
        raise ValueError(
            "young_axial, poisson_axial and shear belong together: give all three for a transversely isotropic material, whose "
            "young and poisson are those of the plane."
        )
    return given


def _in_plane(made: Callable[..., T], young: float, poisson: float, **more: Any) -> T:
    """A transversely isotropic body whose constants of the plane have the names that they have for all bodies."""
    try:
        return made(young_in_plane=young, poisson_in_plane=poisson, **more)
    except BadValue as error:
        raise BadValue(error.field.replace("_in_plane", ""), error.value, error.text) from None


def _check_contrast(layers: tuple[AnyLayer, ...], base: Base) -> None:
    """Refuse stacks whose moduli or thicknesses differ by more than floating point resolves."""
    moduli = [layer.surface_modulus for layer in layers] + ([] if base.rigid else [base.surface_modulus])
    if moduli and max(moduli) > CONTRAST * min(moduli):
        raise ValueError(
            f"Medium has moduli from {min(moduli):.3g} to {max(moduli):.3g} Pa; they may differ by a factor of {CONTRAST:.0e}. "
            "Check the units; what is far stiffer than all else is a RigidBase()."
        )
    lengths = [layer.thickness for layer in layers]
    if lengths and max(lengths) > CONTRAST * min(lengths):
        raise ValueError(
            f"Medium has layers from {text(min(lengths), 'm')} to {text(max(lengths), 'm')} thick; they may differ by a "
            "factor of "
            f"{CONTRAST:.0e}. Check the units."
        )


def _as_layers(layers: Iterable[object]) -> tuple[AnyLayer, ...]:
    if isinstance(layers, AnyLayer):
        raise TypeError("Medium.layers is one layer; give a list, also of one: Medium([layer], base=...).")
    try:
        checked = tuple(islice(layers, LAYERS + 1))
    except TypeError:
        raise TypeError(f"Medium.layers = {shown(layers)} must be a list of layers. {ORDER}") from None
    if len(checked) > LAYERS:
        raise BadValue(
            "Medium.layers", "", f"has more than {LAYERS} layers; give the grading of many thin ones as a GradedLayer."
        )
    found: list[AnyLayer] = []
    for i, layer in enumerate(checked):
        if not isinstance(layer, AnyLayer):
            raise TypeError(
                f"Medium.layers[{i}] = {shown(layer)} must be a Layer, a GradedLayer or a TransverselyIsotropicLayer. {ORDER}"
            )
        found.append(layer)
    return tuple(found)
