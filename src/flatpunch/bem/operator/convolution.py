"""Displacement of the surface from the pressure on a grid, u = G * p in free space, and an approximate inverse.

The convolution is done by FFT on the doubled grid, so that nothing is periodic. Only half of that grid's rows carry
pressure and only half of them are needed: rows are transformed first (real to complex), then the columns in narrow
blocks, so that the doubled spectrum never exists as a whole. The coefficients are even in x and y, hence their
transform is real and a quarter of it is kept (a cosine transform). On a folded grid the pressure is even as well, and cosine
transforms of half the length take the place of Fourier transforms along the axes that are folded: then columns, while they are
real, go first if they are even, and rows follow in blocks.

Here lengths are in cells and pressures in units of E*: numbers of order one, safe in single precision.

The approximate inverse divides by the symbol C(|k|) on the grid itself, without padding. It is positive by construction, unlike
the transform of the truncated coefficients, whose lowest entries can be negative under stiff films. Conjugate gradients also
want displacements extended smoothly beyond the contact (conjugate.py): `spread` is what they are averaged with.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import repeat

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch._support.threads import allowed_threads
from flatpunch.bem.grid import Cells, Grid, Namespace
from flatpunch.bem.operator.influence import influence_coefficients
from flatpunch.bem.operator.radial import BLOCK, STEP
from flatpunch.compliances import Kernel

Axes = tuple[int, ...]
Numbers = NDArray[np.inexact]
"""Real or complex, in single or double precision."""


def padded(values: Numbers, shape: tuple[int, int]) -> Numbers:
    """Array whose last two axes are continued with zeros to a shape; always a new one, which transforms may overwrite."""
    ny, nx = values.shape[-2:]
    wide = np.empty((*values.shape[:-2], *shape), dtype=values.dtype)
    wide[..., :ny, :nx] = values
    wide[..., ny:, :] = 0
    wide[..., :ny, nx:] = 0
    return wide


def cosine(values: Numbers, axes: Axes, threads: int = 1) -> Numbers:
    """Transform of arrays that are even about half a cell before their first value (type 2); overwrites them."""
    return np.asarray(scipy.fft.dctn(values, axes=axes, workers=threads, overwrite_x=True))


def cosine_back(spectrum: Numbers, axes: Axes, threads: int = 1) -> Numbers:
    """Inverse of `cosine`; overwrites the spectrum."""
    return np.asarray(scipy.fft.idctn(spectrum, axes=axes, workers=threads, overwrite_x=True))


def fourier(values: Numbers, axes: Axes, threads: int = 1) -> Numbers:
    """Transform of real arrays, of which half is kept along the last of the axes."""
    return np.asarray(scipy.fft.rfftn(values, axes=axes, workers=threads))


def fourier_back(spectrum: Numbers, size: int, axes: Axes, threads: int = 1) -> Numbers:
    """Inverse of `fourier`, with `size` values along the last of the axes; overwrites the spectrum."""
    shape = [*(spectrum.shape[axis] for axis in axes[:-1]), size]
    return np.asarray(scipy.fft.irfftn(spectrum, shape, axes=axes, workers=threads, overwrite_x=True))


BYTES_PER_CELL = 200
"""Upper bound of what operator and solver together hold per cell in double precision; a test measures it."""


SINGLE_FLOOR = 1e-5
"""Smallest tolerance in single precision; a tenth of it is below its rounding."""

THREADED = 500**2
"""Number of cells above which threads are used; below, two of them take up to four times as long as one."""


@dataclass(frozen=True, slots=True)
class Operator:
    """Free-space convolution with the influence coefficients of a medium, on one grid.

    Attributes
    ----------
    grid : Grid
        The grid.
    spectrum : array, shape (my/2 + 1, mx/2 + 1)
        Transform of the coefficients on the padded grid of my x mx cells; real, one quarter.
    inverse : array, shape (qy, qx/2 + 1)
        1/C(|k|) on the periodic grid of the preconditioner.
    smoothing : array, shape (qy, qx/2 + 1)
        exp(-|k| h), h the side of a cell, on the same grid.
    padded, periodic : (int, int)
        Shapes (my, mx) and (qy, qx).
    xp : module
        Array namespace of the work; NumPy unless another was asked for.
    threads : int
        Threads of the transforms (NumPy only).
    """

    grid: Grid
    spectrum: Cells
    inverse: Cells
    smoothing: Cells
    padded: tuple[int, int]
    periodic: tuple[int, int]
    xp: Namespace
    threads: int

    @property
    def repeats(self) -> bool:
        """Whether the grid repeats along an axis: it is not padded there."""
        return any(n == m for n, m in zip(self.grid.shape, self.padded, strict=True))

    def apply(self, pressure: Cells) -> Cells:
        """Displacement [cells] of a pressure [E*], shape (..., ny, nx)."""
        if self.xp is np:
            return self._apply_numpy(pressure)
        return self._apply_standard(pressure)

    def precondition(self, gap: Cells) -> Cells:
        """Pressure [E*] that approximately removes a gap error [cells], shape (ny, nx)."""
        return self._periodic(gap, self.inverse)

    def spread(self, values: Cells) -> Cells:
        """Values averaged with weights 1/(r^2 + h^2)^(3/2), whose transform is `smoothing`; shape (ny, nx)."""
        return self._periodic(values, self.smoothing)

    def single(self) -> Operator:
        """Operator in single precision."""
        xp = self.xp
        names = ("spectrum", "inverse", "smoothing")
        return replace(self, **{name: xp.astype(getattr(self, name), xp.float32) for name in names})

    def asarray(self, values: Cells) -> Cells:
        """NumPy values as an array of this operator's namespace and precision."""
        return self.xp.asarray(np.asarray(values), dtype=self.spectrum.dtype)

    def _apply_numpy(self, pressure: Array) -> Array:
        return self._columns_first(pressure) if self.grid.mirrored[1] else self._rows_first(pressure)

    def _columns_first(self, pressure: Array) -> Array:
        """Columns that are even are transformed while they are real, and then rows in blocks."""
        (my, mx), (ny, nx), threads = self.padded, self.grid.shape, self.threads
        even = self.grid.mirrored[0]
        columns = cosine(padded(pressure, (my // 2, nx)), (-2,), threads)
        count = _block(mx)

        def convolve(first: int, inside: int) -> None:
            rows = slice(first, min(first + count, my // 2))
            block = padded(columns[..., rows, :], (rows.stop - first, mx // (1 + even)))
            columns[..., rows, :] = _convolved(block, (-1,), self.spectrum[rows], inside, even=even)[..., :nx]

        self._in_blocks(convolve, range(0, my // 2, count))
        return np.asarray(cosine_back(columns, (-2,), threads)[..., :ny, :])

    def _rows_first(self, pressure: Array) -> Array:
        """Only the rows that carry pressure are transformed, and then columns in blocks."""
        (my, mx), (ny, nx), threads = self.padded, self.grid.shape, self.threads
        even = self.grid.mirrored[0]
        wide = padded(pressure, (ny, mx // (1 + even)))
        rows = cosine(wide, (-1,), threads) if even else fourier(wide, (-1,), threads)
        count = _block(my)

        def convolve(first: int, inside: int) -> None:
            columns = slice(first, min(first + count, rows.shape[-1]))
            block, factor = padded(rows[..., columns], (my, columns.stop - first)), self.spectrum[:, columns]
            if even:
                block = _convolved(block, (-2,), factor, inside)
            else:
                block = scipy.fft.fft(block, axis=-2, workers=inside, overwrite_x=True)
                block[..., : factor.shape[0], :] *= factor
                block[..., factor.shape[0] :, :] *= factor[my - factor.shape[0] : 0 : -1]
                block = scipy.fft.ifft(block, axis=-2, workers=inside, overwrite_x=True)
            rows[..., columns] = block[..., :ny, :]

        self._in_blocks(convolve, range(0, rows.shape[-1], count))
        u = cosine_back(rows, (-1,), threads) if even else fourier_back(rows, mx, (-1,), threads)
        return np.asarray(u[..., :nx])

    def _in_blocks(self, convolve: Callable[[int, int], None], blocks: range) -> None:
        """Convolve blocks that begin at these places, side by side: so also what is not a transform has several threads."""
        if self.threads > 1:
            with ThreadPoolExecutor(self.threads) as pool:
                list(pool.map(convolve, blocks, repeat(1)))
        else:
            for first in blocks:
                convolve(first, 1)

    def _periodic(self, values: Cells, factor: Cells) -> Cells:
        """Values times a factor in the space of wavenumbers of the grid, without padding; shape (ny, nx)."""
        (qy, qx), (ny, nx), threads = self.periodic, self.grid.shape, self.threads
        if self.xp is not np:
            fft = self.xp.fft
            spectrum = fft.rfftn(values, s=self.periodic, axes=(0, 1)) * factor
            return fft.irfftn(spectrum, s=self.periodic, axes=(0, 1))[:ny, :nx]
        along_x, along_y = self.grid.mirrored
        wide = padded(values, (qy // (1 + along_y), qx // (1 + along_x)))
        if along_x == along_y:
            u = _convolved(wide, (0, 1), factor, threads, even=along_x)
        else:
            even, other = ((1,), (0,)) if along_x else ((0,), (1,))
            u = cosine_back(_convolved(cosine(wide, even, threads), other, factor, threads), even, threads)
        return np.asarray(u[:ny, :nx])

    def _apply_standard(self, pressure: Cells) -> Cells:
        (my, mx), (ny, nx), xp = self.padded, self.grid.shape, self.xp
        half = self.spectrum
        rows = xp.fft.fft(xp.fft.rfft(pressure, n=mx, axis=1), n=my, axis=0)
        full = xp.concat([half, xp.flip(half[1 : my - half.shape[0] + 1, :], axis=0)], axis=0)
        u = xp.fft.ifft(rows * full, axis=0)[:ny, :]
        return xp.fft.irfft(u, n=mx, axis=1)[:, :nx]


def _convolved(block: Cells, axes: Axes, factor: Array, threads: int, *, even: bool = False) -> Cells:
    """Real values convolved along axes: their transforms, cosine ones if they are `even`, times a factor that may be larger."""
    spectrum = cosine(block, axes, threads) if even else fourier(block, axes, threads)
    spectrum *= factor[: spectrum.shape[-2], : spectrum.shape[-1]]
    if even:
        return cosine_back(spectrum, axes, threads)
    return fourier_back(spectrum, block.shape[axes[-1]], axes, threads)


def _block(length: int) -> int:
    """Lines transformed at a time: 64, or as many as make 2^15 numbers, since calls cost as much as small transforms."""
    return max(64, 2**15 // length)


def build_operator(
    kernel: Kernel, grid: Grid, *, xp: Namespace = np, coefficients: Array | None = None, solving: bool = True
) -> Operator:
    """Transform of the influence coefficients and, for solving, of the approximate inverse on a grid.

    `xp` is an array namespace (array API standard with its fft extension); folded grids need NumPy, the standard has no cosine
    transforms. `coefficients` are those of `coefficients_for`, where they are known already.
    """
    ny, nx = grid.shape
    threads = allowed_threads() if nx * ny >= THREADED else 1
    my, mx = padded_shape(grid)
    periodic = (my // 2, mx // 2)
    unit = kernel.modulus / grid.spacing
    g = (coefficients_for(kernel, grid) if coefficients is None else coefficients) * unit
    # even about their first and last values
    spectrum = np.asarray(scipy.fft.dctn(g, type=1, workers=threads, overwrite_x=True))
    inverse = smoothing = np.empty((0, 0))
    if solving:
        k = wavenumbers(grid.spacing, periodic)
        inverse, smoothing = (
            whole_plane(half, periodic[0]) for half in (inverse_symbol(kernel, k), np.exp(-k * grid.spacing))
        )
        inverse /= unit
    if xp is not np:
        spectrum, inverse, smoothing = (xp.asarray(part) for part in (spectrum, inverse, smoothing))
    return Operator(grid, spectrum, inverse, smoothing, (my, mx), periodic, xp, threads)


def padded_shape(grid: Grid) -> tuple[int, int]:
    """Cells (my, mx) of the doubled grid; on folded grids transforms are as long as the part that is kept."""
    my, mx = (
        2 * (1 + half) * scipy.fft.next_fast_len(n, real=True)
        for n, half in zip(grid.shape, reversed(grid.mirrored), strict=True)
    )
    return my, mx


def coefficients_for(kernel: Kernel, grid: Grid) -> Array:
    """Influence coefficients [m/Pa] at all offsets on the doubled grid, shape (my/2 + 1, mx/2 + 1)."""
    my, mx = padded_shape(grid)
    return influence_coefficients(kernel, grid.spacing, (my // 2 + 1, mx // 2 + 1))


def wavenumbers(spacing: float, shape: tuple[int, int]) -> Array:
    """|k| [1/m] in one quadrant of a periodic grid, shape (ny/2 + 1, nx/2 + 1)."""
    ny, nx = shape
    ky = 2 * np.pi * np.abs(scipy.fft.fftfreq(ny, spacing))[: ny // 2 + 1]
    kx = 2 * np.pi * scipy.fft.rfftfreq(nx, spacing)
    return np.asarray(np.hypot(kx, ky[:, None]))


def whole_plane(quadrant: Array, ny: int) -> Array:
    """What is even in ky, shape (ny/2 + 1, m), at all ny of them."""
    return np.concatenate([quadrant, quadrant[(ny - 1) // 2 : 0 : -1]])


def inverse_symbol(kernel: Kernel, k: Array) -> Array:
    """1/C(|k|) in a quadrant of wavenumbers; in the place of zero half of the next one."""
    k = np.array(k)
    k[0, 0] = 0.5 * max(k[0, 1], k[1, 0])
    return np.asarray(1 / compliance_values(kernel, k))


def compliance_values(kernel: Kernel, k: Array) -> Array:
    """C(k) at many wavenumbers, linear in ln k between those of a grid that all operators of a medium share."""
    x = np.log(k) / STEP
    first, last = int(x.min()) // BLOCK - 1, int(x.max()) // BLOCK + 1
    values = np.concatenate([_compliance_block(kernel, block) for block in range(first, last + 1)])
    return np.asarray(np.exp(np.interp(x - first * BLOCK, np.arange(values.size), values)))


@byte_cached
def _compliance_block(kernel: Kernel, block: int) -> Array:
    """ln C at ln k = n step."""
    n = np.arange(block * BLOCK, (block + 1) * BLOCK)
    return np.log(np.asarray(kernel(np.exp(n * STEP))))


def to_numpy(values: Cells) -> Array:
    """Array of any library as a NumPy array in main memory."""
    if hasattr(values, "get"):
        values = values.get()
    elif hasattr(values, "cpu"):
        values = values.cpu()
    return np.asarray(values)
