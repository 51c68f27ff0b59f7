"""What layers and bases are made of: elastic constants at a depth, their derivatives, and faces of layers.

All that calculates with a layer or a base takes it as a `Material`: coefficients of plane strain at each depth. A kind of its own
derives from `Isotropic` or `Homogeneous`, or from `Material` where its constants vary, and as a layer from `AnyLayer` too. A face
sticks, slides, or yields like the springs of an `Interface`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol, Self

import numpy as np

from flatpunch._support.checks import Array, instance, shown
from flatpunch._support.declared import Checked, Number, a_length, a_pressure, a_ratio, a_stiffness
from flatpunch._support.prefixes import text
from flatpunch._support.readable import quantity_of, readable
from flatpunch.media.membrane import Membrane
from flatpunch.media.plane import (
    Plane,
    contact_modulus,
    exponent_slopes,
    exponents,
    in_plane,
    isotropic_plane,
    isotropic_slopes,
)

_HOW = (
    "True sticks to what lies below, False slides on it without friction, an Interface(normal=..., shear=...) yields."
)


@readable
@dataclass(frozen=True, slots=True)
class Interface(Checked):
    """Springs between the lower face of a layer and what lies below it, or a membrane on the latter, or both.

    Springs are a weak interphase, a glue, contact at asperities: the traction at the interface is the stiffness times the jump of
    the displacement across it, without lift-off. A thin interphase of thickness t has normal = C33/t and shear = G/t of its
    material. A membrane moves with the upper face of what lies below; the springs, or the slip, are between it and the layer.

    Parameters
    ----------
    normal : float, optional
        Traction per jump across the interface [Pa/m], > 0; by default it does not yield.
    shear : float, optional
        Traction per jump along it [Pa/m], >= 0; by default it does not yield. 0 slides.
    membrane : Membrane, optional
        Membrane that is bonded to what lies below the springs; by default there is none.

    Raises
    ------
    ValueError, TypeError
        If a stiffness is outside its range, or the membrane is none.

    See Also
    --------
    Layer, GradedLayer, TransverselyIsotropicLayer : Take one as `bonded`.

    Examples
    --------
    >>> glue = fp.Interface(normal=1e15, shear=3e14)
    >>> film = fp.Medium([fp.Layer(70e9, 0.22, thickness=5e-6, bonded=glue)], base=fp.HalfSpace(200e9, 0.3))
    >>> print(f"{float(fp.indent(film, fp.Sphere(50e-6), depth=1e-7).force[0]) * 1e3:.1f} mN")
    11.0 mN
    """

    normal: Annotated[float | None, a_stiffness("normal interface stiffness")] = None
    shear: Annotated[float | None, a_stiffness("shear interface stiffness", above=-inf, least=0.0)] = None
    membrane: Membrane | None = None

    def __post_init__(self) -> None:
        instance("Interface.membrane", self.membrane, (Membrane, type(None)), "a Membrane(tension=...), or None")
        for name in ("normal", "shear"):
            value = getattr(self, name)
            if isinstance(value, (float, np.floating)) and value == inf:
                object.__setattr__(self, name, None)
        Checked.__post_init__(self)

    def __bool__(self) -> bool:
        """Whether it carries shear; otherwise it slides."""
        return self.shear != 0

    @property
    def softness(self) -> tuple[float, float]:
        """Jumps along the interface and across it per traction [m/Pa]; infinite where it slides."""
        along, across = self.shear, self.normal
        return (0.0 if along is None else 1 / along if along else inf), (0.0 if across is None else 1 / across)


def lower_face(name: str, value: object) -> bool | Interface:
    """How the lower face of a layer is attached, checked."""
    if isinstance(value, Interface):
        return value
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} = {shown(value)} must be True, False or an Interface. {_HOW}")
    return bool(value)


def in_words(bonded: bool | Interface) -> str:
    """How a lower face is attached, for tables."""
    if not isinstance(bonded, Interface):
        return "bonded" if bonded else "slides"
    normal = "" if bonded.normal is None else f"normal {text(bonded.normal, 'Pa/m')}"
    shear = "" if bonded.shear is None else "slides" if bonded.shear == 0 else f"shear {text(bonded.shear, 'Pa/m')}"
    springs = "springs, " + ", ".join(each for each in (normal, shear) if each) if normal or shear else ""
    membrane = bonded.membrane.in_words() if bonded.membrane else ""
    return ", on ".join(each for each in (springs, membrane) if each) or "bonded"


ORDER = "Layers run from the free surface down; what lies below them all is the base."

YOUNG = a_pressure("Young's modulus")
POISSON = a_ratio(
    "Poisson ratio",
    above=-1.0,
    most=0.5,
    example="0.5",
    outside="must lie in -1 < poisson <= 0.5. 0.5 is incompressible and allowed; above it an isotropic body is unstable.",
)
Young = Annotated[float, YOUNG]
Poisson = Annotated[float, POISSON]
Thickness = Annotated[float, a_length("thickness", example="1.2 um", remedy=ORDER)]


class PowerLaw(Protocol):
    """A half-space whose Young's modulus is a power of depth, E(z) = modulus (z/depth)^exponent."""

    @property
    def modulus(self) -> float: ...  # noqa: D102

    @property
    def depth(self) -> float: ...  # noqa: D102

    @property
    def exponent(self) -> float: ...  # noqa: D102

    @property
    def poisson(self) -> float: ...  # noqa: D102

    @property
    def surface_modulus(self) -> float: ...  # noqa: D102

    @property
    def length(self) -> float: ...  # noqa: D102


