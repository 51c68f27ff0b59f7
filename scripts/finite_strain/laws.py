"""Hyperelastic laws: the isochoric energy w(I) of the first invariant I = J^(-2/3) tr(F^T F), and the bulk term.

W = w(I) + p (J - 1) - p^2 / (2 kappa): mixed, with the pressure p as a field of its own. Stresses are over the shear modulus.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RR, RZ, ZR, ZZ, TT = range(5)
"""Components of the axisymmetric deformation gradient, in the order in which they are stored."""


class TooFar(ArithmeticError):
    """The deformation has no energy: an element turned inside out or beyond the limit stretch."""


@dataclass(frozen=True, slots=True)
class Law:
    """Neo-Hookean, or Gent where `limit` is finite.

    Parameters
    ----------
    poisson : float
        Poisson ratio at small strain, < 0.5.
    limit : float
        J_m, the value of I - 3 at which a Gent solid locks [-]. W = -mu J_m/2 ln(1 - (I - 3)/J_m); A. N. Gent (1996), Rubber
        Chem. Technol. 69, 59.
    """

    poisson: float
    limit: float = np.inf

    @property
    def bulk(self) -> float:
        """Bulk modulus over the shear modulus."""
        return 2 * (1 + self.poisson) / (3 * (1 - 2 * self.poisson))

    def slopes(self, invariant: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First and second derivative of w."""
        if not np.isfinite(self.limit):
            return np.full_like(invariant, 0.5), np.zeros_like(invariant)
        room = 1 - (invariant - 3) / self.limit
        if not (room > 0).all():
            raise TooFar("beyond the limit stretch")
        return 0.5 / room, 0.5 / (room**2 * self.limit)

    def stress(
        self, gradient: np.ndarray, pressure: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """First Piola stress (5, ...), its derivative (5, 5, ...), dJ/dF (5, ...) and J."""
        f = gradient
        plane = f[RR] * f[ZZ] - f[RZ] * f[ZR]
        volume = plane * f[TT]
        if not ((plane > 0) & (f[TT] > 0)).all():
            raise TooFar("an element turned inside out")
        # F^-T, and d(F^-T) = -F^-T dF^T F^-T as a matrix on the stored components
        inverse = np.stack([f[ZZ] / plane, -f[ZR] / plane, -f[RZ] / plane, f[RR] / plane, 1 / f[TT]])
        turn = np.zeros((5, 5, *volume.shape))
        place = {(0, 0): RR, (0, 1): RZ, (1, 0): ZR, (1, 1): ZZ}
        for (i, j), row in place.items():
            for (k, m), column in place.items():
                turn[row, column] = -inverse[place[i, m]] * inverse[place[k, j]]
        turn[TT, TT] = -(inverse[TT] ** 2)
        outer = inverse[:, None] * inverse[None]
        scale = volume ** (-2 / 3)
        square = (f**2).sum(axis=0)
        first = scale * (2 * f - 2 / 3 * square * inverse)  # dI/dF
        second = -2 / 3 * inverse[None] * first[:, None]
        second = second - scale * (4 / 3 * inverse[:, None] * f[None] + 2 / 3 * square * turn)
        second[np.arange(5), np.arange(5)] += 2 * scale
        slope, bend = self.slopes(scale * square)
        cofactor = volume * inverse
        stress = slope * first + pressure * cofactor
        tangent = slope * second + bend * first[:, None] * first[None] + pressure * volume * (outer + turn)
        return stress, tangent, cofactor, volume
