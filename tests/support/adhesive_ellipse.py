"""Bonded elliptic contact on a half-space in closed form: an independent judge of adhesion under elliptic paraboloids.

Pressures (c_0 + c_1 x^2 + c_2 y^2)/sqrt(1 - x^2/A^2 - y^2/B^2) on the ellipse with semi-axes A, B press the surface into
d - alpha x^2 - beta y^2. With Hertz's integrals for sqrt(1 - ...) and their derivatives by A and B the three coefficients
follow. The energy U - pi A B w, made stationary over A and B, gives the force at given depth. Real outlines are ellipses but
for terms of second order, which enter the energy squared.
"""

import numpy as np
from scipy.integrate import quad


def _hertz(a, b):
    """Coefficients (1, x^2, y^2) of the displacement under sqrt(1 - x^2/a^2 - y^2/b^2) and their derivatives by a, b; E* = 1."""
    c = np.sqrt(a * b)

    def integral(p, q):
        def integrand(t):
            s = (c * np.tan(t)) ** 2
            return c / np.cos(t) ** 2 * (a * a + s) ** (-0.5 - p) * (b * b + s) ** (-0.5 - q)

        return quad(integrand, 0, np.pi / 2, epsabs=0, epsrel=1e-13)[0]

    value, by_a, by_b = np.empty(3), np.empty(3), np.empty(3)
    for i, (p, q, sign) in enumerate([(0, 0, 1), (1, 0, -1), (0, 1, -1)]):
        here = integral(p, q)
        value[i] = sign * a * b * here
        by_a[i] = sign * (b * here - a * b * 2 * a * (0.5 + p) * integral(p + 1, q))
        by_b[i] = sign * (a * here - a * b * 2 * b * (0.5 + q) * integral(p, q + 1))
    return value, by_a, by_b


def force_and_energy(a, b, depth, alpha, beta):
    """Force and elastic energy of the bonded ellipse."""
    value, by_a, by_b = _hertz(a, b)
    matrix = np.array([value + a * by_a + b * by_b, a**3 * by_a, b**3 * by_b]).T
    c = np.linalg.solve(matrix, [depth, -alpha, -beta])
    one = 2 * np.pi * a * b
    xx, yy, xy = one * a**4 / 5, one * b**4 / 5, one * a**2 * b**2 / 15
    x, y = one * a**2 / 3, one * b**2 / 3
    force = c @ [one, x, y]
    return force, (depth * force - alpha * (c @ [x, xx, xy]) - beta * (c @ [y, xy, yy])) / 2


def adhesive_ellipse(depth, alpha, beta, work, guess):
    """Force and semi-axes of the adhesive contact at given depth: Newton's method with differences in ln A, ln B."""

    def potential(z):
        return force_and_energy(*np.exp(z), depth, alpha, beta)[1] - work * np.pi * np.exp(z.sum())

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
    return force_and_energy(*np.exp(z), depth, alpha, beta)[0], np.exp(z)
