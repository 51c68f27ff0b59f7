"""A second road for round tips: collocation on rings, stepped in time with an active set.

It shares nothing with the package: neither flat punches nor an elastic curve. The compliance is 2 L/(E* k) with L in closed form.
A ring of uniform pressure is the difference of two discs, and under a disc of radius b the surface sinks by

    u(r) = (2b/E*) int L(kh) J1(kb) J0(kr)/k dk,

for L = 1 with complete elliptic integrals. With the elastic pressure e, u = G e, and the memories of a Prony series,
p = psi * de, every time step (e linear over it) is one contact problem for p: p >= 0 where u = d - f, u >= d - f where p = 0.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import hyp2f1, j0, j1


def bonded(kappa, poisson):
    """L of a layer bonded to a rigid base, for E* of the layer (docs/theory, page on the compliance)."""
    c = 3 - 4 * poisson
    return (c * np.sinh(kappa) * np.cosh(kappa) - kappa) / (c * np.cosh(kappa) ** 2 + kappa**2 + (1 - 2 * poisson) ** 2)


def under_discs(points, discs, layer=None):
    """u E* at points under unit pressure on discs; `layer` is (thickness, Poisson ratio), None a half-space."""
    r, b = points[:, None], discs[None, :]
    inside = r < b
    safe = np.where(b == 0, 1, b)
    u = np.where(
        inside,
        2 * b * hyp2f1(0.5, -0.5, 1, np.where(inside, r / safe, 0) ** 2),
        b**2 / r * hyp2f1(0.5, 0.5, 2, np.where(inside, 0, b / r) ** 2),
    )
    if layer is not None:
        thickness, poisson = layer
        # L - 1 ~ exp(-2 kh); panels short against the oscillations
        edges = np.linspace(0, 18 / thickness, 1 + int(np.ceil(18 / thickness * points.max() / 4)) + 18)
        t, weight = np.polynomial.legendre.leggauss(12)
        k = ((edges[1:] + edges[:-1])[:, None] / 2 + np.diff(edges)[:, None] / 2 * t).ravel()
        weight = (np.diff(edges)[:, None] / 2 * weight).ravel() * (bonded(k * thickness, poisson) - 1) / k
        u += 2 * b * (j0(np.outer(points, k)) @ (weight[:, None] * j1(np.outer(k, discs))))
    return u


@dataclass
class Rings:
    """Rings up to a radius, and the relaxation psi = constant + sum weights exp(-rates t)."""

    radius: float
    count: int
    modulus: float
    shape: object
    constant: float
    weights: np.ndarray
    rates: np.ndarray
    layer: tuple | None = None

    def __post_init__(self):
        edges = np.linspace(0, self.radius, self.count + 1)
        middle = (edges[1:] + edges[:-1]) / 2
        self.area = np.pi * np.diff(edges**2)
        self.height = self.shape(middle)
        self.influence = np.diff(under_discs(middle, edges, self.layer), axis=1) / self.modulus
        self.elastic = np.zeros(self.count)
        self.memory = np.zeros((self.rates.size, self.count))
        self.touching = np.zeros(self.count, dtype=bool)

    def step(self, depth, step):
        """Force and contact area at the end of a step; step = 0 is a jump."""
        z = step * self.rates
        gain = np.ones_like(z) if step == 0 else -np.expm1(-z) / z
        total = self.constant + gain @ self.weights
        left = self.memory * np.exp(-z)[:, None]
        held = self.constant * self.elastic + self.weights @ left
        wanted = depth - self.height
        rest = self.influence @ (self.elastic - held / total)
        active = self.touching
        for _ in range(200):
            pressure = np.zeros(self.count)
            rows = np.flatnonzero(active)
            pressure[rows] = total * np.linalg.solve(self.influence[np.ix_(rows, rows)], (wanted - rest)[rows])
            inside = wanted - rest - self.influence @ pressure / total
            better = np.where(active, pressure > 0, inside > 1e-12 * abs(wanted).max())
            if (better == active).all():
                break
            active = better
        else:
            raise RuntimeError("The active set does not settle.")
        change = (pressure - held) / total
        self.elastic = self.elastic + change
        self.memory = left + np.outer(gain, change)
        self.touching = active
        return pressure @ self.area, active @ self.area

    def follow(self, time, depth):
        """Force and area over time; a first depth above zero is a jump."""
        first = self.step(depth[0], 0.0) if depth[0] > 0 else (0.0, 0.0)
        rest = [self.step(d, h) for d, h in zip(depth[1:], np.diff(time), strict=True)]
        return np.array([first, *rest]).T
