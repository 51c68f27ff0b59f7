"""Homogeneous layers, bases, and the stack made of layers of all kinds.

z points into the material, the free surface is z = 0, and layers are listed from the surface down. All objects
are frozen, validated once, and hashable, so that solutions can be cached by the medium they belong to.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice

from flatpunch._support.ceilings import LAYERS
from flatpunch._support.checks import BadValue, poisson_ratio, positive, shown
from flatpunch._support.prefixes import text
from flatpunch._support.readable import Table, quantity_of, readable
from flatpunch.media.graded import CONTRAST, GradedLayer
from flatpunch.media.interface import Interface, in_words, lower_face
from flatpunch.media.transverse import (
    TransverselyIsotropicHalfSpace,
    TransverselyIsotropicLayer,
    constants_of,
    summary,
)

_ORDER = "Layers run from the free surface down; what lies below them all is the base."


def plane_strain_modulus(young: float, poisson: float) -> float:
    """Plane-strain modulus E* = E/(1 - nu^2) [Pa]."""
    return young / (1 - poisson**2)


@readable
@dataclass(frozen=True, slots=True)
class Layer:
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

    young: float
    poisson: float
    thickness: float
    bonded: bool | Interface = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "young", positive("Layer.young", self.young, unit="Pa"))
        object.__setattr__(self, "poisson", poisson_ratio("Layer.poisson", self.poisson))
        object.__setattr__(self, "thickness", positive("Layer.thickness", self.thickness, _ORDER, unit="m"))
        object.__setattr__(self, "bonded", lower_face("Layer.bonded", self.bonded))

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* at the upper face [Pa]."""
        return plane_strain_modulus(self.young, self.poisson)


@readable
@dataclass(frozen=True, slots=True)
class HalfSpace:
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

    young: float
    poisson: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "young", positive("HalfSpace.young", self.young, unit="Pa"))
        object.__setattr__(self, "poisson", poisson_ratio("HalfSpace.poisson", self.poisson))

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* [Pa]."""
        return plane_strain_modulus(self.young, self.poisson)

    @property
    def length(self) -> float:
        """Own length l [m]: infinite, a half-space has none."""
        return float("inf")


@readable
@dataclass(frozen=True, slots=True)
class RigidBase:
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


AnyLayer = Layer | GradedLayer | TransverselyIsotropicLayer

ElasticBase = HalfSpace | TransverselyIsotropicHalfSpace


@readable
@dataclass(frozen=True, slots=True)
class Medium:
    """Stack of layers on a base.

    Parameters
    ----------
    layers : sequence of Layer, GradedLayer and TransverselyIsotropicLayer
        From the free surface down. Empty only on an elastic base.
    base : HalfSpace, TransverselyIsotropicHalfSpace or RigidBase
        What lies below the lowest layer.

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
    base: ElasticBase | RigidBase

    def __init__(self, layers: Iterable[AnyLayer] = (), base: ElasticBase | RigidBase | None = None) -> None:
        object.__setattr__(self, "layers", _as_layers(layers))
        object.__setattr__(self, "base", base)
        if not isinstance(base, (HalfSpace, TransverselyIsotropicHalfSpace, RigidBase)):
            raise TypeError(
                f"Medium.base = {shown(base)} must be HalfSpace(young=..., poisson=...), a TransverselyIsotropicHalfSpace or "
                "RigidBase(): it is what lies below all layers."
            )
        _check_contrast(self.layers, base)
        if not self.layers and isinstance(base, RigidBase):
            raise ValueError(
                "Medium.layers is empty on a rigid base, so nothing can deform. "
                "Add a Layer, or use a HalfSpace as base."
            )

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* of the material at z = 0 [Pa]."""
        top = self.layers[0] if self.layers else self.base
        assert not isinstance(top, RigidBase)
        return top.surface_modulus

    @property
    def length(self) -> float:
        """Own length l [m] with beta = a/l: thickness of the top layer, infinite without layers."""
        return self.layers[0].thickness if self.layers else float("inf")

    @property
    def thickness(self) -> float:
        """Thickness of all layers together [m]."""
        return sum(layer.thickness for layer in self.layers)

    def _table_(self) -> Table:
        """A row for each layer, from the surface down."""
        rows = [
            (f"layer {i + 1}", *_elasticity(layer), quantity_of(layer.thickness, "m"), in_words(layer.bonded))
            for i, layer in enumerate(self.layers)
        ]
        if isinstance(self.base, RigidBase):
            rows.append(("base", "rigid", "", "", ""))
        else:
            rows.append(("base", *_elasticity(self.base), "half-space", ""))
        return Table("Medium, from the surface down", ("", "young", "poisson", "thickness", "lower face"), tuple(rows))


def _elasticity(body: AnyLayer | ElasticBase) -> tuple[str, str]:
    """Modulus and Poisson ratio of a layer or base, as text."""
    if isinstance(body, (TransverselyIsotropicLayer, TransverselyIsotropicHalfSpace)):
        return summary(constants_of(body))
    if isinstance(body, GradedLayer) and body.anisotropic:
        return summary([getattr(body, name) for name in body.laws])
    return quantity_of(body.young, "Pa"), quantity_of(body.poisson, "")


def _check_contrast(layers: tuple[AnyLayer, ...], base: ElasticBase | RigidBase) -> None:
    """Refuse stacks whose moduli or thicknesses differ by more than floating point resolves."""
    moduli = [layer.surface_modulus for layer in layers] + (
        [] if isinstance(base, RigidBase) else [base.surface_modulus]
    )
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
        raise TypeError(f"Medium.layers = {shown(layers)} must be a list of layers. {_ORDER}") from None
    if len(checked) > LAYERS:
        raise BadValue(
            "Medium.layers", "", f"has more than {LAYERS} layers; give the grading of many thin ones as a GradedLayer."
        )
    found: list[AnyLayer] = []
    for i, layer in enumerate(checked):
        if not isinstance(layer, AnyLayer):
            raise TypeError(
                f"Medium.layers[{i}] = {shown(layer)} must be a Layer, a GradedLayer or a TransverselyIsotropicLayer. {_ORDER}"
            )
        found.append(layer)
    return tuple(found)
