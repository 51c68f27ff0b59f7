"""Angular asymmetry u(phi) of a power-law indenter and the operators that act on its harmonics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.indenters.geometry.angles import angular_rule
from flatpunch.indenters.geometry.features import rotational_symmetry
from flatpunch.indenters.profile import Indenter


@dataclass(frozen=True, slots=True)
class Angles:
    """One period of a profile psi(phi) in the variable of the expansion.

    Attributes
    ----------
    u : ndarray, shape (points,)
        ((psi/C)^lam - 1)/lam at equal steps from `start` over one period.
    orders : ndarray of int, shape (points/2,)
        Harmonics m that its Fourier coefficients belong to.
    start : float
        First angle [rad].
    mean : float
        Reference C [m^(1-n)], for which <u> = 0.
    c2, c3, c4 : float
        Coefficients of psi/C - 1 = u + c2 u^2 + c3 u^3 + c4 u^4 + ...
    """

    u: Array
    orders: Indices
    start: float
    mean: float
    c2: float
    c3: float
    c4: float

    def waves(self, phi: Array) -> Array:
        """Harmonics of -u at angles phi, shape (orders, p): weighted by R they add up to w."""
        spectrum = np.fft.rfft(self.u) / self.u.size
        # the highest frequency of the grid has no partner
        spectrum[1:-1] *= 2
        return np.asarray(-np.real(spectrum[1:, None] * np.exp(1j * np.outer(self.orders, phi - self.start))))


def act(weights: Array, field: Array) -> Array:
    """Multiply the harmonics m > 0 of angular fields by weights, shape (nb, orders); the mean goes to zero."""
    spectrum = np.fft.rfft(field)
    weighted = np.zeros((weights.shape[0], spectrum.shape[-1]), dtype=complex)
    weighted[:, 1:] = weights * spectrum[..., 1:]
    return np.asarray(np.fft.irfft(weighted, n=field.shape[-1], axis=-1))


def expand(indenter: Indenter, lam: float) -> Angles:
    """Profile psi(phi) of a power-law indenter as one period of the variable u."""
    phi, weights = angular_rule(indenter)
    psi = _angular(indenter, phi)
    mean = float(np.exp(weights @ np.log(psi)) if lam == 0 else (weights @ psi**lam) ** (1 / lam))
    fold = rotational_symmetry(indenter)
    start = indenter.corners[0] if indenter.corners else 0.0
    # points on one period of a kinked outline: its harmonics fall like 1/m^2, which leaves 1e-7 of the force
    points = 2048
    while True:
        grid = start + 2 * np.pi / fold * np.arange(points) / points
        ratio = _angular(indenter, grid) / mean
        u = np.log(ratio) if lam == 0 else (ratio**lam - 1) / lam
        spectrum = np.abs(np.fft.rfft(u))
        # products of four fields must fit on the grid
        if points <= 128 or spectrum[points // 16 :].max() > 1e-15 * max(spectrum.max(), 1e-15):
            break
        points //= 2
    c2 = (1 - lam) / 2
    c3 = c2 * (1 - 2 * lam) / 3
    return Angles(u - u.mean(), fold * np.arange(1, points // 2 + 1), start, mean, c2, c3, c3 * (1 - 3 * lam) / 4)


def _angular(indenter: Indenter, phi: Array) -> Array:
    return np.asarray(indenter.height(np.ones_like(phi), phi))
