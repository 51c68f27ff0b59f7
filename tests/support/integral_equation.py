"""Punch and round contacts a second way: collocation of the integral equation in real space, for stacks of any layers.

    q(t) + (1/pi) int_-1^1 M(t - s) q(s) ds = g(t),      M(t) = int_0^inf (L - 1)(x/beta) cos(xt) dx

With g = 1: Kbar = int_0^1 q dt and pi e = q(1); with g(t) = t int_0^t f'(r)/sqrt(t^2 - r^2) dr the pressure that follows the
profile f. Nothing is shared with the package: L comes from a recursion of its own at complex wavenumbers, where the integrand
of M decays instead of oscillating, and q is a polynomial on panels that shorten towards the rim, down to a part of the
thinnest layer. Errors below 1e-9 (change of the angle, of the panels and of their degree).
"""

from dataclasses import dataclass

import numpy as np

import flatpunch as fp

DEGREE = 14
ANGLE = 0.35


def response(medium, k):
    """L(k) of a stack of homogeneous layers at complex wavenumbers k, shape (n,).

    The flexibility of all below is carried up layer by layer, by the constants of two decaying and two growing solutions.
    """
    flexibility = np.zeros((k.size, 2, 2), dtype=complex)
    if isinstance(medium.base, fp.HalfSpace):
        decaying = _solutions(medium.base, k, np.zeros_like(k), -1)
        flexibility = decaying[:, :2] @ np.linalg.inv(decaying[:, 2:])
    for layer in reversed(medium.layers):
        x = k * layer.thickness
        x = x * np.minimum(1, 40 / x.real)
        decay, zero = np.exp(-x)[:, None, None], np.zeros_like(x)
        # growing solutions are measured from the lower face, decaying ones from the upper
        bottom = np.concatenate([_solutions(layer, k, x, -1) * decay, _solutions(layer, k, x, 1)], axis=2)
        top = np.concatenate([_solutions(layer, k, zero, -1), _solutions(layer, k, zero, 1) * decay], axis=2)
        if layer.bonded:
            rows = bottom[:, :2] - flexibility @ bottom[:, 2:]
        else:
            rows = np.stack(
                [bottom[:, 2] / k[:, None], bottom[:, 1] - flexibility[:, 1, 1, None] * bottom[:, 3]], axis=1
            )
        growing = -np.linalg.solve(rows[:, :, 2:], rows[:, :, :2])
        fields = top[:, :, :2] + top[:, :, 2:] @ growing
        flexibility = fields[:, :2] @ np.linalg.inv(fields[:, 2:])
    return -flexibility[:, 1, 1] * k * medium.surface_modulus / 2


def _solutions(body, k, x, sign):
    """(u_r, u_z, s_rz, s_zz) at depth x/k of the two solutions that go like exp(sign x), that factor left out; (n, 4, 2)."""
    stiff, c, one = k * body.young / (2 * (1 + body.poisson)), 3 - 4 * body.poisson, np.ones_like(x)
    plain = (one, -sign * one, 2 * sign * stiff, -2 * stiff)
    linear = (x, c - sign * x, stiff * (1 - c + 2 * sign * x), stiff * (sign * (1 + c) - 2 * x))
    return np.stack([np.stack(plain, axis=1), np.stack(linear, axis=1)], axis=2)


@dataclass(frozen=True)
class RealSpaceKernel:
    """M(t)/beta over z = t beta: Chebyshev pieces in ln z, constant below 1e-4 of the thinnest layer."""

    low: float
    high: float
    pieces: np.ndarray

    @classmethod
    def of(cls, medium, beta, shortest, angle=ANGLE):
        """Sampled for |t| <= 2; `shortest` is the thinnest layer over the medium's length."""
        low, high = 1e-4 * shortest, 2.2 * beta
        count = int(np.ceil(2 * np.log(high / low)))
        unit = np.cos(np.pi * (np.arange(DEGREE + 2) + 0.5) / (DEGREE + 2))
        edges = np.linspace(np.log(low), np.log(high), count + 1)
        z = np.exp((edges[:-1, None] + edges[1:, None]) / 2 + np.diff(edges)[:, None] / 2 * unit)
        turn = np.exp(1j * angle)
        ends = np.geomspace(1e-11 / beta, 40 / shortest, int(4 * np.log(4e12 * beta / shortest)))
        x, w = panels(np.append(0.0, ends))
        # far below k a = 1 L changes no more but by its first power, and its recursion is singular
        felt = np.maximum(x, 1e-8 / beta)
        remainder = (response(medium, felt * turn / medium.length) - 1) * w * turn
        values = np.stack([(np.exp(1j * x * turn * point) @ remainder).real for point in z.ravel()]).reshape(z.shape)
        return cls(np.log(low), np.log(high), np.polynomial.chebyshev.chebfit(unit, values.T, DEGREE + 1).T)

    def __call__(self, z):
        """Values at z >= 0, any shape."""
        s = np.clip(np.log(np.maximum(z, 1e-300)), self.low, self.high)
        place = (s - self.low) / (self.high - self.low) * len(self.pieces)
        piece = np.minimum(place.astype(int), len(self.pieces) - 1)
        t = 2 * (place - piece) - 1
        series, total, before, last = self.pieces[piece], np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
        for n in range(series.shape[-1] - 1, 0, -1):
            before, last = series[..., n] + 2 * t * before - last, before
        return total + series[..., 0] + t * before - last


