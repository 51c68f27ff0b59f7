"""What an indenter is to the contact theory: the gap f(r, phi) at first touch and its slope.

f >= 0 is measured from the surface upwards in polar coordinates about the point of first touch, f(0) = 0. Concrete indenters are
frozen dataclasses. All derive from `Indenter`, which has the members of an idealised smooth shape, and define only what differs;
so does an indenter of your own. Power-law shapes, those with an `exponent`, also have `angular(phi)`, their psi.

A member that is a field in a concrete class needs `field()` or a value of its own there: `dataclass` would take the inherited
property of that name as the default of the field.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from operator import attrgetter
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from flatpunch._support.checks import Array, shown
from flatpunch._support.declared import Checked
from flatpunch.indenters._common import power


class Indenter(Checked, ABC):
    """Rigid, smooth, frictionless indenter.

    A shape of your own derives from it and defines `height` and `slope`, and of the other members those that differ from the ones
    of an idealised smooth shape that rises from its apex. Equal indenters share what has been computed for them, so they are
    hashable.

    See Also
    --------
    flatpunch.HeightMap, flatpunch.RadialProfile : Shapes given by numbers.
    flatpunch.plot_tip : The picture of any indenter.

    Examples
    --------
    >>> isinstance(fp.Sphere(radius=1e-6), fp.indenters.Indenter)
    True
    """

    __slots__ = ()

    @abstractmethod
    def height(self, r: Array, phi: Array) -> Array:
        """Gap f(r, phi) [m] at radii r [m] and polar angles phi [rad], broadcast together."""

    @abstractmethod
    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""

    @property
    def exponent(self) -> float | None:
        """Exponent n of a power-law shape f = r^n psi(phi); None for every other shape."""
        return None

    @property
    def reach(self) -> float:
        """Largest radius at which the shape is defined [m]; infinite for the idealised ones."""
        return float("inf")

    @property
    def flat(self) -> bool:
        """Whether the whole end is flat: the contact has the radius `reach` at every depth."""
        return False

    @property
    def corners(self) -> tuple[float, ...]:
        """Polar angles in [0, 2 pi) at which f has an edge, ascending; empty for smooth outlines."""
        return ()

    @property
    def rings(self) -> tuple[float, ...]:
        """Radii > 0 at which the slope df/dr or the curvature jumps [m], in some directions at least; empty for most shapes."""
        return ()

    @property
    def round(self) -> bool:
        """Whether f depends on r alone."""
        return False

    @property
    def seams(self) -> tuple[float, ...]:
        """Polar angles at which pieces are joined without an edge [rad]; quadrature over the angle is split there."""
        return ()

    @property
    def rounded_edges(self) -> tuple[float, ...]:
        """Polar angles of rounded edges [rad], along which the contact is drawn out as along `corners`."""
        return ()

    @property
    def tabulated(self) -> bool:
        """Whether the shape goes through the points of a table; quadrature along the radius takes more points then."""
        return False

    @property
    def angular_tolerance(self) -> float:
        """Relative change of means over the angle below which more angles do not help [-].

        Not zero where kinks are neither along rays nor on circles about the apex (the border of a square flat, the rounding of an
        edge).
        """
        return 0.0

    @property
    def scales(self) -> tuple[float, ...]:
        """Radii at which such kinks begin and end [m], at which means over the angle are checked.

        `rings` then has the smallest and the largest distance of such a kink from the axis, and others at which it turns.
        """
        return ()

    @property
    def crossings(self) -> Callable[[Array], Array] | None:
        """Polar angles at which circles of radii r, shape (n,), cross such kinks, as a function of r, or None.

        It returns shape (n, k), NaN where a circle has fewer. Means over the angle are then exact to rounding.
        """
        return None

    def reach_along(self, phi: Array) -> Array:
        """Largest radius in the directions phi [m], of the shape of phi; at least `reach`.

        Only boundary elements use it; the other methods, whose contacts are round to first order, end at `reach`.
        """
        return np.broadcast_to(self.reach, np.shape(phi))

    def height_and_slope(self, r: Array, phi: Array) -> tuple[Array, Array]:
        """Gap [m] and its radial derivative, broadcast together."""
        return np.asarray(self.height(r, phi)), np.asarray(self.slope(r, phi))

    @property
    def rising(self) -> bool:
        """Whether f rises from the apex in every direction, within `reach`, so that contacts have outlines a(phi).

        Only boundary elements solve contacts of other shapes (several summits, flat tops, noise).
        """
        return True

    @property
    def why_not_rising(self) -> str:
        """Where it does not rise, and what does, for refusals."""
        return type(self).__name__

    @property
    def elsewhere(self) -> float:
        """Height of the lowest part of the tip that does not belong to the apex and lies beyond `reach` [m]."""
        return float("inf")

    @property
    def has_parts(self) -> bool:
        """Whether it may touch elsewhere than about its apex."""
        return not self.rising or bool(np.isfinite(self.elsewhere))

    def box(self, depth: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Half-widths and centre of the box along x and y around all that is lower than a depth [m].

        Needed where `has_parts`; the whole tip about its apex, if a shape does not define it.
        """
        return (self.reach, self.reach), (0.0, 0.0)

    @property
    def cut(self) -> bool:
        """Whether the shape ends because it was not measured farther; contacts that reach the end are not valid then."""
        return False

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks on the shape, which results carry."""
        return ()

    @property
    def split_angles(self) -> list[float]:
        """Polar angles at which quadrature over the angle is split [rad]: `corners` and `seams`."""
        return sorted({*self.corners, *self.seams})


def check_indenter(indenter: object, name: str = "indenter") -> Indenter:
    """The indenter itself; what is none is refused."""
    if not isinstance(indenter, Indenter) or type(indenter).__hash__ is None:
        raise TypeError(
            f"{name} = {shown(indenter)} must be an indenter such as Paraboloid(radius=...) or Pyramid(sides=..., "
            "inclination=...). A shape of your own derives from flatpunch.indenters.Indenter and is hashable."
        )
    return indenter


Shape = TypeVar("Shape", bound=type[Indenter])


def as_of(part: str, names: str) -> Callable[[Shape], Shape]:
    """Class decorator of tips made of another one, the field `part`: members of these names are those of that tip."""

    def made(kind: Shape) -> Shape:
        for name in names.split():
            setattr(kind, name, property(attrgetter(f"{part}.{name}"), doc=getattr(Indenter, name).__doc__))
        return kind

    return made


class NotRising(ValueError):
    """What was asked needs a tip that rises from one apex; the message says where this one does not."""


def check_rising(indenter: Indenter) -> None:
    """Refuse indenters that only boundary elements solve."""
    if not indenter.rising:
        raise NotRising(indenter.why_not_rising)


class PowerLawShape(Indenter):
    """Shape f = r^n psi(phi), n its `exponent`: every level line has the same form."""

    __slots__ = ()

    if TYPE_CHECKING:  # a field of one class, a method of others

        @property
        def angular(self) -> Callable[[Array], Array]:
            """psi(phi) [m^(1-n)], in the shape of phi [rad]."""

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        assert self.exponent is not None
        return np.asarray(power(r, self.exponent) * self.angular(phi))

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        assert self.exponent is not None
        return np.asarray(self.exponent * power(r, self.exponent - 1) * self.angular(phi))


class RoundShape(Indenter):
    """Body of revolution: f depends on r alone."""

    __slots__ = ()

    round = True
