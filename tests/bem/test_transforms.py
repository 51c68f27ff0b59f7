"""Transforms against their sums, by either library, and that both serve the convolution alike."""

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


@pytest.fixture(params=["ducc0", "SciPy"])
def library(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    if request.param == "ducc0":
        pytest.importorskip("ducc0", reason="the extra `fast` is not installed")
    else:
        monkeypatch.setattr(transforms, "ducc", None)
    return str(request.param)


def lines(shape: tuple[int, int], dtype: Any = float) -> np.ndarray:
    return np.random.default_rng(3).standard_normal(shape).astype(dtype)


def close(found: np.ndarray, wanted: np.ndarray) -> None:
    precision = np.finfo(found.dtype).eps
    np.testing.assert_allclose(found, wanted, rtol=0, atol=20 * precision * np.abs(wanted).max())


@pytest.mark.usefixtures("library")
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("size", [12, 15, 16])
def test_cosine(size: int, dtype: Any) -> None:
    values, n = lines((5, size), dtype), np.arange(size)
    waves = 2 * np.cos(np.pi * np.outer(n + 0.5, n) / size)
    along = transforms.cosine(values.copy(), (-1,))
    close(along, values @ waves)
    close(transforms.cosine_back(along, (-1,)), values)
    close(transforms.cosine(np.ascontiguousarray(values.T), (-2,)), (values @ waves).T)


@pytest.mark.usefixtures("library")
def test_cosine_along_both_axes() -> None:
    values = lines((6, 10))
    both = transforms.cosine(values.copy(), (0, 1))
    close(both, transforms.cosine(transforms.cosine(values.copy(), (0,)), (1,)))
    close(transforms.cosine_back(both, (0, 1)), values)


@pytest.mark.usefixtures("library")
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)])
def test_fourier(axes: tuple[int, ...], dtype: Any) -> None:
    values = lines((12, 10), dtype)
    spectrum = transforms.fourier(values.copy(), axes)
    assert spectrum.real.dtype == dtype
    close(spectrum, np.fft.rfftn(values.astype(float), axes=axes).astype(spectrum.dtype))
    close(transforms.fourier_back(spectrum, values.shape[axes[-1]], axes), values)


@pytest.mark.usefixtures("library")
def test_complex_fourier() -> None:
    values = lines((12, 10)) + 1j * lines((12, 10))[::-1]
    spectrum = transforms.complex_fourier(values.copy(), -2)
    close(spectrum, np.fft.fft(values, axis=0))
    close(transforms.complex_fourier_back(spectrum, -2), values)


@pytest.mark.usefixtures("library")
def test_even_transform() -> None:
    values = lines((5, 9))
    whole = np.pad(values, [(0, 3), (0, 7)], mode="reflect")
    transformed = transforms.even_transform(values.copy())
    close(transformed, np.fft.fft2(whole).real[:5, :9])


def test_padded_is_always_another_array() -> None:
    values = lines((2, 3))
    wide = transforms.padded(values, (4, 5))
    assert wide[:2, :3].tolist() == values.tolist()
    assert np.count_nonzero(wide) == values.size
    assert not np.shares_memory(transforms.padded(values, (2, 3)), values)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("mirrored", [(False, False), (True, False), (False, True), (True, True)])
def test_both_libraries_convolve_alike(
    mirrored: tuple[bool, bool], threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("ducc0", reason="the extra `fast` is not installed")
    grid = Grid(70, 90, 0.05, mirrored=mirrored)
    pressure = lines(grid.shape)
    fast = replace(build_operator(SOFT, grid), threads=threads)
    displacement, change = fast.apply(pressure), fast.precondition(pressure)
    monkeypatch.setattr(transforms, "ducc", None)
    slow = replace(build_operator(SOFT, grid), threads=threads)
    close(slow.spectrum, fast.spectrum)
    close(slow.apply(pressure), displacement)
    close(slow.precondition(pressure), change)
