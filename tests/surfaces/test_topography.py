"""Topographies: checks, rms values, and the spectrum of random ones."""

import numpy as np
import pytest

import flatpunch as fp


def test_rms_values_of_a_wave():
    n, wavelength = 256, 64
    x = np.arange(n) * 1e-7
    rough = fp.Topography(1e-8 * np.sin(2 * np.pi * x / (wavelength * 1e-7)) * np.ones((8, 1)), 1e-7)
    assert rough.rms_height == pytest.approx(1e-8 / np.sqrt(2), rel=1e-12)
    # differences of neighbours are less than the slope by sin(x)/x, x = pi/64
    x = np.pi / wavelength
    assert rough.rms_slope == pytest.approx(2 * np.pi / 64 * 0.1 / np.sqrt(2) * np.sin(x) / x, rel=1e-9)
    assert rough.size == (n * 1e-7, 8e-7)


@pytest.mark.parametrize("hurst", [0.3, 0.8])
def test_spectrum_of_random_surfaces(hurst):
    """Slope of the power spectrum -2 - 2 hurst between the limits, zero beyond the cut-off, constant above the roll-off."""
    n, spacing = 512, 1e-8
    rough = fp.self_affine(n, spacing, hurst=hurst, rms_height=1e-8, roll_off=64 * spacing, cut_off=4 * spacing, seed=2)
    assert rough.rms_height == pytest.approx(1e-8, rel=1e-12)
    assert abs(rough.heights.mean()) < 1e-20
    power = np.abs(np.fft.fft2(rough.heights)) ** 2
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(n), np.fft.fftfreq(n)))
    assert power[q > 0.2501].max() < 1e-20 * power.max()
    ring = [power[(q > low) & (q < 1.1 * low)].mean() for low in (0.02, 0.2)]
    assert np.log(ring[1] / ring[0]) / np.log(10) == pytest.approx(-2 - 2 * hurst, abs=0.15)
    flat = [power[(q > low) & (q < low + 0.004)].mean() for low in (0.003, 0.01)]
    assert flat[0] == pytest.approx(flat[1], rel=0.5)


def test_heights_can_be_handed_to_other_programs():
    """Tamaas takes arrays that are contiguous, aligned and writable, without a copy; what is written there is the surface."""
    given = np.random.default_rng(0).random((16, 8)).T
    rough = fp.Topography(given, 1e-7)
    assert rough.heights.flags.carray
    assert rough.heights.flags.owndata
    before = hash(rough), rough.rms_height
    rough.heights[:] *= 2
    assert given.max() < 1
    assert rough != fp.Topography(given, 1e-7)
    assert rough == fp.Topography(2 * given, 1e-7)
    assert hash(rough) != before[0]
    assert rough.rms_height == pytest.approx(2 * before[1])


def test_seeds_and_slopes():
    first, same, other = (fp.self_affine((16, 32), 1e-8, rms_slope=0.1, seed=seed) for seed in (1, 1, 2))
    assert first == same
    assert hash(first) == hash(same)
    assert first != other
    assert first.rms_slope == pytest.approx(0.1)
    assert first.shape == (16, 32)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "exactly one"),
        ({"rms_height": 1e-8, "rms_slope": 0.1}, "exactly one"),
        ({"rms_slope": 0.1, "hurst": 1.5}, "hurst"),
        ({"rms_slope": 0.1, "cut_off": 1.0}, "leaves no wavelength"),
        ({"rms_slope": np.nan}, "rms_slope"),
    ],
)
def test_random_surfaces_refuse(arguments, words):
    with pytest.raises(ValueError, match=words):
        fp.self_affine(32, 1e-8, **arguments)


@pytest.mark.parametrize(
    ("heights", "spacing", "periodic", "error", "words"),
    [
        (np.zeros(9), 1e-8, True, ValueError, r"shape \(9,\)"),
        (np.zeros((4, 9)), 1e-8, True, ValueError, "8 x 8"),
        (
            np.where(np.eye(9) > 0, np.nan, 0.0),
            1e-8,
            True,
            ValueError,
            "9 missing or infinite values, the first in row 0",
        ),
        (np.zeros((9, 9)), 0.0, True, ValueError, "spacing"),
        (np.zeros((9, 9)), 1e-8, "x", TypeError, "periodic"),
        (np.zeros((9, 9)), 1e-8, (True, 1), TypeError, "periodic"),
    ],
)
def test_topographies_refuse(heights, spacing, periodic, error, words):
    with pytest.raises(error, match=words):
        fp.Topography(heights, spacing, periodic)