class Part:
    """Properties of a layer, a base or a body, with the values that most have."""

    __slots__ = ()

    @property
    def rigid(self) -> bool:
        """Whether it does not deform."""
        return False

    @property
    def varies(self) -> bool:
        """Whether elastic constants vary with depth inside a layer."""
        return False

    @property
    def anisotropic(self) -> bool:
        """Whether it is transversely isotropic, at least in part."""
        return False

    @property
    def power_law(self) -> PowerLaw | None:
        """The half-space itself where the modulus is a power of depth."""
        return None

    @property
    def isotropic(self) -> tuple[float, float] | None:
        """Shear modulus [Pa] and Poisson ratio of isotropic material that does not vary."""
        return None


class Material(Part, Checked, ABC):
    """Elastic material of a layer or a half-space."""

    __slots__ = ()
    group: ClassVar[tuple[str, Number]] = ("surface_modulus", a_pressure("contact modulus"))
    """Property that stands for all moduli at their ratios, and what it is; where it is a field there is no group."""

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the elastic constants, by each of which `slopes_at` has the derivatives."""
        return ()

    @property
    def extent(self) -> float:
        """Depth to which it reaches [m]; infinite for a half-space."""
        return inf

    @property
    def breaks(self) -> tuple[float, ...]:
        """Depths inside at which a law of depth is not smooth [m]."""
        return ()

    @property
    def sampled_depths(self) -> Array:
        """Depths at which ranges of the moduli are sought [m]."""
        return np.array([0.0, self.extent])

    @abstractmethod
    def plane_at(self, z: Array) -> Plane[Array]:
        """Coefficients of plane strain at depths z below the upper face [m], of the shape of z."""

    @abstractmethod
    def slopes_at(self, z: Array) -> dict[str, Plane[Any]]:
        """Derivatives of the coefficients by each of `numbers`; of the shape of z, or numbers where nothing varies."""

    @abstractmethod
    def times(self, factor: float) -> Self:
        """The same with all moduli multiplied by a factor."""

    @abstractmethod
    def elasticity(self) -> tuple[str, str]:
        """Moduli and Poisson ratios in words."""

    @property
    def plane(self) -> Plane[float]:
        """Coefficients of plane strain at the upper face."""
        return Plane(*(float(each[0]) for each in self.plane_at(np.zeros(1))))

    @property
    def rigidity(self) -> float:
        """Shear modulus along z at the upper face [Pa]."""
        return 1 / self.plane.shear

    @property
    def surface_modulus(self) -> float:
        """Contact modulus E* of the upper face [Pa]: a frictionless rigid punch of radius a has the stiffness 2 E* a."""
        return contact_modulus(self.plane)

    @property
    def softest(self) -> float:
        """Largest 1/E* over the depth [1/Pa]."""
        return 1 / self.surface_modulus

    def young_at(self, z: Array) -> Array:
        """Young's modulus along the surface at depths z [Pa]."""
        return in_plane(self.plane_at(z))[0]

    def surface_slope(self, name: str) -> float:
        """Derivative of ln E* of the upper face by one of `numbers`."""
        plane, change = self.plane, self.slopes_at(np.zeros(()))[name]
        s, d, _, _ = exponents(plane)
        of_s, of_d = exponent_slopes(plane, change)
        return float(change.stiffness / plane.stiffness - of_s / s - of_d / d)


