"""Random self-affine surfaces: Gaussian heights with a power spectrum of given exponent between two wavelengths."""

from __future__ import annotations

import numpy as np
import scipy.fft

from flatpunch._support.checks import CELLS, positive, real, shown, whole
from flatpunch.surfaces.topography import FEWEST, Topography


def self_affine(
    shape: int | tuple[int, int],
    spacing: float,
    *,
    hurst: float = 0.8,
    rms_height: float | None = None,
    rms_slope: float | None = None,
    roll_off: float | None = None,
    cut_off: float | None = None,
    seed: int = 0,
) -> Topography:
    """Random periodic surface whose power spectrum falls like q^(-2 - 2 hurst).

    Parameters
    ----------
    shape : int or (int, int)
        Number of cells (ny, nx); one number for a square.
    spacing : float
        Side of a cell [m].
    hurst : float
        Hurst exponent [-], 0 < hurst <= 1.
    rms_height, rms_slope : float
        Exactly one of them, > 0: the heights [m] are scaled until `Topography.rms_height` or `Topography.rms_slope` [-] is it.
    roll_off : float, optional
        Wavelength [m] above which the spectrum is constant; by default it rises up to the length of the surface.
    cut_off : float, optional
        Shortest wavelength [m]; by default twice the spacing. Eight spacings or more resolve the shape of each asperity.
    seed : int
        Seed of the random numbers; equal seeds give equal surfaces.

    Returns
    -------
    Topography
        Periodic in both directions, mean height zero.

    Raises
    ------
    ValueError, TypeError
        If not exactly one of `rms_height` and `rms_slope` is given, or no wavelength lies between the limits.

    See Also
    --------
    Topography : Measured surfaces.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001 (2017).

    Examples
    --------
    >>> rough = fp.self_affine(128, 10e-9, hurst=0.8, rms_slope=0.1, roll_off=0.5e-6, cut_off=40e-9, seed=1)
    >>> print(rough.shape, f"{rough.rms_slope:.3f}")
    (128, 128) 0.100
    """
    ny, nx = (whole("shape", n, FEWEST, "It counts cells along a side.", most=CELLS) for n in _two(shape))
    spacing = positive("spacing", spacing, "It is the side of a cell.", unit="m")
    hurst = real("hurst", hurst, "1")
    if not 0 < hurst <= 1:
        raise ValueError(f"hurst = {hurst!r} must lie in 0 < hurst <= 1: it is the Hurst exponent of the surface.")
    if (rms_height is None) == (rms_slope is None):
        raise ValueError("Give exactly one of rms_height [m] and rms_slope [-]; the other follows from the spectrum.")
    wanted = (
        positive("rms_height", rms_height, unit="m")
        if rms_slope is None
        else positive("rms_slope", rms_slope, unit="1")
    )
    longest, shortest = max(ny, nx) * spacing, 2 * spacing
    roll_off = longest if roll_off is None else positive("roll_off", roll_off, "It is a wavelength.", unit="m")
    cut_off = shortest if cut_off is None else positive("cut_off", cut_off, "It is a wavelength.", unit="m")
    q = np.hypot(scipy.fft.fftfreq(ny, spacing)[:, None], scipy.fft.rfftfreq(nx, spacing))
    with np.errstate(divide="ignore"):
        amplitude = np.maximum(q, 1 / roll_off) ** (-1 - hurst)
    # wavelengths that equal a limit count, whatever the rounding of their inverse
    amplitude[(q == 0) | (q * cut_off > 1 + 1e-9)] = 0.0
    if not amplitude.any():
        raise ValueError(
            f"cut_off = {cut_off!r} m leaves no wavelength: the longest that fits on the surface is {longest:.4g} m, the "
            f"shortest that its cells resolve {shortest:.4g} m."
        )
    noise = np.random.default_rng(whole("seed", seed, 0)).standard_normal((ny, nx))
    heights = scipy.fft.irfft2(scipy.fft.rfft2(noise) * amplitude, (ny, nx))
    rough = Topography(heights / np.abs(heights).max(), spacing)
    factor = wanted / (rough.rms_height if rms_slope is None else rough.rms_slope)
    return Topography(rough.heights * factor, spacing)


def _two(shape: object) -> tuple[object, object]:
    if not isinstance(shape, (tuple, list)):
        return shape, shape
    if len(shape) != 2:
        raise ValueError(f"shape = {shown(shape)} must be one number of cells, or the pair (ny, nx).")
    return shape[0], shape[1]
