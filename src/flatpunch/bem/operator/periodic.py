"""Displacement from pressure on a grid that repeats along one axis or both.

Along an axis that repeats the wavenumbers are discrete and C(k) itself is the operator: nothing is padded. Along an axis that
ends the grid is doubled, as in free space, and the kernel is the Green's function of each wavenumber q of the other axis,

    g(q, y) = (1/2 pi) int C(sqrt(q^2 + k^2)) e^(iky) dk,      |k| <= pi/spacing

For q > 0 it falls like exp(-q y), so that a sum over the wavenumbers of a period some decay lengths longer takes its place. Waves
about as short as two cells, at which both are cut off, reach farther: they are exact to 1e-4. For q = 0, a line load, the
integral is done by Gauss panels. On an elastic base it is infinite and taken against the displacement at twice the width of the
grid: depths then mean nothing, gaps and pressures are not affected.

The compliance of the mean pressure, C(0), is chosen by the caller: at given force the pressure does not depend on it.
"""

from __future__ import annotations

import numpy as np
import scipy.fft

from flatpunch._support.checks import AT_ONCE, Array
from flatpunch._support.threads import allowed_threads
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator.convolution import (
    THREADED,
    Operator,
    inverse_symbol,
    padded_shape,
    wavenumbers,
    whole_plane,
)
from flatpunch.compliances import Kernel
from flatpunch.numerics.gauss import gauss


def periodic_operator(kernel: Kernel, grid: Grid, periodic: tuple[bool, bool], uniform: float) -> Operator:
    """Operator on a grid, not folded, that repeats along x, y or both; in free space see `build_operator`.

    `uniform` is C(0) [m/Pa], finite. Where one axis ends it only says by being positive or not whether line loads sink without
    limit.
    """
    shape = tuple(
        n if repeats else m for n, m, repeats in zip(grid.shape, padded_shape(grid), periodic[::-1], strict=True)
    )
    my, mx = shape
    qy, qx = (n if repeats else n // 2 for n, repeats in zip(shape, periodic[::-1], strict=True))
    unit = kernel.modulus / grid.spacing
    k = wavenumbers(grid.spacing, (qy, qx))
    if all(periodic):
        spectrum = _symbol(kernel, k, uniform)
    elif periodic[0]:
        spectrum = _half_periodic(kernel, grid.spacing, mx, my, uniform)
    else:
        spectrum = np.ascontiguousarray(_half_periodic(kernel, grid.spacing, my, mx, uniform).T)
    inverse = whole_plane(inverse_symbol(kernel, k), qy)
    if all(periodic) and uniform > 0:
        inverse[0, 0] = 1 / uniform
    threads = allowed_threads() if grid.nx * grid.ny >= THREADED else 1
    smoothing = whole_plane(np.exp(-k * grid.spacing), qy)
    return Operator(grid, spectrum * unit, inverse / unit, smoothing, (my, mx), (qy, qx), np, threads)


def _symbol(kernel: Kernel, k: Array, uniform: float) -> Array:
    """C(|k|) in a quadrant of wavenumbers, the first of which is zero."""
    values = np.full(k.size, uniform)
    values[1:] = kernel(k.ravel()[1:])
    return values.reshape(k.shape)


def _half_periodic(kernel: Kernel, spacing: float, period: int, padded: int, uniform: float) -> Array:
    """Transform of g(q, y) over y, in a quadrant (padded/2 + 1, period/2 + 1) of wavenumbers; `period` cells repeat along x."""
    count = padded // 2 + 1
    g = np.empty((count, period // 2 + 1))
    g[:, 0] = _line_load(kernel, spacing, count, vanishing=uniform > 0)
    for i in range(1, g.shape[1]):
        q = 2 * np.pi * i / (period * spacing)
        # images decayed to the rounding of double precision
        longer = scipy.fft.next_fast_len(padded + int(-np.log(np.finfo(float).eps) / (q * spacing)), real=True)
        k = 2 * np.pi * scipy.fft.rfftfreq(longer, spacing)
        g[:, i] = scipy.fft.irfft(kernel(np.hypot(q, k)), longer)[:count]
    return np.asarray(scipy.fft.dct(g, type=1, axis=0))


def _line_load(kernel: Kernel, spacing: float, count: int, *, vanishing: bool) -> Array:
    """g(0, y) times the side of a cell at `count` distances; less its value at the farthest of them if not `vanishing`."""
    farthest = (count - 1) * spacing
    # a wave of the farthest distance for each panel, below that ever shorter ones: C varies with ln k there
    octaves = np.geomspace(1e-8, 1.0, 28)
    edges = np.concatenate([[0.0], octaves, np.arange(2, count // 2 + 1)]) * (2 * np.pi / farthest)
    edges = np.append(edges[edges < np.pi / spacing], np.pi / spacing)
    nodes, weights = gauss()
    half = np.diff(edges)[:, None] / 2
    k, w = (edges[:-1, None] + half * (nodes + 1)).ravel(), (half * weights).ravel()
    w *= kernel(k) * spacing / np.pi
    y = spacing * np.arange(count)
    parts = np.array_split(y, -(-count * k.size // AT_ONCE))
    values = np.concatenate([np.cos(np.outer(part, k)) @ w for part in parts])
    return values if vanishing else values - values[-1]