class Homogeneous(Material):
    """Material that does not vary with depth: from its coefficients `plane`."""

    __slots__ = ()

    @property
    @abstractmethod
    def plane(self) -> Plane[float]:
        """Coefficients of plane strain."""

    def plane_at(self, z: Array) -> Plane[Array]:
        """Coefficients of plane strain, the same at all depths z, of the shape of z."""
        return Plane(*(np.full(np.shape(z), each) for each in self.plane))


class Isotropic(Homogeneous):
    """Isotropic material that does not vary: from `young` [Pa] and `poisson`, which are fields or follow from fields."""

    __slots__ = ()
    group = ("young", YOUNG)

    if TYPE_CHECKING:  # properties here would be taken for defaults of fields

        @property
        def young(self) -> float:
            """Young's modulus [Pa]."""

        @property
        def poisson(self) -> float:
            """Poisson ratio."""

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the elastic constants."""
        return ("young", "poisson")

    @property
    def isotropic(self) -> tuple[float, float]:
        """Shear modulus [Pa] and Poisson ratio."""
        return self.rigidity, self.poisson

    @property
    def plane(self) -> Plane[float]:
        """Coefficients of plane strain."""
        return isotropic_plane(self.young, self.poisson)

    def young_at(self, z: Array) -> Array:
        """Young's modulus at depths z [Pa]."""
        return np.full(np.shape(z), self.young)

    @property
    def rigidity(self) -> float:
        """Shear modulus [Pa]."""
        return self.young / (2 * (1 + self.poisson))

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* [Pa]."""
        return plane_strain_modulus(self.young, self.poisson)

    def slopes_at(self, z: Array) -> dict[str, Plane[Any]]:
        """Derivatives of the coefficients by each of `numbers`."""
        return isotropic_slopes(self.young, self.poisson)

    def surface_slope(self, name: str) -> float:
        """Derivative of ln E* by one of `numbers`."""
        return float(self.slopes_at(np.zeros(()))[name].stiffness / self.plane.stiffness)

    def elasticity(self) -> tuple[str, str]:
        """Young's modulus and Poisson ratio in words."""
        return quantity_of(self.young, "Pa"), quantity_of(self.poisson, "")


_FACES = {True: Interface(), False: Interface(shear=0.0)}


class AnyLayer(Material):
    """A layer of any kind: a material with a thickness [m] and a lower face."""

    __slots__ = ()

    if TYPE_CHECKING:

        @property
        def thickness(self) -> float:
            """Thickness [m]."""

        @property
        def bonded(self) -> bool | Interface:
            """Whether the lower face sticks to what lies below, slides on it, or yields like springs."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "bonded", lower_face(f"{type(self).__name__}.bonded", self.bonded))
        Checked.__post_init__(self)

    @property
    def extent(self) -> float:
        """The thickness [m]."""
        return self.thickness

    @property
    def face(self) -> Interface:
        """The lower face as springs: those of a bonded one do not yield, a sliding one has none along it."""
        return self.bonded if isinstance(self.bonded, Interface) else _FACES[self.bonded]


def young_and_poisson(part: Material) -> tuple[float, float]:
    """Young's modulus [Pa] and Poisson ratio of a layer or base that is isotropic and does not vary."""
    assert part.isotropic is not None
    return float(part.young_at(np.zeros(()))), part.isotropic[1]


def plane_strain_modulus(young: float, poisson: float) -> float:
    """Plane-strain modulus E* = E/(1 - nu^2) [Pa]."""
    return young / (1 - poisson**2)
