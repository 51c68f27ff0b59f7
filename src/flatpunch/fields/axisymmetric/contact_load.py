"""The pressure of a round contact as ring sources.

On a half-space g(t) = (E*/pi) (d - w(t)), w(t) = t int_0^t f'(r)/sqrt(t^2 - r^2) dr: that part has the kinks of the profile. What
layers add, s, is smooth: with A = D + B the punch matrix of the medium (`flatpunch.punch.matrix`) and c the coefficients on the
half-space, (D + B) s = B c, where B c = 2 int (L - 1) j_2l(x) int_0^1 g cos(xt) dt dx needs no series of g.

At the edge g vanishes; with adhesion, and under a flat end, it does not (the pressure is infinite there).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre
from scipy.special import gamma

from flatpunch._support.checks import Array
from flatpunch.compliance import Kernel
from flatpunch.fields.axisymmetric.power_law import power_law_load
from flatpunch.fields.axisymmetric.ring_sources import RingSources, sampled
from flatpunch.indenters import Cylinder
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.gauss import gauss
from flatpunch.punch.basis import edge_signs, half_space_diagonal
from flatpunch.punch.graded import graded_matrices
from flatpunch.punch.matrix import RemainderRule, remainder_rule, sufficient_terms
from flatpunch.punch.wavenumbers import bessel_table

_TOLERANCE = 1e-12, 1e-8
"""Last terms of a panel over the largest g at which it is fine enough: of smooth profiles, and of tabulated ones."""

_NARROWEST = 1e-9, 1e-2
"""Shortest panels over the radius, beside kinks: of smooth profiles, and of tabulated ones."""

_ANGLES = 64, 256
"""Gauss nodes in arcsin(r/t) between two kinks: of smooth profiles, and of tabulated ones."""


def contact_load(kernel: Kernel, indenter: Indenter, radius: float, depth: float, *, edge: bool) -> RingSources:
    """The pressure of a round contact.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    indenter : Indenter
        A round indenter.
    radius, depth : float
        Contact radius a and depth d [m].
    edge : bool
        Whether the pressure may be infinite at the edge (adhesion, flat ends). Otherwise g(a) = 0 decides on the depth, to
        rounding.

    Returns
    -------
    RingSources
    """
    if kernel.exponent:
        return power_law_load(kernel, indenter, radius, depth, edge=edge)
    tabulated = bool(getattr(indenter, "tabulated", False))
    rough = tabulated or kernel.graded
    sunk = _indentation(indenter, tabulated)
    rings = [ring for ring in indenter.rings if 0 < ring < radius * (1 - 1e-12)]
    breaks = np.array([0.0, *sorted(rings), radius])

    def panels(function: Callable[[Array], Array]) -> RingSources:
        return sampled(function, breaks, _TOLERANCE[rough], _NARROWEST[rough], vanishing=not edge)

    if kernel.homogeneous:
        depth = depth if edge else float(sunk(np.array([radius]))[0])
        return panels(lambda t: kernel.modulus / np.pi * (depth - sunk(t)))
    # the response is linear in depth and profile: both by themselves, so that g(a) = 0 can be met
    end = float(sunk(np.array([radius]))[0])
    of_depth, of_rest = _smooth_part(kernel, panels(lambda t: (end - sunk(t)) / np.pi))
    of_tip = end * of_depth - of_rest
    signs = edge_signs(of_depth.size)
    if not edge:
        depth = float((end / np.pi - signs @ of_tip) / (1 / np.pi - signs @ of_depth))
    series = np.zeros(2 * of_depth.size - 1)
    series[::2] = signs * (depth * of_depth - of_tip)
    return panels(lambda t: kernel.modulus * ((depth - sunk(t)) / np.pi - legendre.legval(t / radius, series)))


def _indentation(indenter: Indenter, tabulated: bool) -> Callable[[Array], Array]:
    """w(t) [m], which on a half-space is the depth that brings the contact to the radius t."""
    zero = np.zeros(1)
    if isinstance(indenter, Cylinder):
        return np.zeros_like
    if indenter.exponent is not None:
        n = indenter.exponent
        height = float(np.asarray(indenter.height(np.ones(1), zero))[0])
        factor = height * n * np.sqrt(np.pi) / 2 * gamma(n / 2) / gamma((n + 1) / 2)
        return lambda t: factor * t**n
    rings = np.array(sorted(indenter.rings))
    x, weight = gauss(_ANGLES[tabulated])

    def sunk(t: Array) -> Array:
        flat = np.maximum(t.ravel(), 1e-300)
        cuts = [np.zeros_like(flat)]
        cuts += [np.arcsin(np.minimum(ring / flat, 1.0)) for ring in rings if ring < flat.max()]
        cuts.append(np.full_like(flat, np.pi / 2))
        total = np.zeros_like(flat)
        for low, high in pairwise(cuts):
            half = (high - low)[:, None] / 2
            # rounded so that a point right at a kink is not taken for one beyond it
            r = flat[:, None] * np.sin(low[:, None] + half * (1 + x))
            total += np.sum(indenter.slope(r, zero) * half * weight, axis=1)
        return np.asarray((flat * total).reshape(t.shape))

    return sunk


def _smooth_part(kernel: Kernel, tip: RingSources) -> tuple[Array, Array]:
    """Coefficients s_n [-], [m] that layers take off g/E*: of the flat punch per depth, and of a g that vanishes at the edge."""
    radius = tip.radius
    beta = np.array([radius / kernel.length])
    # terms under a graded surface over those that stiffness needs: the series of the pressure itself converges slowly there
    terms = sufficient_terms(kernel, float(beta[0])) * (3 if kernel.graded else 1)
    if kernel.graded:
        remainder = np.asarray(graded_matrices(kernel, beta, terms, 0)[0][0])
        matrix = remainder + np.diag(half_space_diagonal(0, terms))
        rule = _rule_for_graded(kernel, beta, terms)
    else:
        rule = remainder_rule(kernel, beta, terms, 0)
        matrix = rule.matrix()[0]
        remainder = matrix - np.diag(rule.diagonal)
    # the flat punch of a half-space has the one coefficient 1/pi
    loads = np.column_stack(
        [remainder[:, 0] / np.pi, rule.column(tip.transform(rule.table.x / radius)[None, :] / radius)[0]]
    )
    found = np.linalg.solve(matrix, loads)
    return found[:, 0], found[:, 1]


def _rule_for_graded(kernel: Kernel, beta: Array, terms: int) -> RemainderRule:
    """The same quadrature where L - 1 decays like 1/x: the integrand falls like x^-4."""
    assert kernel.series is not None
    first = min(0, int(np.floor(np.log(kernel.series.floor * float(beta[0])) / np.log(4))))
    # wavenumber times radius at which integrals over the response of a graded surface end: 1e-6 of the pressure remains
    table = bessel_table(0, terms, first, 2048.0)
    weights = 2 * kernel.remainder(table.x / beta[0]) * table.w
    return RemainderRule(table, weights[None, :], np.array([table.x.size]), half_space_diagonal(0, terms))
