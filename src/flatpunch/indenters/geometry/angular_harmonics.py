"""Angular harmonics of an indenter, or of its logarithm, as functions of the radius."""

from __future__ import annotations

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, Indices
from flatpunch.indenters.geometry.angular_mean import AngularTable
from flatpunch.indenters.geometry.symmetry import rotational_symmetry
from flatpunch.indenters.profile import Indenter


class AngularHarmonics(AngularTable):
    """c_m(r) in f = <f> + sum Re(c_m exp(i m (phi - start))) and their derivatives; or of ln f in the place of f.

    Parameters
    ----------
    indenter : Indenter
        The tip; of the logarithm one with f > 0 away from the apex.
    count : int
        Number of orders m: the first so many multiples of the shape's rotational symmetry.
    logarithmic : bool
        Whether the harmonics are those of ln f.
    """

    extra_nodes = 64
    """Between the rings crossings turn by up to half a period, and high orders many times with them."""

    def __init__(self, indenter: Indenter, count: int, *, logarithmic: bool) -> None:
        self.orders: Indices = rotational_symmetry(indenter) * np.arange(1, count + 1)
        super().__init__(indenter, int(self.orders[-1]))
        self._logarithmic, self.start = logarithmic, self._rule.start

    def harmonics(self, r: Array) -> tuple[Array, Array]:
        """c_m of f [m] or ln f, and of its derivative by r, at radii r [m] of shape (...).

        Shape (..., 2 orders): real part and imaginary part of one order after the other.
        """
        value, rise = np.split(self.at(r), 2, axis=-1)
        return value, rise

    def integrals(self, f: Array, slope: Array, phi: Array, weights: Array) -> Array:
        """Amplitudes of height and slope, or of ln f and its derivative; each real part before its imaginary one."""
        if self._logarithmic:
            with np.errstate(divide="ignore", invalid="ignore"):
                f, slope = np.log(f), slope / f
        return np.hstack(self._amplitudes([f * weights, slope * weights], phi)).view(float)

    def _amplitudes(self, fields: list[Array], phi: Array) -> list[Array]:
        """2 sum of each field, shape (n, angles), times exp(-i m (phi - start)); shape (n, orders)."""
        turn = phi - self.start
        if phi.shape[0] == 1:
            wave = 2 * np.exp(-1j * turn[0][:, None] * self.orders)
            return [field @ wave for field in fields]
        # angles differ from radius to radius: wave after wave, each the one before turned once more
        first = np.exp(-1j * self.orders[0] * turn)
        wave, found = 2 * first, [np.empty((turn.shape[0], self.orders.size), dtype=complex) for _ in fields]
        for column in range(self.orders.size):
            for field, amplitudes in zip(fields, found, strict=True):
                amplitudes[:, column] = np.einsum("np,np->n", field, wave)
            wave *= first
        return found


@byte_cached
def angular_harmonics(indenter: Indenter, count: int, *, logarithmic: bool) -> AngularHarmonics:
    """The harmonics of an indenter; what is already tabulated is shared."""
    return AngularHarmonics(indenter, count, logarithmic=logarithmic)
