"""Error estimates of the series on non-round indenters: relative error of the force, and error of the outline.

Second order is judged by its own third and fourth terms, or by the sum of a series with their ratio, fourth order by what its
Pade form adds to the plain sum and by its last term. Outlines are known to first order of their logarithm w only; their error
is a fraction of the square of max|w|, the swing, and of the swing itself at edges, where outlines have cusps. First order is
judged by second order on a half-space, where that is a matter of the indenter alone, and by so much more as the medium enlarges
the square of the outline's deviation from a circle, to which the terms of second order are proportional. The factors were
fitted to the honesty catalogue (tests/catalogue), in which at least 95 % of the true errors are below the estimate; all are
proportional, so that doubling one doubles its part of the estimate.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact.curve import Control, Extra
from flatpunch.contact.perturbation.first_order_outline import outline
from flatpunch.contact.perturbation.general_series import LARGEST_WAVE, general_expansion
from flatpunch.contact.perturbation.perturbed_contact import PerturbedContact
from flatpunch.contact.perturbation.power_law_series import power_expansion
from flatpunch.contact.round.mean_profile import mean_contact
from flatpunch.contact.round.radius_search import Loading
from flatpunch.contact.round.round_contact import RoundContact
from flatpunch.indenters.geometry.angles import angular_rule
from flatpunch.indenters.geometry.features import beside_flat_end
from flatpunch.indenters.profile import Indenter
from flatpunch.media import HalfSpace


@dataclass(frozen=True, slots=True)
class Factors:
    """Factors of the estimates.

    Attributes
    ----------
    outline : float
        Error of an outline per swing^2.
    edges, blunt : float
        Error of an outline per swing, of tips with edges and of general profiles without (blunted tips).
    last : float
        Second order: share of |x4| that is added to what x3 and x4 say.
    higher : float
        Next term over its measure: |x4| swing^2 in fourth order; |x3| and x2^2 of general profiles, whose x4 is not known.
    layers : float
        First order: error of force and outline on any medium over that on a half-space, beside what the medium enlarges.
    flat_force, flat_outline : float
        Error beside a flat end per ln(largest/smallest radius) of it: a square punch is 15 % stiffer than the disc inside it.
    floor, sampled_floor : float
        What quadrature over the angle leaves of the force: kinked outlines 1e-7, sampled ones 2e-5. Boundary elements, with which
        all this is compared, know it to 1e-6.
    outline_floor : float
        The same of the outline.
    """

    outline: float = 0.7
    edges: float = 0.4
    blunt: float = 0.2
    last: float = 0.2
    higher: float = 1.5
    layers: float = 1.8
    flat_force: float = 0.5
    flat_outline: float = 1.0
    floor: float = 1e-6
    sampled_floor: float = 4e-5
    outline_floor: float = 1e-3


_FACTORS = Factors()


def estimates(force: Array, contour: Array) -> Extra:
    """Both estimates as result variables."""
    return {
        "force_error": (("step",), force, "1", "estimated relative error of the force"),
        "contour_error": (("step",), contour, "1", "estimated error of the outline a(phi) over the mean radius"),
    }


def second_order_error(indenter: Indenter, contact: PerturbedContact) -> tuple[Array, Array]:
    """Estimates for second order, shape (n,) each; x3 and x4 of general profiles are not known."""
    x2, x3, x4 = contact.terms.T
    if indenter.exponent is None:
        force = _FACTORS.higher * (np.abs(x3) + x2**2) + _FACTORS.sampled_floor
        # swing above which the outline of a general profile was cut: there the force is lost as well
        force = np.where(contact.swing > 0.99 * LARGEST_WAVE, np.maximum(force, np.abs(x2) * contact.swing), force)
        force = force + _FACTORS.flat_force * _flat_spread(indenter, contact)
    else:
        # terms of opposite signs may cancel by chance; the sum of a series with their ratio does not
        size = np.abs(x3) + np.abs(x4)
        rest = np.maximum(np.abs(x3 + x4), x3**2 / np.where(size > 0, size, 1.0))
        force = rest + _FACTORS.last * np.abs(x4) + _FACTORS.floor
    return force, _outline_error(indenter, contact)


def fourth_order_error(indenter: Indenter, contact: PerturbedContact) -> tuple[Array, Array]:
    """Estimates for fourth order, shape (n,) each."""
    x2, x3, x4 = contact.terms.T
    safe = np.where(x2 == 0, 1.0, x2)
    denominator = safe - x3 + x3**2 / safe - x4
    # far outside the sound range it may vanish
    pade = np.where(x2 == 0, 0.0, x2**2 / np.where(np.abs(denominator) > 1e-3 * np.abs(safe), denominator, safe))
    force = np.abs(pade - x2 - x3 - x4) + _FACTORS.higher * np.abs(x4) * contact.swing**2 + _FACTORS.floor
    return force, _outline_error(indenter, contact)


def _outline_error(indenter: Indenter, contact: PerturbedContact) -> Array:
    """Largest error of a(phi) over the mean radius, shape (n,)."""
    linear = _FACTORS.edges if indenter.corners else (_FACTORS.blunt if indenter.exponent is None else 0.0)
    error = linear * contact.swing + _FACTORS.outline * contact.swing**2 + _FACTORS.outline_floor
    return np.asarray(error + _FACTORS.flat_outline * _flat_spread(indenter, contact))


def _flat_spread(indenter: Indenter, contact: PerturbedContact) -> Array:
    """ln of the largest over the smallest radius of a flat end while the contact hardly exceeds it, else 0; shape (n,)."""
    beside = beside_flat_end(indenter, contact.radius)
    return (
        np.where(beside, np.log(indenter.rings[-1] / indenter.rings[0]), 0.0) if beside.any() else 0.0 * contact.radius
    )


def first_order_error(kernel: Kernel, indenter: Indenter, contact: RoundContact) -> tuple[Array, Array]:
    """Estimates for first order, shape (n,) each: its difference to second order on a half-space, and what the medium adds.

    Infinite in force where the medium leaves no outline of first order.
    """
    radius = contact.radius
    if indenter.exponent is not None:
        force, contour = _half_space_difference(indenter, 1.0)
    else:
        places = radius.max(initial=0.0) * np.array([1.0, 0.3])
        found = [_half_space_difference(indenter, float(a)) for a in places if a > 0]
        force, contour = np.max(found, axis=0) if found else np.zeros(2)
    enlarged = np.maximum(_enlargement(kernel, indenter, contact), 1.0)
    return (
        _FACTORS.layers * force * enlarged + _FACTORS.floor,
        _FACTORS.layers * contour * enlarged + _FACTORS.outline_floor,
    )


def _enlargement(kernel: Kernel, indenter: Indenter, contact: RoundContact) -> Array:
    """Mean square of the outline's deviation from a circle over that on a half-space at the same radius, shape (n,)."""
    deviates = contact.depth > 0
    if kernel.homogeneous or not deviates.any():
        return np.ones_like(contact.radius)
    half_space = compliance(HalfSpace(1.0, 0.0))
    _, other = mean_contact(half_space, indenter, Control("radius", contact.radius))
    phi, weights = angular_rule(indenter)
    radius = np.where(deviates, contact.radius, 1.0)[:, None]
    here, there = (
        (outline(body, indenter, round_, phi) / radius - 1) ** 2 @ weights
        for body, round_ in ((kernel, contact), (half_space, other))
    )
    # contacts within a round apex are circles but for rounding, on any medium
    enlarged = np.where(np.isfinite(here), here, np.inf) / np.maximum(there, _FACTORS.outline_floor**2)
    return np.where(deviates, enlarged, 1.0)


