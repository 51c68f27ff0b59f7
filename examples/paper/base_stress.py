"""Normal stress between a sliding layer and its rigid base.

A pressure wave p cos(kx) on a layer of thickness h that slides on a rigid base arrives there as T(kh) p cos(kx),

    T(x) = 2 (sinh x + x cosh x)/(sinh 2x + 2x),

which is plane strain per wavenumber and independent of the elastic constants: the base is the plane of symmetry of a layer 2h
thick that is pressed from both sides, with the stress function (A cosh kz + B kz sinh kz) cos kx of which two constants remain.
T(0) = 1: what is spread widely arrives unchanged. T has no negative value, but its inverse transform has: around the contact
the layer would lift off (a receding contact). The paper neglects that, and so does the rest of this package; here is its
size.

Lengths are in thicknesses; stress is positive in compression.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft
from scipy.special import j0

from flatpunch._support.checks import Array
from flatpunch.contact import pressure
from flatpunch.indenters import Paraboloid
from flatpunch.numerics.gauss import gauss
from paper.cases import medium

_BLOCK = 0.06
"""Side of the blocks of cells: averaging over it changes T at kh = 3 by (kh)^2 _BLOCK^2/24 = 1e-3."""

_REACH = 8.0
"""Distance around a contact over which the stress is evaluated; it decays exponentially."""


def transfer(x: Array) -> Array:
    """T(kh)."""
    x = np.asarray(x, dtype=float)
    small = np.maximum(x, 1e-8)
    decay = np.exp(-small)
    # both numerator and denominator over e^(2x)
    top = decay * ((1 - decay**2) + small * (1 + decay**2))
    bottom = (1 - decay**4) / 2 + 2 * small * decay**2
    return np.asarray(np.where(x < 1e-8, 1.0, top / bottom))


@dataclass(frozen=True, slots=True)
class BaseStress:
    """Stress at the base under one contact.

    Attributes
    ----------
    r, stress : ndarray
        Distance from the axis, and stress over the peak pressure.
    tension : float
        Largest tension over the peak pressure.
    where : float
        Its distance from the axis.
    pull : float
        Force carried in tension over the normal force.
    """

    r: Array
    stress: Array
    tension: float
    where: float
    pull: float


def under_round(radius: float) -> BaseStress:
    """Under a round paraboloid with contact radius a = `radius` (in thicknesses): the exact contact, by two Hankel transforms."""
    # the pressure falls like the root of the distance to the edge: smooth in r = a sin(theta)
    theta, weight = _gauss(0.0, np.pi / 2, max(48, int(8 * radius)))
    r = radius * np.sin(theta)
    p = pressure(medium("unbonded"), Paraboloid(1.0), r, np.zeros_like(r), radius=radius)
    peak = float(pressure(medium("unbonded"), Paraboloid(1.0), 0.0, 0.0, radius=radius))
    # the integrands oscillate with k (a + r): two nodes and more for each radian
    # wavenumber beyond which T is below 1e-17
    k, dk = _gauss(0.0, 45.0, int(135.0 * (2 * radius + _REACH)))
    transformed = j0(np.outer(k, r)) @ (p * r * radius * np.cos(theta) * weight)
    out, dr = _gauss(0.0, radius + _REACH, 600)
    stress = j0(np.outer(out, k)) @ (transformed * transfer(k) * k * dk)
    force = 2 * np.pi * float(transformed[0])
    lowest = int(np.argmin(stress))
    return BaseStress(
        out,
        np.asarray(stress / peak),
        max(0.0, float(-stress[lowest]) / peak),
        float(out[lowest]),
        float(2 * np.pi * np.sum(np.maximum(-stress, 0) * out * dr) / force),
    )


def under_cells(pressure: Array, spacing: float) -> dict[str, float]:
    """Under a pressure given on square cells: largest tension over the peak and over the mean pressure, and where.

    The pressure is summed over blocks of cells, as T lets nothing shorter than a thickness through, and its periodic images are
    kept away by 2 x 8 thicknesses of free surface.
    """
    block = max(1, int(_BLOCK / spacing))
    ny, nx = (-(-n // block) for n in pressure.shape)
    padded = np.zeros((ny * block, nx * block))
    padded[: pressure.shape[0], : pressure.shape[1]] = pressure
    coarse = padded.reshape(ny, block, nx, block).mean(axis=(1, 3))
    step = block * spacing
    shape = tuple(scipy.fft.next_fast_len(n + int(2 * _REACH / step), real=True) for n in (ny, nx))
    ky = 2 * np.pi * scipy.fft.fftfreq(shape[0], step)[:, None]
    kx = 2 * np.pi * scipy.fft.rfftfreq(shape[1], step)[None, :]
    stress = scipy.fft.irfft2(scipy.fft.rfft2(coarse, shape) * transfer(np.hypot(kx, ky)), shape)
    lowest = np.unravel_index(int(np.argmin(stress)), stress.shape)
    # centre of the summed cells; beyond the middle of the padding distances count from the other side
    y, x = (
        (i if i < (n + m) / 2 else i - m) - (old / block - 1) / 2
        for i, n, m, old in zip(lowest, (ny, nx), shape, pressure.shape, strict=True)
    )
    tension = max(0.0, float(-stress.min()))
    inside = pressure > 0
    return {
        "base_tension": tension / float(pressure.max()),
        "base_tension_mean": tension / float(pressure[inside].mean()),
        "base_where": float(np.hypot(x, y)) * step,
        "base_pull": float(np.maximum(-stress, 0).sum() / coarse.sum()),
    }


def _gauss(start: float, end: float, nodes: int) -> tuple[Array, Array]:
    """Panels of 32 Gauss-Legendre nodes."""
    x, w = gauss(32)
    edges = np.linspace(start, end, max(2, -(-nodes // 32) + 1))
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + x)).ravel(), (half * w).ravel()
