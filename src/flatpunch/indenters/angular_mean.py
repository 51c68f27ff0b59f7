"""Angular mean f0(r) of a non-round indenter, tabulated: methods ask for many radii, and each takes hundreds of angles.

Panels, three to a decade and cut at the rings and scales of the shape, carry polynomials in s with
r = r_0 + (r_1 - r_0) sin^2(pi s/2). In s the mean is smooth even where it begins or ends like the root of the distance from a
ring, as it does at the corners and sides of a square flat.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebval, chebvander

from flatpunch._validation import Array
from flatpunch.indenters._common import FULL_TURN
from flatpunch.indenters.angles import angular_rule
from flatpunch.indenters.profile import Indenter, height_and_slope, split_angles
from flatpunch.indenters.symmetry import rotational_symmetry

_PER_DECADE = 3
_NODES = 32
_CHUNK = 2_000_000


class AngularMean:
    """Mean height and slope over the polar angle, as functions of the radius.

    Parameters
    ----------
    indenter : Indenter
        Any indenter; meant for shapes that are neither round nor power laws.
    """

    def __init__(self, indenter: Indenter) -> None:
        self._indenter = indenter
        self._cuts = sorted({*indenter.rings, *getattr(indenter, "scales", ())})
        self._phi, self._weights = self._angles()
        self._panels: dict[tuple[float, float], Array] = {}

    def _angles(self) -> tuple[Array, Array]:
        """Angles and weights of the mean."""
        return _one_period(self._indenter)

    def height(self, r: Array) -> Array:
        """f0 [m] at radii r [m] of any shape."""
        return self._at(r)[..., 0]

    def slope(self, r: Array) -> Array:
        """df0/dr [-], same shape."""
        return self._at(r)[..., 1]

    def _at(self, r: Array) -> Array:
        r = np.asarray(r, dtype=float)
        flat = r.ravel()
        result = np.empty((flat.size, 2))
        outside = (flat <= 0) | (flat > self._indenter.reach)
        result[outside] = self._sample(flat[outside])
        inside = np.flatnonzero(~outside)
        edges = self._edges(flat[inside])
        panel = np.searchsorted(edges, flat[inside], side="right") - 1
        for k in np.unique(panel):
            chosen = inside[panel == k]
            low, high = float(edges[k]), float(edges[k + 1])
            share = np.clip((flat[chosen] - low) / (high - low), 0, 1)
            result[chosen] = chebval(4 / np.pi * np.arcsin(np.sqrt(share)) - 1, self._panel(low, high)).T
        return result.reshape(*r.shape, 2)

    def _edges(self, r: Array) -> Array:
        """Edges of the panels that hold radii r."""
        if not r.size:
            return np.zeros(0)
        first = int(np.floor(_PER_DECADE * np.log10(r.min()) - 1e-9))
        last = int(np.ceil(_PER_DECADE * np.log10(r.max()) + 1e-9))
        even = 10 ** (np.arange(first, last + 1) / _PER_DECADE)
        reach = self._indenter.reach
        cuts = [cut for cut in self._cuts if even[0] < cut < min(reach, even[-1])]
        edges = np.unique(np.concatenate([even[even < reach], cuts, [min(reach, even[-1])]]))
        # a radius at the reach itself belongs to the last panel
        return np.append(edges[:-1], np.nextafter(reach, np.inf)) if edges[-1] == reach else edges

    def _panel(self, low: float, high: float) -> Array:
        """Chebyshev coefficients in 2 s - 1, shape (nodes, 2)."""
        if (low, high) not in self._panels:
            t = chebpts1(_NODES)
            r = low + (high - low) * np.sin(np.pi * (t + 1) / 4) ** 2
            basis = chebvander(t, _NODES - 1) * np.where(np.arange(_NODES) == 0, 1, 2) / _NODES
            self._panels[low, high] = basis.T @ self._sample(np.minimum(r, self._indenter.reach))
        return self._panels[low, high]

    def _sample(self, r: Array) -> Array:
        """Mean height and slope by quadrature, shape (n, 2)."""
        parts = [np.empty((0, 2))]
        step = max(1, _CHUNK // self._phi.size)
        for start in range(0, r.size, step):
            radius = r[start : start + step, None]
            parts.append(np.column_stack(self._means(*height_and_slope(self._indenter, radius, self._phi))))
        return np.vstack(parts)

    def _means(self, f: Array, slope: Array) -> tuple[Array, Array]:
        """Means of height and slope, given at all angles, shape (n, angles)."""
        return f @ self._weights, slope @ self._weights


class GeometricMean(AngularMean):
    """exp of the mean of ln f over the polar angle, and its slope.

    Parameters
    ----------
    indenter : Indenter
        Any indenter with f > 0 away from the apex.
    phi, weights : ndarray, shape (angles,)
        Angles [rad] and weights of the mean.
    """

    def __init__(self, indenter: Indenter, phi: Array, weights: Array) -> None:
        self._given = phi, weights
        super().__init__(indenter)

    def _angles(self) -> tuple[Array, Array]:
        return self._given

    def _means(self, f: Array, slope: Array) -> tuple[Array, Array]:
        with np.errstate(divide="ignore", invalid="ignore"):
            mean = np.exp(np.log(f) @ self._weights)
            return mean, mean * ((slope / f) @ self._weights)


@lru_cache(maxsize=64)
def angular_mean(indenter: Indenter) -> AngularMean:
    """The mean of an indenter; what is already tabulated is shared."""
    return AngularMean(indenter)


def _one_period(indenter: Indenter) -> tuple[Array, Array]:
    """Angles and weights of one period of the shape, or of the whole turn if the rule has no periods."""
    phi, weights = angular_rule(indenter)
    fold = rotational_symmetry(indenter)
    breaks = split_angles(indenter)
    start = breaks[0] if breaks else 0.0
    first = np.mod(phi - start, FULL_TURN) < FULL_TURN / fold * (1 - 1e-13)
    total = float(weights[first].sum())
    if abs(total * fold - 1) > 1e-12:
        return phi, weights
    return phi[first], weights[first] / total