@byte_cached
def _half_space_difference(indenter: Indenter, radius: float) -> tuple[float, float]:
    """Differences of force and outline, both relative, of first to second order at the same depth on a half-space."""
    kernel = compliance(HalfSpace(1.0, 0.0))
    power = indenter.exponent is not None
    series = power_expansion(kernel, indenter, "second") if power else general_expansion(kernel, indenter)
    _, first = mean_contact(kernel, indenter, Control("radius", np.array([radius])))
    if first.depth[0] == 0:
        # within a flat end the depth is zero
        return 0.0, 0.0
    second = series.evaluate(_same_depth(series.loading, first.depth, radius, indenter.reach))
    phi = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    difference = outline(kernel, indenter, first, phi) - series.outline(second, phi)
    shape = float(np.max(np.abs(difference)) / second.mean_radius[0]) if np.all(np.isfinite(difference)) else 1.0
    own = second_order_error(indenter, second)
    return float(abs(first.force[0] / second.force[0] - 1) + own[0][0]), shape + float(own[1][0])


def _same_depth(loading: Callable[[Array], Loading], depth: Array, radius: float, reach: float) -> Array:
    """Base radius of a series at a depth, shape (1,): a few steps of Newton from the radius of the mean profile."""
    found = np.array([radius])
    # Newton steps between two contacts of equal depth, a tenth of their radius apart; each doubles the digits
    for _ in range(6):
        path = loading(found)
        if path.depth_slope[0] <= 0:
            break
        found = np.minimum(found * np.exp(np.clip((depth - path.depth) / path.depth_slope, -0.5, 0.5)), reach)
    return found
