"""Bodies that an indenter can be pressed into: one stack of layers on a base, or two of them.

A half-space is a stack without layers, its own base. A rigid base is one that does not deform.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from math import inf
from typing import TYPE_CHECKING, Self

from flatpunch.media.material import AnyLayer, Material, Part


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
