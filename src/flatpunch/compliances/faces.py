"""From what lies below a face to what lies above it: a membrane on the former stiffens it, springs above the membrane yield.

A membrane with tension T, in-plane stiffness A, shear stiffness G and bending stiffness B takes tractions of its own. Those above
it are less, in tension, than those below by

    [s_lz] = A k^2 u_l,    [s_zz] = (T k^2 + B k^4) u_z,    [s_tz] = G k^2 u_t,

so that the inverse of the flexibility H grows by K = diag(A k, T k + B k^3), H -> H M with M = (1 - K H)^-1, and M are the
tractions below per those above. -H is positive, so that no denominator is below one. Springs add their own flexibility.
"""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.media import Interface, Membrane


def yielding(face: Interface, below: Array, k: Array, scale: float) -> Array:
    """Flexibility of what lies below a layer with what its lower face adds, times `scale`; shape (2, 2, n)."""
    below = stiffened(face.membrane, below, k, scale)[0]
    along, across = face.softness
    if not across and (not along or not face):
        return below
    below = below.copy()
    if face:
        below[0, 0] -= scale * along * k
    below[1, 1] -= scale * across * k
    return below


def yielding_across(face: Interface, below: Array, k: Array, scale: float) -> Array:
    """k u_t/s_tz of what lies below a layer that sticks, with what its lower face adds, times `scale`; shape (n,)."""
    return below * passed_across(face.membrane, below, k, scale) - scale * face.softness[0] * k


def stiffened(membrane: Membrane | None, below: Array, k: Array, scale: float) -> tuple[Array, Array]:
    """Flexibility of what lies below with a membrane on it, and tractions below per those above it; shape (2, 2, n) each."""
    if not membrane:
        return below, np.broadcast_to(np.eye(2)[:, :, None], below.shape)
    a, _, n = membrane.stiffness(k) / (k * scale)
    (p, q), (_, s) = below
    passed = np.array([[1 - n * s, a * q], [n * q, 1 - a * p]]) / ((1 - a * p) * (1 - n * s) - a * n * q * q)
    return np.einsum("ijn,jkn->ikn", below, passed), passed


def passed_across(membrane: Membrane | None, below: Array, k: Array, scale: float) -> Array:
    """Traction across the wave below a membrane per that above it, shape (n,)."""
    return 1 / (1 - membrane.stiffness(k)[1] / (k * scale) * below) if membrane else np.ones_like(k)
