"""Bounding box of the contact: estimated from the tip, then found on a coarse grid that is moved, grown and shrunk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from flatpunch._support.checks import LARGEST, SMALLEST, Array, BadValue, numbers, positive, values
from flatpunch._support.prefixes import text
from flatpunch.bem.grid import Cells, Grid, Height, Mask
from flatpunch.bem.solver.active_set import State
from flatpunch.bem.solver.levels import Levels
from flatpunch.bem.solver.nested import Effort, Rough, solve_depth, solve_force
from flatpunch.compliances import Kernel
from flatpunch.indenters.profile import Indenter

SETTLED = 0.1
"""Relative change of the box below which it is accepted, and free rim that it needs; with half, narrow contacts take one grid
more."""

_SHRINK, _GROW = 8, 1.5
"""Factors of the box where nothing touches, and where the contact touches the edge of the grid."""


@dataclass(frozen=True, slots=True)
class Extent:
    """Bounding box of a contact [m], and the contact on the coarse cells that it was found on."""

    half_widths: tuple[float, float]
    center: tuple[float, float]
    rough: Rough | None = field(default=None, repr=False, compare=False)

    def grid(self, cells: int, **prescribed: float | None) -> Grid:
        """Grid around it, with a free rim of a quarter of its half-widths; messages name the depth or force prescribed."""
        for width in self.half_widths:
            if not cells * SMALLEST <= width <= LARGEST:
                raise ValueError(
                    f"{_asked(**prescribed)}: the contact would be {2 * width:.1g} m wide, beyond what can be computed. "
                    "Check the shape of the tip and the units, or prescribe more."
                )
        return Grid.around(self.half_widths, cells, center=self.center)

    def fits(self, grid: Grid) -> bool:
        """Whether `grid` holds it with a rim of at least a tenth, and it fills at least six tenths of that grid."""
        for width, centre, cells, middle in zip(
            self.half_widths, self.center, (grid.nx, grid.ny), grid.center, strict=True
        ):
            half = cells * grid.spacing / 2
            if abs(centre - middle) + (1 + SETTLED) * width > half or width < 0.6 * half:
                return False
        return True


def expected_extents(half_widths: ArrayLike | None, centers: ArrayLike | None, steps: int) -> list[Extent | None]:
    """Boxes of contacts as they are expected, one for each step; None for those that are not known."""
    given = {"half_widths": half_widths, "centers": (0.0, 0.0) if centers is None else centers}
    pairs = {name: numbers(name, value, "m") for name, value in given.items() if value is not None}
    for name, found in pairs.items():
        if found.shape not in ((2,), (1, 2), (steps, 2)):
            raise BadValue(name, "", f"has shape {found.shape}; it must have a pair along x and y for each step.")
    values("centers", pairs["centers"].ravel(), minimum=-np.inf, unit="m")
    if "half_widths" not in pairs:
        return [None] * steps
    boxes, middles = (np.broadcast_to(found, (steps, 2)).tolist() for found in pairs.values())
    # boxes that are not known are no numbers, or zero
    return [
        Extent((positive("half_widths", wx, unit="m"), positive("half_widths", wy, unit="m")), (cx, cy))
        if wx > 0 and wy > 0
        else None
        for (wx, wy), (cx, cy) in zip(boxes, middles, strict=True)
    ]


class ContactTouchesEdge(ValueError):
    """The contact does not fit on the grid; the message says how large the grid must be.

    See Also
    --------
    flatpunch.bem.solve : Raises it.

    Examples
    --------
    >>> from flatpunch import bem
    >>> kernel = fp.compliance(fp.HalfSpace(young=1e6, poisson=0.3))
    >>> try:
    ...     bem.solve(kernel, fp.Paraboloid(radius=1e-3), depths=1e-5, grid=bem.Grid(nx=32, ny=32, spacing=1e-6))
    ... except bem.ContactTouchesEdge:
    ...     print("a larger grid is needed")
    a larger grid is needed
    """


class NotConverged(ValueError):
    """Not even the coarse solution that looks for the contact converges; the message says for which contact.

    See Also
    --------
    flatpunch.bem.solve : Raises it.

    Examples
    --------
    >>> from flatpunch.bem import NotConverged
    >>> issubclass(NotConverged, ValueError)  # caught with what else cannot be solved
    True
    """


def bounding_box(grid: Grid, contact: Mask) -> Extent:
    """Bounding box of the cells in contact."""
    rows, columns = np.flatnonzero(contact.any(axis=1)), np.flatnonzero(contact.any(axis=0))
    h = grid.spacing
    x, y = grid.x[columns], grid.y[rows]
    return Extent(
        ((x[-1] - x[0] + h) / 2, (y[-1] - y[0] + h) / 2),
        (float(x[-1] + x[0]) / 2, float(y[-1] + y[0]) / 2),
    )


def touches_edge(contact: Mask) -> bool:
    """Whether a cell of the outermost ring is in contact."""
    return bool(np.count_nonzero(contact) > np.count_nonzero(contact[1:-1, 1:-1]))


def find_extent(
    kernel: Kernel, height: Height, first: Extent, *, depth: float | None = None, force: float | None = None
) -> Extent:
    """Bounding box of the contact at one depth [m] or force [N], to about a twentieth of its size.

    The search begins at `first`, of any order of magnitude. NotConverged if a coarse solution does not converge, since the box
    of its contact means nothing; ContactTouchesEdge if no bounded contact is found.
    """
    asked = _asked(depth, force)
    extent = first
    # half as many attempts find no box from a first one that is 1e9 times too large
    attempts = 60
    for _ in range(attempts):
        # half or twice as many cells find boxes that change the force by 1e-4
        grid = extent.grid(48, depth=depth, force=force)
        pressure = _coarse_pressure(kernel, height, grid, asked, depth, force)
        contact = pressure > 0
        if not contact.any():
            extent = Extent((extent.half_widths[0] / _SHRINK, extent.half_widths[1] / _SHRINK), extent.center)
            continue
        box = bounding_box(grid, contact)
        if touches_edge(contact):
            wx, wy = (cells * grid.spacing / 2 * _GROW for cells in (grid.nx, grid.ny))
            extent = Extent((wx, wy), extent.center)
            continue
        before, extent = extent, _recentred(box, grid)
        if _filled(box, grid) or _settled(before, extent, grid.spacing):
            return replace(extent, rough=Rough(grid, pressure))
    raise ContactTouchesEdge(
        f"No bounded contact was found for {asked} in {attempts} attempts. Check the units, ask for less, or give a grid."
    )


def _asked(depth: float | None = None, force: float | None = None) -> str:
    return f"depth = {text(depth, 'm')}" if depth is not None else f"force = {text(force or 0.0, 'N')}"


def grown(grid: Grid, contact: Mask) -> Grid:
    """The grid with half as many cells again along each axis whose ends the contact touches."""
    beside = bool(contact[:, 0].any() or contact[:, -1].any())
    above = bool(contact[0].any() or contact[-1].any())
    nx, ny = (n + 2 * (n // 4) + 2 if touched else n for n, touched in ((grid.nx, beside), (grid.ny, above)))
    return Grid(nx, ny, grid.spacing, grid.center)


def _filled(box: Extent, grid: Grid) -> bool:
    """Whether the box takes nearly half of the grid along both axes, so that it is resolved well enough."""
    return all(
        2 * width > 0.45 * cells * grid.spacing
        for width, cells in zip(box.half_widths, (grid.nx, grid.ny), strict=True)
    )


def _settled(before: Extent, now: Extent, spacing: float) -> bool:
    """Whether a finer grid no longer changes the box by more than a cell: narrow contacts never fill a grid across."""
    return all(abs(w - v) < max(SETTLED * v, spacing) for v, w in zip(before.half_widths, now.half_widths, strict=True))


def _recentred(box: Extent, grid: Grid) -> Extent:
    """The box, with its centre taken as the origin when it is there to within a cell."""
    center = tuple(0.0 if abs(c) <= grid.spacing else c for c in box.center)
    shifted = [abs(c) for c in box.center]
    widths = tuple(w + (s if c == 0.0 else 0.0) for w, s, c in zip(box.half_widths, shifted, center, strict=True))
    return Extent((widths[0], widths[1]), (center[0], center[1]))


def _coarse_pressure(
    kernel: Kernel, height: Height, grid: Grid, asked: str, depth: float | None, force: float | None
) -> Array:
    if depth is not None and not (height(grid) < depth).any():
        return np.zeros(grid.shape)
    # gap error over the depth: the rim is known to a cell anyway
    tolerance = 1e-3
    # 932 contacts on bodies with modulus ratios up to 10 000 took at most 134 iterations
    limit = 300
    state, _ = solve_at(Levels(kernel, grid), height, tolerance, limit, depth=depth, force=force)
    if not state.converged:
        raise NotConverged(
            f"{asked}: boundary elements do not converge on this body, even on {grid.nx} x {grid.ny} cells of "
            f"{text(grid.spacing, 'm')}: its compliance differs too much between the size of the contact and that of a cell. "
            "Check the units, ask for a smaller contact, or take method='second-order'."
        )
    return np.asarray(state.pressure)


def solve_at(
    levels: Levels,
    height: Height,
    tolerance: float,
    limit: int,
    start: Cells = None,
    *,
    rough: Rough | None = None,
    depth: float | None = None,
    force: float | None = None,
) -> tuple[State, Effort]:
    """Contact at a depth [m] or a force [N]; what is known of it, `start` or `rough`, is of use at a depth only."""
    if depth is not None:
        return solve_depth(levels, height, depth, tolerance, limit, start, rough=rough)
    assert force is not None
    guess = _typical_depth(height, levels.grid, force / levels.kernel.modulus)
    return solve_force(levels, height, force, guess, tolerance, limit)


def _typical_depth(height: Height, grid: Grid, compliance: float) -> float:
    """A depth [m] of the order at which the contact covers a part of the grid; `compliance` is F/E* [m^2]."""
    heights = height(grid)
    finite = heights[np.isfinite(heights)]
    if finite.size == 0:
        raise ValueError("The indenter has no surface on this grid. Centre the grid on the indenter, or enlarge it.")
    median = float(np.median(finite))
    return median if median > 0 else compliance / (grid.spacing * min(grid.shape))


def overlap_half_widths(indenter: Indenter, depth: float) -> tuple[float, float]:
    """Half-widths of the bounding box of f < depth about the origin [m]: where the tip would cut a rigid surface."""
    phi = _directions()
    radii = _crossing(lambda r, phi: _finite(indenter, r, phi) - depth, indenter.reach_along(phi), phi)
    return float(np.max(np.abs(radii * np.cos(phi)))), float(np.max(np.abs(radii * np.sin(phi))))


def loaded_half_widths(indenter: Indenter, force: float, modulus: float) -> tuple[float, float]:
    """Half-widths of the box where force ~ modulus x radius x height [m]: the order of a half-space's contact."""
    phi = _directions()

    def mean_height(r: Array) -> Array:
        return np.asarray(np.broadcast_to(_finite(indenter, r[..., None], phi), (*r.shape, phi.size)).mean(axis=-1))

    typical = _crossing(lambda r: modulus * r * mean_height(r) - force, np.array(indenter.reach))
    depth = float(mean_height(typical))
    return overlap_half_widths(indenter, depth) if depth > 0 else (float(typical), float(typical))


def _finite(indenter: Indenter, r: Array, phi: Array) -> Array:
    """Heights, a face of 45 degrees where the indenter has no surface."""
    height = np.asarray(indenter.height(r, phi))
    return np.where(np.isinf(height), r, height)


def _directions() -> Array:
    # with half as many directions the box of a narrow tip is 1 % too small
    return np.linspace(0, 2 * np.pi, 64, endpoint=False)


def _crossing(excess: Callable[..., Array], reach: Array, *arguments: Array) -> Array:
    """Radii at which increasing functions change sign, to a thousandth, at most the reach; of the shape of `reach`."""
    from scipy.optimize import elementwise

    start = np.minimum(1.0, reach)
    found = elementwise.bracket_root(excess, start / 2, start, xmin=0.0, xmax=reach, args=arguments)
    root = elementwise.find_root(excess, found.bracket, args=arguments, tolerances={"xrtol": 1e-3})
    return np.where(root.success, root.x, reach)
