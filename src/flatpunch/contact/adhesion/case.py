"""One medium, one indenter and one work of adhesion: its stable branch, and the radius at a prescribed depth or force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, BadValue, positive
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel
from flatpunch.contact.adhesion.branch import AdhesiveContact, Branch, Equilibria
from flatpunch.contact.adhesion.maugis import MaugisBranch
from flatpunch.contact.adhesion.non_round import PerturbedBranch
from flatpunch.contact.adhesion.stability import (
    PER_DECADE,
    Quantity,
    Stability,
    Stretch,
    largest_radius,
    slope_of,
    stability,
    steady_radius,
)
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.profile import PowerProfile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.punch.basis import RELATIVE


@dataclass(frozen=True, slots=True)
class AdhesiveCase:
    """One medium, one indenter and one work of adhesion, with its branch and its stable parts."""

    kernel: Kernel
    indenter: Indenter
    branch: Equilibria
    stability: Stability

    @property
    def pinned(self) -> bool:
        """Whether the contact ends at a flat end's own edge."""
        return self.indenter.flat


def adhesive_case(
    kernel: Kernel, indenter: Indenter, work: float, range_of_action: float | None = None
) -> AdhesiveCase:
    """Check the input and find the instabilities; ValueError where there is no theory or no stable contact."""
    work = positive("work_of_adhesion", work, "It is the energy per area gained by contact [J/m^2].", unit="J/m**2")
    # products of both stay representable
    largest = 1e60
    for name, value, unit in (("work_of_adhesion", work, "J/m^2"), ("modulus", kernel.modulus, "Pa")):
        if not 1 / largest <= value <= largest:
            raise BadValue(
                name,
                f"{value:.6g} {unit}",
                f"is beyond what adhesion is computed for, {1 / largest:g} to {largest:g} {unit}. Check the "
                "units; all quantities are in SI.",
            )
    check_indenter(indenter)
    if range_of_action is not None:
        return _of_finite_range(kernel, indenter, work, range_of_action)
    if not indenter.round:
        if indenter.exponent is None:
            raise ValueError(
                f"{type(indenter).__name__} is neither round nor a power law r^n psi(phi): adhesive contact is exact for round "
                "indenters and known to second order for power laws. Take an elliptic paraboloid or a pyramid that resembles it, "
                "or leave work_of_adhesion out."
            )
        perturbed = PerturbedBranch(kernel, indenter, work)
        # the round contact costs little: it is refused for the same reasons, and says how far the correction can turn the branch
        mean = stability(perturbed.base, perturbed.profile, indenter.reach)
        steady = steady_radius(perturbed.base, mean)
        found = stability(perturbed, perturbed.profile, indenter.reach, steady=steady)
        return AdhesiveCase(kernel, indenter, perturbed, found)
    pinned = indenter.flat
    # a flat face: f = 0
    profile = PowerProfile(exponent=2.0, factor=0.0) if pinned else mean_profile(indenter)
    branch = Branch(kernel, lambda radius: round_contact(kernel, profile, radius), work)
    return AdhesiveCase(kernel, indenter, branch, stability(branch, profile, indenter.reach, pinned=pinned))


def _of_finite_range(kernel: Kernel, indenter: Indenter, work: float, range_of_action: float) -> AdhesiveCase:
    within = check_range(kernel, indenter, range_of_action)
    profile = mean_profile(indenter)
    branch = MaugisBranch(kernel, profile, indenter.reach, work, within)
    return AdhesiveCase(kernel, indenter, branch, stability(branch, profile, indenter.reach))


def check_range(kernel: Kernel, indenter: Indenter, range_of_action: float) -> float:
    """Return the range of action, or refuse what is solved without one only."""
    about = (
        "It is the largest gap across which adhesion acts [m]; without it JKR theory holds, the limit of short ranges."
    )
    within = positive("range_of_action", range_of_action, about, unit="m")
    if kernel.exponent or indenter.flat or not indenter.round:
        what = "power-law half-spaces" if kernel.exponent else f"the indenter {type(indenter).__name__}"
        raise BadValue(
            "range_of_action",
            text(within, "m"),
            f"does not go with {what}: adhesion of finite range is solved under round tips without a flat end of their own, on "
            "half-spaces, layers and graded layers. Leave it out, which is JKR theory.",
        )
    return within


