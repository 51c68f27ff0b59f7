"""The rigorous reference as a contact method: boundary elements on a grid for every medium and indenter."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from flatpunch import bem
from flatpunch._support.checks import FEWEST, Array, Flags, Indices
from flatpunch._support.progress import Report, reporting
from flatpunch.bem.grid import IndenterHeight
from flatpunch.bem.operator.convolution import SINGLE_FLOOR
from flatpunch.bem.outline import enough_rays
from flatpunch.bem.solution import reaches_end
from flatpunch.compliances import Kernel
from flatpunch.contact.boundary_elements import error as cell_error
from flatpunch.contact.boundary_elements.expected_box import traced_whole
from flatpunch.contact.boundary_elements.outlines import Trace, traced
from flatpunch.contact.curve import Control, Curve, Extra, PressureField, first_failure
from flatpunch.contact.limits import cut_off, steep_faces
from flatpunch.contact.perturbation.error import estimates
from flatpunch.indenters.profile import Indenter, check_rising

TOLERANCE = 1e-6
"""Default gap error over the depth; ten times as much leaves 1e-5 of the force."""


def solve(
    kernel: Kernel,
    indenter: Indenter,
    control: Control,
    phi: Array,
    *,
    grid: bem.Grid | int | None = None,
    tolerance: float | None = None,
    limit: int = 1000,
    fields: bool = False,
    single: bool = False,
    progress: bool | Report | None = None,
) -> Curve:
    """A whole curve; steps that are close share a grid, others are solved side by side where there are several cores.

    Parameters
    ----------
    kernel, indenter, control, phi
        Medium, indenter, prescribed depths or forces, and polar angles of the outline.
    grid : Grid or int, optional
        One grid for all steps, or cells per side (256) of a grid fitted to each contact.
    tolerance : float
        Largest gap error in contact and penetration outside it, relative to the depth: 1e-6, or 1e-5 in single precision.
    limit : int
        Largest number of iterations on one grid; a step that needs more is marked in `valid` and `notes`.
    fields : bool
        Whether to return pressure(step, y, x), displacement and contact; they then share one grid, that of the largest
        contact.
    single : bool
        Single precision: half the memory.
    progress : bool or callable, optional
        True shows a bar; a function is called with (steps done, steps in all).
    """
    live = _live(indenter, control)
    targets = control.values[live]
    if tolerance is None:
        tolerance = SINGLE_FLOOR if single else TOLERANCE
    if fields and targets.size and not isinstance(grid, bem.Grid):
        grid = _solutions(kernel, indenter, control.name, targets.max()[None], grid, tolerance, single, limit=limit)[
            0
        ].grid
    rays = enough_rays(phi.size)

    def solved(some: Array, **options: object) -> list[bem.Solution]:
        return _solutions(
            kernel, indenter, control.name, some, grid, tolerance, single, rays, limit=limit, stiffness=True, **options
        )

    def with_outline(target: float, solution: bem.Solution) -> tuple[bem.Solution, Trace]:
        if isinstance(grid, bem.Grid):
            return solution, traced(kernel, indenter, solution, rays)
        return traced_whole(kernel, indenter, solution, rays, lambda **box: solved(np.array([target]), **box)[0])

    traces = []
    with reporting("Boundary elements", progress) as report:
        found = solved(targets, progress=report)
    for step, (target, solution) in enumerate(zip(targets, found, strict=True)):
        found[step], trace = with_outline(target, solution)
        traces.append(trace)
    rows = np.flatnonzero(live)

    def collect(name: str) -> Array:
        values = np.zeros(control.values.size)
        values[rows] = [getattr(solution, name) for solution in found]
        return values

    contour = np.zeros((control.values.size, phi.size))
    radius, area = np.zeros(control.values.size), np.zeros(control.values.size)
    for row, trace in zip(rows, traces, strict=True):
        contour[row], radius[row], area[row] = trace.contour[:: rays // phi.size], trace.radius, trace.area
    converged, inside = np.ones((2, control.values.size), dtype=bool)
    converged[rows] = [solution.converged for solution in found]
    slope, rising, height = np.zeros(control.values.size), indenter.rising, IndenterHeight(indenter)
    if not rising or indenter.cut:
        heights = [height(solution.grid) for solution in found]
        ended = [reaches_end(each, solution.contact) for each, solution in zip(heights, found, strict=True)]
        inside[rows] = ~np.array(ended, dtype=bool)
        slope[rows] = [_mean_slope(each, solution) for each, solution in zip(heights, found, strict=True)]
    force_error, contour_error = np.zeros((2, control.values.size))
    if found:
        force_error[rows], across = _errors(found, traces, indenter)
        contour_error[rows] = cell_error.along_rays(across, contour[rows])
    extra: Extra = {
        **estimates(force_error, contour_error),
        "gap_error": (("step",), collect("gap_error"), "1", "largest gap in contact over the depth"),
        "patches": (("step",), collect("patches").astype(int), "1", "number of separate parts of the contact"),
        "penetration": (
            ("step",),
            collect("penetration"),
            "1",
            "largest penetration outside the contact over the depth",
        ),
    }
    depth = collect("depth")
    # a tip with edges or several parts is described by its cells, not by the rays of an outline
    sound = converged & (cell_error.located(contour_error) | (not rising))
    notes = tuple(dict.fromkeys(note for solution in found for note in solution.notes))
    if np.isnan(contour).any():
        notes += ("Where the contact has no outline the radius is the mean length of its rays in contact.",)
    return Curve(
        depth=depth,
        force=collect("force"),
        radius=radius,
        area=area,
        stiffness=collect("stiffness"),
        contour=contour,
        valid=sound & (inside | (not indenter.cut)),
        notes=notes
        + (() if rising else steep_faces(slope, depth))
        + (cut_off(indenter, contour, phi, depth) if not indenter.cut else ())
        + first_failure(~inside, depth, _at_end(indenter)),
        extra={**extra, **(_fields(found, rows, control.values.size) if fields and found else {})},
    )


def _mean_slope(height: Array, solution: bem.Solution) -> float:
    if not solution.contact.any():
        return 0.0
    with np.errstate(invalid="ignore"):
        slopes = np.hypot(*np.gradient(np.where(np.isfinite(height), height, np.nan), solution.grid.spacing))
    known = slopes[solution.contact & np.isfinite(slopes)]
    return float(known.mean()) if known.size else 0.0


def _at_end(indenter: Indenter) -> str:
    if indenter.cut:
        return "the contact reaches the border of the map, beyond which the tip is not known. Ask for less depth."
    return "the contact reaches the end of the tip, which presses like the edge of a punch there."


def pressure(
    kernel: Kernel,
    indenter: Indenter,
    control: Control,
    r: Array,
    phi: Array,
    *,
    grid: bem.Grid | int | None = None,
    tolerance: float | None = None,
    limit: int = 1000,
    single: bool = False,
) -> PressureField:
    """Pressure at polar coordinates (r, phi), shape (n,) [Pa], interpolated linearly between cell centres.

    The error is that of interpolation between cells twice as wide, and the difference to a contact solved on such cells.
    """
    if not _live(indenter, control).any():
        return PressureField(np.zeros_like(r), np.zeros_like(r))
    if tolerance is None:
        tolerance = SINGLE_FLOOR if single else TOLERANCE

    def solved(cells: bem.Grid | int | None) -> bem.Solution:
        return _solutions(kernel, indenter, control.name, control.values, cells, tolerance, single, limit=limit)[0]

    fine = solved(grid)
    # room for a contact that is a cell wider
    nx, ny = (max((n + 1) // 2 + 2, FEWEST) for n in (fine.grid.nx, fine.grid.ny))
    coarse = solved(bem.Grid(nx, ny, 2 * fine.grid.spacing, fine.grid.center))
    points = np.column_stack([r * np.sin(phi), r * np.cos(phi)])
    values = _between(fine.grid, fine.pressure)(points)
    difference = np.abs(values - _between(coarse.grid, coarse.pressure)(points))
    return PressureField(values, difference + _between(fine.grid, _interpolation_error(fine.pressure))(points))


def _between(grid: bem.Grid, field: Array) -> scipy.interpolate.RegularGridInterpolator:
    """Linear interpolation between the centres of cells, zero outside."""
    field = np.asarray(field, dtype=float)
    return scipy.interpolate.RegularGridInterpolator((grid.y, grid.x), field, bounds_error=False, fill_value=0.0)


def _interpolation_error(field: Array) -> Array:
    """Error of linear interpolation between the centres of cells twice as wide, the largest of a cell and its four neighbours.

    Those along x and along y are added as squares: where the field is harmonic, as near the apex of a tilted cone, they are
    equal and opposite.
    """
    # a quarter of a wide cell from its centre, (h/2)(3h/2)/2 = 3/8 h^2 times the second derivative
    along_y, along_x = (scipy.ndimage.convolve1d(field, [1, -2, 1], axis=i, mode="constant") for i in (0, 1))
    cross = scipy.ndimage.generate_binary_structure(2, 1)
    return np.asarray(scipy.ndimage.maximum_filter(3 / 8 * np.hypot(along_y, along_x), footprint=cross))


def _live(indenter: Indenter, control: Control) -> Flags:
    if control.name == "radius":
        check_rising(indenter)
        raise ValueError(
            "radius cannot control method='bem': the contact is found from the depth or the force. Give one of them "
            "(method='refined' or 'second-order' takes a mean radius and returns the depth)."
        )
    return control.values > 0


def _solutions(
    kernel: Kernel,
    indenter: Indenter,
    name: str,
    targets: Array,
    grid: bem.Grid | int | None,
    tolerance: float,
    single: bool,
    angles: int = 360,
    *,
    limit: int = 1000,
    **options: Any,
) -> list[bem.Solution]:
    if not targets.size:
        return []
    return bem.solve(
        kernel,
        indenter,
        depths=targets if name == "depth" else None,
        forces=targets if name == "force" else None,
        grid=grid,
        tolerance=tolerance,
        limit=limit,
        single=single,
        angles=angles,
        **options,
    )


def _errors(found: list[bem.Solution], traces: list[Trace], indenter: Indenter) -> tuple[Array, Array]:
    """Estimated relative errors of the forces, and of the outlines across them, over the mean radius."""
    force = np.array([cell_error.own_error(solution, indenter) for solution in found])
    measured = np.isfinite([solution.coarser_force for solution in found])
    # steps that start from the previous one have no solution on wider cells
    latest = np.maximum.accumulate(np.where(measured, np.arange(force.size), 0))
    return np.maximum(force, force[latest]), np.array([trace.error for trace in traces])


def _fields(found: list[bem.Solution], rows: Indices, steps: int) -> Extra:
    grid = found[0].grid
    shape = (steps, grid.y.size, grid.x.size)
    pressure, displacement, contact = np.zeros(shape), np.zeros(shape), np.zeros(shape, dtype=bool)
    for row, solution in zip(rows, found, strict=True):
        pressure[row], displacement[row], contact[row] = solution.pressure, solution.displacement, solution.contact
    dims = ("step", "y", "x")
    return {
        "x": (("x",), grid.x, "m", "cell centres along x"),
        "y": (("y",), grid.y, "m", "cell centres along y"),
        "pressure": (dims, pressure, "Pa", "contact pressure"),
        "displacement": (dims, displacement, "m", "inward displacement of the surface"),
        "contact": (dims, contact, "1", "cells in contact"),
    }
