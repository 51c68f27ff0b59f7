"""An independent road to JKR on one layer: a Fredholm equation on Gauss nodes, and differences instead of Krein's identity.

q(t) + (2/pi) int_0^1 q(s) int_0^inf (L(x/beta) - 1) cos(x t) cos(x s) dx ds = 1 on 0 <= t <= 1. The flat punch then has
K = 2 E* a int q dt, and a paraboloid r^2/(2R) the reaction K d - F = 2 E* a (a^2/(2R)) 2 int q t^2 dt. With dF/dd = K,
d = (d(K d - F)/da)/K'. Run as a script, it writes the table of pull-off forces beside the other reference numbers.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

NODES = 96
CHEBYSHEV = 40
TABLE = Path(__file__).parent.parent / "data" / "jkr_layer_pull_off.csv"
CASES = {"frictionless": None, "bonded nu=0.3": 0.3, "bonded nu=0.5": 0.5}


def layer_response(kappa, poisson):
    """L of one layer on a rigid base (closed forms); frictionless if `poisson` is None."""
    # exp(-2 kappa) keeps both forms finite; below 0.02 the cancellation of the bonded form is done by series elsewhere
    e = np.exp(-2 * kappa)
    sinh2, sinh_cosh, cosh2 = (1 - e) ** 2 / 4, (1 - e**2) / 4, (1 + e) ** 2 / 4
    if poisson is None:
        return 2 * sinh2 / (2 * sinh_cosh + 2 * kappa * e)
    three = 3 - 4 * poisson
    return (three * sinh_cosh - kappa * e) / (three * cosh2 + (kappa**2 + (1 - 2 * poisson) ** 2) * e)


def moments(beta, poisson):
    """int q dt and 2 int q t^2 dt at one beta."""
    t, v = np.polynomial.legendre.leggauss(NODES)
    t, v = (t + 1) / 2, v / 2
    edges = np.concatenate([[0.0], np.geomspace(1e-4, 1, 9) * 2, np.arange(4, 24)]) * beta
    x, w = np.polynomial.legendre.leggauss(40)
    x = (np.diff(edges)[:, None] / 2 * (x + 1) + edges[:-1, None]).ravel()
    w = (np.diff(edges)[:, None] / 2 * w).ravel()
    c = np.cos(np.outer(t, x))
    kernel = 2 / np.pi * (c * ((layer_response(x / beta, poisson) - 1) * w)) @ c.T
    q = np.linalg.solve(np.eye(NODES) + kernel * v, np.ones(NODES))
    return v @ q, 2 * v @ (q * t**2)


def pull_off(softness, poisson):
    """Largest tension over pi w R, and its contact radius over h, for theta = E* h^3/(w R^2) = softness."""
    # units: h = E* = R = 1, so w = 1/theta; the half-space's radius is the scale of the search
    work = 1 / softness
    guess = (9 * np.pi * work / 8) ** (1 / 3)
    low, high = np.log(guess / 6), np.log(guess * 2.5)
    node = np.cos(np.pi * (np.arange(CHEBYSHEV) + 0.5) / CHEBYSHEV)
    beta = np.exp((low + high) / 2 + (high - low) / 2 * node)
    mean, second = np.array([moments(b, poisson) for b in beta]).T
    to_log = 2 / (high - low)
    stiffness = chebyshev.chebfit(node, np.log(2 * beta * mean), CHEBYSHEV - 1)
    reaction = chebyshev.chebfit(node, np.log(beta**3 * second), CHEBYSHEV - 1)

    def force(at):
        k, g = np.exp(chebyshev.chebval(at, stiffness)), np.exp(chebyshev.chebval(at, reaction))
        growth = to_log * chebyshev.chebval(at, chebyshev.chebder(stiffness)) * k
        depth = to_log * chebyshev.chebval(at, chebyshev.chebder(reaction)) * g / growth
        a = np.exp((low + high) / 2 + at / to_log)
        return k * depth - g - k * a * np.sqrt(4 * np.pi * work / growth)

    nodal = chebyshev.chebfit(node, force(node), CHEBYSHEV - 1)
    slope = chebyshev.chebder(nodal)
    grid = np.linspace(-1, 1, 200)
    turn = np.flatnonzero(np.diff(np.sign(chebyshev.chebval(grid, slope))) > 0)[-1]
    at = brentq(lambda z: chebyshev.chebval(z, slope), grid[turn], grid[turn + 1], xtol=1e-14)
    return force(at) / (np.pi * work), np.exp((low + high) / 2 + at / to_log)


def write():
    lines = [
        "# Largest tension of a paraboloid f = r^2/(2R), work of adhesion w, on one layer of thickness h on a rigid base (JKR).",
        "# theta = E* h^3/(w R^2); force in units of pi w R; beta = contact radius there over h. By tests/support/fredholm.py:",
        "# Fredholm equation on 96 Gauss nodes, derivatives by Chebyshev series; self-convergence 1e-9 in the force.",
        "base,theta,force,beta",
    ]
    for name, poisson in CASES.items():
        for theta in (1e3, 1e2, 10.0, 1.0, 0.1, 0.01):
            force, beta = pull_off(theta, poisson)
            lines.append(f"{name},{theta:g},{force:.10f},{beta:.8f}")
    TABLE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    write()
