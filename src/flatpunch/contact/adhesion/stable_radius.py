"""From a prescribed depth or force to the contact radius on the stable parts of an adhesive branch."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, BadValue
from flatpunch._support.prefixes import text
from flatpunch.contact.adhesion.branch import AdhesiveContact, Equilibria
from flatpunch.contact.adhesion.non_round import PerturbedBranch
from flatpunch.contact.adhesion.stability import PER_DECADE, Quantity, Stability, Stretch, largest_radius, slope_of


def stable_radius(
    branch: Equilibria,
    stability: Stability,
    quantity: Quantity,
    target: Array,
    reach: float,
    pinned: bool,
) -> Array:
    """Radii [m] of the stable contacts of given depths or forces of any sign, shape (n,); 0 where there is none.

    A target that several stretches can hold belongs to the outermost: a tip that is withdrawn stays there until its end. Where
    `pinned` (a flat end), targets beyond the reach of the profile [m] keep that radius; else a ValueError names them.
    """
    radius = np.zeros_like(target)
    open_ = np.ones(target.shape, dtype=bool)
    if pinned:
        at_edge = target >= value_of(branch.at(np.array([reach])), quantity)[0]
        radius[at_edge] = reach
        open_ &= ~at_edge
    for stretch in stability.of(quantity):
        lowest, highest = ends_of(branch, stretch, quantity)
        # the pull-off itself, prescribed as computed, is still in contact
        held = open_ & (target >= lowest - ROUNDING * abs(lowest)) & (target <= highest)
        if held.any():
            radius[held] = radius_on(branch, stretch, quantity, np.maximum(target[held], lowest), reach)
            open_ &= ~held
    return radius


def ends_of(branch: Equilibria, stretch: Stretch, quantity: Quantity) -> tuple[float, float]:
    """Lowest and highest depth or force of a stretch; without bounds where the stretch has none."""
    low, high = -np.inf, np.inf
    if stretch.start > 0:
        low = float(value_of(branch.at(np.array([stretch.start])), quantity)[0])
    if np.isfinite(stretch.end):
        high = float(value_of(branch.at(np.array([stretch.end])), quantity)[0])
    return low, high


def value_of(contact: AdhesiveContact, quantity: str) -> Array:
    """Depth or force of contacts."""
    return contact.depth if quantity == "depth" else contact.force


def radius_on(branch: Equilibria, stretch: Stretch, quantity: Quantity, target: Array, reach: float) -> Array:
    """Radii at which one stable stretch has the given depths or forces, shape (n,).

    Newton in ln a inside brackets from a grid, by bisection where a step would leave its bracket.
    """
    grid = _grid(branch, quantity, float(target.max()), stretch, reach)
    sampled = value_of(branch.at(np.exp(grid)), quantity)
    upper = np.clip(np.searchsorted(sampled, target), 1, grid.size - 1)
    low, high = grid[upper - 1], grid[upper]
    # near a minimum the quantity grows like the square of the distance
    x = low + (high - low) * np.sqrt(np.clip((target - sampled[upper - 1]) / np.diff(sampled)[upper - 1], 0, 1))
    scale = np.abs(sampled).max() * np.finfo(float).eps
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


def _grid(branch: Equilibria, quantity: str, most: float, stretch: Stretch, reach: float) -> Array:
    """Nodes of ln a from the start of a stretch to where the quantity exceeds `most`."""
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
