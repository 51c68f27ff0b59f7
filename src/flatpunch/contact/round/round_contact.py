"""Round contact, exact for every medium (T6.1), (T6.3); paper (P4)-(P7).

At the right depth the edge singularity of the pressure vanishes, which gives d(a) without derivative or root search:

    d = S[A^-1 b[f]]/e,    F = 2 pi a E* (d b[1] - b[f]).c*,    a d'(a) = (d t[c*] - t[A^-1 b[f]])/e

with b[f] the moments of the profile on the unit disc, c* the flat punch, e = S[c*] its edge strength, and S, t the edge
functionals of `flatpunch.punch.basis`. Their half-space parts, slow in the number of terms for kinked profiles, are closed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliance import Kernel
from flatpunch.contact.round.profile import Moments, PowerProfile, RoundProfile
from flatpunch.punch.family import punch_family
from flatpunch.punch.matrix import Answers, edge_strength
from flatpunch.punch.power_law import PowerLawPunch, power_law_punch

POWER_LAW_NODES = 256
"""Quadrature points of profiles on power-law half-spaces: 1e-13 of smooth ones, where 64 leave 1e-9."""

STENCIL = 2e-3
"""Relative step of the five-point difference in ln a: its error is 0.03 step^4 = 5e-13 of smooth profiles."""


@dataclass(frozen=True, slots=True)
class RoundContact:
    """Round contacts of given radii, shape (n,) each.

    Attributes
    ----------
    radius, depth, force : ndarray
        a [m], d [m], F [N].
    stiffness : ndarray
        dF/dd = K(a) [N/m].
    depth_slope : ndarray
        a dd/da [m]; not positive where the contact cannot grow steadily.
    answers : Answers
        Punch solutions at these radii.
    moments : Moments
        Moments of the profile.
    rings : tuple of float
        Radii at which the slope of the profile jumps [m].
    """

    radius: Array
    depth: Array
    force: Array
    stiffness: Array
    depth_slope: Array
    answers: Answers
    moments: Moments
    rings: tuple[float, ...] = ()


def round_contact(kernel: Kernel, profile: RoundProfile, radius: Array) -> RoundContact:
    """Exact round contact on any medium.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    profile : RoundProfile
        The axisymmetric indenter.
    radius : ndarray, shape (n,)
        Contact radii a [m], >= 0.

    Returns
    -------
    RoundContact
        Depth, force, stiffness and what they were made from.
    """
    answers = punch_family(kernel).at(radius / kernel.length)
    if kernel.exponent:
        moments = _power_law_moments(kernel, profile, radius, answers)
    else:
        moments = profile.moments(radius, answers.flat.shape[1])
    strength = edge_strength(answers)
    depth = (moments.edge + np.sum(moments.b * answers.edge, axis=1)) / strength
    reaction = np.sum(moments.b * answers.flat, axis=1)
    scale = 2 * np.pi * kernel.modulus * radius
    tangent = -moments.edge_slope + np.sum(moments.b * answers.slope, axis=1)
    return RoundContact(
        radius=radius,
        depth=depth,
        force=scale * (depth * answers.flat[:, 0] - reaction),
        stiffness=scale * answers.flat[:, 0],
        depth_slope=(depth * answers.slope[:, 0] - tangent) / strength,
        answers=answers,
        moments=moments,
        rings=getattr(profile, "rings", ()),
    )


def _power_law_moments(kernel: Kernel, profile: RoundProfile, radius: Array, answers: Answers) -> Moments:
    """Moments in the one term of a power-law half-space, scaled so that the general formulas hold (`PunchFamily`)."""
    punch = power_law_punch(kernel)
    if isinstance(profile, PowerProfile):
        height = profile.factor * radius**profile.exponent
        depth = punch.power_depth(profile.exponent) * height
        mean, growth = depth * (1 - punch.power_force(profile.exponent)), profile.exponent * depth
    else:
        depth, mean = _power_law_depth(punch, profile, radius)
        steps = [_power_law_depth(punch, profile, radius * np.exp(j * STENCIL))[0] for j in (-2, -1, 1, 2)]
        growth = (steps[0] - 8 * steps[1] + 8 * steps[2] - steps[3]) / (12 * STENCIL)
    strength = edge_strength(answers)
    return Moments(mean[:, None], depth * strength - mean * answers.edge[:, 0], growth * strength)


def _power_law_depth(punch: PowerLawPunch, profile: RoundProfile, radius: Array) -> tuple[Array, Array]:
    """Depth d = int (2 (1 + alpha) f + r f') w dr and the mean int 2 (1 + alpha) f w dr of a sampled profile [m]."""
    rho, weight = punch.rule(POWER_LAW_NODES)
    r = radius[:, None] * rho
    mean = 2 * (1 + punch.alpha) * (profile.height(r) @ weight)
    return mean + (r * profile.slope(r)) @ weight, mean
