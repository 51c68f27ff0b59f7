"""How far to trust each method on non-round indenters: estimates of the relative error of the force, and of the outline.

The series tell their own error: second order by its third and fourth terms, fourth order by what its Pade form adds to the
plain sum and by its last term. Outlines are known to first order of the logarithm only; they miss by a fraction of the
square of its swing, and at edges, where they have cusps, by one of the swing itself. The first-order method is judged by
second order on a half-space, where that is a matter of the indenter alone; on layers its error changes by up to half as
much again. The constants were read off the honesty catalogue (tests/catalogue), where at least 95 % of the true errors are
below the estimate.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliance import compliance
from flatpunch.contact.curve import Control, Extra
from flatpunch.contact.perturbation.first_order_outline import outline
from flatpunch.contact.perturbation.general_series import general_expansion
from flatpunch.contact.perturbation.perturbed_contact import PerturbedContact
from flatpunch.contact.perturbation.power_law_series import power_expansion
from flatpunch.contact.round.mean_profile import mean_contact
from flatpunch.contact.round.radius_search import Loading
from flatpunch.indenters.geometry.flat_end import beside_flat_end
from flatpunch.indenters.profile import Indenter
from flatpunch.media import HalfSpace

_OUTLINE, _EDGES, _BLUNT = 0.7, 0.4, 0.2
"""Error of an outline per swing^2 for all tips, and per swing for tips with edges and for blunted ones."""
_OUTLINE_FLOOR = 1e-3
_LAST, _SKEW, _SQUARE = 0.2, 1.5, 1.5
"""Second order: share of x4 added to |x3 + x4|; for general profiles, per measure of x3 and per x2^2."""
_SPREAD = 1.5
"""Fourth order: share of |x4| swing^2, of the size of the sixth order."""
_LAYERS, _LAYERS_OUTLINE = 1.8, 2.5
"""First order: what layers make of its error on a half-space, in force and outline."""
_FLOOR, _SAMPLED_FLOOR = 1e-6, 4e-5
"""Kinked outlines end at 1e-7 of the force, sampled ones at 2e-5; boundary elements could not tell below 1e-6."""
_LOST = 3.0
"""|ln a/abar| at which general outlines are cut: there the force is lost as well."""
_FLAT_FORCE, _FLAT_OUTLINE = 0.5, 1.0
"""Per ln(largest/smallest radius) of a flat end: a square punch is 15 % stiffer than the disc inside it, ln 2/2 = 0.35."""
_NEWTON = 6


def estimates(force: Array, contour: Array) -> Extra:
    """Both estimates as result variables."""
    return {
        "force_error": (("step",), force, "1", "estimated relative error of the force"),
        "contour_error": (("step",), contour, "1", "estimated error of the outline a(phi) over the mean radius"),
    }


def second_order_error(indenter: Indenter, contact: PerturbedContact) -> tuple[Array, Array]:
    """Estimates for second order, shape (n,) each; those of general profiles do not know x3 and x4."""
    x2, x3, x4 = contact.terms.T
    if indenter.exponent is None:
        force = _SKEW * np.abs(x3) + _SQUARE * x2**2 + _SAMPLED_FLOOR
        force = np.where(contact.swing > 0.99 * _LOST, np.maximum(force, np.abs(x2) * contact.swing), force)
        force = force + _FLAT_FORCE * _flat_spread(indenter, contact)
    else:
        force = np.abs(x3 + x4) + _LAST * np.abs(x4) + _FLOOR
    return force, _outline_error(indenter, contact)


def fourth_order_error(indenter: Indenter, contact: PerturbedContact) -> tuple[Array, Array]:
    """Estimates for fourth order, shape (n,) each."""
    x2, x3, x4 = contact.terms.T
    safe = np.where(x2 == 0, 1.0, x2)
    denominator = safe - x3 + x3**2 / safe - x4
    # far outside the sound range it may vanish
    pade = np.where(x2 == 0, 0.0, x2**2 / np.where(np.abs(denominator) > 1e-3 * np.abs(safe), denominator, safe))
    force = np.abs(pade - x2 - x3 - x4) + _SPREAD * np.abs(x4) * contact.swing**2 + _FLOOR
    return force, _outline_error(indenter, contact)


def _outline_error(indenter: Indenter, contact: PerturbedContact) -> Array:
    """Largest error of a(phi) over the mean radius, shape (n,)."""
    linear = _EDGES if indenter.corners else (_BLUNT if indenter.exponent is None else 0.0)
    error = linear * contact.swing + _OUTLINE * contact.swing**2 + _OUTLINE_FLOOR
    return np.asarray(error + _FLAT_OUTLINE * _flat_spread(indenter, contact))


def _flat_spread(indenter: Indenter, contact: PerturbedContact) -> Array:
    """ln of the largest over the smallest radius of a flat end while the contact hardly exceeds it, else 0; shape (n,)."""
    beside = beside_flat_end(indenter, contact.radius)
    return (
        np.where(beside, np.log(indenter.rings[-1] / indenter.rings[0]), 0.0) if beside.any() else 0.0 * contact.radius
    )


def first_order_error(indenter: Indenter, radius: Array) -> tuple[Array, Array]:
    """Estimates for first order, shape (n,) each: its difference to second order on a half-space."""
    if indenter.exponent is not None:
        force, contour = _half_space_difference(indenter, 1.0)
    else:
        places = radius.max(initial=0.0) * np.array([1.0, 0.3])
        found = [_half_space_difference(indenter, float(a)) for a in places if a > 0]
        force, contour = np.max(found, axis=0) if found else np.zeros(2)
    return np.full_like(radius, _LAYERS * force + _FLOOR), np.full_like(radius, _LAYERS_OUTLINE * contour + 1e-3)


@lru_cache(maxsize=256)
def _half_space_difference(indenter: Indenter, radius: float) -> tuple[float, float]:
    """Differences of force (relative) and outline (over the mean radius) between first and second order on a half-space.

    Taken at the depth at which the mean profile has the contact radius `radius`.
    """
    kernel = compliance(HalfSpace(1.0, 0.0))
    power = indenter.exponent is not None
    series = power_expansion(kernel, indenter, "second") if power else general_expansion(kernel, indenter)
    _, first = mean_contact(kernel, indenter, Control("radius", np.array([radius])))
    if first.depth[0] == 0:
        # within a flat end nothing has happened yet
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
    for _ in range(_NEWTON):
        path = loading(found)
        if path.depth_slope[0] <= 0:
            break
        found = np.minimum(found * np.exp(np.clip((depth - path.depth) / path.depth_slope, -0.5, 0.5)), reach)
    return found
