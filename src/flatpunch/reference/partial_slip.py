"""Partial slip of power-law tips on a homogeneous half-space: Cattaneo (1938), Mindlin (1949), Ciavarella (1998), Jaeger (1998).

The tip f = A r^n is pressed to the radius a, with the force F and the depth d, and pulled along the surface. With the coefficient
of friction mu, the stick radius c = s a and rho = (2 - nu)/(2 (1 - nu)) the traction is mu times the difference of two normal
contacts:

    T = mu F (1 - s^(n + 1)),      delta = mu rho d (1 - s^n),      dT/ddelta = 2 E* c/rho = 8 G c/(2 - nu).

See Also
--------
flatpunch.reference.half_space : The normal contacts.

Examples
--------
>>> from flatpunch.reference import partial_slip
>>> found = partial_slip.power_law_tip(0.5, exponent=2.0, force=1.0, depth=1.0, friction=0.3, poisson=0.3)
>>> print(f"{float(found.force):.4f}")
0.2625
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PartialSlip:
    """Force T [N], displacement delta [m], and energy lost in a cycle between +/- delta [J]; arrays of one shape."""

    force: Array
    displacement: Array
    energy: Array


def power_law_tip(
    stick: float | Array, *, exponent: float, force: float, depth: float, friction: float, poisson: float
) -> PartialSlip:
    """Contact with the stick radius over the contact radius `stick` in [0, 1].

    Parameters
    ----------
    stick : float or array
        s = c/a [-].
    exponent : float
        n of f = A r^n [-].
    force, depth : float
        Normal force F [N] and depth d [m].
    friction : float
        Coefficient of friction [-].
    poisson : float
        Poisson ratio [-].
    """
    s, n = np.asarray(stick, dtype=float), exponent
    ratio = (2 - poisson) / (2 * (1 - poisson))
    pulled, moved = friction * force * (1 - s ** (n + 1)), friction * ratio * depth * (1 - s**n)
    # int T ddelta, F ~ a^(n + 1) and d ~ a^n; a cycle follows it, twice as large (Masing)
    work = friction**2 * ratio * force * depth * ((1 - s**n) - n / (2 * n + 1) * (1 - s ** (2 * n + 1)))
    return PartialSlip(np.asarray(pulled), np.asarray(moved), np.asarray(8 * (work - pulled * moved / 2)))
