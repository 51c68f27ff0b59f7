"""Quadrature over the polar angle, and the angular harmonics of functions sampled on it.

Smooth outlines take equally spaced angles (exponential convergence), outlines with edges Gauss panels from
edge to edge. The number of angles grows until the angular means of f and of its logarithm no longer
change, to rounding.
"""

from __future__ import annotations

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.indenters._common import FULL_TURN
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.gauss import gauss

_STILL = float(100 * np.finfo(float).eps)
"""Change of a mean, over its own scale, that counts as rounding: tens of eps, sums of hundreds."""


def angular_rule(indenter: Indenter, harmonics_hint: int = 32, *, radius: float | None = None) -> tuple[Array, Array]:
    """Angles and weights for means over the polar angle.

    Parameters
    ----------
    indenter : Indenter
        Hashable; its `corners` (and `seams`, where it has any: joints without an edge) split the rule.
    harmonics_hint : int
        Highest harmonic of interest; products of two harmonics up to it are integrated at rounding as well.
    radius : float, optional
        Largest radius of interest [m]. Without it the reach of the indenter, or 1 where that is infinite
        (power laws look the same at every radius).

    Returns
    -------
    phi, weights : ndarray, shape (n,)
        Angles in [0, 2 pi) [rad] and weights that sum to 1; read-only, shared between calls.
    """
    if radius is None:
        radius = indenter.reach if np.isfinite(indenter.reach) else 1.0
    return _rule(indenter, int(harmonics_hint), float(radius))


@byte_cached
def _rule(indenter: Indenter, order: int, radius: float) -> tuple[Array, Array]:
    breaks = indenter.split_angles
    size = _first_size(breaks, order)
    phi, weights = _nodes(breaks, size)
    if not indenter.round:
        radii, tolerance = _watched(indenter, radius)
        if not radii.size:
            # kinks cross all circles, and between them more angles are no use
            return _kept(phi, weights)
        means, scale = _means(indenter, radii, phi, weights)
        while phi.size < 10_000:
            more = _finer(breaks, size, crossed=tolerance > _STILL)
            finer = _nodes(*more)
            new, scale = _means(indenter, radii, *finer)
            still = bool((np.abs(new - means) <= tolerance * scale).all())
            if still:
                break
            (breaks, size), (phi, weights), means = more, finer, new
    return _kept(phi, weights)


def _kept(phi: Array, weights: Array) -> tuple[Array, Array]:
    """A rule that is shared."""
    phi.setflags(write=False)
    weights.setflags(write=False)
    return phi, weights


def _finer(breaks: list[float], size: int, crossed: bool) -> tuple[list[float], int]:
    """Panels and angles on each for the next trial: more angles, or more panels where kinks cross the rays."""
    if not breaks:
        return breaks, 2 * size
    if not crossed:
        # outlines that vary by orders of magnitude need thousands: few trials reach them
        return breaks, size + max(10, size // 10)
    ends = np.array([*breaks, breaks[0] + FULL_TURN])
    return sorted({*map(float, ends[:-1]), *map(float, (ends[:-1] + ends[1:]) / 2)}), size


def _watched(indenter: Indenter, radius: float) -> tuple[Array, float]:
    """Radii at which the means must have converged, and the tolerance."""
    tolerance = max(_STILL, indenter.angular_tolerance)
    if indenter.exponent is not None:
        return np.array([1.0]), tolerance
    scales = indenter.scales
    radii = np.array(scales) if scales else radius * np.array([0.05, 0.2, 0.5, 0.8, 1.0])
    crossings = indenter.crossings
    if crossings is None:
        return radii, tolerance
    return radii[~np.isfinite(crossings(radii)).any(axis=1)], tolerance


def _first_size(breaks: list[float], order: int) -> int:
    """Angles of the whole turn, or of one panel: enough for cos(2 order phi)."""
    if not breaks:
        return 4 * (order + 2)
    widest = float(np.diff([*breaks, breaks[0] + FULL_TURN]).max())
    return _gauss_nodes(order * widest) if len(breaks) <= 100 else 10


def _gauss_nodes(z: float) -> int:
    """Gauss nodes that integrate cos(z t) over |t| < 1 at rounding: half of z, and a transition like its cube root."""
    return int(np.ceil(z / 2 + 5 * np.cbrt(z) + 4))


def _nodes(breaks: list[float], size: int) -> tuple[Array, Array]:
    if not breaks:
        return FULL_TURN * np.arange(size) / size, np.full(size, 1 / size)
    edges = np.array([*breaks, breaks[0] + FULL_TURN])
    t, v = gauss(size)
    half = np.diff(edges)[:, None] / 2
    phi = (edges[1:] + edges[:-1])[:, None] / 2 + half * t
    return np.mod(phi.ravel(), FULL_TURN), (half * v).ravel() / FULL_TURN


def panel_rule(edges: Array, order: int) -> tuple[Array, Array]:
    """Gauss points and weights, shape (n, points), on the panels of n integrals between ascending `edges`, shape (n, panels + 1).

    Panels of some integrals may be empty where those of others are not; products of two harmonics up to `order` are exact.
    """
    half, parts = np.diff(edges, axis=1) / 2, []
    for panel, widest in enumerate(half.max(axis=0)):
        if widest > 0:
            # six more, as shapes between kinks are more than a few harmonics
            t, v = gauss(_gauss_nodes(2 * order * float(widest)) + 6)
            middle = (edges[:, panel] + edges[:, panel + 1])[:, None] / 2
            parts.append((middle + half[:, [panel]] * t, half[:, [panel]] * v))
    points, weights = zip(*parts, strict=True)
    return np.hstack(points), np.hstack(weights)


def _means(indenter: Indenter, radii: Array, phi: Array, weights: Array) -> tuple[Array, Array]:
    """Angular means of f and ln f at some radii, and the scales by which their changes are judged."""
    f = indenter.height(radii[:, None], phi)
    touching = ~(f > 0).all(axis=1)
    mean = f @ weights
    with np.errstate(divide="ignore", invalid="ignore"):
        # relative to the mean, so that units do not matter; a radius with f = 0 has no logarithm and is
        # judged by f alone
        logarithm = np.where(touching, 0.0, np.log(f / mean[:, None]) @ weights)
    return np.concatenate([mean, logarithm]), np.concatenate([np.abs(mean), np.ones_like(mean)])


def harmonics(values: Array, phi: Array, weights: Array, order: int) -> tuple[Array, Array]:
    """Angular harmonics v, w: values = v_0 + sum_m v_m cos m phi + w_m sin m phi, shape (..., order + 1); w_0 = 0.

    Angles and weights are those of `angular_rule`.
    """
    m = np.arange(order + 1)
    scaled = np.where(m == 0, 1.0, 2.0) * weights[:, None]
    angle = np.outer(phi, m)
    return np.asarray(values @ (scaled * np.cos(angle))), np.asarray(values @ (scaled * np.sin(angle)))