def panels(edges, nodes=16):
    """Gauss nodes and weights on consecutive panels."""
    t, v = np.polynomial.legendre.leggauss(nodes)
    half = np.diff(edges)[:, None] / 2
    return ((edges[1:] + edges[:-1])[:, None] / 2 + half * t).ravel(), (half * v).ravel()


@dataclass(frozen=True)
class Solution:
    """Punch and round contacts on the unit disc, modulus 1."""

    kbar: float
    edge: float
    cone: tuple[float, float]
    paraboloid: tuple[float, float]


def solve(medium, radius, angle=ANGLE, finest=0.05):
    """Flat punch (Kbar, pi e) and, for f = r and f = r^2, depth and F/(2 E* a) of the round contact of a `radius`."""
    beta, thinnest = radius / medium.length, min(layer.thickness for layer in medium.layers)
    kernel = RealSpaceKernel.of(medium, beta, thinnest / medium.length, angle)
    # panels that halve towards the rim, and towards the tip of the cone
    steps = 0.5 ** np.arange(1, int(np.ceil(np.log2(max(radius / (finest * thinnest), 4.0)))) + 1)
    edges = np.concatenate([[0.0], steps[::-1], 1 - steps[1:], [1.0]])
    unit = np.polynomial.legendre.leggauss(DEGREE)[0]
    vandermonde = np.linalg.inv(np.polynomial.legendre.legvander(unit, DEGREE - 1))
    t, w = panels(edges, DEGREE)
    points = np.append(t, 1.0)
    rows = np.stack([_row(point, edges, kernel, beta, thinnest / radius, vandermonde) for point in points])
    right = np.stack([np.ones(t.size), np.pi / 2 * t, 2 * t**2], axis=1)
    q = np.linalg.solve(np.eye(t.size) + rows[:-1], right)
    # the equation itself at the rim
    rim = np.array([1.0, np.pi / 2, 2.0]) - rows[-1] @ q
    found = [(d := rim[i] / rim[0], float(w @ (d * q[:, 0] - q[:, i]))) for i in (1, 2)]
    return Solution(float(w @ q[:, 0]), float(rim[0]), *((float(d), force) for d, force in found))


def _row(point, edges, kernel, beta, thin, vandermonde):
    """(1/pi) int_0^1 (M(t - s) + M(t + s)) l_j(s) ds over all nodal polynomials l_j, shape (nodes,).

    Gauss panels that halve towards s = t down to a part of the thinnest layer.
    """
    steps = 0.5 ** np.arange(0, int(np.ceil(np.log2(20 / thin))) + 1)
    cuts = np.unique(np.concatenate([edges, point - steps, point + steps, [point]]))
    cuts = cuts[(cuts >= 0) & (cuts <= 1)]
    s, w = panels(cuts, 16)
    panel = np.clip(np.searchsorted(edges, s) - 1, 0, edges.size - 2)
    local = (2 * s - edges[panel] - edges[panel + 1]) / (edges[panel + 1] - edges[panel])
    basis = np.polynomial.legendre.legvander(local, DEGREE - 1) @ vandermonde
    weights = beta / np.pi * w * (kernel(beta * np.abs(point - s)) + kernel(beta * (point + s)))
    row = np.zeros((edges.size - 1, DEGREE))
    np.add.at(row, panel, weights[:, None] * basis)
    return row.ravel()
