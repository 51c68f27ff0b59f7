"""Half-space integrals of a round load in closed form: complex ring sources.

A round pressure with the transform P(k) = int_0^a g(t) cos(kt) dt, p(r) = int k P J_0(kr) dk, needs at depth the integrals

    I_mj(r, z) = int_0^inf k^j P(k) J_m(kr) exp(-kz) dk = Re int_0^a g(t) (i d/dt)^j kappa_m dt,
    kappa_m = exp(-m v)/(r cosh v),     r sinh v = z + i t,

a ring source at the complex depth z + i t (m = 0: 1/sqrt(r^2 + (z + it)^2)). `ring_panel` integrates over panels of g. Beyond a
kink of the profile, such as the border of a flat end, g has a root, g(b) + g_1 sqrt(t - b) + .... There g is a polynomial in
u = sqrt((t - b)/(c - b)), b < t < c.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial import chebyshev
from numpy.polynomial import legendre as polynomial

from flatpunch._support.checks import Array, Flags
from flatpunch._support.threads import in_threads
from flatpunch.numerics.chebyshev import Numbers, nodal_transform, unit_nodes
from flatpunch.numerics.gauss import gauss
from flatpunch.stresses.axisymmetric.panels import SHORTEST, Edges
from flatpunch.stresses.axisymmetric.ring_panel import ORDERS, Complex, Panel, add_jump

_TERMS = 16
"""Chebyshev terms on a panel of g."""


_CHUNK = 2048
"""Points, or wavenumbers, at once: their arrays stay in the cache."""

_LIFTED = 1e-30
"""Smallest depth over the radius: at the surface itself kappa is infinite at the ends of panels, and with it integrals of j = 2,
which are needed times the depth only."""

_EVEN = 1e-13
"""Largest approximation error over that of g: of its integral over a panel, and as a jump between panels that is none."""


@dataclass(frozen=True, eq=False)
class RingSources:
    """g(t) as Chebyshev series on panels.

    Parameters
    ----------
    breaks : ndarray, shape (panels + 1,)
        Ends of the panels, from 0 to the radius of the load [m].
    series : ndarray, shape (panels, terms)
        Chebyshev coefficients of g on each panel [Pa]: in t, or in sqrt(t - b) on panels that begin with a root.
    rooted : ndarray of bool, shape (panels,)
        Whether a panel begins with a root.
    edges : tuple of Edge
        Where the pressure is not smooth, the rim last; none where nobody asks.
    """

    breaks: Array
    series: Array
    rooted: Flags
    edges: Edges = ()

    @property
    def radius(self) -> float:
        """Radius of the load [m]."""
        return float(self.breaks[-1])

    @property
    def scale(self) -> float:
        """Size of the pressure [Pa]: the largest g over the radius, three quarters of the mean pressure under a paraboloid."""
        return float(np.abs(chebyshev.chebval(np.linspace(-1, 1, _TERMS), self.series.T)).max()) / self.radius

    @property
    def shallow(self) -> float:
        """Depth to which the closed form is used under a power-law half-space [m]: deeper there is no need."""
        return 2 * SHORTEST * self.radius

    @property
    def force(self) -> float:
        """Total load [N], 2 pi P(0)."""
        return float(2 * np.pi * self.transform(np.zeros(1))[0])

    @cached_property
    def _jumps(self) -> Array:
        """Jumps of g at the breaks, value below minus value above, shape (panels + 1,)."""
        start, end = (chebyshev.chebval(x, self.series.T) for x in (-1.0, 1.0))
        jump = np.concatenate([[0.0], end]) - np.concatenate([start, [0.0]])
        return np.where(np.abs(jump) > _EVEN * self.scale * self.radius, jump, 0.0)

    @cached_property
    def _without_roots(self) -> RingSources:
        """Sources with g as polynomials in t alone, which is enough where it is integrated without derivatives."""
        if not self.rooted.any():
            return self
        return sampled(self.value, self.breaks, _EVEN, by_area=True)

    def value(self, t: Array) -> Array:
        """g at 0 <= t <= radius [Pa]."""
        flat = t.ravel()
        panel = np.clip(np.searchsorted(self.breaks, flat, side="right") - 1, 0, len(self.series) - 1)
        low, high, rooted = self.breaks[panel], self.breaks[panel + 1], self.rooted[panel]
        share = np.clip((flat - low) / (high - low), 0.0, 1.0)
        x = 2 * np.where(rooted, np.sqrt(share), share) - 1
        return np.asarray(chebyshev.chebval(x, self.series[panel].T, tensor=False).reshape(t.shape))

    def transform(self, k: Array) -> Array:
        """P(k) = int g cos(kt) dt [Pa m], shape of k, (n,).

        Gauss quadrature where a panel holds few oscillations. Beyond, Legendre's series: int P_n(x) exp(iwx) dx = 2 i^n j_n(w).
        """
        if self.rooted.any():
            return self._without_roots.transform(k)
        total = np.zeros_like(k)
        for low, high, series in zip(self.breaks[:-1], self.breaks[1:], self.series, strict=True):
            half, middle = (high - low) / 2, (high + low) / 2
            own = chebyshev.chebtrim(series)
            # Legendre's series needs more radians over half a panel than it has terms
            slow = k * half <= 2 * _TERMS
            x, w = gauss(_TERMS + int(np.ceil(min(2 * _TERMS, k.max(initial=0.0) * half))))
            weight, few = chebyshev.chebval(x, own) * w * half, np.flatnonzero(slow)
            for start in range(0, few.size, _CHUNK):
                some = few[start : start + _CHUNK]
                total[some] += np.cos(np.outer(k[some], middle + half * x)) @ weight
            total[~slow] += 2 * half * _oscillating(own, k[~slow] * half, k[~slow] * middle)
        return total

    def integrals(self, r: Array, z: Array | Complex) -> Numbers:
        """I_mj at points (r, z), shape (n,), with Re z >= 0.

        Returns
        -------
        ndarray, shape (4, 3, n)
            m = 0 ... 3, j = 0, 1, 2 [Pa m^(1-j)]; complex at complex depths.
        """
        if np.iscomplexobj(z):
            # the integrand is the mean of the sources at z + i t and z - i t, which are no longer conjugates
            return np.asarray(self._integrals(r, z) + self._integrals(r, z.conj()).conj()) / 2
        return self._integrals(r, z)

    def _integrals(self, r: Array, z: Array | Complex) -> Numbers:
        """Contribution of the sources at z + i t, or its real part where z is real."""
        result = np.empty((ORDERS, 3, r.size), dtype=z.dtype)
        # on the axis all orders but m = 0 vanish; this far off it they do, to rounding
        r, z = np.maximum(r, 1e-20 * self.radius), np.where(z == 0, _LIFTED * self.radius, z)

        def fill(i: int) -> None:
            some = slice(i * _CHUNK, (i + 1) * _CHUNK)
            result[:, :, some] = self._chunk(r[some], z[some])

        # floating-point operations at a point and panel, for the choice of threads
        in_threads(fill, -(-r.size // _CHUNK), operations=1e4 * r.size * len(self.series))
        return result

    def _chunk(self, r: Array, z: Array | Complex) -> Numbers:
        v = np.arcsinh((z + 1j * self.breaks[:, None]) / r)
        result: Numbers = np.zeros((ORDERS, 3, r.size), dtype=z.dtype)
        for at, jump in zip(v, self._jumps, strict=True):
            if jump:
                add_jump(result, at, r, jump)
        for i, length in enumerate(np.diff(self.breaks)):
            Panel(length, chebyshev.chebtrim(self.series[i]), bool(self.rooted[i])).add(result, v[i], v[i + 1], r)
        return result


@lru_cache(maxsize=64)
def _to_legendre(terms: int) -> Array:
    """Matrix from Chebyshev to Legendre coefficients, shape (terms, terms)."""
    x, w = gauss(terms)
    values = polynomial.legvander(x, terms - 1) * (np.arange(terms) + 0.5)
    return np.asarray((values.T * w) @ chebyshev.chebvander(x, terms - 1))


def _oscillating(series: Array, w: Array, phase: Array) -> Array:
    """Re exp(i phase) sum c_n i^n j_n(w) for w beyond the number of terms, c_n the coefficients in Legendre polynomials."""
    legendre = _to_legendre(series.size) @ series
    bessel, ahead = np.sin(w) / w, np.cos(w) / w
    turns = np.cos(phase), -np.sin(phase), -np.cos(phase), np.sin(phase)
    total = np.zeros_like(w)
    for n, c in enumerate(legendre):
        total += c * turns[n % 4] * bessel
        # j_(n+1) = (2n + 1)/w j_n - j_(n-1), stable while n < w; j_(-1) = cos(w)/w
        bessel, ahead = (2 * n + 1) / w * bessel - ahead, bessel
    return total


def sampled(
    function: Callable[[Array], Array],
    breaks: Array,
    tolerance: float,
    narrowest: float = 1e-9,
    *,
    roots: Array | None = None,
    rounding: float = 0.0,
    edges: Edges = (),
    by_area: bool = False,
) -> RingSources:
    """Ring sources of any continuous function g(t).

    Parameters
    ----------
    function : callable
        t [m] -> g [Pa], of the same shape.
    breaks : ndarray, shape (n,)
        Ends of the panels to begin with, 0 and the radius of the load among them [m]; panels are halved until their series end.
    tolerance : float
        Last terms of a panel, over the largest g, at which it is fine enough.
    narrowest : float
        Shortest panel over the radius.
    roots : ndarray, optional
        Breaks beyond which g is smooth in sqrt(t - b) [m].
    rounding : float
        Rounding error of g [Pa], which no panel can resolve.
    edges : tuple of Edge
        Those of the sources; where the power of the last one is positive, g is zero at the radius.
    by_area : bool
        Whether the tolerance is that of the integral of g, over the radius times the largest g.
    """
    nodes, transform = unit_nodes(_TERMS), nodal_transform(_TERMS)
    low, high = breaks[:-1], breaks[1:]
    rooted = np.zeros(low.size, dtype=bool) if roots is None else np.isin(low, roots)
    done: list[tuple[float, Array, bool]] = []
    size = 0.0
    while low.size:
        share = np.where(rooted[:, None], ((1 + nodes) / 2) ** 2, (1 + nodes) / 2)
        series = function(low[:, None] + (high - low)[:, None] * share) @ transform.T
        size = max(size, float(np.abs(series[:, 0]).max()))
        weight = (high - low) / breaks[-1] if by_area else 1.0
        last = np.abs(series[:, -3:]).max(axis=1)
        # t itself is rounded, which is a larger share of shorter panels
        of_place = _TERMS * np.spacing(high) / (high - low) * np.abs(series[:, 1:]).sum(axis=1)
        rough = (weight * last > max(tolerance * size, rounding)) & (last > of_place)
        rough &= high - low > 2 * narrowest * breaks[-1]
        done += zip(low[~rough].tolist(), series[~rough], rooted[~rough].tolist(), strict=True)
        middle = (low + high)[rough] / 2
        low, high = np.concatenate([low[rough], middle]), np.concatenate([middle, high[rough]])
        rooted = np.concatenate([rooted[rough], np.zeros(middle.size, dtype=bool)])
    done.sort(key=lambda panel: panel[0])
    coefficients = np.array([each for _, each, _ in done])
    # what is below rounding costs time without a digit
    coefficients[np.abs(coefficients) < 1e-16 * size] = 0.0
    ends = np.array([start for start, _, _ in done] + [breaks[-1]])
    found = RingSources(ends, coefficients, np.array([root for _, _, root in done]), edges)
    _join(found)
    return found


def _join(sources: RingSources) -> None:
    """Make panels meet by linear terms within their error: a jump of g is a ring of infinite stress at the surface.

    The shorter panel takes most of it, as the error is largest on short panels beside kinks.
    """
    series, width = sources.series, np.diff(sources.breaks)
    start, end = (np.asarray(chebyshev.chebval(x, series.T)) for x in (-1.0, 1.0))
    meeting = (width[:-1] * end[:-1] + width[1:] * start[1:]) / (width[:-1] + width[1:])
    at_start = np.concatenate([[0.0], meeting - start[1:]])
    at_end = np.concatenate([meeting - end[:-1], [-end[-1] if sources.edges and sources.edges[-1].power > 0 else 0.0]])
    series[:, 0] += (at_end + at_start) / 2
    series[:, 1] += (at_end - at_start) / 2
