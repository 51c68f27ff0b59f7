"""Curves from a perturbation series of any order and profile; second order for any shape and medium (T8.1)-(T8.5)."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import Protocol

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, BadValue
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact.curve import Control, Curve, check_reach, first_failure
from flatpunch.contact.perturbation import first_order
from flatpunch.contact.perturbation.error import estimates, second_order_error
from flatpunch.contact.perturbation.general_series import general_expansion
from flatpunch.contact.perturbation.perturbed_contact import PerturbedContact
from flatpunch.contact.perturbation.power_law_series import power_expansion
from flatpunch.contact.round.mean_profile import resolved_radius, searched_radius
from flatpunch.contact.round.profile import TINY, RoundProfile
from flatpunch.contact.round.radius_search import PER_DECADE, Loading
from flatpunch.contact.round.soundness import soundness
from flatpunch.indenters.profile import Indenter
from flatpunch.media import HalfSpace

LARGEST_SWING = 1.2
"""|ln a(phi)/abar| above which outlines are off by tens of per cent."""


def outline_causes(kernel: Kernel, indenter: Indenter, contact: PerturbedContact) -> tuple[str, ...]:
    """What makes the outline uncertain, with the depths beyond which it does."""
    wide = contact.swing > LARGEST_SWING
    if not wide.any():
        return ()
    # swing over that on a half-space above which the medium is the cause, not the tip
    amplified = wide & (contact.swing > 1.5 * _half_space_swing(kernel, indenter))
    remedy = (
        "(|ln a/abar| above 1.2), so outline and area are uncertain by ten per cent and more; the force is less affected. "
        "Refine outline and area with method='refined' or 'bem'."
    )
    edges = "its sharp edges draw" if indenter.corners else "it draws"
    return first_failure(
        amplified,
        contact.depth,
        f"the medium (a stiff film) amplifies the asymmetry of the tip in the outline {remedy}",
    ) + first_failure(
        wide & ~amplified,
        contact.depth,
        f"the tip is strongly asymmetric: {edges} the outline far from a circle {remedy}",
    )


def _half_space_swing(kernel: Kernel, indenter: Indenter) -> float:
    """Swing of a power-law tip on a half-space; infinite where that is the medium, or the tip is none."""
    if kernel.homogeneous or indenter.exponent is None:
        return float("inf") if kernel.homogeneous else 1.0
    return _power_swing(indenter)


@byte_cached
def _power_swing(indenter: Indenter) -> float:
    series = power_expansion(compliance(HalfSpace(1.0, 0.0)), indenter, "second")
    return float(series.evaluate(np.ones(1)).swing[0])


class Expansion(Hashable, Protocol):
    """Perturbation series of one indenter on one medium over its base radius."""

    @property
    def base(self) -> RoundProfile:
        """Profile of the round base contact."""

    def descent(self, radius: Array) -> Loading:
        """Depth and its derivative at base radii, shape (n,); the force is not to be used."""

    def loading(self, radius: Array) -> Loading:
        """Depth, force and their derivatives at base radii, shape (n,)."""

    def evaluate(self, radius: Array) -> PerturbedContact:
        """Contacts at base radii, shape (n,)."""

    def outline(self, contact: PerturbedContact, phi: Array) -> Array:
        """Outlines a(phi), shape (n, p)."""


def controlled(kernel: Kernel, indenter: Indenter, expansion: Expansion, control: Control) -> PerturbedContact:
    """Contacts at the prescribed depths, forces or mean radii a0."""
    if control.name == "radius":
        check_reach(indenter, control.values)
        return expansion.evaluate(_base_radius(kernel, indenter, expansion, control.values))
    path = expansion.descent if control.name == "depth" else expansion.loading
    radius = searched_radius(kernel, expansion.base, path, control, indenter.reach)
    contact = expansion.evaluate(radius)
    # the rounding error of the radius is removed along the curve, so that the prescribed value is met exactly
    if control.name == "depth":
        rest = control.values - contact.depth
        force = contact.force + contact.stiffness * rest
        # beside a flat end the radius is known to a millionth, and smaller depths are those of a punch
        force = np.where((force < 0) & (contact.force > 0), contact.stiffness * control.values, force)
        return replace(contact, depth=control.values, force=force)
    rest = (control.values - contact.force) / np.where(contact.stiffness > 0, contact.stiffness, 1.0)
    depth = contact.depth + np.where(contact.stiffness > 0, rest, 0.0)
    # beside a flat end depths are known to a millionth of it
    return replace(contact, force=control.values, depth=np.maximum(depth, 0.0))


def _base_radius(kernel: Kernel, indenter: Indenter, expansion: Expansion, mean_radius: Array) -> Array:
    """First base radii whose contacts have the mean radii a0, which need not grow with them; shape (n,)."""
    from scipy.optimize import elementwise

    radius = mean_radius.copy()
    live = mean_radius > 0
    if not live.any():
        return radius
    wanted = np.log(mean_radius[live])

    def excess(x: Array) -> Array:
        # a contact whose size the series does not give counts as too small
        size = expansion.evaluate(np.exp(x)).mean_radius
        return np.asarray(np.log(np.where(size > 0, size, TINY)))

    most = min(indenter.reach, resolved_radius(kernel))
    nodes, found = _mean_radii(excess, float(wanted.min()), float(wanted.max()), float(np.log(most)))
    reached = np.maximum.accumulate(found)
    missing = wanted > reached[-1]
    if missing.any():
        raise BadValue(
            "radius",
            f"{text(float(np.exp(wanted[missing][0])), 'm')}",
            "is reached by no contact of this method: the largest mean radius is "
            f"{text(float(np.exp(reached[-1])), 'm')}. Prescribe depth or force instead, or choose method='bem'.",
        )
    upper = np.clip(np.searchsorted(reached, wanted), 1, nodes.size - 1)
    found_root = elementwise.find_root(
        lambda x, goal: excess(x) - goal, (nodes[upper - 1], nodes[upper]), args=(wanted,)
    )
    radius[live] = np.exp(np.where(found_root.success, found_root.x, nodes[upper - 1]))
    return radius


def _mean_radii(excess: Callable[[Array], Array], low: float, high: float, most: float) -> tuple[Array, Array]:
    """Logarithms of base radii from below all wanted ones upwards, and of their mean radii."""
    # in a wider spacing a turn of the path may be missed; the margin beyond the wanted radii grows where it is not enough
    spacing, margin = np.log(10) / PER_DECADE, 1.0
    start, stop = low - margin, min(high + spacing, most)
    while True:
        nodes = np.linspace(start, stop, max(int(np.ceil((stop - start) / spacing)), 2) + 1)
        found = excess(nodes)
        if found[0] > low and start > low - 4 * margin:
            start -= margin
        elif found.max() < high and stop < min(most, high + 3 * margin):
            stop = min(stop + margin / 2, most)
        else:
            return nodes, found


def solve_expansion(
    kernel: Kernel, indenter: Indenter, expansion: Expansion, control: Control, phi: Array
) -> tuple[Curve, PerturbedContact]:
    """A whole curve, and the contacts it was made from."""
    contact = controlled(kernel, indenter, expansion, control)
    valid, notes = soundness(kernel, expansion.loading, contact)
    notes += outline_causes(kernel, indenter, contact)
    curve = Curve(
        depth=contact.depth,
        force=contact.force,
        radius=contact.mean_radius,
        area=contact.area,
        stiffness=contact.stiffness,
        contour=expansion.outline(contact, phi),
        valid=valid & (contact.stiffness >= 0),
        notes=notes,
    )
    return curve, contact


def solve(kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
    """A whole curve; round indenters are solved exactly."""
    if indenter.round:
        return first_order.solve(kernel, indenter, control, phi)
    curve, contact = solve_expansion(kernel, indenter, expansion_of(kernel, indenter), control, phi)
    return replace(curve, extra=estimates(*second_order_error(indenter, contact)))


def expansion_of(kernel: Kernel, indenter: Indenter) -> Expansion:
    """The second-order series of an indenter on a medium."""
    if indenter.exponent is None:
        return general_expansion(kernel, indenter)
    return power_expansion(kernel, indenter, "second")
