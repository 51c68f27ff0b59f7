"""One function turns a medium into the kernel that punch, contact and boundary elements use.

C(k) = 2 L(k l)/(E* k) with E* the plane-strain modulus at the surface, l the medium's own length and L -> 1 for short waves.
Solvers work with the remainder L - 1, which vanishes at short waves: exponentially under homogeneous layers, like
tail/(k l) where the modulus varies at the surface itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from flatpunch._validation import Array, values
from flatpunch.compliance.layered import SATURATION, layered_response
from flatpunch.media import HalfSpace, Medium


@dataclass(frozen=True, eq=False)
class Kernel:
    """Surface compliance of one medium (or of two bodies pressed together).

    Parameters
    ----------
    modulus : float
        Plane-strain modulus E* of the surface [Pa].
    length : float
        Own length l [m]; infinite when L = 1 everywhere.
    response : callable
        kappa = k l, shape (n,) -> L, shape (n,) [-].
    tail : float
        L - 1 -> tail/kappa at short waves; zero under homogeneous layers.
    cutoff : float
        kappa above which L - 1 - tail/kappa is below rounding.
    floor : float
        kappa below which L is smooth on the scale of kappa itself.
    """

    modulus: float
    length: float
    response: Callable[[Array], Array]
    tail: float = 0.0
    cutoff: float = SATURATION
    floor: float = 1e-3
    cache: dict[object, object] = field(default_factory=dict, repr=False)

    @property
    def homogeneous(self) -> bool:
        """Whether the medium is a homogeneous half-space, with no length of its own."""
        return not np.isfinite(self.length)

    def remainder(self, kappa: Array) -> Array:
        """L - 1 at kappa = k l."""
        return self.response(kappa) - 1.0

    def __call__(self, k: float | Array) -> Array:
        """Compliance C(k) = u(k)/p(k).

        Parameters
        ----------
        k : float or array, shape (n,)
            Wavenumbers [1/m], > 0.

        Returns
        -------
        ndarray, shape (n,)
            C(k) [m/Pa]: inward displacement per pressure of the same wavenumber.
        """
        k = values("k", k, strict=True)
        kappa = k * self.length if not self.homogeneous else k
        return np.asarray(2 * self.response(kappa) / (self.modulus * k))


@lru_cache(maxsize=256)
def compliance(medium: HalfSpace | Medium) -> Kernel:
    """Surface compliance of a medium.

    Parameters
    ----------
    medium : HalfSpace or Medium
        The body; equal media share one kernel and with it every solution already computed.

    Returns
    -------
    Kernel
        Callable: C(k) [m/Pa] at wavenumbers k [1/m].
    """
    if isinstance(medium, HalfSpace) or (isinstance(medium, Medium) and not medium.layers):
        return Kernel(modulus=medium.surface_modulus, length=float("inf"), response=np.ones_like)
    if isinstance(medium, Medium):
        return _stack(medium)
    raise TypeError(f"medium = {medium!r} must be a Medium or a HalfSpace.")


def _stack(medium: Medium) -> Kernel:
    length = medium.length
    moduli = [layer.surface_modulus for layer in medium.layers]
    if isinstance(medium.base, HalfSpace):
        moduli.append(medium.base.surface_modulus)
    # below this kappa even the longest length of the stack, thickness times modulus ratio, is short
    floor = 1e-3 * (length / medium.thickness) * (min(moduli) / max(moduli))
    return Kernel(
        modulus=medium.surface_modulus,
        length=length,
        response=lambda kappa: layered_response(medium, kappa / length),
        floor=floor,
    )
