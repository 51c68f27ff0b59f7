"""Error of the force that the cells of a boundary element solution cause, measured by solutions on wider cells.

The error of the force falls with a power of the width of the cells. Three widths give that power: the ratio q of the two
differences between their forces is 4 for the square, 2 where the error falls with the width itself, as beside the edges of a
flat, and close to 1 or negative where the cells are wider than the thinnest layer. The error of the finest cells is then
D/(q - 1), with D the difference to cells twice as wide (Richardson's extrapolation), or the larger difference where the signs
differ. So the estimate depends on every length of the problem without knowing any.

The force also depends on where the rim of the contact is among the cells, which no difference reports: at the edges of a flat
forces scatter by half a per cent from one width to the next. A rim that is off by e changes the energy by the rate
G = K^2/(2 E*) per area, as a crack does, and the force by 2 e/d times the integral of G along the rim. K follows from the
pressure of the outermost cells, whose mean is K sqrt(2/(pi h)). Where the pressure falls to zero at the rim this is negligible.
Beside a flat it is not, until the ring of contact around the flat is several cells wide.

So it depends on where the edges of a pyramid are among the cells, which know the height of the tip at their centres. Along an
edge the mean height of a cell differs from that, by up to a sixth of the cell times the jump of the slope. Over the contact the
mean of these differences acts like a change of depth.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_erosion, label

from flatpunch import bem
from flatpunch._support.checks import Array, Flags
from flatpunch.bem.bounding_box import bounding_box
from flatpunch.bem.grid import polar
from flatpunch.indenters.profile import Indenter

_SECOND_ORDER = 4.0
"""Ratio q of errors that fall with the square of the width; larger ones are chance."""


def along_rays(error: Array, contour: Array) -> Array:
    """Errors of outlines along their rays, over the mean radius, shape (n,), from those across them.

    `contour` holds a(phi) at equal angles, shape (n, angles). A ray that meets an outline at an angle meets one that is moved
    across so much farther away.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithm = np.log(contour)
        slope = (np.roll(logarithm, -1, axis=1) - np.roll(logarithm, 1, axis=1)) * contour.shape[1] / (4 * np.pi)
        found = error * np.hypot(1.0, slope).max(axis=1)
    return np.where(np.isfinite(found), found, error)


def located(error: Array) -> Flags:
    """Where an outline is known to less than its mean radius, or there is none, which notes say; shape (n,)."""
    return np.asarray((error < 1) | ~np.isfinite(error))


def own_error(solution: bem.Solution, indenter: Indenter | None = None) -> float:
    """Relative error of the force on the cells of a solution; infinite if none is in contact."""
    if not solution.contact.any():
        return float("inf")
    measured = max(_richardson(*_differences(solution)), _rim_error(solution), _edge_error(solution, indenter))
    return max(measured, _lowest_cell(solution)) + _floor(solution)


def extrapolated(solution: bem.Solution, indenter: Indenter | None = None) -> tuple[float, float]:
    """Force extrapolated to vanishing cells [N] and its relative error.

    The extrapolation holds where the error falls with the square of the width. The force is that of the cells where the
    differences have no common sign, or where the position of rim or edges changes it by more than the last of them.
    """
    if not solution.contact.any():
        return solution.force, float("inf")
    last, before = _differences(solution)
    rim = max(_rim_error(solution), _edge_error(solution, indenter))
    if last * before < 0 or abs(last) < rim:
        return solution.force, own_error(solution, indenter)
    slower = max(_richardson(last, before) - abs(last) / (_SECOND_ORDER - 1), 0.0)
    # share of a difference by which forces scatter about the power law; half as much leaves one estimate in ten too small
    scatter = 0.2 * max(abs(last), abs(before) / _SECOND_ORDER)
    return solution.extrapolated_force, max(slower + scatter, rim) + _floor(solution)


def _differences(solution: bem.Solution) -> tuple[float, float]:
    """Relative differences of forces to wider cells, the finest first; without them the error falls like the width."""
    if not np.isfinite(solution.coarser_force):
        return 0.0, 0.0
    last = solution.coarser_force / solution.force - 1
    before = (solution.coarsest_force - solution.coarser_force) / solution.force
    return last, before if np.isfinite(before) else 2 * last


