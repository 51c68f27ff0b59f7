"""Boundary element solutions of contacts: for any medium and indenter, by depths or by forces."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flatpunch._validation import Array, FlatpunchWarning, positive, values
from flatpunch.bem.extent import (
    ContactTouchesEdge,
    Extent,
    find_extent,
    grown,
    touches_edge,
    typical_depth,
)
from flatpunch.bem.grid import Grid, Mask
from flatpunch.bem.levels import Effort, Levels, solve_depth, solve_force
from flatpunch.bem.operator import BYTES_PER_CELL, to_numpy
from flatpunch.bem.outline import Outline, trace_outline
from flatpunch.bem.shape import Height, IndenterHeight, PunchHeight, loaded_half_widths, overlap_half_widths
from flatpunch.bem.solver import State, punch_stiffness
from flatpunch.compliance import Kernel
from flatpunch.indenters.profile import Indenter

logger = logging.getLogger("flatpunch.bem")

DEFAULT_CELLS = 256
SINGLE_FLOOR = 1e-5
"""Smallest tolerance that single precision can reach."""

_STIFFNESS_TOLERANCE = 1e-5

_CLOSE = 0.005
"""Relative step of depth below which the solution before is as good a start as the next coarser grid."""

_GROWTHS = 8
"""How often a grid that was chosen for the contact may grow when the contact turns out larger: by 1.5^8 along an axis."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Solution:
    """Contact at one depth.

    Attributes
    ----------
    grid : Grid
        The cells.
    pressure, displacement : ndarray, shape (ny, nx)
        Pressure [Pa] and inward displacement of the surface [m] at the cell centres.
    contact : ndarray of bool, shape (ny, nx)
        Cells in contact.
    depth, force : float
        Indentation depth d [m], normal force F [N].
    outline : Outline
        a(phi), mean radius, area, half-axes.
    stiffness : float
        dF/dd [N/m]: stiffness of the flat punch under the final contact; NaN unless asked for.
    gap_error : float
        Largest ``|gap|`` in contact over the depth, of the pressure above.
    penetration : float
        Largest penetration outside the contact over the depth, likewise.
    iterations : tuple of int
        Iterations on each grid, the finest last.
    converged : bool
        Whether both errors are at most the tolerance asked for, and the force is the one asked for.
    notes : tuple of str
        What a user should know about this solution.
    """

    grid: Grid
    pressure: Array
    displacement: Array
    contact: Mask
    depth: float
    force: float
    outline: Outline
    stiffness: float
    gap_error: float
    penetration: float
    iterations: tuple[int, ...]
    converged: bool
    notes: tuple[str, ...] = ()

    @property
    def area(self) -> float:
        """Contact area [m^2]."""
        return self.outline.area

    @property
    def radius(self) -> float:
        """Mean radius a0 [m]."""
        return self.outline.radius


def solve(
    kernel: Kernel,
    indenter: Indenter,
    *,
    depths: Any = None,
    forces: Any = None,
    grid: Grid | int | None = None,
    half_widths: Any = None,
    tolerance: float = 1e-8,
    limit: int = 1000,
    stiffness: bool = False,
    angles: int = 360,
    single: bool = False,
    xp: Any = np,
    progress: Progress | None = None,
) -> list[Solution]:
    """Contact at each depth or force.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    indenter : Indenter
        Rigid indenter.
    depths, forces : float or sequence of float
        One of them, > 0: indentation depths [m] or normal forces [N].
    grid : Grid or int, optional
        The grid for all steps, or the square root of the number of cells (256) of one that is fitted to each contact.
    half_widths : sequence of (float, float), optional
        Expected half-widths of each contact along x and y [m], for example from a fast method; else they are looked for
        from the indenter's shape on. Only a start: the box is found on a coarse grid.
    tolerance : float
        Largest gap error in contact and penetration outside, relative to depth; for forces also the relative error of force.
    limit : int
        Largest number of iterations on one grid.
    stiffness : bool
        Whether to compute dF/dd.
    angles : int
        Number of polar angles of the outline.
    single : bool
        Single precision throughout: half the memory, tolerance 1e-5 or more.
    xp : module
        Array namespace to work in (array API standard with fft extension, wrapped by array-api-compat); NumPy by default.
    progress : callable, optional
        Called with (steps done, steps in all).

    Returns
    -------
    list of Solution
        One for each depth or force. A solution that did not converge says so in `converged` and `notes`, and warns.

    Raises
    ------
    ContactTouchesEdge
        If the contact does not fit on the given grid.
    """
    targets, by_depth = _targets(depths, forces)
    _check_tolerance(tolerance, single)
    height = IndenterHeight(indenter)
    rim = (1 + kernel.exponent) / 2
    hints = _hints(half_widths, targets.size)
    solutions: list[Solution] = []
    levels: Levels | None = None
    before: Levels | None = None
    state: State | None = None
    for i, target in enumerate(targets):
        prescribed = {"depth": float(target)} if by_depth else {"force": float(target)}
        if isinstance(grid, Grid):
            levels = levels or announced(Levels(kernel, grid, xp, single), 1)
        else:
            first = hints[i] or _first_extent(kernel, indenter, solutions, **prescribed)
            extent = find_extent(kernel, height, first, **prescribed)
            if levels is None or not extent.fits(levels.grid):
                levels = announced(Levels(kernel, extent.grid(grid or DEFAULT_CELLS), xp, single), targets.size)
        start = state.pressure if state is not None and _near(target, targets[i - 1], before is levels) else None
        levels, state, effort = _solve_inside(
            levels, height, tolerance, limit, start, 0 if isinstance(grid, Grid) else _GROWTHS, **prescribed
        )
        before = levels
        solutions.append(_solution(levels, height, state, effort, tolerance, rim, angles, stiffness))
        if progress is not None:
            progress(i + 1, targets.size)
    return solutions


