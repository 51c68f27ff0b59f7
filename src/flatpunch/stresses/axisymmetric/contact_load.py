"""The pressure of a round contact as ring sources.

On a half-space g(t) = (E*/pi) (d - w(t)), w(t) = t int_0^t f'(r)/sqrt(t^2 - r^2) dr, with the kinks of the profile. It is written
as a series with the coefficients c and a rest r, which is rounding where the profile is smooth. With A = D + B the punch matrix
of the medium (`flatpunch.punch.matrix`), g on the layers is r plus the series of (D + B)^-1 (D c - b), where
b = 2 int (L - 1) j_2l(x) int_0^1 r cos(xt) dt dx. Nothing is subtracted from c, which may be a million times larger under a
stiff film.

At the edge g vanishes; with adhesion, and under a flat end, it does not (the pressure is infinite there).

On a power-law half-space, E(z) = E_l (z/l)^e, a flat punch of radius s and unit depth has the transform
P = (K/2 pi B) int_0^s (s^2 - t^2)^(e/2) s^-(1 + e) cos(kt) dt, with K its stiffness and B = int_0^1 (1 - t^2)^(e/2) dt (Sonine's
integral). A contact is a pile of such punches, one for each step of the depth d(s), so that its ring sources are

    g(t) = C [int_t^a (s^2 - t^2)^(e/2) d'(s) ds + (d - d(a)) (a^2 - t^2)^(e/2)],     C = K/(2 pi B s^(1 + e)),

the last term with adhesion and under flat ends only. Under a kink of the profile d'(s) is infinite; an integration by parts
leaves (a^2 - t^2)^(e/2) (d - d(t)) - e int_t^a s (s^2 - t^2)^(e/2 - 1) (d(s) - d(t)) ds in the brackets.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre
from scipy.special import beta as beta_function
from scipy.special import gamma

from flatpunch._support.checks import ROUNDING, TINY, Array
from flatpunch.compliances import Kernel
from flatpunch.contact.round.carried import wave_range
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.gauss import gauss
from flatpunch.punch.basis import edge_signs, half_space_diagonal
from flatpunch.punch.graded import graded_matrices
from flatpunch.punch.matrix import RemainderRule, remainder_rule, sufficient_terms
from flatpunch.punch.power_law import power_law_punch
from flatpunch.punch.wavenumbers import bessel_table
from flatpunch.stresses.axisymmetric.panels import Edge, Edges
from flatpunch.stresses.axisymmetric.ring_sources import RingSources, sampled

_TOLERANCE = ROUNDING, 1e-8
"""Last terms of a panel over the largest g at which it is fine enough: on homogeneous and on graded surfaces."""

_NARROWEST = 1e-9, 1e-2
"""Shortest panels over the radius, beside singular points of g: on homogeneous and on graded surfaces."""

_NODES, _TABLE_NODES = 64, 16
"""Gauss nodes between two kinks: of profiles that are smooth there, and between the points of a table."""

_CROWDED = 6
"""On power-law half-spaces nodes are at distances from either kink like x^6: integrands have roots there."""

_SMOOTH = 24
"""Terms of the series c: the rest of a sphere up to 0.8 of its radius is rounding, and 1e-8 with half as many. With hundreds the
rests of kinks oscillate, and their transform takes ten times as long."""


def contact_load(
    kernel: Kernel, indenter: Indenter, radius: float, depth: float, *, edge: bool, again: bool = False
) -> RingSources:
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
    again : bool
        Whether every panel, rule and series is another one, for estimates of the error.

    Returns
    -------
    RingSources
    """
    kinks = np.array([0.0, *sorted(ring for ring in indenter.rings if 0 < ring < radius * (1 - ROUNDING)), radius])
    # a third is no end of a panel that was halved
    breaks = np.sort(np.concatenate([kinks, kinks[:-1] + np.diff(kinks) / 3])) if again else kinks
    edges = (*_inside(kernel, indenter, kinks), Edge(radius, (kernel.exponent + (-1 if edge else 1)) / 2))
    if kernel.exponent:
        return _on_power_law(kernel, indenter, breaks, depth, edges, again=again)
    sunk = _indentation(indenter, again)

    def panels(function: Callable[[Array], Array], rounding: float, edges: Edges) -> RingSources:
        return sampled(
            function,
            breaks,
            _TOLERANCE[kernel.graded],
            _NARROWEST[kernel.graded],
            roots=kinks[1:-1],
            rounding=rounding,
            edges=edges,
        )

    if kernel.homogeneous:
        depth = depth if edge else float(sunk(np.array([radius]))[0])
        return panels(lambda t: kernel.modulus / np.pi * (depth - sunk(t)), 0.0, edges)
    end = float(sunk(np.array([radius]))[0])

    def on_half_space(t: Array) -> Array:
        return (end - sunk(t)) / np.pi

    # stiffness needs the fewest terms, kinks that are wide compared with the layers some times more; the series of the pressure
    # under a graded surface converges slowly
    least = sufficient_terms(kernel, radius / kernel.length)
    series = _projected(on_half_space, radius, min(_SMOOTH, least) + 2 * again)
    rounding = np.finfo(float).eps * 4 * least * (end + float(np.abs(series).sum()))
    rest = partial(_without, on_half_space, series, radius)
    sources = panels(rest, rounding, ())
    first = least + again * (least // 2)
    for terms in ((3 - again) * least,) if kernel.graded else (first, 2 * first, 4 * first):
        # the response is linear in depth and profile: both by themselves, so that g(a) = 0 can be met
        of_depth, of_tip = _responses(kernel, np.pad(series, (0, terms - series.size)), sources)
        # what layers change is smooth: its series has ended, or there are not terms enough
        if np.abs(of_tip[-3:]).max() <= max(1e-9 * np.abs(of_tip).max(), rounding):
            break
    signs = edge_signs(terms)
    if not edge:
        depth = end - float(signs @ of_tip + rest(np.array([radius]))[0]) / float(signs @ of_depth)
    found = _even((depth - end) * of_depth + of_tip)
    return panels(
        lambda t: kernel.modulus * (rest(t) + legendre.legval(t / radius, found)),
        kernel.modulus * rounding,
        edges,
    )


def _inside(kernel: Kernel, indenter: Indenter, kinks: Array) -> Edges:
    """Rings under the tip: where its slope jumps, the pressure varies like the logarithm of the distance or its power e."""
    inside, zero = kinks[1:-1], np.zeros(1)
    if not inside.size:
        return ()
    before, after = (np.asarray(indenter.slope(inside * (1 + step), zero)) for step in (-1e-9, 1e-9))
    jumps = np.abs(after - before) > 1e-6 * np.abs(after).max(initial=0.0)
    return tuple(
        Edge(ring, kernel.exponent + (not sharp), sharp)
        for ring, sharp in zip(inside.tolist(), jumps.tolist(), strict=True)
    )


def _without(function: Callable[[Array], Array], coefficients: Array, radius: float, t: Array) -> Array:
    """The function at t less the sum of c_n (-1)^n P_2n(t/radius)."""
    return np.asarray(function(t) - legendre.legval(t / radius, _even(coefficients)))


def _even(coefficients: Array) -> Array:
    """Legendre series of sum c_n (-1)^n P_2n."""
    series = np.zeros(2 * coefficients.size - 1)
    series[::2] = edge_signs(coefficients.size) * coefficients
    return series


def _projected(function: Callable[[Array], Array], radius: float, terms: int) -> Array:
    """Coefficients c_n of sum c_n (-1)^n P_2n(t/radius) close to a function, shape (terms,)."""
    x, weight = gauss(2 * terms)
    x, weight = (1 + x) / 2, weight / 2
    polynomials = legendre.legvander(x, 2 * terms - 2)[:, ::2]
    return np.asarray(edge_signs(terms) * (4 * np.arange(terms) + 1) * ((weight * function(radius * x)) @ polynomials))


def _between(nodes: int, again: bool) -> tuple[Array, Array]:
    return gauss(nodes + nodes // 4 * again)


def _indentation(indenter: Indenter, again: bool) -> Callable[[Array], Array]:
    """w(t) [m], which on a half-space is the depth that brings the contact to the radius t."""
    zero = np.zeros(1)
    if indenter.flat:
        return np.zeros_like
    if indenter.exponent is not None:
        n = indenter.exponent
        height = float(np.asarray(indenter.height(np.ones(1), zero))[0])
        factor = height * n * np.sqrt(np.pi) / 2 * gamma(n / 2) / gamma((n + 1) / 2)
        return lambda t: factor * t**n
    rings = np.array(sorted(indenter.rings))
    # in arcsin(r/t)
    x, weight = _between(_TABLE_NODES if indenter.tabulated else _NODES, again)

    def sunk(t: Array) -> Array:
        flat = np.maximum(t.ravel(), TINY)
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


def _responses(kernel: Kernel, series: Array, rest: RingSources) -> tuple[Array, Array]:
    """Coefficients of g/E* on the layers: of the flat punch per depth [-], and of a tip given by a series and a rest [m].

    The rest itself is left out of the second.
    """
    radius, terms = rest.radius, series.size
    beta = np.array([radius / kernel.length])
    diagonal = half_space_diagonal(0, terms)
    if kernel.graded:
        matrix = np.asarray(graded_matrices(kernel, beta, terms, 0)[0][0]) + np.diag(diagonal)
        rule = _rule_for_graded(kernel, beta, terms)
    else:
        rule = remainder_rule(kernel, beta, terms, 0)
        matrix = rule.matrix()[0]
    # the flat punch of a half-space has the one coefficient 1/pi
    flat = np.zeros(terms)
    flat[0] = diagonal[0] / np.pi
    of_rest = rule.column(rest.transform(rule.table.x / radius)[None, :] / radius)[0]
    found = np.linalg.solve(matrix, np.column_stack([flat, diagonal * series - of_rest]))
    return found[:, 0], found[:, 1]


def _rule_for_graded(kernel: Kernel, beta: Array, terms: int) -> RemainderRule:
    """Quadrature where L - 1 decays like 1/x: the integrand falls like x^-4."""
    table = bessel_table(0, terms, *wave_range(kernel, float(beta[0]), float(beta[0])))
    weights = 2 * kernel.remainder(table.x / beta[0]) * table.w
    return RemainderRule(table, weights[None, :], np.array([table.x.size]), half_space_diagonal(0, terms))


def _on_power_law(
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
        at_rim = np.maximum((radius - flat) * (radius + flat), TINY) ** (e / 2)
        if own is None:
            return np.asarray(constant * top * at_rim.reshape(t.shape))
        piled = _piled(own, breaks, flat, e, again)
        return np.asarray(constant * ((top - own.value(flat)) * at_rim - e * piled).reshape(t.shape))

    return sampled(sources, breaks, _TOLERANCE[0], edges=edges)


def _depths(kernel: Kernel, indenter: Indenter, breaks: Array) -> RingSources:
    """Depth d(s) at which the contact without adhesion has the radius s."""
    profile, shortest = mean_profile(indenter), ROUNDING * breaks[-1]

    def depth(s: Array) -> Array:
        return round_contact(kernel, profile, np.maximum(s.ravel(), shortest)).depth.reshape(s.shape)

    return sampled(depth, breaks, _TOLERANCE[0])


def _piled(own: RingSources, breaks: Array, t: Array, e: float, again: bool) -> Array:
    """int_t^a s (s^2 - t^2)^(e/2 - 1) (d(s) - d(t)) ds."""
    x, weight = _between(_NODES, again)
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
