"""Bodies that an indenter can be pressed into: one stack of layers on a base, or two of them.

A half-space is a stack without layers, its own base. A rigid base is one that does not deform. The flat punches of any body may
be read from a table instead of being computed.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Protocol, Self

from flatpunch._support.checks import Array, Indices, shown
from flatpunch._support.readable import readable
from flatpunch.media.material import AnyLayer, Material, Part, PowerLaw
from flatpunch.media.membrane import Membrane


class Body(Part, ABC):
    """What an indenter can be pressed into."""

    __slots__ = ()

    @property
    @abstractmethod
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* of the surface [Pa]; of two bodies 1/E* is the sum of both."""

    @property
    @abstractmethod
    def sides(self) -> tuple[tuple[str, Stack], ...]:
        """The bodies that meet in the contact, with the names of two: "upper" and "lower"."""

    @property
    def elastic(self) -> tuple[Stack, ...]:
        """Those that deform, upper first."""
        return tuple(body for _, body in self.sides if not body.rigid)

    @property
    def pair(self) -> bool:
        """Whether two bodies meet."""
        return len(self.sides) > 1

    @property
    def single(self) -> Stack | None:
        """The body itself where it is one stack that is held together."""
        return None

    @property
    def length(self) -> float:
        """Own length l [m], infinite without one: the upper body's, or the lower's if the upper has none."""
        lengths = [body.length for body in self.elastic]
        return lengths[0] if lengths[0] != inf else lengths[-1]

    @property
    def free(self) -> LooseBody | None:
        """The layer itself where it lies loosely and lifts off its base."""
        return None


class Stack(Body):
    """One body: layers, from none on, and what lies below them."""

    __slots__ = ()

    if TYPE_CHECKING:  # properties here would be taken for defaults of fields

        @property
        def layers(self) -> tuple[AnyLayer, ...]:
            """From the surface down."""

        @property
        def base(self) -> Base:
            """What lies below them."""

        @property
        def membrane(self) -> Membrane | None:
            """What lies on the surface."""

    @property
    def sides(self) -> tuple[tuple[str, Stack], ...]:
        """Itself, without a name."""
        return (("", self),)

    @property
    def single(self) -> Stack:
        """Itself."""
        return self

    @property
    def thickness(self) -> float:
        """Thickness of all layers together [m]."""
        return sum(layer.thickness for layer in self.layers)

    @property
    def parts(self) -> tuple[Material, ...]:
        """The layers from the surface down, and the base after them."""
        return (*self.layers, self.base)


class LooseBody(Body):
    """A layer that lies loosely on a base and lifts off around the contact."""

    __slots__ = ()

    if TYPE_CHECKING:  # properties here would be taken for defaults of fields

        @property
        def thickness(self) -> float:
            """Thickness of the layer [m]."""

        @property
        def base(self) -> Base:
            """What it lies on."""

    @property
    @abstractmethod
    def held_down(self) -> Stack:
        """The layer held down by its base, on which it slides."""


class Base(Material, Stack):
    """A stack without layers: what lies below others, or a half-space by itself."""

    __slots__ = ()
    layers = ()
    membrane = None

    @property
    def base(self) -> Self:
        """Itself."""
        return self

    @property
    def thickness(self) -> float:
        """Zero: it has no layers [m]."""
        return 0.0

    @property
    def length(self) -> float:
        """Own length l [m]: infinite, a half-space has none."""
        return inf


class PunchSolution(Protocol):
    """Flat punches of all radii beta, in units of the medium's length, on one medium; unit disc, modulus 1."""

    @property
    def error(self) -> float:
        """Bound of the relative error of stiffness and moments."""
        ...

    def covers(self, beta: Array) -> bool:
        """Whether all these radii are to be taken from here; raises if they should be and cannot."""
        ...

    def summary(self, beta: Array) -> str:
        """Where the flat punches of these radii come from, in one sentence."""
        ...

    def round(self, beta: Array) -> tuple[Array, Array, Array]:
        """Flat punch, edge and slope functionals of round contact, shape (n, terms) each."""
        ...

    def responds_to(self, exponent: float) -> bool:
        """Whether `edges` has indenters r^exponent psi(phi)."""
        ...

    def edges(self, beta: Array, orders: Indices, exponent: float) -> tuple[Array, Array]:
        """k_m and the edge strengths for r^exponent cos(m phi), shape (n, len(orders)) each."""
        ...


@readable
@dataclass(frozen=True, slots=True)
class TabulatedMedium(Body):
    """A medium and the table of its flat punches; made by `flatpunch.atlas.tabulated`.

    Attributes
    ----------
    medium : Medium
        The medium itself, for everything the table does not hold.
    solution : PunchSolution
        Its flat punches.
    """

    medium: Body
    solution: PunchSolution = field(repr=False)

    @property
    def sides(self) -> tuple[tuple[str, Stack], ...]:
        """Those of the medium."""
        return self.medium.sides

    @property
    def varies(self) -> bool:
        """As the medium."""
        return self.medium.varies

    @property
    def anisotropic(self) -> bool:
        """As the medium."""
        return self.medium.anisotropic

    @property
    def power_law(self) -> PowerLaw | None:
        """As the medium."""
        return self.medium.power_law

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* of the surface [Pa]."""
        return self.medium.surface_modulus

    @property
    def length(self) -> float:
        """Own length l [m]."""
        return self.medium.length

    @property
    def recorded(self) -> Body:
        """What a result file says was solved."""
        return self.medium


def underlying(medium: object) -> Body:
    """The medium itself where its solutions are tabulated, any other as it is; what is no medium is refused."""
    if not isinstance(medium, Body) or medium.rigid:
        raise TypeError(
            f"medium = {shown(medium)} must be a Medium, a half-space or TwoBodies. Layers alone are no "
            "medium: Medium([layer, ...], base=...) says what lies below them."
        )
    return medium.medium if isinstance(medium, TabulatedMedium) else medium