def _richardson(last: float, before: float) -> float:
    """Error of the finest cells."""
    if last * before < 0:
        return max(abs(last), abs(before))
    # difference between forces on wider cells above which these are no power of the width, and a ratio above 4 is chance
    if abs(before) > max(0.1, _SECOND_ORDER * abs(last)):
        # the last difference is small by chance, as the error passes through a turn
        return abs(before) / _SECOND_ORDER
    # smaller ratios q are not used: the estimate would exceed four times the last difference
    ratio = np.clip(before / last if last else _SECOND_ORDER, 1.25, _SECOND_ORDER)
    return float(max(abs(last) / (ratio - 1), abs(before) / (_SECOND_ORDER * (_SECOND_ORDER - 1))))


def _rim_error(solution: bem.Solution) -> float:
    """Error from the place of the rim among the cells; zero where the modulus of the surface is not known."""
    if not np.isfinite(solution.modulus):
        return 0.0
    contact, h = solution.pressure > 0, solution.grid.spacing
    padded, half = np.pad(contact, 1), bounding_box(solution.grid, contact).half_widths
    # twice the energy of moving the rim of a cell by one cell
    energy = np.pi * (h * solution.pressure) ** 2 * h / (2 * solution.modulus)
    sides = (padded[1:-1, :-2], 0), (padded[1:-1, 2:], 0), (padded[:-2, 1:-1], 1), (padded[2:, 1:-1], 1)
    error = 0.0
    for beside, axis in sides:
        side = contact & ~beside
        runs = label(side, np.eye(3)[1] * np.ones((3, 1)) if axis == 0 else np.eye(3)[1][:, None] * np.ones(3))[
            0
        ].ravel()
        length, lost = np.bincount(runs)[1:] * h, np.bincount(runs, energy.ravel())[1:]
        # distances in cells: 0.03 to 0.13 along the staircases of flat ends of cones, and half a cell more along straight edges,
        # about which the centres of a whole row of cells decide at once
        straight = length > 2 / 3 * half[1 - axis]
        error += float(lost @ np.where(straight, 0.6, 0.13))
    return error / (solution.force * solution.depth)


def _edge_error(solution: bem.Solution, indenter: Indenter | None) -> float:
    """Error from the place of the tip's edges among the cells; zero without edges."""
    if indenter is None or not indenter.corners or not np.isfinite(solution.stiffness):
        return 0.0
    grid, h = solution.grid, solution.grid.spacing
    rows, columns = np.nonzero(solution.contact)
    x, y = grid.x[columns], grid.y[rows]
    directions = np.array(indenter.corners)[:, None]
    along, across = np.cos(directions) * x + np.sin(directions) * y, np.cos(directions) * y - np.sin(directions) * x
    crossed = ((along > -h) & (np.abs(across) < h)).any(axis=0)
    within = ((np.arange(4) + 0.5) / 4 - 0.5) * h
    # heights at 4 x 4 points of each cell, and at its centre
    dx, dy = (each.ravel() for each in np.meshgrid(within, within))
    inner = indenter.height(*polar(x[crossed, None] + dx, y[crossed, None] + dy)).mean(axis=1)
    differences = inner - indenter.height(*polar(x[crossed], y[crossed]))
    return abs(float(differences.sum())) / x.size * solution.stiffness / solution.force


def _lowest_cell(solution: bem.Solution) -> float:
    """Error where no cell has contact all around, as the tip is lower between the centres of cells; else zero."""
    contact = np.asarray(solution.contact)
    if binary_erosion(contact).any():
        return 0.0
    lowest = solution.depth - float(np.asarray(solution.displacement)[contact].max())
    return max(lowest, 0.0) * solution.stiffness / solution.force


def _floor(solution: bem.Solution) -> float:
    """Error that the differences do not show, four times as large where there are none."""
    unknown = 1 if np.isfinite(solution.coarser_force) else _SECOND_ORDER
    # least relative error, 0.03 times the square of cell over shorter half-width: differences may vanish by chance
    return float(
        unknown * 0.03 * (solution.grid.spacing / min(bounding_box(solution.grid, solution.contact).half_widths)) ** 2
    )
