"""Instabilities of an adhesive contact, and its stable parts.

The branch is scanned on a logarithmic grid of radii, outwards until both slopes have stayed positive for as long as a soft
base could still turn them; each change of sign is then refined by root finding. Under media with films and soft layers there
can be several; each stretch between a minimum and the next maximum is stable.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel
from flatpunch.contact.adhesion.branch import AROUND, STEP, AdhesiveContact, Equilibria
from flatpunch.contact.round import radius_search
from flatpunch.contact.round.profile import RoundProfile
from flatpunch.punch.matrix import RESOLVED, effective_beta

Quantity = Literal["depth", "force"]
QUANTITIES: tuple[Quantity, Quantity] = ("depth", "force")

PER_DECADE = 2 * radius_search.PER_DECADE
"""Radii per decade at which the branch is searched for turns; with half as many a narrow stable stretch may be missed."""


_DECADES = 16
"""Decades below the expected radius down to which the branch is searched for its first instability."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """Stable part of the branch between two radii [m]; `end` is infinite for the outermost one."""

    start: float
    end: float


@dataclass(frozen=True, slots=True)
class Stability:
    """Stable stretches under prescribed depth and force, outermost first, and the largest radius [m] of the search."""

    depth: tuple[Stretch, ...]
    force: tuple[Stretch, ...]
    searched: float

    def of(self, quantity: Quantity) -> tuple[Stretch, ...]:
        """The stretches for one control."""
        return self.depth if quantity == "depth" else self.force


def slope_of(contact: AdhesiveContact, quantity: Quantity) -> Array:
    """Slope of depth [m] or force [N] over ln a."""
    return contact.depth_slope if quantity == "depth" else contact.force_slope


def stability(
    branch: Equilibria, profile: RoundProfile, reach: float, *, pinned: bool = False, steady: float = np.inf
) -> Stability:
    """Find the instabilities of a branch of contacts of a profile, which is defined up to `reach` [m].

    A contact that is `pinned` stays at `reach` when pressed further: a flat end. At the radius `steady` [m] the branch must be
    stable; it is `steady_radius` of the round contact that the branch corrects. A ValueError says that the pull-off is beyond the
    reach of the indenter or the resolution of the medium, or that there is none.
    """
    most = largest_radius(branch.kernel, reach)
    length = (
        branch.kernel.length / effective_beta(branch.kernel, 1.0)
        if not (branch.kernel.homogeneous or branch.kernel.exponent)
        else np.inf
    )
    guess = min(_half_space_balance(branch, profile, most), most / 10, length)
    x = np.log(guess) + np.log(10) * np.arange(-PER_DECADE, PER_DECADE // 2 + 1) / PER_DECADE
    slopes = _slopes(branch, x)
    x, slopes = _extend_down(branch, x, slopes)
    if pinned:
        more = np.linspace(x[-1], np.log(reach), 2 + int(PER_DECADE * (np.log10(reach) - x[-1] / np.log(10))))[1:]
        x, slopes = np.concatenate([x, more]), np.concatenate([slopes, _slopes(branch, more)], axis=1)
    else:
        last = np.log(min(most, steady))
        x, slopes = _extend_up(branch, x, slopes, last, reach, corrected=steady < most)
    return Stability(
        depth=_stretches(branch, x, slopes[0], "depth"),
        force=_stretches(branch, x, slopes[1], "force"),
        searched=float(np.exp(x[-1])),
    )


def steady_radius(branch: Equilibria, found: Stability) -> float:
    """Radius [m] beyond which adhesion reduces both slopes of a round branch by less than half, or the end of its search.

    Beyond it the correction for the shape of the tip cannot make the branch unstable, unless it is as large as the branch itself.
    """
    start = np.log(max(stretch.start for stretch in found.depth + found.force) or found.searched)
    end = np.log(found.searched)
    x = np.linspace(start, end, 2 + int(PER_DECADE * (end - start) / np.log(10)))
    contact = branch.at(np.exp(x))
    plain = contact.plain.depth_slope * np.stack([np.ones_like(x), contact.plain.stiffness])
    taken = (np.stack([contact.depth_slope, contact.force_slope]) < plain / 2) | (plain <= 0)
    last = np.flatnonzero(taken.any(axis=0)).max(initial=0)
    return float(np.exp(x[min(last + 1, x.size - 1)]))


def _slopes(branch: Equilibria, x: Array) -> Array:
    contact = branch.at(np.exp(x))
    return np.stack([contact.depth_slope, contact.force_slope])


def _extend_down(branch: Equilibria, x: Array, slopes: Array) -> tuple[Array, Array]:
    """Towards small radii until adhesion wins in both slopes and the medium is its own surface's half-space."""
    kernel = branch.kernel
    for _ in range(_DECADES):
        thin = (
            not (kernel.homogeneous or kernel.exponent) and effective_beta(kernel, np.exp(x[0]) / kernel.length) > 0.1
        )
        if (slopes[:, 0] < 0).all() and not thin:
            return x, slopes
        more = x[0] - np.log(10) / PER_DECADE * np.arange(PER_DECADE, 0, -1)
        x, slopes = np.concatenate([more, x]), np.concatenate([_slopes(branch, more), slopes], axis=1)
    # under tips that are steep for their adhesion, contacts of finite range come and go without a jump
    if branch.range_of_action > 0 and slopes[1, 0] < 0:
        return x, slopes
    raise ValueError(
        "This contact has no pull-off: towards small radii the profile rises more steeply than adhesion can follow "
        "(f must grow faster than the square root of r). Use a blunter profile."
    )


