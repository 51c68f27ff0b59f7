"""Protocol of an indenter in the contact theory: the gap f(r, phi) at first touch and its slope.

f >= 0 is measured from the surface upwards in polar coordinates about the point of first touch, f(0) = 0. Concrete indenters are
frozen dataclasses, one per file, which inherit the members that most shapes have in common from `Shape` or `RoundShape`
(`shape`); an indenter of your own needs no base class.

Power-law shapes, those with an `exponent`, also have `angular(phi)`, their psi. All other members are optional:

- `seams` (): polar angles like `corners`, at which pieces are joined without an edge; quadrature over the angle is split there.
- `tabulated` (False): whether the shape goes through the points of a table; quadrature along the radius takes more points then.
- `angular_tolerance` (None): relative change of means over the angle below which more angles do not help, for kinks that are
  neither along rays nor on circles about the apex (the border of a square flat, the rounding of an edge).
- `scales` (): radii [m] at which such lines begin and end, at which these means are checked. `rings` then has the smallest and
  the largest distance of such a line from the axis, and others at which it turns.
- `crossings(r)` (None): polar angles at which circles of radii r, shape (n,), cross such lines, shape (n, k), NaN where
  they do not. Means over the angle are then exact to rounding.
- `rounded_edges` (): polar angles of rounded edges, along which the contact is drawn out as along `corners`.
- `reach_along(phi)` (`reach`): largest radius in each direction [m], where it exceeds `reach`. Only boundary elements use it;
  the other methods, whose contacts are round to first order, end at `reach`.
- `height_and_slope(r, phi)`: both from one calculation.
- `rising` (True): whether f rises from the apex in every direction, within `reach`. Contacts of other shapes (several summits,
  flat tops, noise) have no outline a(phi): only boundary elements solve them, and refusals show `why_not_rising`.
- `cut` (False): whether the shape ends because it was not measured farther; contacts that reach the end are not valid then.
- `elsewhere` (infinite): height of the lowest part of the tip that does not belong to the apex and lies beyond `reach` [m].
- `box(depth)`: half-widths and centre of the rectangle around all that is lower than a depth [m], for shapes that do not rise.
"""

from __future__ import annotations

from typing import Protocol, TypeGuard, runtime_checkable

import numpy as np

from flatpunch._support.checks import Array, shown


@runtime_checkable
class Indenter(Protocol):
    """Rigid, smooth, frictionless indenter.

    See Also
    --------
    flatpunch.HeightMap, flatpunch.RadialProfile : Shapes given by numbers.
    flatpunch.plot_tip : The picture of any indenter.

    Examples
    --------
    >>> isinstance(fp.Sphere(radius=1e-6), fp.indenters.Indenter)
    True
    """

    @property
    def exponent(self) -> float | None:
        """Exponent n of a power-law shape f = r^n psi(phi); None for every other shape."""

    @property
    def reach(self) -> float:
        """Largest radius at which the shape is defined [m]; infinite for the idealised ones."""

    @property
    def corners(self) -> tuple[float, ...]:
        """Polar angles in [0, 2 pi) at which f has an edge, ascending; empty for smooth outlines."""

    @property
    def rings(self) -> tuple[float, ...]:
        """Radii > 0 at which the slope df/dr or the curvature jumps [m], in some directions at least; empty for most shapes."""

    @property
    def round(self) -> bool:
        """Whether f depends on r alone."""

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f(r, phi) [m] at radii r [m] and polar angles phi [rad], broadcast together."""

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""

    def __hash__(self) -> int:
        """Equal indenters share what has been computed for them."""


def check_indenter(indenter: object, name: str = "indenter") -> Indenter:
    """The indenter itself; what is none is refused."""
    if isinstance(indenter, type) or not isinstance(indenter, Indenter):
        raise TypeError(
            f"{name} = {shown(indenter)} must be an indenter such as Paraboloid(radius=...) or Pyramid(sides=..., "
            "inclination=...)."
        )
    return indenter


def is_rising(indenter: Indenter) -> bool:
    """Whether an indenter rises from its apex in every direction, so that its contacts have outlines."""
    return bool(getattr(indenter, "rising", True))


class Boxed(Indenter, Protocol):
    """An indenter that knows the box of its overlap with the surface at a depth."""

    def box(self, depth: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Half-widths and centre of the box along x and y [m]."""


def has_parts(indenter: Indenter) -> TypeGuard[Boxed]:
    """Whether an indenter may touch elsewhere than about its apex."""
    return not is_rising(indenter) or bool(np.isfinite(getattr(indenter, "elsewhere", np.inf)))


class NotRising(ValueError):
    """What was asked needs a tip that rises from one apex; the message says where this one does not."""


def check_rising(indenter: Indenter) -> None:
    """Refuse indenters that only boundary elements solve."""
    if not is_rising(indenter):
        raise NotRising(f"{getattr(indenter, 'why_not_rising', type(indenter).__name__)}")


def height_and_slope(indenter: Indenter, r: Array, phi: Array) -> tuple[Array, Array]:
    """Gap [m] and its radial derivative [-], broadcast together."""
    both = getattr(indenter, "height_and_slope", None)
    if both is None:
        return np.asarray(indenter.height(r, phi)), np.asarray(indenter.slope(r, phi))
    f, slope = both(r, phi)
    return np.asarray(f), np.asarray(slope)


def reach_along(indenter: Indenter, phi: Array) -> Array:
    """Largest radius at which the shape is defined in the directions phi [m], of the shape of phi."""
    along = getattr(indenter, "reach_along", None)
    return np.broadcast_to(indenter.reach if along is None else along(phi), np.shape(phi))


def split_angles(indenter: Indenter) -> list[float]:
    """Polar angles at which quadrature over the angle is split [rad]: `corners` and, where the shape has them, `seams`."""
    return sorted({*indenter.corners, *getattr(indenter, "seams", ())})
