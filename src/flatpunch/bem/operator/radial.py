"""Green's function of the surface from the compliance C(k), as a function of the distance r alone.

    G(r) = (1/2 pi) int_0^inf C(k) J0(kr) k dk = (1/(pi E*)) [1/r + R(r)],      R(r) = int_0^inf (L - 1) J0(kr) dk

With x = kr, R(r) = (1/r) int (L(x l/r) - 1) J0(x) dx. L is smooth on the scale of k itself (its singularities lie off the
real axis by a finite angle), so that cutting the integral off gently around x = 80 changes nothing beyond rounding; and
because both k and r may run on one geometric grid, L is needed once per grid point and the whole table is one sliding
product. Layers, gradings with their slow tails (R ~ log r), and distances from a thousandth of the layer's thickness to
thousands of it take the same few milliseconds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import erfc, j0

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import ROUNDING, Array, Indices
from flatpunch.compliances import Kernel
from flatpunch.numerics.gauss import gauss

STEP = 1.0 / 64.0
"""Step in ln x. The trapezoidal rule aliases at the stationary phase x = 2 pi/step = 402, where the window is zero."""


BLOCK = 256
"""Points of the grid of wavenumbers at which a medium is evaluated at a time; any size serves."""


_NEIGHBOURS = 6
"""Points of the table that a value is read from: step^6/64 of the sixth derivative in ln r is lost, below 1e-13."""


@byte_cached
def _rule(low: int) -> tuple[Array, Array]:
    """x = exp(i step) for i = low ... and the weights of int . J0(x) window dx; what lies below x_low counts as constant."""
    window, width = 80.0, 12.0
    i = np.arange(low, int(np.log(2 * window) / STEP) + 1)
    x = np.exp(i * STEP)
    w = STEP * x * j0(x) * erfc((x - window) / width) / 2
    w[0] += x[0] / np.expm1(STEP) * STEP
    return x, w


@dataclass(frozen=True, slots=True)
class RadialTable:
    """A function of r on a geometric grid, ln r = first + i step; shape (n,). Constant below the first radius.

    Values are read with local polynomials through neighbours.
    """

    first: float
    values: Array

    def __call__(self, r: Array) -> Array:
        """Values at radii r [m], any shape."""
        t = (np.log(np.maximum(r, np.exp(self.first))) - self.first) / STEP
        i = np.clip(t.astype(np.intp) - (_NEIGHBOURS // 2 - 1), 0, self.values.size - _NEIGHBOURS)
        middle = (_NEIGHBOURS - 1) / 2
        t -= i + middle
        return _evaluated(_through(self.values, np.arange(float(_NEIGHBOURS)) - middle), i, t)


def _through(values: Array, places: Array) -> Array:
    """Coefficients (powers, n) of the polynomials through neighbours, which are at these places."""
    through = np.linalg.inv(np.vander(places, increasing=True)).T
    return (np.lib.stride_tricks.sliding_window_view(values, places.size) @ through).T


def _evaluated(polynomials: Array, which: Indices, t: Array) -> Array:
    *lower, highest = polynomials
    result: Array = highest[which]
    for coefficient in reversed(lower):
        result *= t
        result += coefficient[which]
    return result


@dataclass(frozen=True, slots=True)
class CellTable:
    """An even function of r by cubics between equidistant radii, to be read at millions of cells.

    With four steps to a cell and a function that varies on the scale of two dozen cells, (1/96)^4 of it is lost.
    """

    step: float
    cubics: Array

    @classmethod
    def of(cls, radial: Callable[[Array], Array], step: float, r_high: float) -> CellTable:
        """Tabulate a function up to r_high."""
        values = radial(np.abs(np.arange(-1, int(r_high / step) + 4) * step))
        return cls(step, np.ascontiguousarray(_through(values, np.arange(-1.0, 3.0))))

    def __call__(self, r: Array) -> Array:
        """Values at radii r, any shape."""
        t = r / self.step
        i = t.astype(np.intp)
        t -= i
        return _evaluated(self.cubics, i, t)


def remainder_table(kernel: Kernel, r_low: float, r_high: float, cell: float = 0.0) -> RadialTable:
    """Table of R(r) [1/m] between two radii [m], of a compliance with a length of its own.

    With `cell` > 0 it is the average of R over a square cell of this side [m] about r, without its part that varies as cos(4
    phi) and higher.
    """
    length = kernel.length
    first, last = int(np.floor(np.log(r_low) / STEP)) - 3, int(np.ceil(np.log(r_high) / STEP)) + 3
    # notation: i over x = k r, j over r, k = exp((i - j) step)
    low = int(np.floor(np.log(1e-4 * min(kernel.floor, 1e-3) * r_low / length) / STEP))
    low = max(low, int(np.log(1e-13) / STEP))
    x, w = _rule(low)
    offsets = np.arange(low - last, low + x.size - first)
    m = _remainder(kernel, int(offsets[0]), int(offsets[-1]) + 1)
    if cell > 0:
        # L - 1 vanishes beyond the cutoff
        live = m != 0
        m[live] *= isotropic_cell_factor(np.exp(offsets[live] * STEP) * cell)
    # window n starts at k = exp((low - last + n) step), so it belongs to j = last - n
    values = np.correlate(m, w, "valid")[::-1]
    r = np.exp(np.arange(first, last + 1) * STEP)
    return RadialTable(first * STEP, values / r)


def _remainder(kernel: Kernel, start: int, stop: int) -> Array:
    """L - 1 at k = exp(n step), n = start ... stop - 1; all tables of a medium read it on this one grid."""
    first, last = start // BLOCK, -(-stop // BLOCK)
    blocks = np.concatenate([_remainder_block(kernel, block) for block in range(first, last)])
    return blocks[start - first * BLOCK : stop - first * BLOCK].copy()


@byte_cached
def _remainder_block(kernel: Kernel, block: int) -> Array:
    n = np.arange(block * BLOCK, (block + 1) * BLOCK)
    return short_wave_remainder(kernel, np.exp(n * STEP) * kernel.length)


def short_wave_remainder(kernel: Kernel, kappa: Array) -> Array:
    """L - 1, by its tail above the kernel's cutoff."""
    result = kernel.tail / kappa
    live = kappa < kernel.cutoff
    if live.any():
        result[live] = kernel.remainder(kappa[live])
    return np.asarray(result)


def isotropic_cell_factor(q: Array) -> Array:
    """Mean over the direction of k of sinc(kx h/2) sinc(ky h/2), q = k h: the factor on J0(kr) of averaging over a square."""
    # it is 1 - q^2/24 where waves are long
    result, short = np.ones_like(q), q**2 > 24 * ROUNDING
    # an eighth of the circle; beyond q = 60, 1e-13 of it, the remainder is zero or r >> h filters it
    t, v = gauss()
    angle = np.pi / 8 * (t + 1)
    x, y = (np.outer(q[short] / 2, trig(angle)) for trig in (np.cos, np.sin))
    result[short] = (np.sin(x) * np.sin(y) / (x * y)) @ (v / 2)
    return result
