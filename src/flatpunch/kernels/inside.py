"""Stresses and displacements at depth under waves of traction."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flatpunch.kernels.bodies import Tuples, body_of
from flatpunch.kernels.vectors import wave_vectors

if TYPE_CHECKING:
    from flatpunch._support.checks import Array, Indices
    from flatpunch.compliances.depth import Waves
    from flatpunch.compliances.stack import Side
    from flatpunch.media import Body, Stack
    from flatpunch.numerics.chebyshev import Numbers


def interior(
    medium: Body | Tuples, qx: Numbers, qy: Numbers, z: Numbers, *, side: Side = "below"
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Displacement and stress at depth under unit waves of traction on the surface.

    Parameters
    ----------
    medium : Body or tuple
        As for `surface_compliance`, but not two bodies: take each by itself.
    qx, qy : array
        Wave vectors [rad/m], broadcast together; not zero.
    z : array, shape (nz,)
        Depths [m], >= 0.
    side : {"below", "above"}
        The side of an interface on which a depth on it is taken.

    Returns
    -------
    displacement : ndarray of complex, shape (..., nz, 3, 3)
        u_x, u_y, u_z under t_x, t_y, t_z [m/Pa].
    stress : ndarray of complex, shape (..., nz, 6, 3)
        s_xx, s_yy, s_zz, s_yz, s_xz, s_xy, tension positive, under t_x, t_y, t_z [-].

    Raises
    ------
    ValueError, TypeError
        On bad input, q = 0 and depths outside the body.

    See Also
    --------
    flatpunch.kernels.surface_compliance : The displacement at the surface.

    Examples
    --------
    >>> from flatpunch import kernels
    >>> u, s = kernels.interior(fp.HalfSpace(1e9, 0.3), 1e6, 0.0, [0.0, 1e-6])
    >>> print(s[0, 2, 2].real, s[1, 2, 2].real.round(3))  # s_zz under a pressure: -1 at the surface
    -1.0 -0.736
    """
    from flatpunch._support.checks import values

    body = body_of(medium).single
    if not body:
        raise TypeError("medium is TwoBodies; `interior` takes each of them by itself.")
    (x, y), magnitude = wave_vectors(qx=qx, qy=qy)
    depths = values("z", z, unit="m")
    k = magnitude.ravel()
    if not (k > 0).all():
        raise ValueError("qx and qy are both zero somewhere; a uniform traction has no wave. Leave q = 0 out.")
    own, which = np.unique(k, return_inverse=True)
    waves = _waves(body, own, depths, side)
    displacement, stress = _turned(waves, own, which.ravel(), x.ravel() / k, y.ravel() / k)
    shape = (*x.shape, depths.size)
    return displacement.reshape(*shape, 3, 3), stress.reshape(*shape, 6, 3)


def _waves(body: Stack, k: Array, z: Array, side: Side) -> Waves:
    from flatpunch._support.checks import ROUNDING, one_of
    from flatpunch._support.prefixes import text
    from flatpunch.compliances.depth import waves_at
    from flatpunch.compliances.power_law import power_law_waves
    from flatpunch.compliances.stack import layer_at

    one_of("side", side, ("above", "below"), "It is the side of an interface on which depths are taken.")
    if body.base.rigid and (z > body.thickness * (1 + ROUNDING)).any():
        raise ValueError(f"z has depths inside the rigid base, which begins at {text(body.thickness, 'm')}.")
    if law := body.power_law:
        return power_law_waves(law, k, z)
    return waves_at(body, k, z, layer_at(body, z, side))


_PLACES = (0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)
"""Axes of the six components of a stress."""


def _turned(
    waves: Waves, k: Array, which: Indices, lx: Array, ly: Array
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Matrices in x, y, z from waves along and across the wave vector, (n, nz, 3, 3) and (n, nz, 6, 3).

    A pressure has the phase cos(k l), for which u_l and s_lz are sines: a factor -i. A traction along l is s_lz = -1 of that
    phase.
    """
    zero = np.zeros_like(lx)
    axes = np.stack([[lx, ly, zero], [-ly, lx, zero], [zero, zero, zero + 1]])
    u_l, u_z, s_lz, s_zz, mean, difference = waves.normal
    v_l, v_z, t_lz, t_zz, t_mean, t_difference = waves.shear
    w_t, w_tz, w_lt = waves.transverse
    # notation: axes l, t, z; fields by their own axes, then by that of the traction
    moved = {(0, 0): -v_l, (2, 0): -1j * v_z, (1, 1): -w_t, (0, 2): -1j * u_l, (2, 2): u_z}
    stressed = {
        (0, 0, 0): -1j * (t_mean + t_difference),
        (1, 1, 0): -1j * (t_mean - t_difference),
        (2, 2, 0): -1j * t_zz,
        (0, 2, 0): -t_lz,
        (1, 2, 1): -w_tz,
        (0, 1, 1): -1j * w_lt,
        (0, 0, 2): mean + difference,
        (1, 1, 2): mean - difference,
        (2, 2, 2): s_zz,
        (0, 2, 2): -1j * s_lz,
    }
    nz = u_l.shape[1]
    displacement, stress = (np.zeros((lx.size, nz, rows, 3), dtype=complex) for rows in (3, 6))
    for (m, load), field in moved.items():
        turn = np.einsum("in,jn->nij", axes[m], axes[load])
        displacement += (field / k[:, None])[which][..., None, None] * turn[:, None]
    for (m, n, load), field in stressed.items():
        tensor = np.stack([axes[m][i] * axes[n][j] + (m != n) * axes[n][i] * axes[m][j] for i, j in _PLACES])
        turn = np.einsum("in,jn->nij", tensor, axes[load])
        stress += field[which][..., None, None] * turn[:, None]
    return displacement, stress
