"""Cosine and Fourier transforms of real arrays, by ducc0 where that is installed and else by SciPy.

ducc0 takes half the time on grids of the sizes met here: it works in place, and a call costs a few microseconds. Both are
correct to rounding, which is all by which they differ.
"""

from __future__ import annotations

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from flatpunch._support.checks import Array

try:
    import ducc0.fft as ducc
except ImportError:
    ducc = None

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
    """Transform of arrays that are even about half a cell before their first value (type 2); in place."""
    if ducc is None:
        return np.asarray(scipy.fft.dctn(values, axes=axes, workers=threads, overwrite_x=True))
    return np.asarray(ducc.dct(values, 2, axes=axes, out=values, nthreads=threads))


def cosine_back(spectrum: Numbers, axes: Axes, threads: int = 1) -> Numbers:
    """Inverse of `cosine`; in place."""
    if ducc is None:
        return np.asarray(scipy.fft.idctn(spectrum, axes=axes, workers=threads, overwrite_x=True))
    return np.asarray(ducc.dct(spectrum, 3, axes=axes, inorm=2, out=spectrum, nthreads=threads))


def fourier(values: Numbers, axes: Axes, threads: int = 1) -> Numbers:
    """Transform of real arrays, of which half is kept along the last of the axes."""
    if ducc is None:
        return np.asarray(scipy.fft.rfftn(values, axes=axes, workers=threads))
    return np.asarray(ducc.r2c(values, axes=axes, nthreads=threads))


def fourier_back(spectrum: Numbers, size: int, axes: Axes, threads: int = 1) -> Numbers:
    """Inverse of `fourier`, with `size` values along the last of the axes; overwrites the spectrum."""
    if ducc is None:
        shape = [*(spectrum.shape[axis] for axis in axes[:-1]), size]
        return np.asarray(scipy.fft.irfftn(spectrum, shape, axes=axes, workers=threads, overwrite_x=True))
    return np.asarray(
        ducc.c2r(
            spectrum, axes=axes, lastsize=size, forward=False, inorm=2, nthreads=threads, allow_overwriting_input=True
        )
    )


def complex_fourier(values: Numbers, axis: int, threads: int = 1) -> Numbers:
    """Transform of complex arrays; in place."""
    if ducc is None:
        return np.asarray(scipy.fft.fft(values, axis=axis, workers=threads, overwrite_x=True))
    return np.asarray(ducc.c2c(values, axes=(axis,), out=values, nthreads=threads))


def complex_fourier_back(spectrum: Numbers, axis: int, threads: int = 1) -> Numbers:
    """Inverse of `complex_fourier`; in place."""
    if ducc is None:
        return np.asarray(scipy.fft.ifft(spectrum, axis=axis, workers=threads, overwrite_x=True))
    return np.asarray(ducc.c2c(spectrum, axes=(axis,), forward=False, inorm=2, out=spectrum, nthreads=threads))


def even_transform(values: Array, threads: int = 1) -> Array:
    """Transform of arrays that are even about their first and last values (type 1), along all axes; in place."""
    if ducc is None:
        return np.asarray(scipy.fft.dctn(values, type=1, workers=threads, overwrite_x=True))
    return np.asarray(ducc.dct(values, 1, out=values, nthreads=threads))
