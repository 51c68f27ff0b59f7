"""Transforms against their sums, and a convolution in several threads."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flatpunch import media
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator import convolution as transforms
from flatpunch.bem.operator.convolution import build_operator
from flatpunch.compliances import compliance

SOFT = compliance(media.Medium([media.Layer(1e6, 0.5, 1.0)], media.RigidBase()))


def lines(shape: tuple[int, int], dtype: Any = float) -> np.ndarray:
    return np.random.default_rng(3).standard_normal(shape).astype(dtype)


def close(found: np.ndarray, wanted: np.ndarray) -> None:
    precision = np.finfo(found.dtype).eps
    np.testing.assert_allclose(found, wanted, rtol=0, atol=20 * precision * np.abs(wanted).max())


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("size", [12, 15, 16])
def test_cosine(size: int, dtype: Any) -> None:
    values, n = lines((5, size), dtype), np.arange(size)
    waves = 2 * np.cos(np.pi * np.outer(n + 0.5, n) / size)
    along = transforms.cosine(values.copy(), (-1,))
    close(along, values @ waves)
    close(transforms.cosine_back(along, (-1,)), values)
    close(transforms.cosine(np.ascontiguousarray(values.T), (-2,)), (values @ waves).T)


def test_cosine_along_both_axes() -> None:
    values = lines((6, 10))
    both = transforms.cosine(values.copy(), (0, 1))
    close(both, transforms.cosine(transforms.cosine(values.copy(), (0,)), (1,)))
    close(transforms.cosine_back(both, (0, 1)), values)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)])
def test_fourier(axes: tuple[int, ...], dtype: Any) -> None:
    values = lines((12, 10), dtype)
    spectrum = transforms.fourier(values.copy(), axes)
    assert spectrum.real.dtype == dtype
    close(spectrum, np.fft.rfftn(values.astype(float), axes=axes).astype(spectrum.dtype))
    close(transforms.fourier_back(spectrum, values.shape[axes[-1]], axes), values)


def test_padded_is_always_another_array() -> None:
    values = lines((2, 3))
    wide = transforms.padded(values, (4, 5))
    assert wide[:2, :3].tolist() == values.tolist()
    assert np.count_nonzero(wide) == values.size
    assert not np.shares_memory(transforms.padded(values, (2, 3)), values)


@pytest.mark.parametrize("mirrored", [(False, False), (True, False), (False, True), (True, True)])
def test_threads_convolve_alike(mirrored: tuple[bool, bool]) -> None:
    grid = Grid(70, 90, 0.05, mirrored=mirrored)
    pressure, alone = lines(grid.shape), build_operator(SOFT, grid)
    several = replace(alone, threads=2)
    close(several.apply(pressure), alone.apply(pressure))
    close(several.precondition(pressure), alone.precondition(pressure))
