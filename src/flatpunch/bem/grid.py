"""Grid of square cells on which pressure and gap are sampled.

Cell (i, j) is centred at x = center[0] + (j - (nx - 1)/2) spacing, y alike with i: arrays are indexed [y, x]. With
even numbers of cells the grid's centre is a corner of four cells, so the tip of a cone or pyramid is not sampled itself.

A contact that is its own mirror image is solved on one half of such a grid, or one quarter: see `Grid.folded`. `IndenterHeight`
is the indenter as the solver sees it, its heights on a grid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flatpunch._support.checks import (
    CELLS,
    FEWEST,
    Array,
    BadValue,
    follows,
    instance,
    non_negative,
    numbers,
    point,
    positive,
    shown,
    switch,
    whole,
)
from flatpunch._support.readable import readable
from flatpunch.indenters.profile import Indenter

Mask = NDArray[np.bool_]

Cells = Any
"""Array of NumPy or of another library that follows the array API standard (PyTorch, JAX, CuPy); these share no class."""

Namespace = Any
"""Module of such a library, with the functions of the array API standard."""


@readable
@dataclass(frozen=True, slots=True)
class Grid:
    """Rectangle of equal square cells.

    Parameters
    ----------
    nx, ny : int
        Number of cells along x and y, at least 8.
    spacing : float
        Side of a cell [m], > 0.
    center : (float, float)
        Coordinates of the grid's centre [m]; the indenter first touches at the origin.
    mirrored : (bool, bool)
        Whether the arrays hold the cells at positive x (y) only, all else being mirror images. Such a grid is centred at zero
        along that axis, and nx (ny) counts the cells it holds.

    See Also
    --------
    flatpunch.bem.solve : Takes it.
    flatpunch.bem.required_bytes : The memory that it needs.

    Examples
    --------
    >>> from flatpunch import bem
    >>> grid = bem.Grid(nx=128, ny=64, spacing=10e-9)
    >>> print(grid.x.shape, grid.y.shape)
    (128,) (64,)
    """

    nx: int
    ny: int
    spacing: float
    center: tuple[float, float] = (0.0, 0.0)
    mirrored: tuple[bool, bool] = (False, False)

    def __post_init__(self) -> None:
        if not follows(self.mirrored, tuple, list) or len(self.mirrored) != 2:
            raise TypeError(
                f"Grid.mirrored = {shown(self.mirrored)} must be a pair of True or False, one for each axis."
            )
        pair = tuple(switch("Grid.mirrored", each) for each in self.mirrored)
        object.__setattr__(self, "mirrored", pair)
        for name, mirrored in zip(("nx", "ny"), self.mirrored, strict=True):
            least = -(-FEWEST // (1 + mirrored))
            hint = "It is the number of cells along an axis."
            # most cells along one axis: grids along narrow contacts are long; their product is limited as that of square ones
            object.__setattr__(self, name, whole(f"Grid.{name}", getattr(self, name), least, hint, most=16 * CELLS))
        if self.nx * self.ny > CELLS**2:
            raise BadValue(
                "Grid.nx",
                f"{self.nx}",
                f"times Grid.ny = {self.ny} is more than {CELLS} x {CELLS} cells, the most that are solved. Take "
                "wider cells, or a smaller grid.",
            )
        object.__setattr__(self, "spacing", positive("Grid.spacing", self.spacing, unit="m"))
        object.__setattr__(self, "center", point("Grid.center", self.center, "m"))

    @classmethod
    def around(
        cls,
        half_widths: tuple[float, float],
        cells: int = 256,
        *,
        margin: float = 0.25,
        center: tuple[float, float] = (0.0, 0.0),
    ) -> Grid:
        """Grid around a contact of the given half-widths.

        Parameters
        ----------
        half_widths : (float, float)
            Half-widths of the contact's bounding box along x and y [m].
        cells : int
            About the square root of the number of cells: a contact of 4:1 gets 2 cells x cells/2.
        margin : float
            Free rim on each side, in units of the half-width, and at least three cells.
        center : (float, float)
            Centre of the bounding box [m].
        """
        wx, wy = (
            positive(f"half_widths[{i}]", w, unit="m") for i, w in enumerate(point("half_widths", half_widths, "m"))
        )
        margin = non_negative("margin", margin, "It is the free rim, in units of the half-width.", unit="1")
        if margin > 100:
            raise BadValue(
                "margin", repr(margin), "must be 100 or less: it is the free rim, in units of the half-width."
            )
        cells = whole("cells", cells, FEWEST, "It is the square root of the number of cells.", most=CELLS)
        wx, wy = wx * (1 + margin), wy * (1 + margin)
        spacing = 2 * np.sqrt(wx * wy) / cells
        nx, ny = (max(_even(2 * w / spacing), _even(2 * w / ((1 + margin) * spacing) + 6)) for w in (wx, wy))
        return cls(max(nx, FEWEST), max(ny, FEWEST), spacing, center)

    @property
    def shape(self) -> tuple[int, int]:
        """(ny, nx), the shape of arrays on the grid."""
        return self.ny, self.nx

    @property
    def cell_area(self) -> float:
        """Area of a cell [m^2]."""
        return self.spacing**2

    @property
    def x(self) -> Array:
        """Cell centres along x [m], shape (nx,)."""
        first = 0.5 if self.mirrored[0] else -(self.nx - 1) / 2
        return np.asarray(self.center[0] + (np.arange(self.nx) + first) * self.spacing)

    @property
    def y(self) -> Array:
        """Cell centres along y [m], shape (ny,)."""
        first = 0.5 if self.mirrored[1] else -(self.ny - 1) / 2
        return np.asarray(self.center[1] + (np.arange(self.ny) + first) * self.spacing)

    @property
    def polar(self) -> tuple[Array, Array]:
        """Radii [m] and polar angles in [0, 2 pi) of the cell centres, shape (ny, nx)."""
        return polar(self.x[None, :], self.y[:, None])

    def coarser(self) -> Grid | None:
        """Grid of cells twice as wide that covers this one, about the same centre; None when it would be too small."""
        whole = self.unfolded
        nx, ny = ((n + 1) // 2 + ((n + 1) // 2) % 2 for n in (whole.nx, whole.ny))
        if min(nx, ny) < 2 * FEWEST:
            return None
        return Grid(nx, ny, 2 * self.spacing, self.center).folded(self.mirrored)

    def scaled(self, factor: float) -> Grid:
        """Grid with all lengths multiplied by `factor`."""
        factor, (cx, cy) = positive("factor", factor, unit="1"), self.center
        return replace(self, spacing=self.spacing * factor, center=(cx * factor, cy * factor))

    @property
    def copies(self) -> int:
        """How often each cell that the arrays hold occurs on the whole grid."""
        return (1 + self.mirrored[0]) * (1 + self.mirrored[1])

    @property
    def unfolded(self) -> Grid:
        """The whole grid."""
        along_x, along_y = self.mirrored
        return replace(self, nx=self.nx * (1 + along_x), ny=self.ny * (1 + along_y), mirrored=(False, False))

    def folded(self, mirrored: tuple[bool, bool]) -> Grid:
        """The half or quarter that remains when what lies at negative x (y) is the mirror image."""
        nx, ny = (n // (1 + half) for n, half in zip((self.nx, self.ny), mirrored, strict=True))
        cx, cy = (0.0 if half else c for c, half in zip(self.center, mirrored, strict=True))
        return replace(self, nx=nx, ny=ny, center=(cx, cy), mirrored=mirrored)

    def unfold(self, values: Cells) -> Cells:
        """An array of this folded grid on the whole one."""
        along_x, along_y = self.mirrored
        wide = np.concatenate([values[:, ::-1], values], axis=1) if along_x else values
        return np.concatenate([wide[::-1], wide]) if along_y else wide

    def part(self, rows: slice, columns: slice) -> Grid:
        """Part of its cells, beginning with the first along mirrored axes."""
        x, y = self.x[columns], self.y[rows]
        center = (0.0 if half else float(v[0] + v[-1]) / 2 for v, half in zip((x, y), self.mirrored, strict=True))
        cx, cy = center
        return replace(self, nx=x.size, ny=y.size, center=(cx, cy))

    def can_fold(self) -> tuple[bool, bool]:
        """Along which axes the grid is its own mirror image, with whole cells on each side."""
        near = 1e-9 * self.spacing
        centred = tuple(n % 2 == 0 and abs(c) <= near for n, c in zip((self.nx, self.ny), self.center, strict=True))
        return centred[0], centred[1]


def check_grid(grid: Grid) -> None:
    """Refuse what is no grid."""
    instance("grid", grid, (Grid,), "a Grid, such as Grid(nx=128, ny=128, spacing=...)")


def on_grid(name: str, given: object, grid: Grid) -> Array:
    """Return numbers, or truth values, of all cells."""
    flags = isinstance(given, np.ndarray) and given.dtype == bool
    found = np.asarray(given, dtype=float) if flags else numbers(name, given)
    if found.shape != grid.shape:
        raise BadValue(name, "", f"has shape {found.shape}, the grid has {grid.shape} (rows along y). They must agree.")
    if np.isnan(found).any():
        raise BadValue(name, "", "holds NaN; it must have a number for each cell.")
    return found


def polar(x: Array, y: Array) -> tuple[Array, Array]:
    """Radii [m] and polar angles in [0, 2 pi) of points [m], broadcast together."""
    angle = np.arctan2(y, x)
    # a tenth of what the remainder takes
    return np.hypot(x, y), np.asarray(angle + 2 * np.pi * (angle < 0))


def _even(number: float) -> int:
    return 2 * int(np.ceil(number / 2 - 1e-9))


Height = Callable[[Grid], Array]


@dataclass(frozen=True, slots=True)
class IndenterHeight:
    """Gap at first touch on a grid [m], infinite beyond the indenter's reach."""

    indenter: Indenter

    def __call__(self, grid: Grid) -> Array:
        """Heights at the cell centres, shape (ny, nx)."""
        return self.at(*grid.polar)

    def at(self, r: Array, phi: Array) -> Array:
        """Heights at polar coordinates (r, phi) of equal shape."""
        reach = self.indenter.reach_along(phi)
        height = np.array(self.indenter.height(np.minimum(r, reach), phi), dtype=float)
        height[r > reach] = np.inf
        return height
