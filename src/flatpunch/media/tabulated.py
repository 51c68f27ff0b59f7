"""A medium whose flat-punch solutions are read from a table instead of being computed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from flatpunch._support.checks import Array, Indices, shown
from flatpunch._support.readable import readable
from flatpunch.media.power_law import PowerLawHalfSpace
from flatpunch.media.stack import Body, Stack


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
    def power_law(self) -> PowerLawHalfSpace | None:
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
