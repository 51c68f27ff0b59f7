"""Round contact of the angular mean of a profile, on which every fast method is based."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch.compliance import Kernel
from flatpunch.contact.curve import UNITS, Control, check_reach
from flatpunch.contact.round.profile import PowerProfile, RoundProfile, SampledProfile
from flatpunch.contact.round.radius_search import Loading, radius_for
from flatpunch.contact.round.round_contact import RoundContact, round_contact
from flatpunch.indenters.geometry.angle_rule import angular_rule
from flatpunch.indenters.geometry.angular_mean import angular_mean
from flatpunch.indenters.profile import Indenter
from flatpunch.punch.family import UnresolvedLayer
from flatpunch.punch.matrix import LARGEST, effective_beta

_TABLE_NODES = 256
"""Quadrature points of tabulated profiles: 1e-8 of tables of a hundred points."""

_BEYOND = 30.0
"""Depth or force over that on a half-space of the same stiffness at one radius: media come to some times it, up or down."""

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
    radius = searched_radius(kernel, profile, evaluate, control, indenter.reach)
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


def searched_radius(
    kernel: Kernel, profile: RoundProfile, path: Callable[[Array], Loading], control: Control, reach: float
) -> Array:
    """Radii along a path at which the prescribed depths or forces are reached, shape (n,); refusals name what is prescribed."""
    assert control.name != "radius"
    check_size(kernel, profile, control, reach)
    guess = half_space_radius(kernel, profile, control, reach)
    try:
        return radius_for(path, control.name, control.values, guess, reach, resolved_radius(kernel))
    except UnresolvedLayer as error:
        largest = text(float(control.values.max()), UNITS[control.name])
        raise UnresolvedLayer(f"{control.name} = {largest}: {error}") from None


def check_size(kernel: Kernel, profile: RoundProfile, control: Control, reach: float) -> None:
    """Refuse depths and forces beyond those of the largest contact that is resolved, before any search.

    Where they are far from it, which a half-space of the stiffness at that size says, nothing is solved.
    """
    resolved = resolved_radius(kernel) * (1 - 1e-9)
    if not resolved < reach:
        return
    target, radius = float(control.values.max()), np.array([resolved])
    height, rise = float(profile.height(radius)[0]), resolved * float(profile.slope(radius)[0])
    expected = height + rise / 2
    if control.name == "force":
        expected *= 4 * resolved**2 / float(kernel(1 / radius)[0]) * rise / (rise + height)
    if target < expected / _BEYOND:
        return
    largest = -np.inf
    if target < expected * _BEYOND:
        # the largest force of a tip that is not round is up to some ten per cent larger than that of its mean
        slack = 1.3 if control.name == "force" else 1.0
        # where the depth turns back it was larger before
        for share in (1.0, 0.7, 0.5):
            single = round_contact(kernel, profile, share * radius, single=True)
            largest = max(largest, slack * float(getattr(single, control.name)[0]))
            if target <= largest:
                return
    raise UnresolvedLayer(
        f"{control.name} = {text(target, UNITS[control.name])} needs a contact radius of more than {text(resolved, 'm')}, "
        f"{LARGEST:g} times the shortest length of the medium: layers are resolved up to there. Ask for less, or check the units."
    )


def half_space_radius(kernel: Kernel, profile: RoundProfile, control: Control, reach: float) -> float:
    """Radius at which the search starts.

    It is that on the half-space of the surface material for the largest target, but at most the shortest length of the
    medium: far beyond it the half-space says little, and large radii cost most.
    """
    target = control.values.max()
    if target <= 0:
        return 1.0
    radius, depth, force = _half_space_path(profile, reach)
    quantity = np.log(kernel.modulus) + force if control.name == "force" else depth
    guess = np.exp(np.interp(np.log(target), quantity, radius))
    return float(min(guess, shortest_length(kernel)))


@lru_cache(maxsize=64)
def _half_space_path(profile: RoundProfile, reach: float) -> tuple[Array, Array, Array]:
    """Logarithms of radii [m], and of d [m] and F/E* [m^2] on a half-space at them, to some per cent; ascending.

    Those of a power law as steep as the profile at the rim: d = f + r f'/2 is off by 5 % for cones, by nothing for paraboloids.
    """
    radius = np.geomspace(1e-150, min(1e150, reach), 600)
    with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
        height, rise = profile.height(radius), radius * profile.slope(radius)
        depth = height + rise / 2
        force = 2 * radius * depth * (rise / (rise + height))
        known = np.isfinite(depth) & np.isfinite(force) & (depth > 0) & (force > 0)
    if not known.any():
        return np.zeros(1), np.zeros(1), np.zeros(1)
    logs = [np.log(each[known]) for each in (radius, depth, force)]
    return logs[0], np.maximum.accumulate(logs[1]), np.maximum.accumulate(logs[2])
