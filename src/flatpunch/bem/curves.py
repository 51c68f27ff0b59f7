"""Boundary element solutions of contacts over a curve: one step after the other, by depths or by forces.

The grid is the one that was given, or is chosen for each contact and grows when the contact turns out larger. Steps close
together start from the solution before, others from coarser grids.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flatpunch._support.checks import (
    CELLS,
    FEWEST,
    Array,
    BadValue,
    Flags,
    Values,
    follows,
    positive,
    switch,
    values,
    whole,
)
from flatpunch._support.prefixes import text
from flatpunch._support.progress import Report
from flatpunch.bem.bounding_box import (
    SETTLED,
    ContactTouchesEdge,
    Extent,
    expected_extents,
    find_extent,
    grown,
    loaded_half_widths,
    overlap_half_widths,
    solve_at,
    touches_edge,
)
from flatpunch.bem.grid import Cells, Grid, Height, IndenterHeight, Namespace
from flatpunch.bem.operator.convolution import to_numpy
from flatpunch.bem.outline import checked_angles
from flatpunch.bem.solution import Solution, checked_effort, solution_of
from flatpunch.bem.solver.active_set import State
from flatpunch.bem.solver.levels import Levels, announced, fitting_threads
from flatpunch.bem.solver.nested import Effort, Rough
from flatpunch.compliances import Kernel
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.parallel.engine import shared_out

DEFAULT_CELLS = 256
"""Cells per side of a grid that is chosen for a contact; half as many quadruple the errors of force and outline."""


SHARED_CELLS = 2 * DEFAULT_CELLS
"""Most cells per side for which far steps are shared with worker processes, each of which holds as much as this one."""


def solve(
    kernel: Kernel,
    indenter: Indenter,
    *,
    depths: Values | None = None,
    forces: Values | None = None,
    grid: Grid | int | None = None,
    half_widths: ArrayLike | None = None,
    centers: ArrayLike | None = None,
    search: bool | Flags = True,
    tolerance: float = 1e-8,
    limit: int = 1000,
    stiffness: bool | float = False,
    angles: int = 360,
    single: bool = False,
    xp: Namespace = np,
    progress: Report | None = None,
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
        Expected half-widths of each contact along x and y [m], for example from a fast method; by default an
        estimate from the indenter's shape. Only a start: the box is found on a coarse grid.
    centers : sequence of (float, float), optional
        Centres of these boxes [m]; the point of first touch by default.
    search : bool or sequence of bool
        Whether to look for the box of each contact on a coarse grid; else `half_widths` are taken for it, and only a contact
        that touches the edge of its grid makes that grow.
    tolerance : float
        Largest gap error in contact and penetration outside, relative to depth; for forces also the relative error of force.
    limit : int
        Largest number of iterations on one grid.
    stiffness : bool or float
        Whether to compute dF/dd, or the largest deviation of the displacement under the flat punch that gives it (1e-5).
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

    See Also
    --------
    flatpunch.BoundaryElements : The same through `indent`.
    flatpunch.bem.Solution : What it returns.

    Examples
    --------
    >>> from flatpunch import bem
    >>> kernel = fp.compliance(fp.HalfSpace(young=1e6, poisson=0.3))
    >>> (contact,) = bem.solve(kernel, fp.Paraboloid(radius=1e-3), depths=1e-5, grid=64)
    >>> print(f"{contact.force:.2e} N, Hertz {4 / 3 * 1e6 / 0.91 * 1e-3**0.5 * 1e-5**1.5:.2e} N")
    1.47e-03 N, Hertz 1.47e-03 N
    """
    targets, by_depth = _targets(depths, forces)
    limit = checked_effort(kernel, tolerance, limit, single)
    angles = checked_angles(angles)
    check_indenter(indenter)
    if not isinstance(stiffness, bool):
        positive("stiffness", stiffness, "It is the largest deviation under the flat punch, or True or False.")
    if grid is not None and not isinstance(grid, Grid):
        grid = whole("grid", grid, FEWEST, "It is the number of cells per side, or a Grid.", most=CELLS)
    course = _Course(kernel, indenter, by_depth, grid, tolerance, limit, stiffness, angles, single)
    hints, searched = expected_extents(half_widths, centers, targets.size), _searched(search, targets.size)
    steps = [_Step(float(t), hint, look) for t, hint, look in zip(targets, hints, searched, strict=True)]
    solved: list[Solution] = []

    def took(more: list[Solution]) -> None:
        solved.extend(more)
        if progress is not None:
            progress(len(solved), targets.size)

    if isinstance(grid, Grid) or xp is not np:
        for solution in _solutions(course, steps, xp):
            took([solution])
        return solved
    few = (grid or DEFAULT_CELLS) <= SHARED_CELLS
    groups = shared_out(_solve_group, course, _together(steps), done=took, helped=few)
    return [solution for group in groups for solution in group]


