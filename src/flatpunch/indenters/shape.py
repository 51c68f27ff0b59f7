"""Members that most shapes have in common: no power law, no end, no edges, no kinks.

Concrete indenters derive from `Shape` or `RoundShape` and define only what differs, and their height and slope. Neither has a
field or a place to keep one, so frozen dataclasses derived from them hold only their own fields.

A member that is a field in a concrete class needs `field()` or a value of its own there: `dataclass` would take the inherited
property of that name as the default of the field.
"""

from __future__ import annotations

from flatpunch._support.numbers import Checked


class Shape(Checked):
    """Idealised smooth shape: the members of `Indenter` that describe it, with the values that most shapes have."""

    __slots__ = ()

    @property
    def exponent(self) -> float | None:
        """None: no power law."""
        return None

    @property
    def reach(self) -> float:
        """Infinite: an idealised shape."""
        return float("inf")

    @property
    def corners(self) -> tuple[float, ...]:
        """No edges."""
        return ()

    @property
    def rings(self) -> tuple[float, ...]:
        """No kinks along a radius."""
        return ()

    @property
    def round(self) -> bool:
        """False: f depends on the angle."""
        return False


class RoundShape(Shape):
    """Body of revolution: f depends on r alone."""

    __slots__ = ()

    @property
    def round(self) -> bool:
        """True."""
        return True
