"""Contact outline of the paper's first-order method: (P17), and (P23) for power-law shapes."""

from __future__ import annotations

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import AT_ONCE, Array
from flatpunch.compliances import Kernel
from flatpunch.contact.round.round_contact import RoundContact
from flatpunch.indenters.geometry.angles import angular_mean, angular_rule
from flatpunch.indenters.geometry.features import different_rays, flat_radius
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.piecewise import PiecewiseChebyshev, log_table
from flatpunch.punch.family import punch_family


def outline(kernel: Kernel, indenter: Indenter, contact: RoundContact, phi: Array) -> Array:
    """Contact outline a(phi) [m] by (P17), shape (n, p), of n contacts of the mean profile at p polar angles [rad].

    NaN where (P17) has no answer: the denominator 2d - 2 g0 - a g0' is not negative (stiff films), or the outline would pass
    through the axis.
    """
    a = contact.radius
    if indenter.round:
        return np.repeat(a[:, None], phi.size, axis=1)
    if indenter.exponent is not None:
        psi = np.asarray(indenter.height(np.ones_like(phi), phi))
        angles, weights = angular_rule(indenter)
        mean = float(weights @ np.asarray(indenter.height(np.ones_like(angles), angles)))
        shape = np.outer(a * growth_factor(contact, indenter.exponent), 1 - psi / mean)
    else:
        shape = _general(kernel, indenter, contact, phi)
        shape *= a[:, None]
    shape += a[:, None]
    # NaN compares as False, so rows without an answer are lost as well
    lost = ~((shape.min(axis=1) > 0) | (a == 0))
    shape[lost] = np.nan
    return shape


def area(kernel: Kernel, indenter: Indenter, contact: RoundContact) -> Array:
    """Contact area within the outline, shape (n,) [m^2]; NaN where there is no outline."""
    a = contact.radius
    if indenter.round:
        return np.asarray(np.pi * a**2)
    angles, weights = angular_rule(indenter)
    if indenter.exponent is None:
        return np.asarray(np.pi * outline(kernel, indenter, contact, angles) ** 2 @ weights)
    psi = np.asarray(indenter.height(np.ones_like(angles), angles))
    deviation = 1 - psi / (weights @ psi)
    growth = growth_factor(contact, indenter.exponent)
    gone = (growth * deviation.min() <= -1) | (growth * deviation.max() <= -1)
    return np.where(gone, np.nan, np.pi * a**2 * (1 + growth**2 * (weights @ deviation**2)))


def growth_factor(contact: RoundContact, exponent: float) -> Array:
    """(n + 2)/((n + 1)(n + 2 - 2 d*)) of (P23), NaN where the denominator is not positive; shape (n,)."""
    b, responses = contact.moments.b, contact.responses
    moment = (exponent + 1) * np.sum(b * responses.flat, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        d_star = np.where(contact.radius > 0, contact.depth * responses.flat[:, 0] / moment, 1.0)
    denominator = exponent + 2 - 2 * d_star
    return np.where(
        denominator > 0, (exponent + 2) / (exponent + 1) / np.where(denominator > 0, denominator, 1), np.nan
    )


def _general(kernel: Kernel, indenter: Indenter, contact: RoundContact, phi: Array) -> Array:
    """Relative deviation of the outline for any profile, shape (n, p): (P17) with the radius as the unit."""
    result = np.zeros((contact.radius.size, phi.size))
    live = contact.radius > 0
    a = contact.radius[live]
    different, of_ray = different_rays(indenter, phi)
    # number of contacts above which general outlines are read from a table over ln a
    read = np.full(a.size, a.size > 100)
    if flat_radius(indenter) > 0:
        # radius of the contact over that of a flat end above which they are: closer by each ray has a kink of its own
        read &= a > 3.0 * indenter.rings[-1]
    terms = np.empty((a.size, different.size + 1))
    if read.any():
        terms[read] = _table(kernel, indenter, different.tobytes()).at(np.log(a[read]))
    terms[~read] = _terms(kernel, indenter, a[~read], different)
    terms = terms[:, [*of_ray, -1]]
    denominator = 2 * contact.depth[live] / a * contact.responses.flat[live, 0] - terms[:, -1]
    with np.errstate(divide="ignore", invalid="ignore"):
        result[live] = np.where(denominator[:, None] < 0, terms[:, :-1] / denominator[:, None], np.nan)
    return result


@byte_cached
def _table(kernel: Kernel, indenter: Indenter, angles: bytes) -> PiecewiseChebyshev:
    """The terms over ln a: far fewer radii than a long curve has."""
    phi = np.frombuffer(angles)
    return log_table(lambda a: _terms(kernel, indenter, a, phi), indenter.reach, kinks=indenter.rings)


def _terms(kernel: Kernel, indenter: Indenter, radius: Array, phi: Array) -> Array:
    """Numerators of (P17) and the profile's part of its denominator, over the radius; shape (n, p + 1)."""
    nodes = punch_family(kernel).rule(radius[-1:] / kernel.length)[0].shape[-1] if radius.size else 1
    size = max(1, AT_ONCE // (nodes * phi.size))
    parts = [_terms_of(kernel, indenter, radius[i : i + size], phi) for i in range(0, radius.size, size)]
    return np.vstack([*parts, np.empty((0, phi.size + 1))])


def _terms_of(kernel: Kernel, indenter: Indenter, a: Array, phi: Array) -> Array:
    rho, weight = punch_family(kernel).rule(a / kernel.length)
    r = a[:, None] * rho
    # notation: J0 = b[f].c*, J1 = b[r f'].c* per angle; a G = a^2 J0/c0, so G + a g = a (2 J0 + J1)/c0
    height, slope = indenter.height_and_slope(r[..., None], phi)
    local = 2 * np.einsum("nj,njp->np", weight, height) + np.einsum("nj,njp->np", weight * r, slope)
    mean = _mean_response(indenter, a, rho, weight)
    second = _second_response(indenter, a, rho, weight)
    return np.column_stack([local - mean[:, None], second]) / a[:, None]


def _mean_response(indenter: Indenter, a: Array, rho: Array, weight: Array) -> Array:
    """2 J0 + J1 of the mean profile on discs a, at fixed flat-punch pressure; shape (n,)."""
    mean, r = angular_mean(indenter), a[:, None] * rho
    return np.asarray(np.einsum("nj,nj->n", weight, 2 * mean.height(r) + r * mean.slope(r)))


def _second_response(indenter: Indenter, a: Array, rho: Array, weight: Array) -> Array:
    """c0 (2 g0 + a g0') = (a^2 J0)''/... = (1 + a d/da)(2 J0 + J1), by a five-point difference in log a."""
    # relative step: the error is 0.03 step^4 of smooth profiles, below rounding
    step = 1e-3
    value = [_mean_response(indenter, a * np.exp(j * step), rho, weight) for j in (-2, -1, 1, 2)]
    derivative = (4 * (value[2] - value[1]) / 2 - (value[3] - value[0]) / 4) / (3 * step)
    return np.asarray(_mean_response(indenter, a, rho, weight) + derivative)
