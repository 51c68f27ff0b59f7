"""Error of the force that the cells of a boundary element solution cause, measured by solutions on wider cells.

The error of the force falls with a power of the width of the cells. Three widths give that power: the ratio q of the two
differences between their forces is 4 for the square, 2 where the error falls with the width itself, as beside the edges of a
flat, and close to 1 or negative where the cells are wider than the thinnest layer. The error of the finest cells is then
D/(q - 1), with D the difference to cells twice as wide (Richardson's extrapolation), or the larger difference where the signs
differ. So the estimate depends on every length of the problem without knowing any.
"""

from __future__ import annotations

import numpy as np

from flatpunch import bem
from flatpunch.bem.bounding_box import bounding_box

_SECOND_ORDER = 4.0
"""Ratio q of errors that fall with the square of the width; larger ones are chance."""


def own_error(solution: bem.Solution) -> float:
    """Relative error of the force on the cells of a solution; infinite if none is in contact."""
    if not solution.contact.any():
        return float("inf")
    last, before = _differences(solution)
    return _richardson(last, before) + _floor(solution)


def extrapolated(solution: bem.Solution) -> tuple[float, float]:
    """Force extrapolated to vanishing cells [N] and its relative error.

    The extrapolation holds where the error falls with the square of the width. The force is that of the cells where the
    differences have no common sign.
    """
    if not solution.contact.any():
        return solution.force, float("inf")
    last, before = _differences(solution)
    if last * before < 0:
        return solution.force, own_error(solution)
    slower = max(_richardson(last, before) - abs(last) / (_SECOND_ORDER - 1), 0.0)
    # share of a difference by which forces scatter about the power law; half as much leaves one estimate in ten too small
    scatter = 0.2 * max(abs(last), abs(before) / _SECOND_ORDER)
    return solution.extrapolated_force, slower + scatter + _floor(solution)


def _differences(solution: bem.Solution) -> tuple[float, float]:
    """Relative differences of forces on cells of one width and of the next wider ones, the finest first.

    Where wider cells were not solved the errors are taken to fall with the width itself; both are zero where none were.
    """
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


def _floor(solution: bem.Solution) -> float:
    """Error that the differences do not show, four times as large where there are none."""
    unknown = 1 if np.isfinite(solution.coarser_force) else _SECOND_ORDER
    # least relative error, 0.03 times the square of cell over shorter half-width: differences may vanish by chance
    return float(
        unknown * 0.03 * (solution.grid.spacing / min(bounding_box(solution.grid, solution.contact).half_widths)) ** 2
    )
