"""Half-space whose modulus is a power of depth, E(z) = modulus (z/depth)^exponent."""

from __future__ import annotations

from dataclasses import dataclass

from flatpunch._support.checks import BadValue, poisson_ratio, positive, real
from flatpunch._support.readable import readable


@readable
@dataclass(frozen=True, slots=True)
class PowerLawHalfSpace:
    """Half-space with Young's modulus E(z) = modulus (z/depth)^exponent.

    Parameters
    ----------
    modulus : float
        Young's modulus at z = depth [Pa], > 0.
    depth : float
        Reference depth [m], > 0; the medium's own length l.
    exponent : float
        k of the grading [-], -0.5 < exponent < 1; 1 is allowed for poisson = 0.5 only (the Gibson soil).
    poisson : float
        Poisson ratio nu [-], -1 < poisson <= 0.5. For these exponents every such value leaves the exponents of
        the decaying fields real, (1 + k)(1 - k nu/(1 - nu)) >= 0.

    See Also
    --------
    PowerModulus : The same law in a layer.
    HalfSpace : The homogeneous body.

    Examples
    --------
    >>> fp.PowerLawHalfSpace(modulus=1e9, depth=1e-6, exponent=0.3, poisson=0.3)
    PowerLawHalfSpace(modulus=1e+09, depth=1e-06, exponent=0.3, poisson=0.3)
    """

    modulus: float
    depth: float
    exponent: float
    poisson: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "modulus", positive("PowerLawHalfSpace.modulus", self.modulus, unit="Pa"))
        object.__setattr__(self, "depth", positive("PowerLawHalfSpace.depth", self.depth, unit="m"))
        k = real("PowerLawHalfSpace.exponent", self.exponent, "1")
        nu = poisson_ratio("PowerLawHalfSpace.poisson", self.poisson)
        object.__setattr__(self, "exponent", k)
        object.__setattr__(self, "poisson", nu)
        if k == 1 and nu == 0.5:
            return
        if not -0.5 < k < 1:
            raise BadValue(
                "PowerLawHalfSpace.exponent",
                repr(k),
                "must lie in -0.5 < exponent < 1 (or be 1 with poisson = 0.5, the Gibson soil). From 1 on a point "
                "load sinks in without bound; give such a body a GradedLayer with a modulus > 0 at z = 0.",
            )

    @property
    def surface_modulus(self) -> float:
        """E* = modulus/(1 - nu^2) [Pa], the convention of this medium."""
        return self.modulus / (1 - self.poisson**2)

    @property
    def length(self) -> float:
        """Own length l [m]: the reference depth."""
        return self.depth
