"""Boundary element solution of a punch of any planform that sticks to the surface: flat-ended, or of any face."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flatpunch._support.checks import Array, positive, real
from flatpunch.bem.grid import Grid, Mask, Namespace, check_grid, on_grid
from flatpunch.bem.operator.convolution import to_numpy
from flatpunch.bem.outline import trace_outline
from flatpunch.bem.solution import Solution, checked_effort, not_converged, warned
from flatpunch.bem.solver.active_set import adhering
from flatpunch.bem.solver.levels import Levels, announced, mirror_axes
from flatpunch.compliances import Kernel


def solve_punch(
    kernel: Kernel,
    planform: Callable[[Array, Array], Mask] | Mask,
    grid: Grid,
    *,
    depth: float = 1.0,
    face: Array | None = None,
    tolerance: float = 1e-8,
    limit: int = 1000,
    angles: int = 360,
    single: bool = False,
    xp: Namespace = np,
) -> Solution:
    """Punch of any planform, flat-ended or with a given face, pressed in to `depth`, adhering where it would lift off.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    planform : callable or ndarray of bool, shape (ny, nx)
        (x, y) [m] -> whether inside; or the cells themselves.
    grid : Grid
        Cells; may end at the planform's edge.
    depth : float
        Depth [m]; under a flat end everything is proportional to it.
    face : ndarray, shape (ny, nx), optional
        Gap of the punch at first touch [m]; a flat end by default. Then `depth` may have any sign, and `stiffness` is not
        computed.
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

    See Also
    --------
    flatpunch.flat_punch : The round punch, exact.
    flatpunch.bem.solve : Indenters that are not flat.

    Examples
    --------
    >>> from flatpunch import bem
    >>> kernel = fp.compliance(fp.HalfSpace(young=1e6, poisson=0.3))
    >>> grid = bem.Grid(nx=64, ny=64, spacing=1e-4 / 64)
    >>> square = bem.solve_punch(kernel, np.ones((64, 64), dtype=bool), grid)
    >>> print(f"{square.stiffness / (1e6 / 0.91 * 1e-4):.2f} E* times the side")
    1.15 E* times the side
    """
    check_grid(grid)
    depth = positive("depth", depth, unit="m") if face is None else real("depth", depth, "m")
    limit = checked_effort(kernel, tolerance, limit, single)
    if callable(planform):
        planform = np.broadcast_to(planform(grid.x[None, :], grid.y[:, None]), grid.shape)
    mask = on_grid("planform", planform, grid) != 0
    if face is not None:
        face = on_grid("face", face, grid)
    if not mask.any():
        raise ValueError("planform holds no cell of the grid. Its coordinates are in metres, as the grid's.")
    levels = announced(Levels(kernel, grid, xp, single), 1)
    # displacement under the punch, in units of the depth where the end is flat
    unit = depth if face is None else grid.spacing
    wanted = np.where(mask, 1.0 if face is None else (depth - face) / unit, 0.0)
    part = levels.folded(mirror_axes(levels, wanted))
    p, error, iterations = adhering(
        part.operator, xp.asarray(part.kept(mask)), part.operator.asarray(part.kept(wanted)), tolerance, limit
    )
    u = part.grid.unfold(to_numpy(part.operator.apply(p)).astype(float)) * unit
    p_si = part.grid.unfold(to_numpy(p).astype(float)) * (kernel.modulus * unit / grid.spacing)
    force = float(p_si.sum()) * grid.cell_area
    k = force / depth if face is None else float("nan")
    converged = error <= tolerance
    notes = () if converged else (not_converged(error, 0.0, 0.0, tolerance, (iterations,)),)
    outline = trace_outline(grid, mask.astype(float), angles=angles, sharp=True)
    return Solution(grid, p_si, u, mask, depth, force, outline, k, error, 0.0, (iterations,), converged, warned(notes))
