"""Fields inside a power-law half-space, E(z) = E_l (z/l)^e: the pressure of round contacts, and its part in closed form.

A flat punch of radius s and unit depth has the transform P = (K/2 pi B) int_0^s (s^2 - t^2)^(e/2) s^-(1 + e) cos(kt) dt, with K
its stiffness and B = int_0^1 (1 - t^2)^(e/2) dt (Sonine's integral). A contact is a pile of such punches, one for each step of
the depth d(s), so that its ring sources are

    g(t) = C [int_t^a (s^2 - t^2)^(e/2) d'(s) ds + (d - d(a)) (a^2 - t^2)^(e/2)],     C = K/(2 pi B s^(1 + e)),

the last term with adhesion and under flat ends only. Under a kink of the profile d'(s) is infinite; an integration by parts
leaves (a^2 - t^2)^(e/2) (d - d(t)) - e int_t^a s (s^2 - t^2)^(e/2 - 1) (d(s) - d(t)) ds in the brackets.

Close to the surface the tractions and the pressure that the material
feels along the surface are those of a homogeneous half-space, nu/(1 - nu) s_zz; that part is taken in closed form.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.special import beta as beta_function

from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.gauss import gauss
from flatpunch.punch.power_law import power_law_punch
from flatpunch.stresses.axisymmetric.panels import Edges
from flatpunch.stresses.axisymmetric.ring_sources import RingSources, sampled

_NODES, _CROWDED = 64, 6
"""Gauss nodes in x between two kinks, whose distance from either end is like x^6: integrands have roots there."""

_TOLERANCE = 1e-12
"""Last terms of a panel of g or d(s), over the largest, at which it is fine enough."""


def power_law_load(
    kernel: Kernel, indenter: Indenter, breaks: Array, depth: float, edges: Edges, *, again: bool
) -> RingSources:
    """Ring sources of a round contact on a power-law half-space; `breaks` end with its radius; else as `contact_load`."""
    e, radius = kernel.exponent, float(breaks[-1])
    constant = float(power_law_punch(kernel).stiffness(np.ones(1))[0]) / (np.pi * beta_function(0.5, 1 + e / 2))
    own = None if indenter.flat else _depths(kernel, indenter, breaks)
    # without adhesion the depth is the one at which g vanishes at the rim
    top = depth if edges[-1].power < 0 or own is None else float(own.value(breaks[-1:])[0])

    def sources(t: Array) -> Array:
        flat = t.ravel()
        at_rim = np.maximum((radius - flat) * (radius + flat), 1e-300) ** (e / 2)
        if own is None:
            return np.asarray(constant * top * at_rim.reshape(t.shape))
        piled = _piled(own, breaks, flat, e, _NODES + 16 * again)
        return np.asarray(constant * ((top - own.value(flat)) * at_rim - e * piled).reshape(t.shape))

    return sampled(sources, breaks, _TOLERANCE, edges=edges)


def _depths(kernel: Kernel, indenter: Indenter, breaks: Array) -> RingSources:
    """Depth d(s) at which the contact without adhesion has the radius s."""
    profile, shortest = mean_profile(indenter), 1e-12 * breaks[-1]

    def depth(s: Array) -> Array:
        return round_contact(kernel, profile, np.maximum(s.ravel(), shortest)).depth.reshape(s.shape)

    return sampled(depth, breaks, _TOLERANCE)


def _piled(own: RingSources, breaks: Array, t: Array, e: float, nodes: int) -> Array:
    """int_t^a s (s^2 - t^2)^(e/2 - 1) (d(s) - d(t)) ds."""
    x, weight = gauss(nodes)
    low, high = ((1 + x) / 2) ** _CROWDED, ((1 - x) / 2) ** _CROWDED
    share = low / (low + high)
    # d share/dx
    weight = weight * 2 * _CROWDED * share * (1 - share) / ((1 + x) * (1 - x))
    result, start = np.zeros_like(t), own.value(t)
    for begin, end in pairwise(breaks):
        some = np.flatnonzero(t < end)
        beginning = np.maximum(t[some], begin)
        length = (end - beginning)[:, None]
        beyond = (beginning - t[some])[:, None] + length * share
        s = t[some, None] + beyond
        kernel = s * (beyond * (s + t[some, None])) ** (e / 2 - 1)
        result[some] += np.sum(weight * length * kernel * (own.value(s) - start[some, None]), axis=1)
    return result
