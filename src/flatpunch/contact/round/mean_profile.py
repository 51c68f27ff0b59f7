"""Round contact of the angular mean of a profile, on which every fast method is based."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliance import Kernel
from flatpunch.contact.curve import Control, check_reach
from flatpunch.contact.round.profile import PowerProfile, RoundProfile, SampledProfile
from flatpunch.contact.round.radius_search import radius_for
from flatpunch.contact.round.round_contact import RoundContact, round_contact
from flatpunch.indenters.geometry.angle_rule import angular_rule
from flatpunch.indenters.geometry.angular_mean import angular_mean
from flatpunch.indenters.profile import Indenter
from flatpunch.punch.matrix import LARGEST, effective_beta

_TABLE_NODES = 256
"""Quadrature points of tabulated profiles: 1e-8 of tables of a hundred points."""

Evaluate = Callable[[Array], RoundContact]


def mean_profile(indenter: Indenter) -> RoundProfile:
    """Angular mean f0(r) of an indenter."""
    if indenter.exponent is not None:
        phi, weights = angular_rule(indenter)
        psi = np.asarray(indenter.height(np.ones_like(phi), phi))
        return PowerProfile(indenter.exponent, float(weights @ psi))
    nodes = _TABLE_NODES if getattr(indenter, "tabulated", False) else 0
    if indenter.round:
        zero = np.zeros(1)
        return SampledProfile(
            lambda r: indenter.height(r, zero), lambda r: indenter.slope(r, zero), indenter.rings, nodes
        )
    mean = angular_mean(indenter)
    return SampledProfile(mean.height, mean.slope, indenter.rings, nodes)


def mean_contact(kernel: Kernel, indenter: Indenter, control: Control) -> tuple[Evaluate, RoundContact]:
    """Contacts of the mean profile at the prescribed depths, forces or mean radii, and the function that makes them."""
    profile = mean_profile(indenter)

    def evaluate(radius: Array) -> RoundContact:
        return round_contact(kernel, profile, radius)

    if control.name == "radius":
        check_reach(indenter, control.values)
        return evaluate, evaluate(control.values)
    guess = half_space_radius(kernel, profile, control, indenter.reach)
    radius = radius_for(evaluate, control.name, control.values, guess, indenter.reach, resolved_radius(kernel))
    return evaluate, _on_target(evaluate(radius), control)


def _on_target(contact: RoundContact, control: Control) -> RoundContact:
    """The contact at exactly the prescribed depth or force.

    F(d; a) = K(a) d - ... is linear in d and stationary in a (Barber's principle), so that the rounding error of the
    radius enters squared. It matters where the radius barely moves: a truncated tip begins as a flat punch.
    """
    if control.name == "depth":
        rest = control.values - contact.depth
        return replace(contact, depth=control.values, force=contact.force + contact.stiffness * rest)
    touching = contact.stiffness > 0
    rest = (control.values - contact.force) / np.where(touching, contact.stiffness, 1)
    return replace(contact, force=control.values, depth=contact.depth + np.where(touching, rest, 0))


def resolved_radius(kernel: Kernel) -> float:
    """Largest contact radius at which the thinnest layer is resolved [m]."""
    return LARGEST * shortest_length(kernel)


def shortest_length(kernel: Kernel) -> float:
    """Shortest length of the medium [m]; infinite for half-spaces."""
    finest = effective_beta(kernel, 1.0)
    return kernel.length / finest if finest > 0 else float("inf")


def half_space_radius(kernel: Kernel, profile: RoundProfile, control: Control, reach: float) -> float:
    """Radius at which the search starts.

    It is that on the half-space of the surface material for the largest target, but at most the shortest length of the
    medium: far beyond it the half-space says little, and large radii cost most.
    """
    target = control.values.max()
    if target <= 0:
        return 1.0
    radius, depth, force = _half_space_path(profile, reach)
    quantity = kernel.modulus * force if control.name == "force" else depth
    guess = radius[min(np.searchsorted(quantity, target), radius.size - 1)]
    return float(min(guess, shortest_length(kernel)))


@lru_cache(maxsize=64)
def _half_space_path(profile: RoundProfile, reach: float) -> tuple[Array, Array, Array]:
    """Radii [m], and d [m] and F/E* [m^2] that are reached on a half-space up to each of them, to some per cent.

    Those of a power law as steep as the profile at the rim: d = f + r f'/2 is off by 5 % for cones, by nothing for paraboloids.
    """
    radius = np.geomspace(1e-15, min(1e6, reach), 160)
    height, rise = profile.height(radius), radius * profile.slope(radius)
    depth = height + rise / 2
    force = 2 * radius * depth * rise / np.where(rise > 0, rise + height, 1.0)
    return radius, np.maximum.accumulate(depth), np.maximum.accumulate(force)
