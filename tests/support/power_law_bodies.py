"""Bodies and tips that the perturbation tests share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import flatpunch as fp
from flatpunch.media import GradedLayer, LinearModulus, TwoBodies

HALF_SPACE = fp.HalfSpace(1.0, 0.3)
INCOMPRESSIBLE = fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase())
STIFF_FILM = fp.Medium([fp.Layer(5.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
GRADED = fp.Medium([GradedLayer(LinearModulus(1.0, 3.0, 1.0), 0.3, 1.0)], base=fp.HalfSpace(3.0, 0.3))
PAIR = TwoBodies(INCOMPRESSIBLE, fp.HalfSpace(4.0, 0.3))

MEDIA = {
    "half-space": HALF_SPACE,
    "incompressible": INCOMPRESSIBLE,
    "stiff-film": STIFF_FILM,
    "graded": GRADED,
    "pair": PAIR,
}


@dataclass(frozen=True)
class Disguised(fp.indenters.Indenter):
    """A tip that hides what it is: whether it is round, and whether it is a power law."""

    tip: Any
    exponent: float | None = None

    @property
    def reach(self) -> float:
        return self.tip.reach

    @property
    def corners(self) -> tuple[float, ...]:
        return self.tip.corners

    @property
    def rings(self) -> tuple[float, ...]:
        return self.tip.rings

    @property
    def round(self) -> bool:
        return False

    def angular(self, phi: Any) -> Any:
        return self.tip.angular(phi)

    def height(self, r: Any, phi: Any) -> Any:
        return self.tip.height(r, phi)

    def slope(self, r: Any, phi: Any) -> Any:
        return self.tip.slope(r, phi)
