"""Outline, mean radius and area of a boundary element solution.

An edge of the tip draws the contact out. The outermost part of the contact along an edge, where either side of the edge is less
than a quarter of the mean radius wide, is called a lobe. A lobe ends in a point that is narrower than a cell over several
cells, which carry no pressure, so that the contact of the cells ends too early. Each lobe is therefore solved once more, on
cells a sixth as wide, of which up to seven are missing at its end. The estimated error there is one cell of the whole grid.

Elsewhere the outline is that of bem.outline, whose estimated error is the distance between the rim of the pressure and that of
the cells. Area and mean radius of contacts with lobes are sums over cells, over the finer ones where there are such.

In the window of the finer cells the pressure outside is kept. The displacement in the window under the pressure outside is the
known displacement less that under the pressure inside. It is smooth, so that it is interpolated to the finer cells. The contact
on these is solved against it. Correcting the pressure outside afterwards would change little: the load along a lobe from 256
cells with a window agrees with that from 2048 to one per cent.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import label, map_coordinates

from flatpunch import bem
from flatpunch._support.checks import Array
from flatpunch.bem.grid import Grid, Mask, polar
from flatpunch.bem.height import IndenterHeight
from flatpunch.bem.operator.convolution import Operator, build_operator
from flatpunch.bem.outline import covered, ray_lengths, read, rim_along, why_none
from flatpunch.bem.solver.active_set import solve_contact
from flatpunch.compliances import Kernel
from flatpunch.indenters.geometry.features import mirrored_about, place_of, wedges_of
from flatpunch.indenters.profile import Indenter


def solve_closer(
    kernel: Kernel,
    indenter: Indenter,
    solution: bem.Solution,
    operator: Operator,
    grid: Grid,
    angle: float,
    *,
    even: bool,
) -> tuple[Array, bool]:
    """Pressure on a finer grid whose axes are turned by an angle [rad], shape (ny, nx) [Pa], and whether it converged.

    `solution` is the contact on the whole grid and `operator` the displacement from pressure there. `even` says that indenter and
    contact are their own mirror images about the turned x axis, on which the grid is centred then.
    """
    inner = grid.folded((False, even))
    new = (inner.x[None, :] + 1j * inner.y[:, None]) * np.exp(1j * angle)
    wide = solution.grid
    old = (wide.x[None, :] + 1j * wide.y[:, None]) * np.exp(-1j * angle)
    replaced = _within(old.real, grid.x, grid.spacing) & _within(old.imag, grid.y, grid.spacing)
    own = np.where(replaced, solution.pressure, 0.0) / kernel.modulus
    imposed = solution.displacement - operator.apply(own) * wide.spacing
    places = [(new.imag - wide.y[0]) / wide.spacing, (new.real - wide.x[0]) / wide.spacing]
    elsewhere = map_coordinates(imposed, places, order=3, mode="nearest")
    height = IndenterHeight(indenter).at(*polar(new.real, new.imag))
    finer = build_operator(kernel, inner).single()
    # gap error over the depth; with ten times as much the ends of lobes come and go by 3 % of the mean radius
    state = solve_contact(
        finer,
        finer.asarray((height + elsewhere) / grid.spacing),
        solution.depth / grid.spacing,
        start=finer.asarray(np.maximum(map_coordinates(own, places, order=1, mode="nearest"), 0.0)),
        inner=finer,
        tolerance=1e-5,
    )
    return inner.unfold(np.asarray(state.pressure * kernel.modulus)), state.converged


def _within(values: Array, centres: Array, spacing: float) -> Mask:
    return np.asarray((values > centres[0] - spacing / 2) & (values < centres[-1] + spacing / 2))


_WIDTH = 0.25
"""Half-width over the mean radius below which the contact along an edge is a lobe; twice as much solves four times the cells."""

_ROOT = 2
"""Cells at the beginning of a window that do not count, as the fixed cells disturb them; twice as many lose short lobes."""


@dataclass(frozen=True, slots=True)
class Trace:
    """Outline of one solution.

    Attributes
    ----------
    contour : ndarray, shape (angles,)
        a(phi) [m] at equal angles from 0, the farthest point in contact; NaN where the contact has no outline.
    radius, area : float
        Mean length of the rays in contact [m] and contact area [m^2].
    error : float
        Estimated error of the contour over the mean radius; infinite where the contact has no outline.
    """

    contour: Array
    radius: float
    area: float
    error: float


@dataclass(frozen=True, slots=True)
class _Lobe:
    """A lobe on finer cells.

    Attributes
    ----------
    angle : float
        Polar angle of the edge [rad].
    wedge : float
        Tangent of half the angle to the next edge.
    grid : Grid
        The finer cells, x along the edge.
    pressure : ndarray, shape (ny, nx)
        Their pressure [Pa].
    start : float
        Distance from the point of first touch at which the window begins [m].
    coarse : float
        Spacing of the cells around it [m].
    converged : bool
        Whether the solution on the finer cells was found.
    """

    angle: float
    wedge: float
    grid: Grid
    pressure: Array
    start: float
    coarse: float
    converged: bool

    def share(self, grid: Grid, turn: float = 0.0) -> Array:
        """Weight of the finer cells, 0 before the window and 1 in it, at the cells of a grid with x axis at the angle `turn`."""
        x, y = grid.x[None, :], grid.y[:, None]
        along = np.cos(self.angle - turn) * x + np.sin(self.angle - turn) * y
        across = np.cos(self.angle - turn) * y - np.sin(self.angle - turn) * x
        inside = np.abs(across) < np.minimum(self.grid.ny * self.grid.spacing / 2, self.wedge * along)
        return np.asarray(np.clip((along - self.start) / (_ROOT * self.coarse) - 1, 0.0, 1.0) * inside)

    def whole(self) -> bool:
        """Whether the contact was found, and in one part where the finer cells count."""
        counted = (self.pressure > 0) & (self.share(self.grid, self.angle) > 0)
        return self.converged and int(label(counted, np.ones((3, 3)))[1]) == 1


def traced(kernel: Kernel, indenter: Indenter, solution: bem.Solution, angles: int) -> Trace:
    """Outline of a boundary element solution at `angles` polar angles, with mean radius, area and error estimate."""
    grid, outline, contact = solution.grid, solution.outline, solution.pressure > 0
    lobes = _lobes(kernel, indenter, solution) if contact.any() else []
    if not lobes and np.isfinite(outline.radius):
        return Trace(outline.contour, outline.radius, outline.area, outline.error / outline.radius)
    weight = covered(contact)
    for lobe in lobes:
        weight = weight * (1 - lobe.share(grid))
    radius, area = float(np.sum(weight * ray_lengths(grid))), float(weight.sum()) * grid.cell_area
    for lobe in lobes:
        weight = covered(lobe.pressure > 0) * lobe.share(lobe.grid, lobe.angle)
        radius += float(np.sum(weight * ray_lengths(lobe.grid)))
        area += float(weight.sum()) * lobe.grid.cell_area
    contour, error = _contour(kernel, solution, lobes, angles)
    return Trace(contour, radius, area, error / radius if radius else np.inf)


def _contour(kernel: Kernel, solution: bem.Solution, lobes: list[_Lobe], angles: int) -> tuple[Array, float]:
    """a(phi) [m] and its estimated error [m]; NaN and infinity where the contact has several parts or holes."""
    grid, rim, phi = solution.grid, (1 + kernel.exponent) / 2, 2 * np.pi * np.arange(angles) / angles
    rest = solution.pressure.copy()
    for lobe in lobes:
        rest[lobe.share(grid) == 1] = 0.0
    if why_none(grid, rest > 0) or not all(lobe.whole() for lobe in lobes):
        return np.full(angles, np.nan), np.inf
    # in the corners beside a lobe the pressure follows no root law: believed up to a cell, its rim was off by 1.5
    farthest = 0.7 if lobes else 1.0
    contour, moved = rim_along(grid, rest, phi, rim, length=kernel.surface_length, farthest=farthest)
    # the ends of lobes
    error = max(float(moved.max()), grid.spacing * bool(lobes))
    for lobe in lobes:
        turn = np.mod(phi - lobe.angle + np.pi, 2 * np.pi) - np.pi
        ahead = np.flatnonzero(np.abs(turn) < np.arctan(lobe.wedge))
        found, _ = rim_along(lobe.grid, lobe.pressure, turn[ahead], rim, length=kernel.surface_length)
        met = found * np.cos(turn[ahead]) > lobe.start + 1.5 * _ROOT * lobe.coarse
        contour[ahead[met]] = found[met]
    return contour, error


def _lobes(kernel: Kernel, indenter: Indenter, solution: bem.Solution) -> list[_Lobe]:
    """Lobes along all edges; of those that turning the tip carries into each other one is solved."""
    edges = wedges_of(indenter)
    if not edges:
        return []
    mean = float(np.sum(covered(solution.pressure > 0) * ray_lengths(solution.grid)))
    operator = build_operator(kernel, solution.grid, solving=False)
    solved: dict[float, _Lobe | None] = {}
    found = []
    for angle, wedge in edges:
        place = place_of(indenter, angle)
        if place not in solved:
            solved[place] = _lobe(kernel, indenter, solution, operator, angle, wedge, mean)
        lobe = solved[place]
        if lobe is not None:
            found.append(replace(lobe, angle=angle))
    return found


def _lobe(
    kernel: Kernel,
    indenter: Indenter,
    solution: bem.Solution,
    operator: Operator,
    angle: float,
    wedge: float,
    mean: float,
) -> _Lobe | None:
    """The lobe along one edge; None where the contact has none that is long enough."""
    grid, contact = solution.grid, (solution.pressure > 0).astype(float)
    h, widest = grid.spacing, _WIDTH * mean + grid.spacing
    x = h * np.arange(1, int(np.hypot(grid.nx, grid.ny)))
    y = h / 2 * np.arange(1 - int(2 * widest / h), int(2 * widest / h))
    known = read(grid, contact, (x[:, None] + 1j * y) * np.exp(1j * angle)) >= 0.5
    # half-width of either side, without what is apart from the edge
    sides = known[:, y >= 0], known[:, y <= 0][:, ::-1]
    half = h / 2 * np.maximum.reduce([np.logical_and.accumulate(side, axis=1).sum(axis=1) for side in sides])
    wide = np.flatnonzero(half > np.minimum(_WIDTH * mean, wedge * x))
    start = x[wide[-1]] if wide.size else mean / 2
    beside = known[:, np.abs(y) < 1.5 * h].any(axis=1)
    last = x[beside].max(initial=0.0)
    if last < start + 2 * _ROOT * h:
        return None
    # finer cells per cell along an axis; half as many double the error at the ends of lobes
    fine = h / 6
    ny = 2 * int(np.ceil((half[x >= start - h].max() + 2 * h) / fine))
    nx = int((_edge(grid, angle) - start) / fine)
    window = Grid(nx, ny, fine, (start + nx * fine / 2, 0.0))
    pressure, converged = solve_closer(
        kernel, indenter, solution, operator, window, angle, even=mirrored_about(indenter, angle)
    )
    return _Lobe(angle, wedge, window, pressure, float(start), h, converged)


def _edge(grid: Grid, angle: float) -> float:
    """Distance from the point of first touch at which a ray leaves the grid [m]."""
    sides = ((np.cos(angle), grid.x), (np.sin(angle), grid.y))
    with np.errstate(divide="ignore"):
        return float(min(max(v[[0, -1]] / np.float64(u)) for u, v in sides))
