"""Fields of load waves at depth at many wavenumbers, interpolated between few where layers are graded.

Integrals over oscillating Bessel functions need many wavenumbers; the fields themselves are smooth over an octave of them, and
graded layers are crossed in a hundred steps. Poles of the response lie away from real k, at the inverse of the lengths over which
layers bend, stretch and shear on what is below: below the smallest of these one panel is enough. The fields at the nodes are
kept: loads of different sizes, and points at different distances from them, share depths and panels.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, Indices
from flatpunch.compliances.depth import Waves, waves_at
from flatpunch.compliances.response import smallest_and_largest_modulus
from flatpunch.media import Stack
from flatpunch.numerics.chebyshev import nodal_transform, unit_nodes

_NODES = 16
"""Chebyshev nodes over an octave: with poles at 45 degrees to the real axis they leave 5^-16 = 1e-11."""

_LONG = 0.01
"""Wavenumber times the longest length of the response below which one panel is enough."""

_RUNGS = 4
"""Largest wavenumbers per octave at which panels end: an integral and its check, which ends at 5/6 of it, have different ones."""


def waves_between(medium: Stack, k: Array, z: Array, layer: Indices, *, shear: bool) -> Waves:
    """Fields as of `waves_at`, from panels of wavenumbers if these have fewer nodes than `k`, shape (nk,), ascending."""
    if not medium.varies:
        return waves_at(medium, k, z, layer, shear=shear)
    edges = _edges(medium, float(2.0 ** (np.ceil(_RUNGS * np.log2(k[-1])) / _RUNGS)))
    if _NODES * (edges.size - 1) >= k.size:
        return waves_at(medium, k, z, layer, shear=shear)
    found = _at_nodes(medium, tuple(edges.tolist()), tuple(z.tolist()), tuple(layer.tolist()), shear)
    which = np.searchsorted(edges, k) - 1
    low, high = edges[which], edges[which + 1]
    weights = chebyshev.chebvander((2 * k - low - high) / (high - low), _NODES - 1) @ nodal_transform(_NODES)

    def between(table: Array) -> Array:
        result = np.empty((*table.shape[:-2], k.size, table.shape[-1]))
        for i in np.unique(which) if table.size else ():
            mine = which == i
            result[..., mine, :] = weights[mine] @ table[..., _NODES * i : _NODES * (i + 1), :]
        return result / k[:, None] if table.size else table

    return Waves(between(found.normal), between(found.shear), between(found.transverse))


@byte_cached
def _at_nodes(
    medium: Stack, edges: tuple[float, ...], z: tuple[float, ...], layer: tuple[int, ...], shear: bool
) -> Waves:
    """Fields times k at the nodes of all panels: displacements of sliding layers grow like 1/k at long waves."""
    middle, half = np.array([edges[:-1], edges[1:]]).mean(axis=0), np.diff(edges) / 2
    k = (middle[:, None] + half[:, None] * unit_nodes(_NODES)).ravel()
    found = waves_at(medium, k, np.array(z), np.array(layer), shear=shear)
    return Waves(*(each * k[:, None] if each.size else each for each in (found.normal, found.shear, found.transverse)))


def _edges(medium: Stack, last: float) -> Array:
    """Panels of wavenumbers from zero: octaves below the last one, and one for all that are long."""
    smallest, largest = smallest_and_largest_modulus(medium)
    # layers that shear on a weak interface, the farthest-reaching case, respond over the root of the ratio of moduli
    longest = medium.thickness * np.sqrt(largest / smallest)
    count = max(int(np.ceil(np.log2(last * longest / _LONG))), 0)
    return np.append(0.0, last * 0.5 ** np.arange(count, -1, -1))