@dataclass(frozen=True, slots=True)
class _Course:
    kernel: Kernel
    indenter: Indenter
    by_depth: bool
    grid: Grid | int | None
    tolerance: float
    limit: int
    stiffness: bool | float
    angles: int
    single: bool


@dataclass(frozen=True, slots=True)
class _Step:
    """Depth [m] or force [N], the expected box of its contact, and whether to search for the box first."""

    target: float
    hint: Extent | None
    searched: bool


def _together(steps: list[_Step]) -> list[list[_Step]]:
    """Steps in a row that are close, each of which starts from the one before, in groups; all other steps by themselves."""
    groups: list[list[_Step]] = []
    for step in steps:
        # most close steps in a row; the next begin on coarse cells, so that long rows are shared and reported too
        if groups and len(groups[-1]) < 16 and _near(step, groups[-1][-1]):
            groups[-1].append(step)
        else:
            groups.append([step])
    return groups


def _near(step: _Step, before: _Step) -> bool:
    """Whether the previous solution is a better start than a coarser grid."""
    # relative step of depth below which the solution before is as good a start as the next coarser grid
    return abs(step.target - before.target) < 0.005 * step.target


def _solve_group(course: _Course, steps: list[_Step]) -> list[Solution]:
    return list(_solutions(course, steps, np))


def _solutions(course: _Course, steps: list[_Step], xp: Namespace) -> Iterator[Solution]:
    """Solutions one after the other; close steps share a chosen grid."""
    kernel, indenter, grid = course.kernel, course.indenter, course.grid
    height = IndenterHeight(indenter)
    levels: Levels | None = None
    before: Levels | None = None
    state: State | None = None
    cells = grid.nx * grid.ny if isinstance(grid, Grid) else (grid or DEFAULT_CELLS) ** 2
    hinted = False
    with fitting_threads(cells):
        for i, step in enumerate(steps):
            prescribed = {"depth" if course.by_depth else "force": step.target}
            close = i > 0 and _near(step, steps[i - 1])
            if isinstance(grid, Grid):
                levels = levels or announced(Levels(kernel, grid, xp, course.single), 1)
            else:
                extent, hinted = _extent(course, step, height, **prescribed)
                if levels is None or not (close and extent.fits(levels.grid)):
                    levels = announced(
                        Levels(kernel, extent.grid(grid or DEFAULT_CELLS, **prescribed), xp, course.single), len(steps)
                    )
            start = state.pressure if state is not None and close and before is levels else None
            rough = None if isinstance(grid, Grid) else extent.rough
            # times that a grid chosen for the contact may grow when the contact is larger: by 1.5^8 along an axis
            growths = 0 if isinstance(grid, Grid) else 8
            levels, state, effort = _solve_inside(
                levels, height, course.tolerance, course.limit, start, growths, hinted=hinted, rough=rough, **prescribed
            )
            levels, state, effort = _with_all_parts(course, levels, height, state, effort, growths)
            before = levels
            endless = indenter.reach == np.inf
            yield solution_of(
                levels, height, state, effort, course.tolerance, course.angles, course.stiffness, endless=endless
            )


def _targets(depths: Values | None, forces: Values | None) -> tuple[Array, bool]:
    if (depths is None) == (forces is None):
        raise TypeError("Give either depths or forces.")
    if depths is not None:
        return values("depths", depths, strict=True, unit="m"), True
    return values("forces", forces, strict=True, unit="N"), False


def _searched(search: bool | Flags, steps: int) -> list[bool]:
    given: Any = search.tolist() if isinstance(search, np.ndarray) else search
    flags = list(given) if follows(given, list, tuple) else [given] * steps
    if len(flags) != steps:
        raise BadValue("search", "", f"has {len(flags)} entries; it must have one for each of {steps} steps.")
    return [switch("search", each) for each in flags]