def solve_punch(
    kernel: Kernel,
    planform: Callable[[Array, Array], Mask] | Mask,
    grid: Grid,
    *,
    depth: float = 1.0,
    tolerance: float = 1e-8,
    limit: int = 1000,
    angles: int = 360,
    single: bool = False,
    xp: Any = np,
) -> Solution:
    """Flat-ended punch of any planform, pressed in to `depth`, adhering where it would lift off.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    planform : callable or ndarray of bool, shape (ny, nx)
        (x, y) [m] -> whether inside; or the cells themselves.
    grid : Grid
        Cells; may end at the planform's edge.
    depth : float
        Depth [m]; everything is proportional to it.
    tolerance : float
        Largest deviation of the displacement from the depth under the punch, relative to depth.
    limit : int
        Largest number of iterations.
    angles : int
        Number of polar angles of the outline.
    single : bool
        Single precision throughout.
    xp : module
        Array namespace to work in.

    Returns
    -------
    Solution
        With `stiffness` = force/depth. The pressure may be negative inside under films stiffer than their base. Cells at the
        edge carry a singular pressure, so the force converges like the first power of the spacing.
    """
    positive("depth", depth)
    _check_tolerance(tolerance, single)
    if callable(planform):
        mask = np.isfinite(PunchHeight(planform)(grid))
    else:
        mask = np.asarray(planform, dtype=bool)
        if mask.shape != grid.shape:
            raise ValueError(
                f"planform has shape {mask.shape}, the grid has {grid.shape} (rows along y). They must agree."
            )
    if not mask.any():
        raise ValueError("planform holds no cell of the grid. Its coordinates are in metres, as the grid's.")
    levels = announced(Levels(kernel, grid, xp, single), 1)
    operator = levels.operator
    p, total, error, iterations = punch_stiffness(operator, xp.asarray(mask), tolerance, limit)
    u = to_numpy(operator.apply(p)).astype(float) * depth
    p_si = to_numpy(p).astype(float) * (kernel.modulus * depth / grid.spacing)
    k = total * kernel.modulus * grid.spacing
    converged = error <= tolerance
    notes = () if converged else (_not_converged(error, 0.0, 0.0, tolerance, (iterations,)),)
    outline = trace_outline(grid, mask.astype(float), angles=angles, sharp=True)
    return Solution(
        grid, p_si, u, mask, depth, k * depth, outline, k, error, 0.0, (iterations,), converged, _warned(notes)
    )


