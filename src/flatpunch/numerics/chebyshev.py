"""Chebyshev nodes and polynomials on a panel in the logarithm of a variable."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array

Numbers = NDArray[Any]
"""Real or complex arrays."""

NODES = 24
"""Chebyshev nodes per panel of half a decade: they leave 1e-12 of every answer for modulus ratios 1e-4 .. 1e4 (measured)."""


def tail(series: Array) -> float:
    """Largest of the last three coefficients over the largest of all."""
    size = np.abs(series).max()
    return float(np.abs(series[-3:]).max() / size) if size > 0 else 0.0


def nodes(low: float, high: float, count: int = NODES) -> Array:
    """Radii beta at the Chebyshev nodes of an interval of log(beta), shape (count,)."""
    return np.asarray(np.exp((low + high) / 2 + (high - low) / 2 * unit_nodes(count)))


def nodal_transform(count: int = NODES) -> Array:
    """Matrix from values at the nodes to Chebyshev coefficients."""
    transform = chebyshev.chebvander(unit_nodes(count), count - 1).T * 2 / count
    transform[0] /= 2
    return np.asarray(transform)


def log_derivative(beta: Array) -> Array:
    """Matrix from values at the nodes `beta` of a panel to derivatives by log(beta) there, shape (nodes, nodes)."""
    t = unit_nodes(beta.size)
    stretch = (t[0] - t[-1]) / np.log(beta[0] / beta[-1])
    coefficients = chebyshev.chebder(nodal_transform(t.size)) * stretch
    return np.asarray(chebyshev.chebvander(t, t.size - 2) @ coefficients)


def polynomials(x: Numbers, degree: int = NODES - 1) -> Numbers:
    """Chebyshev polynomials T_0(x) ... T_degree(x) at real or complex points, shape (degree + 1, *x.shape)."""
    values = np.empty((degree + 1, *x.shape), dtype=np.result_type(x, float))
    values[0] = 1.0
    if degree:
        values[1] = x
    twice = 2 * x
    for n in range(2, degree + 1):
        np.multiply(twice, values[n - 1], out=values[n])
        values[n] -= values[n - 2]
    return values


@byte_cached
def derivative(count: int) -> Array:
    """Matrix from Chebyshev coefficients to those of the derivative, shape (count - 1, count)."""
    return np.asarray(chebyshev.chebder(np.eye(count)))


def unit_nodes(count: int) -> Array:
    """Chebyshev nodes of [-1, 1], from the right; shape (count,)."""
    return np.asarray(np.cos(np.pi * (np.arange(count) + 0.5) / count))


def lagrange(nodes: Array, x: float) -> Array:
    """Weights of the polynomial through `nodes`, at x."""
    return np.array([np.prod((x - np.delete(nodes, i)) / (nodes[i] - np.delete(nodes, i))) for i in range(nodes.size)])
