"""The force without contact as a random process over the position of the cantilever's base.

    b(x) = level + tilt x + w(x),    <w(x) w(x')> = size^2 K(|x - x'|/memory),

x from 0 to 1 over the record, forces over their range. w is a walk that is held back over its memory (exponential K) or smooth
waves (Matern 5/2). Drift, waves of interference, slow noise and bent lines are one thing: what the force does without contact is
the scale against which a contact must stand out. The likelihood of the readings before the contact determines size and memory.

These readings are averaged over equal stretches, so that K is the same matrix for all curves and its eigenvectors v_k with
eigenvalues l_k are computed once: the likelihood of every size is a sum over k of variances s^2 + size^2 l_k, and level and tilt,
which may be as large as the range, enter it by Woodbury's identity.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from flatpunch._support.checks import TINY, Array

_WALKS = (0.02, 0.1, 0.5, np.inf)
"""Memories of walks, over the way before the contact."""
_WAVES = (0.15, 0.5, 1.5)
"""Memories of smooth waves, over the way before the contact."""
_SIZES = np.geomspace(1e-3, 0.25, 16)
"""Sizes of a process over the range of the force; a larger process would swallow a contact."""
_UNBOUND = np.geomspace(1e-3, 1.0, 20)
"""Sizes of a process that explains a whole record without contact."""
_USUAL = 0.1
"""Size that the force without contact seldom exceeds, over the range of the force: standard deviation of the prior."""
_NODES = 64
"""Stretches over which the readings before the contact are averaged; more cost time only."""
LEARNT = 8
"""Stretches from which a process can be learnt."""


@dataclass(frozen=True, slots=True)
class Background:
    """Size and memory of a process, whether it is smooth, and whether a tilt comes with it; without memory it is white."""

    size: float = 0.0
    memory: float = np.inf
    smooth: bool = False
    tilt: bool = False

    @property
    def white(self) -> bool:
        """Whether readings over level and tilt are independent."""
        return self.size == 0 or self.memory == 0

    def covariance(self, x: Array) -> Array:
        """Covariance of the process without level and tilt, shape (n, n)."""
        return self.size**2 * _kernel(x, self.memory, self.smooth)


def _kernel(x: Array, memory: float, smooth: bool) -> Array:
    if memory == 0:
        return np.eye(x.size)
    if np.isinf(memory):
        return np.asarray(np.minimum.outer(x, x))
    apart = np.abs(np.subtract.outer(x, x)) / memory
    if smooth:
        apart *= np.sqrt(5)
        return np.asarray((1 + apart + apart**2 / 3) * np.exp(-apart))
    return np.asarray(np.exp(-apart) * memory / 2)


@lru_cache(maxsize=256)
def _spectrum(nodes: int, memory: float, smooth: bool) -> tuple[Array, Array, Array, Array]:
    """Eigenvalues and eigenvectors (columns) of a kernel over equal stretches from 0 to 1, level and tilt in them."""
    x = (np.arange(nodes) + 0.5) / nodes
    values, vectors = np.linalg.eigh(_kernel(x, memory, smooth))
    level, tilt = np.array([np.ones(nodes), x]) @ vectors
    return np.maximum(values, 0.0), vectors, level, tilt


def likeliest(
    x: Array,
    y: Array,
    variance: Array,
    *,
    smooth: bool = True,
    tilt: bool = True,
    given: bool | None = None,
    bound: bool = True,
) -> Background:
    """The process that forces without contact show: the largest of all likelihoods.

    Parameters
    ----------
    x, y, variance : ndarray, shape (n,)
        Ascending positions, forces and variances of their white noise, over the ranges of the record.
    smooth, tilt : bool
        Whether smooth waves and a tilt are tried.
    given : bool, optional
        Whether the background is a tilted line, where the user has chosen one: what departs from it is white.
    bound : bool
        Whether the process is small beside the range of the force: before a contact, but not without one.
    """
    usual, tried = (_USUAL, _SIZES) if bound else (np.inf, _UNBOUND)
    nodes = min(_NODES, x.size)
    way = float(x[-1] - x[0]) if x.size else 0.0
    if nodes < LEARNT or not way > 0:
        return Background(tilt=bool(given))
    index = np.minimum(((x - x[0]) * (nodes / way)).astype(int), nodes - 1)
    weight = np.bincount(index, 1 / variance, nodes)
    filled = weight > 0
    centres = (np.arange(nodes) + 0.5) / nodes
    means = np.interp(centres, centres[filled], (np.bincount(index, y / variance, nodes)[filled] / weight[filled]))
    noise = float(np.mean(1 / weight[filled]))
    best, found = -np.inf, Background()
    kinds = [(m, False) for m in _WALKS] + ([(m, True) for m in _WAVES] if smooth else [])
    tilts = ((False, True) if tilt else (False,)) if given is None else (given,)
    for memory, waves in kinds if given is None else [(0.0, False)]:
        values, vectors, level, slope = _spectrum(nodes, memory, waves)
        # a walk spreads over its way: the same size over a longer record
        scale = way if memory and not waves else 1.0
        sizes = np.append(0.0, tried) if memory in (0.0, np.inf) else tried
        spread = noise + np.multiply.outer(sizes**2 * scale, values)
        # by Akaike's criterion: a process has two numbers, a tilt one
        prior = 2.0 * (sizes > 0) + 0.5 * (sizes / usual) ** 2
        worths = _worths(spread, means @ vectors, level, way * slope)
        for tilted in tilts:
            worth = worths[tilted] - prior - tilted
            at = int(np.argmax(worth))
            if worth[at] > best:
                best = float(worth[at])
                found = Background(float(sizes[at]), memory * way, waves, tilted)
    return found


def _worths(spread: Array, along: Array, level: Array, tilt: Array) -> tuple[Array, Array]:
    """Logarithms of the likelihood for variances (sizes, n) of components, beside a level, and beside a level and a tilt.

    Level and tilt have the variance 1.
    """
    columns = np.array([along**2, along * level, along * tilt, level**2, level * tilt, tilt**2])
    square, by_level, by_tilt, a, b, c = columns @ (1 / np.maximum(spread, TINY)).T
    a, c = 1 + a, 1 + c
    free, determinant = square + np.log(spread).sum(axis=1), a * c - b**2
    both = (c * by_level**2 - 2 * b * by_level * by_tilt + a * by_tilt**2) / determinant
    return -0.5 * (free - by_level**2 / a + np.log(a)), -0.5 * (free - both + np.log(determinant))