def required_bytes(grid: Grid, *, single: bool = False) -> int:
    """Upper bound of the memory that a solve on `grid` takes [bytes]."""
    return grid.nx * grid.ny * (BYTES_PER_CELL // 2 if single else BYTES_PER_CELL)


def announced(levels: Levels, steps: int) -> Levels:
    """Say what is about to be solved and how much memory that takes."""
    grid = levels.grid
    logger.info(
        "%d x %d cells of %.4g m, %d step(s): at most %.0f MB",
        grid.nx,
        grid.ny,
        grid.spacing,
        steps,
        required_bytes(grid, single=levels.single) / 1e6,
    )
    return levels


def _targets(depths: Any, forces: Any) -> tuple[Array, bool]:
    if (depths is None) == (forces is None):
        raise TypeError("Give either depths or forces.")
    if depths is not None:
        return values("depths", depths, strict=True), True
    return values("forces", forces, strict=True), False


def _check_tolerance(tolerance: float, single: bool) -> None:
    positive("tolerance", tolerance)
    if single and tolerance < SINGLE_FLOOR:
        raise ValueError(
            f"tolerance = {tolerance:g} is out of reach of single precision. Use {SINGLE_FLOOR:g} or more, or double precision."
        )


def _hints(half_widths: Any, steps: int) -> list[Extent | None]:
    if half_widths is None:
        return [None] * steps
    boxes = np.broadcast_to(np.asarray(half_widths, dtype=float), (steps, 2))
    return [Extent((float(wx), float(wy)), (0.0, 0.0)) if wx > 0 and wy > 0 else None for wx, wy in boxes]


def _first_extent(
    kernel: Kernel,
    indenter: Indenter,
    before: list[Solution],
    *,
    depth: float | None = None,
    force: float | None = None,
) -> Extent:
    if depth is not None:
        return Extent(overlap_half_widths(indenter, depth), (0.0, 0.0))
    assert force is not None
    return Extent(loaded_half_widths(indenter, force, kernel.modulus), (0.0, 0.0))


def _near(target: float, previous: float, same_grid: bool) -> bool:
    """Whether the solution before is a better start than a coarser grid."""
    return same_grid and abs(target - previous) < _CLOSE * target


def _solve(
    levels: Levels,
    height: Height,
    tolerance: float,
    limit: int,
    start: Any,
    *,
    depth: float | None = None,
    force: float | None = None,
) -> tuple[State, Effort]:
    if depth is not None:
        return solve_depth(levels, height, depth, tolerance, limit, start)
    assert force is not None
    guess = typical_depth(height, levels.grid, force / levels.kernel.modulus)
    return solve_force(levels, height, force, guess, tolerance, limit)


def _solve_inside(
    levels: Levels,
    height: Height,
    tolerance: float,
    limit: int,
    start: Any,
    growths: int,
    **prescribed: float,
) -> tuple[Levels, State, Effort]:
    """Solution that does not touch the grid's edge; the grid may grow along the axes that need it, so many times."""
    for left in range(growths, -1, -1):
        state, effort = _solve(levels, height, tolerance, limit, start, **prescribed)
        contact = to_numpy(state.contact).astype(bool)
        if not touches_edge(contact):
            return levels, state, effort
        if left:
            levels, start = announced(replace(levels, grid=grown(levels.grid, contact)), 1), None
    raise _too_small(levels, height, **prescribed)


def _too_small(
    levels: Levels, height: Height, *, depth: float | None = None, force: float | None = None
) -> ContactTouchesEdge:
    grid = levels.grid
    first = Extent((grid.nx * grid.spacing, grid.ny * grid.spacing), grid.center)
    needed = find_extent(levels.kernel, height, first, depth=depth, force=force)
    wx, wy = (1.1 * width for width in needed.half_widths)
    nx, ny = (int(np.ceil(2 * w / grid.spacing)) for w in (wx, wy))
    return ContactTouchesEdge(
        f"The contact touches the edge of the grid ({grid.nx} x {grid.ny} cells of {grid.spacing:.4g} m). It needs about "
        f"{2 * wx:.4g} m x {2 * wy:.4g} m around ({needed.center[0]:.3g}, {needed.center[1]:.3g}) m: {nx} x {ny} cells "
        "of this size. Or leave the grid to be chosen."
    )


def _solution(
    levels: Levels,
    height: Height,
    state: State,
    effort: Effort,
    tolerance: float,
    rim: float,
    angles: int,
    stiffness: bool,
) -> Solution:
    grid, modulus = levels.grid, levels.kernel.modulus
    h = grid.spacing
    pressure = to_numpy(state.pressure).astype(float)
    contact = pressure > 0
    sharp = _reaches_end(height(grid), contact)
    outline = trace_outline(grid, pressure, angles=angles, rim=rim, length=levels.kernel.length, sharp=sharp)
    k = float("nan")
    if stiffness:
        k = punch_stiffness(levels.operator, state.contact, max(_STIFFNESS_TOLERANCE, tolerance))[1] * modulus * h
    converged = state.converged and effort.force_error <= tolerance
    notes = [outline.note] if outline.note else []
    if not converged:
        notes.append(
            _not_converged(state.gap_error, state.penetration, effort.force_error, tolerance, effort.iterations)
        )
    return Solution(
        grid=grid,
        pressure=pressure * modulus,
        displacement=to_numpy(state.displacement).astype(float) * h,
        contact=contact,
        depth=state.depth * h,
        force=state.force * modulus * h**2,
        outline=outline,
        stiffness=k,
        gap_error=state.gap_error,
        penetration=state.penetration,
        iterations=effort.iterations,
        converged=converged,
        notes=_warned(notes) if not converged else tuple(notes),
    )


def _reaches_end(heights: Array, contact: Mask) -> bool:
    """Whether the contact ends where the indenter does, so that its rim is an edge."""
    if np.isfinite(heights).all():
        return False
    beyond = ~np.isfinite(np.pad(heights, 1, mode="edge"))
    near = beyond[:-2, 1:-1] | beyond[2:, 1:-1] | beyond[1:-1, :-2] | beyond[1:-1, 2:]
    return bool((near & contact).any())


def _not_converged(gap: float, penetration: float, force: float, tolerance: float, iterations: tuple[int, ...]) -> str:
    return (
        f"not converged after {iterations[-1]} iterations: gap error {gap:.1e}, penetration {penetration:.1e} of the depth, "
        f"force error {force:.1e}, asked for {tolerance:.1e}. Raise limit or tolerance; the solution is what was reached"
    )


def _warned(notes: Any) -> tuple[str, ...]:
    for note in notes:
        warnings.warn(note, FlatpunchWarning, stacklevel=4)
    return tuple(notes)
