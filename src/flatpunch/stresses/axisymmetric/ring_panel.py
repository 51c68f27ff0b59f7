"""Integrals of a ring source over one panel of g(t), along a path in the complex plane.

In v, r sinh v = z + i t, kappa_m dt = -i exp(-m v) dv is free of singularities, and the path from end to end of a panel is a
straight line in the complex plane, so that Gauss quadrature is exact at any depth, z = 0 and the rim included. Integration by
parts moves the derivatives to g. With b the beginning of a panel,

    - int g kappa'' dt = -[g kappa'] + [g' (kappa - kappa(b))] - int g'' (kappa - kappa(b)) dt.

The constant kappa(b) removes the cancellation between neighbouring panels, so that panels may be as narrow as a singularity of g
needs. Where g begins with a root the path is described by s = sqrt((v - v_b)/(v_c - v_b)), in which all is smooth again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from flatpunch._support.checks import Array
from flatpunch.numerics.chebyshev import Numbers
from flatpunch.numerics.gauss import gauss

Complex = NDArray[np.complexfloating]

ORDERS = 4
"""Angular orders m = 0 ... 3: friction needs them all, a normal load the first three."""


_NODES = 16
"""Gauss nodes on a path: 2e-12 of the stress; half as many leave 4e-7, twice as many 3e-13. Twice as many on panels that begin
with a root, where as many leave 3e-7."""

_LONG = 3.0
"""Longest path that is not divided, and longest part of one that is; twice as long leaves 8e-10, half changes nothing and takes a
quarter more time."""


def add_jump(result: Numbers, v: Complex, r: Array, jump: float) -> None:
    """What a jump of g leaves."""
    kappa = jump / (r * np.cosh(v))
    for m in range(ORDERS):
        _add(result[m, 1], 1j * kappa)
        _add(result[m, 2], 1j * kappa * (m + np.tanh(v)) / (r * np.cosh(v)))
        kappa = kappa * np.exp(-v)


def _add(result: Numbers, values: Complex) -> None:
    """Add values, or their real part to a real result."""
    result += values if np.iscomplexobj(result) else values.real


def _span(start: Complex, end: Complex, r: Array, length: float) -> Complex:
    """v_c - v_b, without a difference of nearly equal numbers on short panels."""
    direct: Complex = end - start
    return np.where(np.abs(direct) > 1.0, direct, 2 * np.arcsinh(0.5j * length / (r * np.cosh((start + end) / 2))))


@dataclass(frozen=True, eq=False)
class Panel:
    """g on b < t < c as a Chebyshev series, in (t - b)/(c - b) or, where g has a root at b, in the square root of that."""

    length: float
    series: Array
    rooted: bool

    def add(self, result: Numbers, start: Complex, end: Complex, r: Array) -> None:
        """Add the integrals over the panel, along straight paths from v_b = `start` to v_c = `end`; long paths in pieces."""
        span = _span(start, end, r, self.length)
        lengths = np.abs(span)
        long = lengths > _LONG
        for chosen, pieces in ((~long, 1), (long, int(np.ceil(lengths.max() / _LONG)))):
            if chosen.all():
                self._add(result, start, span, r, pieces)
            elif chosen.any():
                part = np.zeros_like(result[..., chosen])
                self._add(part, start[chosen], span[chosen], r[chosen], pieces)
                result[:, :, chosen] += part

    def _add(self, result: Numbers, start: Complex, span: Complex, r: Array, pieces: int) -> None:
        """Add the integrals along paths of length `span`, in equal pieces."""
        x, weight = gauss(2 * _NODES if self.rooted else _NODES)
        s = ((np.arange(pieces)[:, None] + (1 + x) / 2) / pieces).reshape(-1, 1)
        weight = np.tile(weight / (2 * pieces), pieces)[:, None]
        part, dv = (span * s**2, 2 * span * s * weight) if self.rooted else (span * s, span * weight)
        # notation: `decay` = exp(v_b - v) - 1; plus and minus are r exp(v_b)/2 and r exp(-v_b)/2; 1 + decay cancels on long paths
        plus, minus = r * np.exp(start) / 2, r * np.exp(-start) / 2
        decay, grown = np.expm1(-part), plus * np.exp(part)
        last, grown_last = np.expm1(-span), plus * np.exp(span)
        # t - b = -i r (sinh v - sinh v_b)
        value, slope, second = self._derivatives(s, 1j * decay * (grown + minus) / self.length)
        value, slope, second = -1j * dv * value, dv * slope, 1j * dv * second
        # 1 - cosh v/cosh v_b, at the nodes and at the end of the panel
        change = decay * (grown - minus) / (plus + minus)
        change_last = last * (grown_last - minus) / (plus + minus)
        at_end = self._end_slope / (grown_last + minus * np.exp(-span))
        power, since, since_last = np.ones_like(start), np.zeros_like(decay), np.zeros_like(last)
        for m in range(ORDERS):
            # exp(-m v) = power (1 + since)
            _add(result[m, 0], power * (value * (1 + since)).sum(0))
            _add(result[m, 1], -power * (slope * (1 + since)).sum(0))
            _add(result[m, 2], power * ((second * (since + change)).sum(0) + at_end * (since_last + change_last)))
            power = power * np.exp(-start)
            since, since_last = since + decay * (1 + since), since_last + last * (1 + since_last)

    def _derivatives(self, s: Array, share: Complex) -> tuple[Complex, Complex, Complex]:
        """g, g' and g'' at the complex (t - b)/(c - b) that belong to s."""
        slopes = chebyshev.chebder(self.series) * 2
        curvatures = chebyshev.chebder(slopes) * 2
        u: Complex = np.asarray(s * np.sqrt(share / s**2) if self.rooted else share, dtype=complex)
        value, slope, second = (_clenshaw(2 * u - 1, each) for each in (self.series, slopes, curvatures))
        if not self.rooted:
            return value, slope / self.length, second / self.length**2
        # dt = 2 (c - b) u du
        stretch = 2 * self.length * u
        return value, slope / stretch, (second - slope / u) / stretch**2

    @property
    def _end_slope(self) -> float:
        slope = 2 * float(chebyshev.chebval(1.0, chebyshev.chebder(self.series)))
        return slope / (self.length * (2 if self.rooted else 1))


def _clenshaw(s: Complex, series: Numbers) -> Complex:
    """Chebyshev series at complex s."""
    if series.size == 1:
        return np.full_like(s, series[0])
    twice = 2 * s
    ahead, current = np.zeros_like(s), np.full_like(s, series[-1])
    for c in series[-2:0:-1]:
        np.subtract(twice * current, ahead, out=ahead)
        ahead += c
        ahead, current = current, ahead
    result = s * current
    result -= ahead
    result += series[0]
    return np.asarray(result)