def _extend_up(
    branch: Equilibria, x: Array, slopes: Array, most: float, reach: float, *, corrected: bool
) -> tuple[Array, Array]:
    """Towards large radii until both slopes have been positive over the guard distance."""
    guard = _guard(branch.kernel)
    for _ in range(64):
        pulled = np.flatnonzero((slopes <= 0).any(axis=0))
        settled = x[-1] - x[pulled[-1]] if pulled.size else np.inf
        if settled >= guard:
            return x, slopes
        if x[-1] >= most - 1e-9:
            if (slopes[:, -1] > 0).all():
                return x, slopes
            raise ValueError(_still_pulled(branch, float(np.exp(most)), reach, corrected=corrected))
        more = x[-1] + np.log(10) / PER_DECADE * np.arange(1, PER_DECADE // 4 + 1)
        more = np.unique(np.minimum(more, most))
        x, slopes = np.concatenate([x, more]), np.concatenate([slopes, _slopes(branch, more)], axis=1)
    return x, slopes


def _still_pulled(branch: Equilibria, radius: float, reach: float, *, corrected: bool) -> str:
    asked = f"work_of_adhesion = {branch.work:.4g} J/m^2: "
    if corrected:
        return (
            f"{asked}to second order in its asymmetry this tip is still drawn outwards at a contact radius of "
            f"{text(radius, 'm')}, where a round tip of the same mean is held firmly: the tip is too far from round for this "
            "theory. Take a rounder tip, or leave work_of_adhesion out."
        )
    if radius >= reach * (1 - 1e-9):
        return (
            f"{asked}adhesion draws the contact to the end of the indenter's shape, {text(radius, 'm')} from the first touch: "
            "there is no stable contact. Reduce the work of adhesion, or give the shape further out."
        )
    return (
        f"{asked}adhesion draws the contact to radii above {text(radius, 'm')}, the largest at which it is solved on this "
        "medium: no stable contact was found below. Check the units; reduce the work of adhesion, or take a sharper tip."
    )


def _guard(kernel: Kernel) -> float:
    """Distance in ln a over which softer material below could still turn the branch: radii grow like modulus^(-1/3)."""
    if kernel.homogeneous or kernel.exponent:
        return float(np.log(10) / 4)
    kappa = np.geomspace(kernel.floor, kernel.cutoff, 100)
    softer = max(1.0, float(np.max(kernel.response(kappa))))
    return float(np.log(3) + np.log(softer) / 2)


def largest_radius(kernel: Kernel, reach: float) -> float:
    """Largest radius at which the branch can be computed [m]: slopes need a little beyond."""
    if kernel.homogeneous or kernel.exponent:
        return min(reach, 1e12)
    return min(reach, RESOLVED / effective_beta(kernel, 1.0) * kernel.length * float(np.exp(-(AROUND[-1] + 1) * STEP)))


def _half_space_balance(branch: Equilibria, profile: RoundProfile, most: float) -> float:
    """Radius at which depth and retraction balance on the half-space of the surface material."""
    smallest = 1e-15
    if most > smallest:
        radius = np.geomspace(smallest, min(most, 1e6), 1000)
        depth = np.pi * profile.moments(radius, 1).edge
        back = np.sqrt(2 * np.pi * radius * branch.work / branch.kernel.modulus)
        first = int(np.searchsorted(np.maximum.accumulate(depth / back), 1.0))
    # profiles that rise more steeply than adhesion can follow have no such radius: `_extend_down` refuses them
    if most <= smallest or (first == 0 and depth[0] > back[0] and depth[1] / back[1] > depth[0] / back[0]):
        raise ValueError(
            f"With a work of adhesion of {branch.work:.4g} J/m^2 and a modulus of {branch.kernel.modulus:.4g} Pa this tip is "
            f"held by contacts of less than {smallest:g} m, far below the size of an atom. Check the units; all are in SI."
        )
    return float(radius[min(first, radius.size - 1)])


def _stretches(branch: Equilibria, x: Array, slope: Array, quantity: Quantity) -> tuple[Stretch, ...]:
    """Stretches of positive slope, outermost first; their ends are roots of the slope to rounding."""

    def value(at: float) -> float:
        return float(slope_of(branch.at(np.exp([at])), quantity)[0])

    flips = np.flatnonzero((slope[:-1] > 0) != (slope[1:] > 0))
    # the branch itself is known to 1e-10, so its minimum is found to rounding
    roots = [float(np.exp(scipy.optimize.brentq(value, x[i], x[i + 1]))) for i in flips]
    if slope[0] > 0:
        roots.insert(0, 0.0)
    return tuple(Stretch(a, b) for a, b in list(zip(roots[::2], [*roots[1::2], np.inf], strict=False))[::-1])
