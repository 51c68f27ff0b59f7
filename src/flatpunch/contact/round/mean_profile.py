"""Round contact of the angular mean of a profile, on which every fast method is based."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import UNITS, Control, check_reach
from flatpunch.contact.round.profile import NODES, PowerProfile, RoundProfile, SampledProfile
from flatpunch.contact.round.radius_search import Loading, radius_for
from flatpunch.contact.round.round_contact import RoundContact, round_contact
from flatpunch.indenters.geometry.angles import angular_mean, angular_rule
from flatpunch.indenters.profile import Indenter, check_rising
from flatpunch.punch.family import UnresolvedLayer
from flatpunch.punch.matrix import RESOLVED, effective_beta, largest_beta, solve_round, sufficient_terms

Evaluate = Callable[[Array], RoundContact]


def mean_profile(indenter: Indenter) -> RoundProfile:
    """Angular mean f0(r) of an indenter that rises from its apex."""
    check_rising(indenter)
    if indenter.exponent is not None:
        phi, weights = angular_rule(indenter)
        psi = np.asarray(indenter.height(np.ones_like(phi), phi))
        return PowerProfile(indenter.exponent, float(weights @ psi))
    if indenter.round:
        zero = np.zeros(1)
        return SampledProfile(lambda r: indenter.height(r, zero), lambda r: indenter.slope(r, zero), indenter.rings)
    mean = angular_mean(indenter)
    nodes = NODES if indenter.tabulated else 0
    return SampledProfile(mean.height, mean.slope, indenter.rings, nodes)


def mean_contact(kernel: Kernel, indenter: Indenter, control: Control) -> tuple[Evaluate, RoundContact]:
    """Contacts of the mean profile at the prescribed depths, forces or mean radii, and the function that makes them."""
    profile = mean_profile(indenter)

    def evaluate(radius: Array) -> RoundContact:
        return round_contact(kernel, profile, radius)

    if control.name == "radius":
        check_reach(indenter, control.values)
        return evaluate, evaluate(control.values)
    radius = searched_radius(kernel, profile, evaluate, control, indenter.reach)
    return evaluate, _on_target(evaluate(radius), control)


def _on_target(contact: RoundContact, control: Control) -> RoundContact:
    """The contact at the prescribed depth or force: F(d; a) is stationary in a, so that its rounding counts squared."""
    if control.name == "depth":
        rest = control.values - contact.depth
        return replace(contact, depth=control.values, force=contact.force + contact.stiffness * rest)
    touching = contact.stiffness > 0
    rest = (control.values - contact.force) / np.where(touching, contact.stiffness, 1)
    return replace(contact, force=control.values, depth=contact.depth + np.where(touching, rest, 0))


def resolved_radius(kernel: Kernel) -> float:
    """Largest contact radius at which the thinnest layer is resolved [m]."""
    return largest_beta(kernel) * shortest_length(kernel)


def shortest_length(kernel: Kernel) -> float:
    """Shortest length of the medium [m]; infinite for half-spaces."""
    finest = effective_beta(kernel, 1.0)
    return kernel.length / finest if finest > 0 else float("inf")


def searched_radius(
    kernel: Kernel, profile: RoundProfile, path: Callable[[Array], Loading], control: Control, reach: float
) -> Array:
    """Radii along a path at which the prescribed depths or forces are reached, shape (n,); refusals name what is prescribed."""
    assert control.name != "radius"
    check_size(kernel, profile, control, reach)
    guess = half_space_radius(kernel, profile, control, reach)
    near = guess > RESOLVED * shortest_length(kernel)
    return radius_for(path, control.name, control.values, guess, reach, resolved_radius(kernel), near)


def check_size(kernel: Kernel, profile: RoundProfile, control: Control, reach: float) -> None:
    """Refuse depths and forces far beyond those of the largest contact that is resolved, before anything is solved.

    Depths of contacts of one radius differ between media by a factor of a few; forces are at most the flat punch's at such a
    depth.
    """
    resolved = resolved_radius(kernel)
    if not resolved < reach:
        return
    radius, depth, force = _half_space_path(profile, reach)
    at, target = int(np.searchsorted(radius, resolved)), float(control.values.max())
    if at == radius.size:
        return
    # no medium exceeds 30 times the depth on a half-space at the same radius; films on soft bases come to some times it
    most = 30.0 * float(depth[at])
    if control.name == "force":
        if target <= kernel.modulus * float(force[at]):
            return
        beta = np.array([resolved / kernel.length])
        flat = solve_round(kernel, beta, sufficient_terms(kernel, float(beta[0]))).flat[0, 0]
        most *= 2 * np.pi * kernel.modulus * resolved * float(flat)
    if target > most:
        raise UnresolvedLayer(
            f"{control.name} = {text(target, UNITS[control.name])} is far beyond this body: the contact would be wider than "
            f"{text(resolved, 'm')}, {largest_beta(kernel):g} times its thinnest layer, or the reach of the membrane on it, the "
            "largest contact that is solved. Ask for less, or check the units."
        )


def half_space_radius(kernel: Kernel, profile: RoundProfile, control: Control, reach: float) -> float:
    """Radius at which the search starts.

    It is that on the half-space of the surface material for the largest target, but at most the shortest length of the
    medium: beyond it the half-space is a poor guide, and large radii cost most. Where the contact is far larger than the
    shortest length, the start is that on a half-space as compliant as the medium is at the wavelength of the contact.
    """
    target = control.values.max()
    if target <= 0:
        return 1.0
    radius, depth, force = _half_space_path(profile, reach)
    quantity = kernel.modulus * force if control.name == "force" else depth
    guess, shortest = radius[min(np.searchsorted(quantity, target), radius.size - 1)], shortest_length(kernel)
    # the expected radius changes the wavelength at which the compliance is taken, and so the radius
    for _ in range(3 if guess > RESOLVED * shortest else 0):
        softer = float(kernel.response(np.array([kernel.length / guess]))[0]) if control.name == "force" else 1.0
        guess = radius[min(np.searchsorted(quantity / softer, target), radius.size - 1)]
    return float(guess if guess > RESOLVED * shortest else min(guess, shortest))


@byte_cached
def _half_space_path(profile: RoundProfile, reach: float) -> tuple[Array, Array, Array]:
    """Radii [m], and d [m] and F/E* [m^2] reached up to each of them on a half-space, off by 5 % under cones."""
    radius = np.geomspace(1e-15, min(1e6, reach), 100)
    height, rise = profile.height(radius), radius * profile.slope(radius)
    depth = height + rise / 2
    force = 2 * radius * depth * rise / np.where(rise > 0, rise + height, 1.0)
    return radius, np.maximum.accumulate(depth), np.maximum.accumulate(force)
