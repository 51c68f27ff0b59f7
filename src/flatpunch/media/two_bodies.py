"""Two elastic bodies pressed together: in the contact their surface displacements add."""

from __future__ import annotations

from dataclasses import dataclass

from flatpunch._support.checks import shown
from flatpunch._support.readable import Table, readable, table_of
from flatpunch.media.graded import CONTRAST
from flatpunch.media.power_law import PowerLawHalfSpace
from flatpunch.media.stack import Body, Stack


@readable
@dataclass(frozen=True, slots=True)
class TwoBodies(Body):
    """Two elastic bodies in contact; the gap between them is the indenter's, whichever of them is curved.

    Parameters
    ----------
    upper, lower : Medium, HalfSpace, TransverselyIsotropicHalfSpace, PowerLawHalfSpace or RigidBase
        The bodies, each described from its own contact surface inwards. One may be rigid. A power-law half-space goes with a
        rigid body, or with another one of the same exponent: their sum is again one of that exponent, which no other sum is.

    See Also
    --------
    Medium : Each of the two bodies may be one.
    indent : Press them together.

    Examples
    --------
    >>> steel = fp.HalfSpace(young=210e9, poisson=0.3)
    >>> pair = fp.TwoBodies(steel, steel)
    >>> print(f"{pair.surface_modulus / steel.surface_modulus:.3g}")
    0.5
    """

    upper: Stack
    lower: Stack

    def __post_init__(self) -> None:
        for name, body in self.sides:
            if not isinstance(body, Stack):
                raise TypeError(
                    f"TwoBodies.{name} = {shown(body)} must be a Medium, a HalfSpace, a PowerLawHalfSpace, or RigidBase() for a "
                    "rigid body."
                )
        if self.upper.rigid and self.lower.rigid:
            raise ValueError("TwoBodies.upper and TwoBodies.lower are both rigid, so nothing can deform.")
        exponents = {body.power_law.exponent if body.power_law else 0.0 for body in self.elastic}
        if len(exponents) > 1:
            raise ValueError(
                f"TwoBodies has bodies whose moduli grow with the exponents {sorted(exponents)} of depth. A power-law half-space "
                "pairs with one of its own exponent or with RigidBase(); give the other body's grading as GradedLayer."
            )

        moduli = [body.surface_modulus for body in self.elastic]
        if max(moduli) > CONTRAST * min(moduli):
            raise ValueError(
                f"TwoBodies has moduli of {moduli[0]:.3g} and {moduli[-1]:.3g} Pa; they may differ by a factor of "
                f"{CONTRAST:.0e}. Check the units; the far stiffer one is a RigidBase()."
            )

    def _table_(self) -> Table:
        """The rows of both bodies."""
        tables = [(name, table_of(body)) for name, body in self.sides]
        width = max(len(row) for _, table in tables for row in (table.header, *table.rows))
        rows: list[tuple[str, ...]] = []
        for name, table in tables:
            inside = [row for row in (table.header, *table.rows) if row] or [(table.title,)]
            rows += [(name if i == 0 else "", *row, *[""] * (width - len(row))) for i, row in enumerate(inside)]
        return Table("TwoBodies", (), tuple(rows))

    @property
    def sides(self) -> tuple[tuple[str, Stack], ...]:
        """Both bodies with their names."""
        return (("upper", self.upper), ("lower", self.lower))

    @property
    def varies(self) -> bool:
        """Whether the constants of one of them vary with depth."""
        return any(body.varies for body in self.elastic)

    @property
    def anisotropic(self) -> bool:
        """Whether one of them is transversely isotropic, at least in part."""
        return any(body.anisotropic for body in self.elastic)

    @property
    def power_law(self) -> PowerLawHalfSpace | None:
        """The first of them whose modulus is a power of depth."""
        return next((law for body in self.elastic if (law := body.power_law)), None)

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* of the pair [Pa], 1/E* = sum of both."""
        return 1 / sum(1 / body.surface_modulus for body in self.elastic)
