"""Fields inside a power-law half-space, E(z) = E_l (z/l)^e: the pressure of round contacts, and its part in closed form.

A flat punch of radius s and unit depth has the transform P = (K/2 pi B) int_0^s (s^2 - t^2)^(e/2) s^-(1 + e) cos(kt) dt, with K
its stiffness and B = int_0^1 (1 - t^2)^(e/2) dt (Sonine's integral). A contact is a pile of such punches, one for each step of
the depth d(s), so that its ring sources are

    g(t) = C [int_t^a (s^2 - t^2)^(e/2) d'(s) ds + (d - d(a)) (a^2 - t^2)^(e/2)],     C = K/(2 pi B s^(1 + e)),

the last term with adhesion and under flat ends only. Close to the surface the tractions and the pressure that the material
feels along the surface are those of a homogeneous half-space, nu/(1 - nu) s_zz; that part is taken in closed form.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.special import beta as beta_function
from scipy.special import roots_jacobi

from flatpunch._support.checks import Array
from flatpunch.compliance import Kernel
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.fields.axisymmetric.ring_sources import RingSources, sampled
from flatpunch.indenters import Cylinder
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.gauss import gauss
from flatpunch.punch.power_law import power_law_punch

_NODES = 24
"""Gauss nodes on a panel of the radii of the pile, each panel twice as long as the one before."""


_TOLERANCE, _NARROWEST = 1e-9, (1e-5, 1e-3)
"""Last terms of a panel of g at which it is fine enough, and the shortest panel beside the rim, over the radius, where g vanishes
there and where it does not: on shorter ones the integrals of g'' cancel, on longer ones the root at the rim is cut off."""

_GROWTH = 1e-8, 1e-2
"""The same of s d'(s), which is smooth but at kinks of the profile."""


def power_law_load(kernel: Kernel, indenter: Indenter, radius: float, depth: float, *, edge: bool) -> RingSources:
    """Ring sources of a round contact on a power-law half-space; arguments as of `contact_load`."""
    e = kernel.exponent
    constant = float(power_law_punch(kernel).stiffness(np.ones(1))[0]) / (np.pi * beta_function(0.5, 1 + e / 2))
    breaks = np.array([0.0, *sorted(ring for ring in indenter.rings if 0 < ring < radius * (1 - 1e-12)), radius])
    if isinstance(indenter, Cylinder):
        own, growth = 0.0, None
    else:
        profile = mean_profile(indenter)
        own = float(round_contact(kernel, profile, np.array([radius])).depth[0])

        def slope(s: Array) -> Array:
            flat = round_contact(kernel, profile, np.maximum(s.ravel(), 1e-12 * radius))
            return flat.depth_slope.reshape(s.shape)

        growth = sampled(slope, breaks, *_GROWTH)
    rest = depth - own if edge else 0.0

    def sources(t: Array) -> Array:
        flat = t.ravel()
        result = np.zeros_like(flat) if growth is None else _piled(growth, breaks, flat, e)
        if rest:
            result += rest * np.maximum((radius - flat) * (radius + flat), 1e-300) ** (e / 2)
        return np.asarray(constant * result.reshape(t.shape))

    return sampled(sources, breaks, _TOLERANCE, _NARROWEST[edge], vanishing=not edge)


def _piled(growth: RingSources, breaks: Array, t: Array, e: float) -> Array:
    """int_t^a (s^2 - t^2)^(e/2) d'(s) ds, from s d'(s); with s^2 = t^2 + w^2, w^(1 + e) (s d'(s))/s^2 dw."""
    x, weight = gauss(_NODES)
    y, inner_weight = roots_jacobi(_NODES, 0.0, 1 + e)
    shortest = np.maximum(t, 1e-9 * breaks[-1])
    result = np.zeros_like(t)
    for low, high in pairwise(breaks):
        floor, top = (np.sqrt(np.maximum((end - t) * (end + t), 0.0)) for end in (low, high))
        # panels halved towards w = 0 until they are as short as t, where 1/s^2 is smooth
        # panels at most, down to 1e-9 of the longest
        for _ in range(30):
            bottom = np.maximum(floor, top / 2)
            some = np.flatnonzero((bottom < top) & ((floor > 0) | (top > shortest)))
            if not some.size:
                break
            half = (top - bottom)[some, None] / 2
            w = bottom[some, None] + half * (1 + x)
            s2 = t[some, None] ** 2 + w * w
            result[some] += np.sum(half * weight * w ** (1 + e) * growth.value(np.sqrt(s2)) / s2, axis=1)
            top[some] = bottom[some]
        last = np.flatnonzero((floor == 0) & (top > 0))
        w = top[last, None] * (1 + y) / 2
        s2 = np.maximum(t[last, None] ** 2 + w * w, 1e-300)
        result[last] += (top[last] / 2) ** (2 + e) * ((growth.value(np.sqrt(s2)) / s2) @ inner_weight)
    return result
