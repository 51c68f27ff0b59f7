"""Displacement of the surface from the pressure on a grid, u = G * p in free space, and an approximate inverse.

The convolution is done by FFT on the doubled grid, so that nothing is periodic. Only half of that grid's rows carry
pressure and only half of them are asked for: rows are transformed first (real to complex), then the columns in narrow
blocks, so that the doubled spectrum never exists as a whole. The coefficients are even in x and y, hence their
transform is real and a quarter of it is kept (a cosine transform). On a folded grid the pressure is even as well, and cosine
transforms of half the length take the place of Fourier transforms along the axes that are folded.

Here lengths are in cells and pressures in units of E*: numbers of order one, safe in single precision.

The approximate inverse divides by the symbol C(|k|) on the grid itself, without padding. It is positive by construction, unlike
the transform of the truncated coefficients, whose lowest entries can be negative under stiff films.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import repeat
from typing import Any

import numpy as np
import scipy.fft

from flatpunch._threads import allowed_threads
from flatpunch._validation import Array
from flatpunch.bem.grid import Grid
from flatpunch.bem.influence import influence_coefficients
from flatpunch.compliance import Kernel

BYTES_PER_CELL = 200
"""Upper bound of what operator and solver together hold per cell in double precision; a test measures it."""

_BLOCK, _SMALLEST_BLOCK = 64, 2**15
"""Columns transformed at a time, or as many as make this many numbers: calls cost as much as small transforms."""

_STEP, _TABULATED = 1 / 64, 256
"""Step in ln k of the compliances that approximate inverses read, and at how many a medium is asked at a time."""

SINGLE_FLOOR = 1e-5
"""Smallest relative error that single precision is asked for."""

THREADED = 500**2
"""Cells from which on threads gain more than they cost to start; below, two of them take up to four times as long as one."""

_MANY = 400**2
"""Numbers in the transformed rows from which on threads take whole blocks of columns each."""


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
    padded, periodic : (int, int)
        Shapes (my, mx) and (qy, qx).
    xp : module
        Array namespace of the work; NumPy unless another was asked for.
    threads : int
        Threads of the transforms (NumPy only).
    """

    grid: Grid
    spectrum: Any
    inverse: Any
    padded: tuple[int, int]
    periodic: tuple[int, int]
    xp: Any
    threads: int

    def apply(self, pressure: Any) -> Any:
        """Displacement [cells] of a pressure [E*], shape (..., ny, nx)."""
        if self.xp is np:
            return self._apply_numpy(pressure)
        return self._apply_standard(pressure)

    def precondition(self, gap: Any) -> Any:
        """Pressure [E*] that about removes a gap error [cells], shape (ny, nx)."""
        ny, nx = self.grid.shape
        if self.xp is np:
            return self._precondition_numpy(gap)
        fft = self.xp.fft
        spectrum = fft.rfftn(gap, s=self.periodic, axes=(0, 1)) * self.inverse
        return fft.irfftn(spectrum, s=self.periodic, axes=(0, 1))[:ny, :nx]

    def single(self) -> Operator:
        """The same operator in single precision."""
        xp = self.xp
        spectrum, inverse = (xp.astype(part, xp.float32) for part in (self.spectrum, self.inverse))
        return replace(self, spectrum=spectrum, inverse=inverse)

    def asarray(self, values: Any) -> Any:
        """NumPy values as an array of this operator's namespace and precision."""
        return self.xp.asarray(np.asarray(values), dtype=self.spectrum.dtype)

    def _apply_numpy(self, pressure: Array) -> Array:
        (my, mx), (ny, nx), threads = self.padded, self.grid.shape, self.threads
        along_x, along_y = self.grid.mirrored
        if along_y and not along_x and threads == 1:
            return self._apply_even_columns(pressure)
        if along_x:
            rows = scipy.fft.dct(pressure, n=mx // 2, axis=-1, workers=threads)
        else:
            rows = scipy.fft.rfft(pressure, mx, axis=-1, workers=threads)

        block_size = max(_BLOCK, _SMALLEST_BLOCK // my)

        def convolve(first: int, inside: int) -> None:
            columns = slice(first, min(first + block_size, rows.shape[-1]))
            factor = self.spectrum[:, columns]
            if along_y:
                rows[..., columns] = _even_columns(rows[..., columns], factor[: my // 2], inside)
            elif along_x:
                block = scipy.fft.rfft(rows[..., columns], my, axis=-2, workers=inside)
                block *= factor
                rows[..., columns] = scipy.fft.irfft(block, my, axis=-2, workers=inside, overwrite_x=True)[..., :ny, :]
            else:
                block = scipy.fft.fft(rows[..., columns], my, axis=-2, workers=inside)
                block[..., : factor.shape[0], :] *= factor
                block[..., factor.shape[0] :, :] *= factor[my - factor.shape[0] : 0 : -1]
                rows[..., columns] = scipy.fft.ifft(block, axis=-2, workers=inside, overwrite_x=True)[..., :ny, :]

        blocks = range(0, rows.shape[-1], block_size)
        if threads > 1 and rows.size > _MANY:
            # whole blocks side by side: also what is not a transform then has several threads
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(convolve, blocks, repeat(1)))
        else:
            for first in blocks:
                convolve(first, threads)
        if along_x:
            u = scipy.fft.idct(rows, axis=-1, workers=threads, overwrite_x=True)
        else:
            u = scipy.fft.irfft(rows, mx, axis=-1, workers=threads, overwrite_x=True)
        return np.asarray(u[..., :nx])

    def _apply_even_columns(self, pressure: Array) -> Array:
        """The same where columns alone are even: they go first, while they are real, then the rows in blocks."""
        (my, mx), (ny, nx) = self.padded, self.grid.shape
        columns = scipy.fft.dct(pressure, n=my // 2, axis=-2)
        count = max(_BLOCK, _SMALLEST_BLOCK // mx)
        for first in range(0, my // 2, count):
            rows = slice(first, min(first + count, my // 2))
            block = scipy.fft.rfft(columns[..., rows, :], mx, axis=-1)
            block *= self.spectrum[rows]
            columns[..., rows, :] = scipy.fft.irfft(block, mx, axis=-1, overwrite_x=True)[..., :nx]
        return np.asarray(scipy.fft.idct(columns, axis=-2, overwrite_x=True)[..., :ny, :])

    def _precondition_numpy(self, gap: Array) -> Array:
        (qy, qx), (ny, nx), threads = self.periodic, self.grid.shape, self.threads
        along_x, along_y = self.grid.mirrored
        if along_x and along_y:
            spectrum = scipy.fft.dctn(gap, s=(qy // 2, qx // 2), workers=threads)
            spectrum *= self.inverse[: qy // 2, : qx // 2]
            u = scipy.fft.idctn(spectrum, workers=threads, overwrite_x=True)
        elif along_x:
            spectrum = scipy.fft.rfft(
                scipy.fft.dct(gap, n=qx // 2, axis=1, workers=threads), qy, axis=0, workers=threads
            )
            spectrum *= self.inverse[: qy // 2 + 1, : qx // 2]
            u = scipy.fft.irfft(spectrum, qy, axis=0, workers=threads, overwrite_x=True)
            u = scipy.fft.idct(u[:ny], axis=1, workers=threads)
        elif along_y:
            spectrum = scipy.fft.rfft(
                scipy.fft.dct(gap, n=qy // 2, axis=0, workers=threads), qx, axis=1, workers=threads
            )
            spectrum *= self.inverse[: qy // 2]
            u = scipy.fft.irfft(spectrum, qx, axis=1, workers=threads, overwrite_x=True)
            u = scipy.fft.idct(u[:, :nx], axis=0, workers=threads)
        else:
            spectrum = scipy.fft.rfft2(gap, self.periodic, workers=threads)
            spectrum *= self.inverse
            u = scipy.fft.irfft2(spectrum, self.periodic, workers=threads, overwrite_x=True)
        return np.asarray(u[:ny, :nx])

    def _apply_standard(self, pressure: Any) -> Any:
        (my, mx), (ny, nx), xp = self.padded, self.grid.shape, self.xp
        half = self.spectrum
        rows = xp.fft.fft(xp.fft.rfft(pressure, n=mx, axis=1), n=my, axis=0)
        full = xp.concat([half, xp.flip(half[1 : my - half.shape[0] + 1, :], axis=0)], axis=0)
        u = xp.fft.ifft(rows * full, axis=0)[:ny, :]
        return xp.fft.irfft(u, n=mx, axis=1)[:, :nx]


def _even_columns(columns: Array, factor: Array, threads: int) -> Array:
    """Columns, real or complex, that are the positive half of even ones, convolved by a factor of their cosine transforms."""
    count, complex_valued = columns.shape[-2], np.iscomplexobj(columns)
    parts = columns.view(columns.real.dtype) if complex_valued else columns
    block = scipy.fft.dct(parts, n=factor.shape[0], axis=-2, workers=threads)
    if complex_valued:
        factor = np.repeat(factor, 2, axis=-1)
    block *= factor
    convolved = scipy.fft.idct(block, axis=-2, workers=threads, overwrite_x=True)[..., :count, :]
    return np.ascontiguousarray(convolved).view(columns.dtype) if complex_valued else convolved


def build_operator(
    kernel: Kernel, grid: Grid, *, xp: Any = np, coefficients: Array | None = None, solving: bool = True
) -> Operator:
    """Transform of the influence coefficients and of the approximate inverse on a grid.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    grid : Grid
        The grid; folded ones only with NumPy, the standard has no cosine transforms.
    xp : module
        Array namespace (array API standard with its fft extension) that holds the arrays and does the work.
    coefficients : ndarray, optional
        Those of `coefficients_for`, where they are known already.
    solving : bool
        Whether the operator is to solve with: else it has no approximate inverse.
    """
    ny, nx = grid.shape
    threads = allowed_threads() if nx * ny >= THREADED else 1
    my, mx = padded_shape(grid)
    periodic = (my // 2, mx // 2)
    unit = kernel.modulus / grid.spacing
    g = (coefficients_for(kernel, grid) if coefficients is None else coefficients) * unit
    spectrum = scipy.fft.dctn(g, type=1, workers=threads, overwrite_x=True)
    inverse = inverse_symbol(kernel, grid.spacing, periodic) if solving else np.empty((0, 0))
    inverse /= unit
    if xp is not np:
        spectrum, inverse = xp.asarray(spectrum), xp.asarray(inverse)
    return Operator(grid, spectrum, inverse, (my, mx), periodic, xp, threads)


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


def inverse_symbol(kernel: Kernel, spacing: float, shape: tuple[int, int]) -> Array:
    """1/C(|k|) on the half plane of wavenumbers of a periodic grid; shape (ny, nx/2 + 1)."""
    ny, nx = shape
    ky = 2 * np.pi * np.abs(scipy.fft.fftfreq(ny, spacing))[: ny // 2 + 1]
    kx = 2 * np.pi * scipy.fft.rfftfreq(nx, spacing)
    k = np.hypot(kx, ky[:, None])
    k[0, 0] = 0.5 * max(k[0, 1], k[1, 0])
    upper = 1 / compliance_values(kernel, k)
    return np.concatenate([upper, upper[(ny - 1) // 2 : 0 : -1]])


def compliance_values(kernel: Kernel, k: Array) -> Array:
    """C(k) at many wavenumbers, linear in ln k between those of a grid that all operators of a medium share."""
    x = np.log(k) / _STEP
    first, last = int(x.min()) // _TABULATED - 1, int(x.max()) // _TABULATED + 1
    values = np.concatenate([_compliance_block(kernel, block) for block in range(first, last + 1)])
    return np.asarray(np.exp(np.interp(x - first * _TABULATED, np.arange(values.size), values)))


@lru_cache(maxsize=64)
def _compliance_block(kernel: Kernel, block: int) -> Array:
    """ln C at ln k = n step."""
    n = np.arange(block * _TABULATED, (block + 1) * _TABULATED)
    return np.log(np.asarray(kernel(np.exp(n * _STEP))))


def to_numpy(values: Any) -> Array:
    """Array of any library as a NumPy array in main memory."""
    if hasattr(values, "get"):
        values = values.get()
    elif hasattr(values, "cpu"):
        values = values.cpu()
    return np.asarray(values)
