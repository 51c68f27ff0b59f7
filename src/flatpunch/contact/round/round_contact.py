"""Round contact, exact for every medium (T6.1), (T6.3); paper (P4)-(P7).

At the right depth the edge singularity of the pressure vanishes, which gives d(a) without derivative or root search:

    d = S[A^-1 b[f]]/e,    F = 2 pi a E* (d b[1] - b[f]).c*,    a d'(a) = (d t[c*] - t[A^-1 b[f]])/e

with b[f] the moments of the profile on the unit disc, c* the flat punch, e = S[c*] its edge strength, and S, t the edge
functionals of `flatpunch.punch.basis`. Their half-space parts, slow in the number of terms for kinked profiles, are closed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy

from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel
from flatpunch.contact.round.profile import NODES, TINY, Moments, PowerProfile, RoundProfile, SampledProfile
from flatpunch.numerics.gauss import gauss
from flatpunch.punch.basis import node_count
from flatpunch.punch.family import punch_family
from flatpunch.punch.matrix import Responses, edge_strength
from flatpunch.punch.power_law import PowerLawPunch, power_law_punch


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
    responses : Responses
        Punch solutions at these radii.
    moments : Moments
        Moments of the profile.
    rings : tuple of float
        Radii at which the history of the contact starts anew [m]: where the slope or the curvature of the profile jumps.
    """

    radius: Array
    depth: Array
    force: Array
    stiffness: Array
    depth_slope: Array
    responses: Responses
    moments: Moments
    rings: tuple[float, ...] = ()


def round_contact(kernel: Kernel, profile: RoundProfile, radius: Array) -> RoundContact:
    """Exact round contact of radii a >= 0 [m], shape (n,), on any medium."""
    responses = punch_family(kernel).at(radius / kernel.length)
    if kernel.exponent:
        moments = _power_law_moments(kernel, profile, radius, responses)
    else:
        moments = profile.moments(radius, responses.flat.shape[1])
    strength = edge_strength(responses)
    depth = (moments.edge + np.sum(moments.b * responses.edge, axis=1)) / strength
    reaction = np.sum(moments.b * responses.flat, axis=1)
    scale = 2 * np.pi * kernel.modulus * radius
    tangent = -moments.edge_slope + np.sum(moments.b * responses.slope, axis=1)
    return RoundContact(
        radius=radius,
        depth=depth,
        force=scale * (depth * responses.flat[:, 0] - reaction),
        stiffness=scale * responses.flat[:, 0],
        depth_slope=(depth * responses.slope[:, 0] - tangent) / strength,
        responses=responses,
        moments=moments,
        rings=getattr(profile, "rings", ()),
    )


def quadrature_error(kernel: Kernel, profile: RoundProfile, contact: RoundContact) -> Array:
    """Relative change of depth or force, the larger, with twice as many points of the profile, shape (n,)."""
    if not isinstance(profile, SampledProfile):
        return np.zeros_like(contact.radius)
    nodes = 2 * max(NODES * (kernel.exponent > 0), profile.nodes, node_count(contact.responses.flat.shape[1]))
    other = round_contact(kernel, replace(profile, nodes=nodes, beside=2 * profile.beside), contact.radius)
    with np.errstate(divide="ignore", invalid="ignore"):
        changes = other.depth / contact.depth - 1, other.force / contact.force - 1
    return np.where(contact.depth > 0, np.abs(changes).max(axis=0), 0.0)


def _power_law_moments(kernel: Kernel, profile: RoundProfile, radius: Array, responses: Responses) -> Moments:
    """Moments in the one term of a power-law half-space, scaled so that the general formulas hold (`PunchFamily`)."""
    punch = power_law_punch(kernel)
    if isinstance(profile, PowerProfile):
        height = profile.factor * radius**profile.exponent
        depth = punch.power_depth(profile.exponent) * height
        mean, growth = depth * (1 - punch.power_force(profile.exponent)), profile.exponent * depth
    else:
        assert isinstance(profile, SampledProfile)
        depth, mean, growth = _power_law_depth(punch, profile, radius)
    strength = edge_strength(responses)
    return Moments(mean[:, None], depth * strength - mean * responses.edge[:, 0], growth * strength)


def _power_law_depth(punch: PowerLawPunch, profile: SampledProfile, radius: Array) -> tuple[Array, Array, Array]:
    """Depth d, mean height and a d'(a) of a sampled profile, shape (n,) each [m].

    With w = (1 - rho^2)^alpha rho the mean is int 2 (1 + alpha) f w drho, d = mean + int g w drho with g = r f', and by parts
    a d' = g(1) + 2 alpha int (g - g(1)) w/(1 - rho^2) drho.
    """
    alpha = punch.alpha
    ends = profile.ends(radius) if any(ring < radius.max() for ring in profile.rings) else np.full((1, 2), np.pi / 2)
    nodes = max(NODES, profile.nodes)
    panels = [_inner_panel(punch, high, low, nodes) for high, low in pairwise(ends.T[:-1])]
    panels.append(_rim_panel(punch, ends[:, -2], nodes))
    g_edge = radius * profile.slope(radius)
    level, tilt, closed = profile.lines(radius, g_edge, len(panels), alpha)
    mean, depth, growth = np.zeros_like(radius), np.zeros_like(radius), g_edge - closed
    for i, (theta, weight) in enumerate(panels):
        r = radius[:, None] * np.cos(theta)
        g = r * profile.slope(r)
        mean += 2 * (1 + alpha) * np.sum(profile.height(r) * weight, axis=1)
        depth += np.sum(g * weight, axis=1)
        left = (g - level[:, [i]]) / np.maximum(np.sin(theta) ** 2, TINY) - tilt[:, [i]]
        growth += 2 * alpha * np.sum(left * weight, axis=1)
    return mean + depth, mean, growth


def _rim_panel(punch: PowerLawPunch, end: Array, nodes: int) -> tuple[Array, Array]:
    """Angles from 0 at the rim to `end`, shape (n, nodes), and weights of int (.) w drho: Gauss-Jacobi for theta^k."""
    t, v = scipy.special.roots_jacobi(nodes, 0.0, punch.exponent)
    theta, weight = end[:, None] * (t + 1) / 2, (end[:, None] / 2) ** (1 + punch.exponent) * v
    return theta, weight * np.sinc(theta / np.pi) ** punch.exponent * np.cos(theta)


def _inner_panel(punch: PowerLawPunch, high: Array, low: Array, nodes: int) -> tuple[Array, Array]:
    """Integral between two angles; Gauss points in theta^(1 + k), which makes theta^k smooth next to the rim."""
    t, v = gauss(nodes)
    power = 1 + punch.exponent
    start, end = low[:, None] ** power, high[:, None] ** power
    theta = ((start + end) / 2 + (end - start) / 2 * t) ** (1 / power)
    weight = (end - start) / (2 * power) * v
    return theta, weight * np.sinc(theta / np.pi) ** punch.exponent * np.cos(theta)
