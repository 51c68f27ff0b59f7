"""Edge functionals from the flat punch alone, given how it changes with the radius.

The flat punch c* of all radii says what the edge does to any displacement (Krein's identity, see `graded` for the derivation;
primes are derivatives by ln beta, q = 2 l, s_l = (-1)^l):

    pi e^2 = c_0 + c_0',        pi e v_l = -q c_l - (2 q + 1) s_l (e - sum_(i<=l) s_i c_i) + c_l',

where e = S[c*] and S[A_0^-1 b] = S0[b] + b.v. The derivative of v gives the functional of d'(a). Sums over the edge signs are
never taken to the end of the series, which under graded surfaces would converge like N^-2 only.
"""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.punch.basis import edge_signs


def round_functionals(c: Array, first: Array, second: Array) -> tuple[Array, Array]:
    """Edge functional v and slope functional u of harmonic 0, shape (nb, terms) each.

    From the flat punch c* on the unit disc at nb radii and its derivatives by ln beta. S[A_0^-1 b] = S0[b] + b.v, and
    -a dS[f]/da = t0[f] + b.u up to a multiple of S, which d'(a) does not feel.
    """
    s = edge_signs(c.shape[1])
    width = 4.0 * np.arange(c.shape[1]) + 1
    strength = np.sqrt((c[:, 0] + first[:, 0]) / np.pi)[:, None]
    growth = (first[:, 0] + second[:, 0])[:, None] / (2 * np.pi * strength**2)
    edge = (excess(0, c, strength) + first) / (np.pi * strength)
    change = (excess(0, first, growth * strength) + second) / (np.pi * strength) - edge * growth
    sums = np.cumsum(s * edge, axis=-1)
    total = sums[:, -1:]
    # the multiple of S added makes the functional small at the end of the series, so that slow moments (cones) converge
    slope = ((width + 1) / 2 + np.pi * total) * edge + width * s * (total - sums) - change
    return edge, slope


def excess(m: int, c: Array, strength: Array) -> Array:
    """(m - q) c_l - (2 q + 1) s_l (S - sum_(i<=l) s_i c_i) for q = m + 2 l; shapes (nb, terms) and (nb, 1)."""
    s = edge_signs(c.shape[-1])
    q = m + 2.0 * np.arange(c.shape[-1])
    return np.asarray((m - q) * c - (2 * q + 1) * s * (strength - np.cumsum(s * c, axis=-1)))