def _extent(course: _Course, step: _Step, height: Height, **prescribed: float) -> tuple[Extent, bool]:
    """Box of a contact, and whether it is one that was only hinted at."""
    if course.indenter.has_parts:
        return _around_parts(course, height, **prescribed), False
    if (first := step.hint) is None and course.by_depth:
        first = Extent(overlap_half_widths(course.indenter, step.target), (0.0, 0.0))
    elif first is None:
        first = Extent(loaded_half_widths(course.indenter, step.target, course.kernel.modulus), (0.0, 0.0))
    hinted = step.hint is not None and not step.searched
    return first if hinted else find_extent(course.kernel, height, first, **prescribed), hinted


def _around_parts(course: _Course, height: Height, *, depth: float | None = None, force: float | None = None) -> Extent:
    """Box around all that is lower than the depth, of tips that may touch in several places.

    The depth of a force is first found on the whole tip.
    """
    box = course.indenter
    assert box.has_parts
    if force is not None:
        whole = Levels(course.kernel, Extent(*box.box(np.inf)).grid(DEFAULT_CELLS // 2, force=force))
        # a tenth of the depth more than is known on these cells
        state, _ = solve_at(whole, height, 1e-2, course.limit, force=force)
        depth = (1 + SETTLED) * state.depth * whole.grid.spacing
    assert depth is not None
    return Extent(*box.box(depth))


def _with_all_parts(
    course: _Course, levels: Levels, height: Height, state: State, effort: Effort, growths: int
) -> tuple[Levels, State, Effort]:
    """The solution, or one on a larger grid where the depth found for a force reaches parts of the tip beyond the grid."""
    box = course.indenter
    if not box.has_parts or course.by_depth or not growths:
        return levels, state, effort
    extent, grid = Extent(*box.box(state.depth * levels.grid.spacing)), levels.grid
    inside = all(
        abs(centre - middle) + width < cells * grid.spacing / 2
        for centre, middle, width, cells in zip(
            extent.center, grid.center, extent.half_widths, (grid.nx, grid.ny), strict=True
        )
    )
    if inside:
        return levels, state, effort
    cells = round(np.sqrt(grid.nx * grid.ny))
    larger = replace(levels, grid=extent.grid(cells))
    force = state.force * levels.unit
    return _solve_inside(larger, height, course.tolerance, course.limit, None, growths, force=force)


def _solve_inside(
    levels: Levels,
    height: Height,
    tolerance: float,
    limit: int,
    start: Cells,
    growths: int,
    *,
    hinted: bool = False,
    rough: Rough | None = None,
    **prescribed: float,
) -> tuple[Levels, State, Effort]:
    """Solution that does not touch the grid's edge; the grid may grow along the axes that need it, so many times.

    What is known of the contact on `rough` cells takes the place of the coarsest level. Where its box was only `hinted` at, it is
    looked for first: growing would leave the cells as fine as they were.
    """
    for left in range(growths, -1, -1):
        state, effort = solve_at(levels, height, tolerance, limit, start, rough=rough, **prescribed)
        contact = to_numpy(state.contact).astype(bool)
        if not touches_edge(contact):
            return levels, state, effort
        if left:
            grid = grown(levels.grid, contact)
            if hinted:
                half_widths = grid.nx * grid.spacing / 2, grid.ny * grid.spacing / 2
                found = find_extent(levels.kernel, height, Extent(half_widths, grid.center), **prescribed)
                grid, hinted = found.grid(round(np.sqrt(levels.grid.nx * levels.grid.ny)), **prescribed), False
                rough = found.rough
            levels, start = announced(replace(levels, grid=grid), 1), None
    raise _too_small(levels, height, **prescribed)


def _too_small(
    levels: Levels, height: Height, *, depth: float | None = None, force: float | None = None
) -> ContactTouchesEdge:
    grid = levels.grid
    first = Extent((grid.nx * grid.spacing, grid.ny * grid.spacing), grid.center)
    needed = find_extent(levels.kernel, height, first, depth=depth, force=force)
    wx, wy = ((1 + SETTLED) * width for width in needed.half_widths)
    nx, ny = (int(np.ceil(2 * w / grid.spacing)) for w in (wx, wy))
    return ContactTouchesEdge(
        f"The contact touches the edge of the grid ({grid.nx} x {grid.ny} cells of {text(grid.spacing, 'm')}). It needs about "
        f"{text(float(2 * wx), 'm')} x {text(float(2 * wy), 'm')} around ({needed.center[0]:.3g}, "
        f"{needed.center[1]:.3g}) m: {nx} x {ny} cells "
        "of this size. Or leave the grid to be chosen."
    )
