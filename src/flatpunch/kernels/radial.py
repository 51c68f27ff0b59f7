"""The surface compliance under uniform tractions, and its interpolation over |q|.

Times |q| the four functions of `flatpunch.compliances.tangential` are smooth in ln |q|. They are sampled at nodes that are
equally spaced there, twice as many until the spline through them meets the new ones within the tolerance.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

    from flatpunch._support.checks import Array
    from flatpunch.media import AnyLayer, Body

_DEGREE = 7
"""Degree of splines over ln |q|."""

_SPACING = 0.25
"""Distance of the first nodes in ln |q|; features of C(k) are as wide as one or more."""

_MOST = 10_000
"""Nodes beyond which they are not doubled again."""


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


def table(body: Body, low: float, high: float, rtol: float) -> BSpline:
    """Spline over ln |q| of |q| times the four functions, shape (n, 4), in a range of |q| [1/m].

    `rtol` is its largest error, relative to each diagonal entry, and of d to the root of a and n.
    """
    from scipy.interpolate import make_interp_spline

    start, end = np.log(low), np.log(high)
    s = np.linspace(start, end, max(_DEGREE + 1, int(np.ceil((end - start) / _SPACING)) + 1))
    values = _smooth(body, s)
    while True:
        middle = (s[1:] + s[:-1]) / 2
        new = _smooth(body, middle)
        error = float(np.abs(make_interp_spline(s, values, k=_DEGREE)(middle) - new).max())
        s, values = _merged(s, middle), _merged(values, new)
        if error <= rtol:
            n, a, c = np.exp(values[:, :3].T)
            functions = np.column_stack([n, a, c, values[:, 3] * np.sqrt(n * a)])
            return make_interp_spline(s, functions, k=_DEGREE)
        if s.size > _MOST:
            raise ValueError(
                f"the compliance of this medium cannot be interpolated over |q| to rtol = {rtol:g} (it is at {error:.1e}). "
                "Ask for a larger rtol, or rtol=0, which takes no table."
            )


def _smooth(body: Body, s: Array) -> Array:
    """Logarithms of k n, k a and k c, and d over the root of n and a, at s = ln k; shape (n, 4)."""
    from flatpunch.compliances.tangential import radial_compliance

    k = np.exp(s)
    n, a, c, d = radial_compliance(body, k)
    return np.column_stack([np.log(k * n), np.log(k * a), np.log(k * c), d / np.sqrt(n * a)])


def _merged(one: Array, other: Array) -> Array:
    found = np.empty((one.shape[0] + other.shape[0], *one.shape[1:]))
    found[::2], found[1::2] = one, other
    return found
