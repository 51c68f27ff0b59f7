"""Symmetries, edges and flat ends of an indenter, found by looking at its heights."""

from __future__ import annotations

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.indenters._common import FULL_TURN, RAYS, SAME, SCATTERED
from flatpunch.indenters.profile import Indenter

_PHI = SCATTERED[::7]
"""Angles at which heights are compared: a prime number of them, off the axes; half as many may miss a difference."""


def sample_radii(indenter: Indenter, count: int = 50) -> Array:
    """Radii at which an indenter of any size is sampled: up to its reach, or from atoms to metres if it has none."""
    if np.isfinite(indenter.reach):
        return np.asarray(indenter.reach * np.geomspace(1e-6, 1, count, endpoint=False))
    return np.geomspace(1e-10, 1e3, 2 * count)


@byte_cached
def rotational_symmetry(indenter: Indenter) -> int:
    """Largest n <= 24 for which turning the indenter by 2 pi/n leaves it as it is; 1 if there is none."""
    for fold in range(24, 1, -1):
        if _same(indenter, _PHI, _PHI + 2 * np.pi / fold):
            return fold
    return 1


def different_rays(indenter: Indenter, phi: Array) -> tuple[Array, Indices]:
    """Polar angles among phi, shape (n,), that symmetry does not map onto each other, and the index of each phi in them."""
    start, period = next(iter(indenter.corners), 0.0), 2 * np.pi / rotational_symmetry(indenter)
    turn = np.mod(phi - start, period)
    if mirrored_about(indenter, start):
        turn = np.minimum(turn, period - turn)
    order = np.argsort(turn)
    apart = np.diff(turn[order], prepend=-1.0) > SAME
    of_ray = np.empty(phi.size, dtype=np.intp)
    of_ray[order] = np.cumsum(apart) - 1
    return start + turn[order][apart], of_ray


def mirrored_about(indenter: Indenter, angle: float) -> bool:
    """Whether the indenter is its own mirror image about the ray at a polar angle [rad]."""
    return _same(indenter, angle + _PHI, angle - _PHI)


def _same(indenter: Indenter, phi: Array, other: Array) -> bool:
    """Whether heights at all radii are the same at pairs of polar angles, shape (n,) each."""
    r = (np.ones(1) if indenter.exponent is not None else sample_radii(indenter, 10))[:, None]
    f, g = (np.asarray(indenter.height(r, np.mod(at, 2 * np.pi))) for at in (phi, other))
    return bool(np.all(np.abs(f - g) <= SAME * f.max(axis=1, keepdims=True)))


def wedges_of(indenter: Indenter) -> list[tuple[float, float]]:
    """Polar angles of the edges, rounded ones included [rad], and tangents of half the angle to the next one."""
    angles = np.array(sorted(indenter.corners + indenter.rounded_edges))
    gaps = np.diff(np.append(angles, angles[:1] + 2 * np.pi))
    # half of the angle to the next edge at most [rad]
    half = np.minimum(np.minimum(gaps, np.roll(gaps, 1)) / 2, 1.5)
    return [(float(angle), float(np.tan(h))) for angle, h in zip(angles, half, strict=True)]


def place_of(indenter: Indenter, angle: float) -> float:
    """Place of an edge in the sector that repeats as the indenter is turned, as a share of it: equal for equivalent edges."""
    return round(angle * rotational_symmetry(indenter) / (2 * np.pi), 6) % 1


@byte_cached
def flat_radius(indenter: Indenter) -> float:
    """Mean radius of the flat end [m] that a tip begins with; 0 if it has none."""
    rings = indenter.rings
    # with the rays alone the mean radius of a square changes by 1e-6
    phi = np.asarray(np.arange(2 * RAYS) * (FULL_TURN / 2 / RAYS))
    if len(rings) < 2 or np.any(indenter.height(np.array((1 - 1e-3) * rings[0]), phi)):
        return 0.0

    def beyond(r: Array, phi: Array) -> Array:
        return np.where(indenter.height(r, phi) > 0, 1.0, -1.0)

    from scipy.optimize import elementwise

    return float(elementwise.find_root(beyond, (0.0, (1 + SAME) * rings[-1]), args=(phi,)).x.mean())


def beside_flat_end(indenter: Indenter, radius: Array) -> Flags:
    """Where contacts hardly exceed a flat end that is not round, so that its edge rules the pressure; shape (n,)."""
    if flat_radius(indenter) == 0:
        return np.zeros(radius.shape, dtype=bool)
    return np.asarray(radius < 1.2 * indenter.rings[-1])


def radius_above(indenter: Indenter, height: Array | float, phi: Array, limit: float) -> Array:
    """Radii up to `limit` above which the shape is higher along rays [m], by bisection, as it may end in a step."""
    high = np.full(np.broadcast_shapes(np.shape(height), phi.shape), min(limit, indenter.reach))
    low = np.zeros_like(high)
    for _ in range(90):
        middle = (low + high) / 2
        above = np.asarray(indenter.height(middle, phi)) > height
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(high)
