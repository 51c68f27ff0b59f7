"""Half-space integrals of a round load in closed form: complex ring sources.

A round pressure with the transform P(k) = int_0^a g(t) cos(kt) dt, p(r) = int k P J_0(kr) dk, needs at depth the integrals

    I_mj(r, z) = int_0^inf k^j P(k) J_m(kr) exp(-kz) dk = Re int_0^a g(t) (i d/dt)^j kappa_m dt,
    kappa_m = exp(-m v)/(r cosh v),     r sinh v = z + i t,

a ring source at the complex depth z + i t (m = 0: 1/sqrt(r^2 + (z + it)^2)). Two integrations by parts leave g'' under the
integral, with antiderivatives of kappa_m that are elementary in v. In v the integrand is free of singularities, and the path
from end to end of a panel is a straight line in the complex plane, so that Gauss quadrature is exact at any depth, z = 0 and
the rim included. g is a polynomial on each panel; where it has degree one (cones) no integral is left.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import scipy
from numpy.polynomial import chebyshev
from numpy.polynomial import legendre as polynomial
from numpy.typing import NDArray

from flatpunch._support.checks import Array
from flatpunch._support.threads import in_threads
from flatpunch.numerics.chebyshev import unit_nodes
from flatpunch.numerics.gauss import gauss

ORDERS = 4
"""Angular orders m = 0 ... 3: friction needs them all, a normal load the first three."""

_TERMS = 16
"""Chebyshev terms on a panel of g."""


_SLOW = 24.0
"""Largest k times half a panel at which Gauss quadrature is used for its transform; more than the terms on a panel."""

_SPAN, _SAMPLES = 64.0, 72
"""Length of a span of k times the radius, and Chebyshev nodes that give the transform all over it: they leave J_72(32) = 2e-19 of
cos(kt)."""

_CHUNK = 2048
"""Points at once: their arrays stay in the cache."""


_JUMP = 1e-13, 1e-11
"""Jumps of g and g' between panels, over the largest g (and the radius), that are approximation error."""

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class RingSources:
    """g(t) as Chebyshev series on panels.

    Parameters
    ----------
    breaks : ndarray, shape (panels + 1,)
        Ends of the panels, from 0 to the radius of the load [m].
    series : ndarray, shape (panels, terms)
        Chebyshev coefficients of g on each panel [Pa].
    """

    breaks: Array
    series: Array

    @property
    def radius(self) -> float:
        """Radius of the load [m]."""
        return float(self.breaks[-1])

    @property
    def shallow(self) -> float:
        """Depth to which the closed form is used under a power-law half-space [m]: deeper there is no need."""
        return self.radius / 12

    @property
    def force(self) -> float:
        """Total load [N], 2 pi P(0)."""
        return float(2 * np.pi * self.transform(np.zeros(1))[0])

    @cached_property
    def _second(self) -> Array:
        """Coefficients of g'' on each panel."""
        half = np.diff(self.breaks)[:, None] / 2
        return np.asarray(chebyshev.chebder(self.series, 2, axis=1) / half**2)

    @cached_property
    def _jumps(self) -> tuple[Array, Array]:
        """Jumps of g and g' at the breaks, value below minus value above, shape (panels + 1,) each."""
        half = np.diff(self.breaks)[:, None] / 2
        slopes = chebyshev.chebder(self.series, 1, axis=1) / half
        size = float(np.abs(chebyshev.chebval(np.linspace(-1, 1, 9), self.series.T)).max())
        found = []
        for coefficients, scale, share in zip((self.series, slopes), (size, size / self.radius), _JUMP, strict=True):
            start, end = (chebyshev.chebval(x, coefficients.T) for x in (-1.0, 1.0))
            jump = np.concatenate([[0.0], end]) - np.concatenate([start, [0.0]])
            found.append(np.where(np.abs(jump) > share * scale, jump, 0.0))
        return found[0], found[1]

    def value(self, t: Array) -> Array:
        """g at 0 <= t <= radius [Pa]."""
        flat = t.ravel()
        panel = np.clip(np.searchsorted(self.breaks, flat, side="right") - 1, 0, len(self.series) - 1)
        low, high = self.breaks[panel], self.breaks[panel + 1]
        found = chebyshev.chebval((2 * flat - low - high) / (high - low), self.series[panel].T, tensor=False)
        return np.asarray(found.reshape(t.shape))

    def transform(self, k: Array) -> Array:
        """P(k) = int g cos(kt) dt [Pa m], shape of k, (n,).

        g ends at the radius, so that P is as smooth as cos(ka): where wavenumbers are dense it is interpolated between
        Chebyshev nodes.
        """
        span, total = np.floor(k * (self.radius / _SPAN)), np.empty_like(k)
        spans, which, counts = np.unique(span, return_inverse=True, return_counts=True)
        crowded = counts > 2 * _SAMPLES
        few = ~crowded[which]
        total[few] = self._on_product(k[few], np.zeros(1))[:, 0]
        length = _SPAN / self.radius
        values = self._on_product(spans[crowded] * length, length * (1 + unit_nodes(_SAMPLES)) / 2)
        series = scipy.fft.dct(values, axis=1) / _SAMPLES
        series[:, 0] /= 2
        for i, own in zip(np.flatnonzero(crowded), series, strict=True):
            here = np.flatnonzero(which == i)
            total[here] = chebyshev.chebval(2 * (k[here] / length - spans[i]) - 1, own)
        return total

    def _on_product(self, start: Array, offset: Array) -> Array:
        """P at start_i + offset_j, shape (starts, offsets), offsets >= 0.

        Gauss quadrature where a panel holds few oscillations. Beyond, Legendre's series: int P_n(x) exp(iwx) dx = 2 i^n j_n(w).
        """
        total = np.zeros((start.size, offset.size))
        if not start.size:
            return total
        k = start[:, None] + offset
        for low, high, series in zip(self.breaks[:-1], self.breaks[1:], self.series, strict=True):
            half, middle = (high - low) / 2, (high + low) / 2
            own = chebyshev.chebtrim(series)
            slow = start * half <= _SLOW
            if slow.any():
                x, w = gauss(own.size + 8 + int(0.6 * (_SLOW + offset.max() * half)))
                t, weight = middle + half * x, chebyshev.chebval(x, own) * w * half
                total[slow] += _cosines(start[slow], t, weight, offset)
            fast = k[~slow]
            total[~slow] += 2 * half * _oscillating(own, fast * half, fast * middle)
        return total

    def integrals(self, r: Array, z: Array) -> Array:
        """I_mj at points (r, z), shape (n,), with z >= 0.

        Returns
        -------
        ndarray, shape (4, 3, n)
            m = 0 ... 3, j = 0, 1, 2 [Pa m^(1-j)].
        """
        result = np.empty((ORDERS, 3, r.size))
        # on the axis all orders but m = 0 vanish; this far off it they do, to rounding
        r = np.maximum(r, 1e-20 * self.radius)

        def fill(i: int) -> None:
            some = slice(i * _CHUNK, (i + 1) * _CHUNK)
            result[:, :, some] = self._chunk(r[some], z[some])

        # floating-point operations at a point and panel, for the choice of threads
        in_threads(fill, -(-r.size // _CHUNK), operations=1e4 * r.size * len(self.series))
        return result

    def _chunk(self, r: Array, z: Array) -> Array:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            v = np.arcsinh((z + 1j * self.breaks[:, None]) / r)
        result = np.zeros((ORDERS, 3, r.size))
        for at, of_value, of_slope in zip(v, *self._jumps, strict=True):
            if of_value or of_slope:
                _add_end(result, at, r, of_value, of_slope)
        for i, series in enumerate(self._second):
            if not np.any(series):
                continue
            middle, half = (self.breaks[i] + self.breaks[i + 1]) / 2, (self.breaks[i + 1] - self.breaks[i]) / 2
            # length of the path in v above which more nodes are needed
            long = np.abs(v[i + 1] - v[i]) > 3.0
            # Gauss nodes on a panel: exact for polynomials g'' of degree 13 on a straight path
            # Gauss nodes where the path in v is long, on the axis close to the surface
            for chosen, nodes in ((~long, 16), (long, 64)):
                if chosen.all():
                    _add_panel(result, (v[i], v[i + 1]), r, z, (middle, half), series, nodes)
                elif chosen.any():
                    part = np.zeros((ORDERS, 3, int(chosen.sum())))
                    ends = v[i][chosen], v[i + 1][chosen]
                    _add_panel(part, ends, r[chosen], z[chosen], (middle, half), series, nodes)
                    result[:, :, chosen] += part
        return result


@lru_cache(maxsize=64)
def _to_legendre(terms: int) -> Array:
    """Matrix from Chebyshev to Legendre coefficients, shape (terms, terms)."""
    x, w = gauss(terms)
    values = polynomial.legvander(x, terms - 1) * (np.arange(terms) + 0.5)
    return np.asarray((values.T * w) @ chebyshev.chebvander(x, terms - 1))


def _cosines(start: Array, t: Array, weight: Array, offset: Array) -> Array:
    """Sum over t of weight cos((start_i + offset_j) t), shape (starts, offsets)."""
    first, second = np.outer(start, t), np.outer(t, offset)
    cosines = (np.cos(first) * weight) @ np.cos(second)
    return np.asarray(cosines - (np.sin(first) * weight) @ np.sin(second) if offset.any() else cosines)


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
    narrowest: float,
    *,
    rounding: float = 0.0,
    vanishing: bool = False,
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
    rounding : float
        Rounding error of g [Pa], which no panel can resolve.
    vanishing : bool
        Whether g is zero at the radius.
    """
    nodes = np.cos(np.pi * (np.arange(_TERMS) + 0.5) / _TERMS)
    transform = chebyshev.chebvander(nodes, _TERMS - 1).T * 2 / _TERMS
    transform[0] /= 2
    pending = np.column_stack([breaks[:-1], breaks[1:]])
    done: list[tuple[float, Array]] = []
    size = 0.0
    while len(pending):
        middle, half = pending.mean(axis=1, keepdims=True), np.diff(pending, axis=1) / 2
        series = function(middle + half * nodes) @ transform.T
        size = max(size, float(np.abs(series[:, 0]).max()))
        rough = np.abs(series[:, -3:]).max(axis=1) > max(tolerance * size, rounding)
        rough &= half[:, 0] > narrowest * breaks[-1]
        done += [(float(low), each) for low, each in zip(pending[~rough, 0], series[~rough], strict=True)]
        centre = middle[rough, 0]
        pending = np.concatenate(
            [np.column_stack([pending[rough, 0], centre]), np.column_stack([centre, pending[rough, 1]])]
        )
    done.sort(key=lambda panel: panel[0])
    coefficients = np.array([each for _, each in done])
    # what is below rounding costs time without a digit
    coefficients[np.abs(coefficients) < 1e-16 * size] = 0.0
    found = RingSources(np.array([low for low, _ in done] + [breaks[-1]]), coefficients)
    _join(found, vanishing=vanishing)
    return found


def _join(sources: RingSources, *, vanishing: bool) -> None:
    """Make panels meet by linear terms within their error: a jump of g is a ring of infinite stress at the surface.

    The shorter panel takes most of it, as the error is largest on short panels beside kinks.
    """
    series, width = sources.series, np.diff(sources.breaks)
    start, end = (np.asarray(chebyshev.chebval(x, series.T)) for x in (-1.0, 1.0))
    meeting = (width[:-1] * end[:-1] + width[1:] * start[1:]) / (width[:-1] + width[1:])
    at_start = np.concatenate([[0.0], meeting - start[1:]])
    at_end = np.concatenate([meeting - end[:-1], [-end[-1] if vanishing else 0.0]])
    series[:, 0] += (at_end + at_start) / 2
    series[:, 1] += (at_end - at_start) / 2


def _add_end(result: Array, v: Complex, r: Array, of_value: float, of_slope: float) -> None:
    """What the jumps of g and g' at one break leave."""
    e = np.exp(-v)
    root = r * np.cosh(v)
    root = np.where(root == 0, 1e-150, root)
    tangent = np.tanh(v)
    powers = np.ones_like(e)
    for m in range(ORDERS):
        kappa = powers / root
        first, second = _antiderivatives(m, v, e, r)
        result[m, 0] += (of_value * first - of_slope * second).real
        result[m, 1] -= (of_value * kappa - of_slope * first).imag
        with np.errstate(over="ignore", invalid="ignore"):
            steep = -1j * kappa * (m + tangent) / root if of_value else 0.0
        result[m, 2] -= (of_value * steep - of_slope * kappa).real
        powers = powers * e


def _antiderivatives(m: int, v: Complex, e: Complex, r: Array) -> tuple[Any, Any]:
    """First and second antiderivative of kappa_m over t; e = exp(-v)."""
    if m == 0:
        return -1j * v, -r * (v * np.sinh(v) - np.cosh(v))
    if m == 1:
        return 1j * e, r / 2 * (v - e * e / 2)
    if m == 2:
        return 0.5j * e * e, -r / 4 * (e + e**3 / 3)
    return 1j / 3 * e**3, -r / 6 * (e * e / 2 + e**4 / 4)


def _add_panel(
    result: Array,
    ends: tuple[Complex, Complex],
    r: Array,
    z: Array,
    panel: tuple[float, float],
    series: Array,
    nodes: int,
) -> None:
    """Integrals of g'' with kappa_m and its antiderivatives over one panel, along the straight path in v."""
    x, weight = gauss(nodes)
    half = (ends[1] - ends[0]) / 2
    v = (ends[1] + ends[0]) / 2 + half * x[:, None]
    e = np.exp(-v)
    inverse = 1 / e
    cosh = (inverse + e) * (0.5 * r)
    sinh = (inverse - e) * (0.5 * r)
    # t = -i (r sinh v - z), in the panel's own variable
    s: Complex = np.asarray(((z - sinh) * 1j - panel[0]) / panel[1], dtype=complex)
    w = _clenshaw(s, series)
    w *= half * weight[:, None]
    # notation: dt = -i r cosh(v) dv; `cosh`, `sinh` carry the factor r
    wc = w * cosh
    second = v * sinh - cosh
    result[0, 0] += (1j * wc * second).sum(0).real
    result[0, 1] += (wc * v).sum(0).imag
    result[0, 2] -= (-1j * w).sum(0).real
    e2 = e * e
    result[1, 0] += (-0.5j * wc * (v - e2 / 2)).sum(0).real * r
    first = (wc * e).sum(0)
    result[1, 1] -= first.imag
    result[1, 2] -= (-1j * w * e).sum(0).real
    result[2, 0] += (0.25j * wc * e * (1 + e2 / 3)).sum(0).real * r
    result[2, 1] -= (wc * e2).sum(0).imag / 2
    w *= e2
    result[2, 2] -= (-1j * w).sum(0).real
    result[3, 0] += (1j / 12 * wc * e2 * (1 + e2 / 2)).sum(0).real * r
    wc *= e2
    wc *= e
    result[3, 1] -= wc.sum(0).imag / 3
    w *= e
    result[3, 2] -= (-1j * w).sum(0).real


def _clenshaw(s: Complex, series: Array) -> Complex:
    """Chebyshev series at complex s."""
    last = np.flatnonzero(series)[-1] + 1
    if last == 1:
        return np.full_like(s, series[0])
    twice = 2 * s
    ahead, current = np.zeros_like(s), np.full_like(s, series[last - 1])
    for c in series[last - 2 : 0 : -1]:
        np.subtract(twice * current, ahead, out=ahead)
        ahead += c
        ahead, current = current, ahead
    result = s * current
    result -= ahead
    result += series[0]
    return np.asarray(result)
