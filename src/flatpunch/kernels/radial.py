"""The surface compliance under uniform tractions, and its interpolation over |q|.

Times |q| the four functions of `flatpunch.compliances.tangential` are smooth in ln |q|. They
are sampled at nodes that are equally spaced there, twice as many until polynomials of eight nodes meet the new ones within the
tolerance; a finer table of cubics, made from the last nodes, is then evaluated at all wavenumbers.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flatpunch._support.checks import Array
    from flatpunch.media import AnyLayer, Body

_POINTS = 8
"""Nodes of a polynomial."""

_SPACING = 0.25
"""Distance of the first nodes in ln |q|; features of C(k) are as wide as one or more."""

_FINE = 8
"""Intervals of the table of cubics in one of the last nodes', whose own error is far below the tolerance."""


def at_zero(body: Body) -> tuple[float, float]:
    """C_zz and C_xx of a uniform traction, infinite where it is carried by nothing that limits the displacement."""
    if not all(side.base.rigid for side in body.elastic):
        return np.inf, np.inf
    total = np.zeros(2)
    for layer in (layer for side in body.elastic for layer in side.layers):
        total += _of_layer(layer)
    return float(total[0]), float(total[1])


def _of_layer(layer: AnyLayer) -> Array:
    """Thickness over C33 and over C44 of a layer and its lower face."""
    from flatpunch.numerics.gauss import gauss

    edges = [0.0, *layer.breaks, layer.thickness]
    # Gauss nodes between breaks of a law, which is smooth there
    x, w = gauss()
    found: Array = np.zeros(2)
    for low, high in pairwise(edges):
        z = low + (high - low) * (1 + x) / 2
        plane = layer.plane_at(z)
        found += (high - low) / 2 * np.array([w @ plane.oedometric, w @ plane.shear])
    along, across = layer.face.softness
    found += across, along
    return found


class Table:
    """Cubics in ln |q| for |q| times the four functions.

    Parameters
    ----------
    body : object
        The medium.
    low, high : float
        Range of |q| [1/m].
    rtol : float
        Largest error, relative to each diagonal entry, and of d to the root of a and n.
    """

    def __init__(self, body: Body, low: float, high: float, rtol: float) -> None:
        start, end = np.log(low), np.log(high)
        count = max(_POINTS, int(np.ceil((end - start) / _SPACING)) + 1)
        s = np.linspace(start, end, count)
        values = _smooth(body, s)
        while True:
            middle = (s[1:] + s[:-1]) / 2
            new = _smooth(body, middle)
            error = float(np.abs(_interpolated(s, values, middle) - new).max())
            s, values = _merged(s, middle), _merged(values, new)
            if error <= rtol:
                break
            if s.size > 2**14:
                raise ValueError(
                    f"the compliance of this medium cannot be interpolated over |q| to rtol = {rtol:g} (it is at {error:.1e}). "
                    "Ask for a larger rtol, or rtol=0, which takes no table."
                )
        self.error, self._start = error, start
        # two more intervals on either side for the cubics, which need a node beyond
        count = _FINE * (s.size - 1)
        self._step = (end - start) / count
        nodes = start + self._step * np.arange(-1, count + 3)
        fine = _smooth_inverse(_interpolated(s, values, nodes))
        p, q, r, t = (fine[:, i : i + count + 1] for i in range(4))
        # the cubic through four neighbours, in powers of the distance from the second one
        self._cubics = np.stack([q, r - t / 6 - p / 3 - q / 2, (p + r) / 2 - q, (t - p) / 6 + (q - r) / 2], axis=1)

    def __call__(self, log_k: Array) -> Array:
        """|q| times the four functions, shape (4, n)."""
        x = (log_k - self._start) / self._step
        i = np.clip(x.astype(np.intp), 0, self._cubics.shape[2] - 1)
        x -= i
        found = np.empty((4, x.size))
        for out, cubic in zip(found, self._cubics, strict=True):
            np.take(cubic[3], i, out=out)
            for power in (2, 1, 0):
                out *= x
                out += cubic[power].take(i)
        return found


def _smooth(body: Body, s: Array) -> Array:
    """Logarithms of k n, k a and k c, and d over the root of n and a, at s = ln k; shape (4, n)."""
    from flatpunch.compliances.tangential import radial_compliance

    k = np.exp(s)
    n, a, c, d = radial_compliance(body, k)
    return np.stack([np.log(k * n), np.log(k * a), np.log(k * c), d / np.sqrt(n * a)])


def _smooth_inverse(values: Array) -> Array:
    """k times the four functions."""
    n, a, c = np.exp(values[:3])
    return np.stack([n, a, c, values[3] * np.sqrt(n * a)])


def _merged(one: Array, other: Array) -> Array:
    found = np.empty((*one.shape[:-1], one.shape[-1] + other.shape[-1]))
    found[..., ::2], found[..., 1::2] = one, other
    return found


def _interpolated(s: Array, values: Array, wanted: Array) -> Array:
    """Polynomials of the eight nearest equally spaced nodes, shape (functions, n)."""
    step = (s[-1] - s[0]) / (s.size - 1)
    x = (wanted - s[0]) / step
    first = np.clip(np.floor(x).astype(int) - _POINTS // 2 + 1, 0, s.size - _POINTS)
    t = x - first
    found = np.zeros((values.shape[0], wanted.size))
    for j in range(_POINTS):
        weight = np.ones_like(t)
        for m in range(_POINTS):
            if m != j:
                weight *= (t - m) / (j - m)
        found += values[:, first + j] * weight
    return found
