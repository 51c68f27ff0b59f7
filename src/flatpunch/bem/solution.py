"""A boundary element solution, made from the state of a solver, and the criterion of its convergence."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from flatpunch._support.checks import Array, BadValue, FlatpunchWarning, instance, positive, switch, whole
from flatpunch._support.readable import readable
from flatpunch.bem.grid import Grid, Height, Mask
from flatpunch.bem.operator.convolution import SINGLE_FLOOR, to_numpy
from flatpunch.bem.outline import Outline, trace_outline
from flatpunch.bem.solver.active_set import State
from flatpunch.bem.solver.levels import Levels
from flatpunch.bem.solver.nested import Effort, solve_stiffness
from flatpunch.compliances import Kernel


@readable
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
    coarser_force, coarsest_force : float
        Forces on cells twice and four times as wide at the same depth [N]; NaN where these were not solved.
    modulus : float
        Contact modulus E* of the surface [Pa]; NaN for flat punches.
    notes : tuple of str
        What a user should know about this solution.

    See Also
    --------
    flatpunch.bem.solve, flatpunch.bem.solve_punch : Make it.

    Examples
    --------
    >>> from flatpunch import bem
    >>> kernel = fp.compliance(fp.HalfSpace(young=1e6, poisson=0.3))
    >>> (contact,) = bem.solve(kernel, fp.Paraboloid(radius=1e-3), depths=1e-5, grid=64)
    >>> print(contact.converged, contact.pressure.shape == contact.contact.shape)
    True True
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
    coarser_force: float = float("nan")
    coarsest_force: float = float("nan")
    modulus: float = float("nan")

    @property
    def extrapolated_force(self) -> float:
        """Force extrapolated to vanishing cells from these and wider ones [N]; of these alone if wider ones were not solved.

        The error of the cells falls with the square of their width: over 252 contacts solved with 256 cells a side the largest
        error falls by half, the median by three.
        """
        if not np.isfinite(self.coarser_force):
            return self.force
        return self.force + (self.force - self.coarser_force) / 3

    @property
    def area(self) -> float:
        """Contact area [m^2]."""
        return self.outline.area

    @property
    def patches(self) -> int:
        """Number of separate parts of the contact, cells joined by sides and corners."""
        return int(label(self.contact, np.ones((3, 3)))[1])

    @property
    def radius(self) -> float:
        """Mean radius a0 [m]."""
        return self.outline.radius


def solution_of(
    levels: Levels,
    height: Height,
    state: State,
    effort: Effort,
    tolerance: float,
    angles: int,
    stiffness: bool | float,
    *,
    endless: bool,
) -> Solution:
    """Make the solution from the last state of the solver; `endless` if the indenter has a surface everywhere."""
    grid, modulus = levels.grid, levels.kernel.modulus
    h = grid.spacing
    pressure = to_numpy(state.pressure).astype(float)
    contact = pressure > 0
    rim = (1 + levels.kernel.exponent) / 2
    sharp = not endless and reaches_end(height(grid), contact)
    outline = trace_outline(grid, pressure, angles=angles, rim=rim, length=levels.kernel.surface_length, sharp=sharp)
    k = float("nan")
    if stiffness:
        wanted = 1e-5 if stiffness is True else float(stiffness)
        k = solve_stiffness(levels, state.contact, max(wanted, tolerance))
    converged = state.converged and effort.force_error <= tolerance
    notes = [outline.note] if outline.note else []
    if not converged:
        notes.append(
            not_converged(state.gap_error, state.penetration, effort.force_error, tolerance, effort.iterations)
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
        notes=warned(notes) if not converged else tuple(notes),
        coarser_force=effort.coarser_force,
        coarsest_force=effort.coarsest_force,
        modulus=modulus,
    )


def reaches_end(heights: Array, contact: Mask) -> bool:
    """Whether the contact ends where the indenter does, so that its rim is an edge."""
    if np.isfinite(heights).all():
        return False
    beyond = ~np.isfinite(np.pad(heights, 1, mode="edge"))
    near = beyond[:-2, 1:-1] | beyond[2:, 1:-1] | beyond[1:-1, :-2] | beyond[1:-1, 2:]
    return bool((near & contact).any())


def check_tolerance(tolerance: float, single: bool) -> None:
    """Refuse a tolerance that cannot be reached."""
    if positive("tolerance", tolerance) >= 1:
        raise BadValue("tolerance", f"{tolerance:g}", "must be below 1, as it is relative to the depth. Try 1e-6.")
    if switch("single", single) and tolerance < SINGLE_FLOOR:
        raise BadValue(
            "tolerance",
            f"{tolerance:g}",
            f"is out of reach of single precision. Use {SINGLE_FLOOR:g} or more, or double precision.",
        )
    if tolerance < np.finfo(float).eps:
        raise BadValue("tolerance", f"{tolerance:g}", "is below the rounding of floating point. Try 1e-6.")


def checked_effort(kernel: Kernel, tolerance: float, limit: int, single: bool) -> int:
    """Refuse what is no kernel and a tolerance that cannot be reached; return the limit of iterations."""
    instance("kernel", kernel, (Kernel,), "the kernel of a medium: compliance(medium)")
    check_tolerance(tolerance, single)
    return whole("limit", limit, 1, "It is the largest number of iterations on one grid.")


def not_converged(gap: float, penetration: float, force: float, tolerance: float, iterations: tuple[int, ...]) -> str:
    """Say what was reached."""
    return (
        f"not converged after {iterations[-1]} iterations: gap error {gap:.1e}, penetration {penetration:.1e} of the depth, "
        f"force error {force:.1e}, asked for {tolerance:.1e}. Raise limit or tolerance; the solution is what was reached"
    )


def warned(notes: Iterable[str]) -> tuple[str, ...]:
    """Warn with each note, at the place that called `solve`."""
    for note in notes:
        warnings.warn(note, FlatpunchWarning, stacklevel=4)
    return tuple(notes)
