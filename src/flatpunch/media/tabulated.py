"""A medium whose flat-punch solutions are read from a table instead of being computed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from flatpunch._support.checks import Array, Indices
from flatpunch._support.readable import readable
from flatpunch.media.bodies import ElasticBase, Medium
from flatpunch.media.power_law import PowerLawHalfSpace
from flatpunch.media.two_bodies import TwoBodies


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


Solid = ElasticBase | Medium | PowerLawHalfSpace | TwoBodies
"""Bodies whose solutions are computed."""


@readable
@dataclass(frozen=True, slots=True)
class TabulatedMedium:
    """A medium and the table of its flat punches; made by `flatpunch.atlas.tabulated`.

    Attributes
    ----------
    medium : Medium
        The medium itself, for everything the table does not hold.
    solution : PunchSolution
        Its flat punches.
    """

    medium: Solid
    solution: PunchSolution = field(repr=False)

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* of the surface [Pa]."""
        return self.medium.surface_modulus

    @property
    def length(self) -> float:
        """Own length l [m]."""
        return self.medium.length

    @property
    def recorded(self) -> Solid:
        """What a result file says was solved."""
        return self.medium


def underlying(medium: Solid | TabulatedMedium) -> Solid:
    """The medium itself where its solutions are tabulated; any other as it is."""
    return medium.medium if isinstance(medium, TabulatedMedium) else medium
