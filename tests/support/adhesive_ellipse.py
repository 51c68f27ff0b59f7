"""Bonded elliptic contact on a half-space in closed form: an independent judge of adhesion under elliptic paraboloids.

Pressures (c_0 + c_1 x^2 + c_2 y^2) (1 - x^2/A^2 - y^2/B^2)^(mu - 1) on the ellipse with semi-axes A, B press the surface into d
- alpha x^2 - beta y^2, mu = (1 + k)/2 on a half-space with E ~ z^k. With Hertz's integrals for (1 - ...)^mu, whose kernel is
distance^-(1 + k), and their derivatives by A and B the three coefficients follow. The energy U - pi A B w, made stationary over
A and B, gives the force at given depth. Real outlines are ellipses but for terms of second order, which enter the energy
squared.
"""

import numpy as np
from scipy.integrate import quad


def _hertz(a, b, k=0.0):
    """Coefficients (1, x^2, y^2) of the displacement under (1 - x^2/a^2 - y^2/b^2)^mu and their derivatives by a, b.

    E* = 1 for k = 0; otherwise up to a factor.
    """
    c = np.sqrt(a * b)

    def integral(p, q):
        # (1 - k) int s^-mu (a^2 + s)^(-1/2 - p) (b^2 + s)^(-1/2 - q) ds/2, smooth below and above s = c^2
        def decay(s):
            return (a * a + s) ** (-0.5 - p) * (b * b + s) ** (-0.5 - q)

        def near(v):
            return decay(c**2 * v ** (2 / (1 - k)))

        def far(u):
            s = c**2 * u ** (-2 / (1 + k))
            return (1 - k) / (1 + k) * s / c**2 * decay(s)

        return c ** (1 - k) * sum(quad(part, 0, 1, epsabs=0, epsrel=1e-13)[0] for part in (near, far))

    value, by_a, by_b = np.empty(3), np.empty(3), np.empty(3)
    for i, (p, q, sign) in enumerate([(0, 0, 1), (1, 0, -1), (0, 1, -1)]):
        here = integral(p, q)
        value[i] = sign * a * b * here
        by_a[i] = sign * (b * here - a * b * 2 * a * (0.5 + p) * integral(p + 1, q))
        by_b[i] = sign * (a * here - a * b * 2 * b * (0.5 + q) * integral(p, q + 1))
    return value, by_a, by_b


def force_and_energy(a, b, depth, alpha, beta, k=0.0, unit=1.0):
    """Force and elastic energy of the bonded ellipse; `unit` scales the displacements."""
    mu = (1 + k) / 2
    value, by_a, by_b = _hertz(a, b, k)
    matrix = (
        unit * np.array([value + (a * by_a + b * by_b) / (2 * mu), a**3 * by_a / (2 * mu), b**3 * by_b / (2 * mu)]).T
    )
    c = np.linalg.solve(matrix, [depth, -alpha, -beta])
    one = np.pi * a * b / mu
    fourth = one / (4 * (mu + 1) * (mu + 2))
    xx, yy, xy = 3 * fourth * a**4, 3 * fourth * b**4, fourth * a**2 * b**2
    x, y = one * a**2 / (2 * (mu + 1)), one * b**2 / (2 * (mu + 1))
    force = c @ [one, x, y]
    return force, (depth * force - alpha * (c @ [x, xx, xy]) - beta * (c @ [y, xy, yy])) / 2


def unit_of(stiffness, k):
    """Unit of displacement with which a round flat punch of radius 1 has this stiffness."""
    return force_and_energy(1 + 1e-9, 1.0, 1.0, 0.0, 0.0, k)[0] / stiffness


def adhesive_ellipse(depth, alpha, beta, work, guess, k=0.0, unit=1.0):
    """Force and semi-axes of the adhesive contact at given depth: Newton's method with differences in ln A, ln B."""

    def potential(z):
        return force_and_energy(*np.exp(z), depth, alpha, beta, k, unit)[1] - work * np.pi * np.exp(z.sum())

    z, h = np.log([guess, guess]), 1e-3
    e = h * np.eye(2)
    for _ in range(12):
        middle = potential(z)
        plus, minus = [potential(z + s) for s in e], [potential(z - s) for s in e]
        far = [potential(z + 2 * s) - potential(z - 2 * s) for s in e]
        gradient = np.array([8 * (plus[i] - minus[i]) - far[i] for i in (0, 1)]) / (12 * h)
        cross = sum(s * t * potential(z + s * e[0] + t * e[1]) for s in (1, -1) for t in (1, -1)) / (4 * h**2)
        hessian = np.array(
            [[plus[i] + minus[i] - 2 * middle if i == j else cross * h**2 for j in (0, 1)] for i in (0, 1)]
        )
        step = np.linalg.solve(hessian / h**2, gradient)
        z = z - step
        if np.abs(step).max() < 1e-9:
            break
    return force_and_energy(*np.exp(z), depth, alpha, beta, k, unit)[0], np.exp(z)
