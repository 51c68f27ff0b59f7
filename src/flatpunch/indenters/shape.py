"""Bodies of revolution."""

from __future__ import annotations

from flatpunch.indenters.profile import Indenter


class RoundShape(Indenter):
    """Body of revolution: f depends on r alone."""

    __slots__ = ()

    @property
    def round(self) -> bool:
        """True."""
        return True
