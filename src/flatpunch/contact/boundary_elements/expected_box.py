"""Expected boxes of contacts: from neighbouring solutions, the round contact and the tip, or an outline that left its grid."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from flatpunch import bem
from flatpunch._support.checks import Array, Flags
from flatpunch._support.paths import Plain
from flatpunch.bem.grid import Grid
from flatpunch.compliances import Kernel
from flatpunch.contact.boundary_elements.outlines import Trace, traced
from flatpunch.indenters.profile import Indenter

POWER = 1.25
"""Logarithm of an outline over that of the tip's level line: 1 to 2, from soft to stiff layers."""


def boxes_between(
    positions: Array, known: Mapping[float, Array], round_radius: Array, level_line: Array, phi: Array
) -> tuple[Array, Array, Flags]:
    """Half-widths and centres of the contacts at positions ln d, shape (n, 2) each, and which of them are reliable, shape (n,).

    `known` are the outlines ln a(phi) of the solutions at their ln d, NaN where there is none; `round_radius` the radii of the
    round contacts [m], shape (n,); `level_line` is the function of that name, shape (angles,).
    """
    every = np.array(sorted(known))
    # the box is a tenth wider
    logarithms = np.log(round_radius)[:, None] + POWER * level_line + 0.1 * (level_line != 0).any()
    sure = np.zeros(positions.size, dtype=bool)
    for row, x in enumerate(positions):
        upper = int(np.searchsorted(every, x))
        if 0 < upper < every.size:
            low, high = (known[node] for node in every[upper - 1 : upper + 1])
            between = low + (x - every[upper - 1]) / (every[upper] - every[upper - 1]) * (high - low)
            # largest difference of ln a(phi) between neighbours for which their mean gives the box between them
            sure[row] = np.isfinite(between).all() and np.abs(high - low).max() < 1.0
            logarithms[row] = np.where(np.isfinite(between), between, logarithms[row])
    half_widths, centers = boxes_around(np.exp(logarithms), phi)
    # contacts that are their own mirror images have the point of first touch as centre, to 2 % of the half-width
    centers[np.abs(centers) < 0.02 * half_widths] = 0.0
    return half_widths, centers, sure


def boxes_around(outlines: Array, phi: Array) -> tuple[Array, Array]:
    """Half-widths and centres of the boxes around outlines a(phi) [m], shape (n, angles) -> (n, 2) each."""
    sides = [outlines * trig(phi) for trig in (np.cos, np.sin)]
    half_widths = np.column_stack([np.ptp(side, axis=1) / 2 for side in sides])
    centers = np.column_stack([(side.max(axis=1) + side.min(axis=1)) / 2 for side in sides])
    return half_widths, centers


def outgrown(grid: Grid, contour: Array) -> Plain | None:
    """Box for another solution where an outline a(phi) [m] leaves its grid, as arguments of `bem.solve`; else None.

    Coarse cells miss the ends of narrow lobes, so that the box of the grid is too small.
    """
    half_widths, center = (
        sides[0] for sides in boxes_around(contour[None], 2 * np.pi * np.arange(contour.size) / contour.size)
    )
    # outermost cells that an outline must leave free: an outline that reaches them may be cut off
    inside = (np.array([grid.nx, grid.ny]) / 2 - 2) * grid.spacing
    if not (np.abs(center - grid.center) + half_widths > inside).any():
        return None
    return {"half_widths": half_widths, "centers": center, "search": False}


def traced_whole(
    kernel: Kernel,
    indenter: Indenter,
    solution: bem.Solution,
    angles: int,
    solved: Callable[..., bem.Solution],
) -> tuple[bem.Solution, Trace]:
    """A solution and its outline; where this leaves the grid, those of another one, `solved` with a larger box."""
    trace = traced(kernel, indenter, solution, angles)
    larger = outgrown(solution.grid, trace.contour)
    if larger is None:
        return solution, trace
    again = solved(**larger)
    return again, traced(kernel, indenter, again, angles)


def level_line(indenter: Indenter, phi: Array) -> Array:
    """ln r on a line of equal height, less its mean, shape (angles,); zero for tips whose lines differ in shape."""
    if indenter.exponent is None:
        return np.zeros_like(phi)
    line = -np.log(indenter.height(np.ones_like(phi), phi)) / indenter.exponent
    return np.asarray(line - line.mean())