def stable_radius(case: AdhesiveCase, quantity: Quantity, target: Array) -> Array:
    """Radii [m] of the stable contacts of given depths or forces of any sign, shape (n,); 0 where there is none.

    A target that several stretches can hold belongs to the outermost: a tip that is withdrawn stays there until its end. Targets
    beyond the reach of a flat end keep that radius; else a ValueError names them.
    """
    branch, reach = case.branch, case.indenter.reach
    radius = np.zeros_like(target)
    open_ = np.ones(target.shape, dtype=bool)
    if case.pinned:
        at_edge = target >= value_of(branch.at(np.array([reach])), quantity)[0]
        radius[at_edge] = reach
        open_ &= ~at_edge
    for stretch in case.stability.of(quantity):
        lowest, highest = ends_of(branch, stretch, quantity)
        # the pull-off itself, prescribed as computed, is still in contact
        held = open_ & (target >= lowest - ROUNDING * abs(lowest)) & (target <= highest)
        if held.any():
            radius[held] = radius_on(case, stretch, quantity, np.maximum(target[held], lowest))
            open_ &= ~held
    return radius


def ends_of(branch: Equilibria, stretch: Stretch, quantity: Quantity) -> tuple[float, float]:
    """Lowest and highest depth or force of a stretch; its depth begins at the range of action, its end may have no bound."""
    low, high = -branch.range_of_action, np.inf
    if stretch.start > 0:
        low = float(value_of(branch.at(np.array([stretch.start])), quantity)[0])
    if np.isfinite(stretch.end):
        high = float(value_of(branch.at(np.array([stretch.end])), quantity)[0])
    return low, high


def value_of(contact: AdhesiveContact, quantity: str) -> Array:
    """Depth or force of contacts."""
    return contact.depth if quantity == "depth" else contact.force


def radius_on(case: AdhesiveCase, stretch: Stretch, quantity: Quantity, target: Array) -> Array:
    """Radii at which one stable stretch has the given depths or forces, shape (n,).

    Newton in ln a inside brackets from a grid, by bisection where a step would leave its bracket.
    """
    branch, grid = case.branch, _grid(case, quantity, float(target.max()), stretch)
    sampled = value_of(branch.at(np.exp(grid)), quantity)
    upper = np.clip(np.searchsorted(sampled, target), 1, grid.size - 1)
    low, high = grid[upper - 1], grid[upper]
    # rounding of the series of a branch
    scale = np.abs(sampled).max() * RELATIVE
    above = target - sampled[upper - 1]
    # near a minimum, which is prescribed as computed, the quantity grows like the square of the distance
    x = low + (high - low) * np.sqrt(np.clip(np.where(above > scale, above, 0) / np.diff(sampled)[upper - 1], 0, 1))
    for _ in range(60):
        here = branch.at(np.exp(x))
        miss, slope = value_of(here, quantity) - target, slope_of(here, quantity)
        low, high = np.where(miss < 0, x, low), np.where(miss >= 0, x, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            trial = x - miss / slope
        trial = np.where((slope > 0) & (trial >= low) & (trial <= high), trial, (low + high) / 2)
        trial = np.where(np.abs(miss) <= scale, x, trial)
        moved = np.abs(trial - x).max()
        x = trial
        # quadratic convergence: the next step would be below rounding
        if moved < 1e-9:
            break
    return np.asarray(np.exp(x))


def _grid(case: AdhesiveCase, quantity: str, most: float, stretch: Stretch) -> Array:
    """Nodes of ln a from the start of a stretch to where the quantity exceeds `most`."""
    branch, reach = case.branch, case.indenter.reach
    start = np.log(stretch.start) if stretch.start > 0 else np.log(1e-15 * min(reach, 1.0))
    end = np.log(min(stretch.end, largest_radius(branch.kernel, reach)))
    if np.isfinite(stretch.end):
        return np.linspace(start, end, 2 + int(PER_DECADE * (end - start) / np.log(10)))
    grid = [start]
    if isinstance(branch, PerturbedBranch):
        # the asymmetry changes depth and force by far less than half, and the round contact is a hundred times faster
        out_of_reach = 2 * value_of(branch.base.at(np.exp([end])), quantity)[0] < most
    else:
        out_of_reach = False
    while not out_of_reach:
        more = np.minimum(grid[-1] + np.log(10) / PER_DECADE * np.arange(1, PER_DECADE // 4 + 1), end)
        reached = value_of(branch.at(np.exp(more)), quantity)
        grid.extend(more.tolist())
        if reached[-1] >= most:
            # no further than needed: the cost of a radius grows with it
            return np.unique(grid)
        if more[-1] >= end:
            break
    raise BadValue(
        quantity,
        f"{most:.6g} {'m' if quantity == 'depth' else 'N'}",
        f"needs a contact radius above {text(float(np.exp(end)), 'm')}, "
        "where the indenter ends or the medium is no longer resolved. Ask for less.",
    )
