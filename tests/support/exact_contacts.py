"""Exact round contacts on layers from the punch matrix, to judge boundary elements by."""

import numpy as np

from flatpunch.compliances import Kernel
from flatpunch.punch.basis import power_edge, power_moments
from flatpunch.punch.matrix import solve_round, sufficient_terms


def power_law_on_layer(kernel: Kernel, radius: float, exponent: float, coefficient: float) -> tuple[float, float]:
    """Depth and force of f = coefficient r^exponent at contact radius `radius`."""
    beta = np.array([radius / kernel.length])
    # the moments of r^n decay like a power only; 40 terms more than the matrix needs leave 1e-9 for n = 2
    terms = sufficient_terms(kernel, float(beta[0])) + 40
    responses = solve_round(kernel, beta, terms)
    c, edge = responses.flat[0], responses.edge[0]
    scale = coefficient * radius**exponent
    b = scale * power_moments(exponent, 0, terms)
    depth = (scale * power_edge(exponent, 0) + b @ edge) / (1 / np.pi + edge[0])
    force = 2 * kernel.modulus * radius * np.pi * (depth * c[0] - b @ c)
    return float(depth), float(force)
