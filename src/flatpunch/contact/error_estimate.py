"""How far to trust each method on non-round indenters: estimates of the relative error of force and outline.

The series tell their own error: second order by its third and fourth terms, fourth order by what its Pade form adds to the
plain sum. Outlines are known to first order of the logarithm only, and miss by a fraction of the square of its swing. The
first-order method is judged by second order on a half-space, where that is a matter of the indenter alone; on layers its
error changes by up to half as much again. Constants are those of the honesty catalogue (validation page).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from flatpunch._validation import Array
from flatpunch.compliance import compliance
from flatpunch.contact.control import Loading
from flatpunch.contact.curve import Control, Extra
from flatpunch.contact.expansion import PerturbedContact, power_expansion
from flatpunch.contact.general_expansion import general_expansion
from flatpunch.contact.mean import mean_contact
from flatpunch.contact.outline import outline
from flatpunch.indenters.profile import Indenter
from flatpunch.media import HalfSpace

_OUTLINE = 0.45
_NEWTON = 6
_LAYERS = 1.6
_FLOOR = 1e-5
"""Kinked outlines end at 1e-7 of the force, sampled general ones at 1e-4 (`general_expansion`)."""


def estimates(force: Array, contour: Array) -> Extra:
    """Both estimates as result variables."""
    return {
        "force_error": (("step",), force, "1", "estimated relative error of the force"),
        "contour_error": (("step",), contour, "1", "estimated relative error of the outline a(phi)"),
    }


def second_order_error(contact: PerturbedContact) -> tuple[Array, Array]:
    """Estimates for second order, shape (n,) each; for general profiles, whose higher terms are unknown, from x2 alone."""
    x2, x3, x4 = contact.terms.T
    higher = np.abs(x3 + x4) + 0.2 * np.abs(x4)
    force = np.where((x3 == 0) & (x4 == 0), 2.5 * x2**2 + 1e-4, higher)
    return force + _FLOOR, _OUTLINE * contact.swing**2 + 1e-3


def fourth_order_error(contact: PerturbedContact) -> tuple[Array, Array]:
    """Estimates for fourth order, shape (n,) each: the Pade form against the plain sum."""
    x2, x3, x4 = contact.terms.T
    safe = np.where(x2 == 0, 1.0, x2)
    pade = np.where(x2 == 0, 0.0, x2**2 / (safe - x3 + x3**2 / safe - x4))
    return np.abs(pade - x2 - x3 - x4) + _FLOOR, _OUTLINE * contact.swing**2 + 1e-3


def first_order_error(indenter: Indenter, radius: Array) -> tuple[Array, Array]:
    """Estimates for first order, shape (n,) each: its difference to second order on a half-space."""
    if indenter.exponent is not None:
        force, contour = _half_space_difference(indenter, 1.0)
    else:
        live = radius[radius > 0]
        places = [live.max(), 0.3 * live.max()] if live.size else [1.0]
        force, contour = np.max([_half_space_difference(indenter, float(a)) for a in places], axis=0)
    return np.full_like(radius, _LAYERS * force + _FLOOR), np.full_like(radius, _LAYERS * contour + 1e-3)


@lru_cache(maxsize=256)
def _half_space_difference(indenter: Indenter, radius: float) -> tuple[float, float]:
    """Differences of force (relative) and outline (over the mean radius) between first and second order on a half-space.

    Taken at the depth at which the mean profile has the contact radius `radius`.
    """
    kernel = compliance(HalfSpace(1.0, 0.0))
    power = indenter.exponent is not None
    series = power_expansion(kernel, indenter, "second") if power else general_expansion(kernel, indenter)
    _, first = mean_contact(kernel, indenter, Control("radius", np.array([radius])))
    second = series.evaluate(_same_depth(series.loading, first.depth, radius, indenter.reach))
    phi = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    difference = outline(kernel, indenter, first, phi) - series.outline(second, phi)
    shape = float(np.max(np.abs(difference)) / second.mean_radius[0]) if np.all(np.isfinite(difference)) else 1.0
    own = second_order_error(second)
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
