"""A rough surface on a body, solved step by step, and what is measured on the cells of each contact.

The error of the cells is what cells twice as wide change, which know every second height (`wider`). Counted areas depend
besides on where the rims of the patches are among the cells.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flatpunch._support.checks import FEWEST, ROUNDING, Array, Flags
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator.convolution import SINGLE_FLOOR, Operator, build_operator
from flatpunch.bem.operator.periodic import periodic_operator
from flatpunch.bem.solver.active_set import State, punch_stiffness
from flatpunch.bem.solver.levels import COARSEST
from flatpunch.compliances import Kernel
from flatpunch.rough.solver import COARSE, Level, Solved, at_depth, at_force
from flatpunch.surfaces import Topography

logger = logging.getLogger("flatpunch.rough")

STAIRCASE = (math.pi - 1 + math.log(2)) / 24
"""Area by which counted cells exceed a contact, over perimeter times side of a cell (Yastrebov, Anciaux, Molinari 2017)."""

TWICE = 2.0
"""Safety factor on the errors of mean gap and largest pressure: differences between cells may be small by chance."""

COUNTED = 0.676 / 8
"""Variance of the number of cells in an oval, over the sides of its rim: .676 times the radius in cells, which has 8 sides."""

COLUMNS = {
    "mean_pressure": ("Pa", "force over nominal area"),
    "force": ("N", "normal force of one period, or of the surface"),
    "depth": ("m", "depth of the highest peak below the undeformed surface"),
    "area": ("m^2", "area of the cells in contact"),
    "area_fraction": ("1", "share of the cells in contact"),
    "area_fraction_corrected": ("1", "share of the area in contact, less the staircase of the cells"),
    "plastic_fraction": ("1", "share of the cells at the hardness"),
    "mean_gap": ("m", "mean gap between the surfaces"),
    "max_pressure": ("Pa", "largest pressure of a cell"),
    "stiffness": ("N/m", "dF/dd"),
    "gap_stiffness": ("N/m", "-dF/d(mean gap)"),
    "energy": ("J", "elastic energy"),
    "patches": ("1", "number of connected contact patches"),
    "largest_patch": ("m^2", "area of the largest patch"),
    "area_error": ("1", "error of the corrected share that the cells cause"),
    "mean_gap_error": ("m", "error of the mean gap that the cells cause"),
    "max_pressure_error": ("Pa", "error of the largest pressure that the cells cause"),
    "gap_error": ("1", "largest gap in contact over the approach"),
    "penetration": ("1", "largest penetration outside the contact over the approach"),
}


@dataclass(frozen=True, slots=True)
class Step:
    """Numbers of a step by their names, whether it converged, and its fields: pressure [Pa], gap and displacement [m]."""

    numbers: dict[str, float]
    converged: bool
    at_border: bool
    fields: tuple[Array, ...] = ()


@dataclass(frozen=True, slots=True)
class Case:
    """A surface on a body, with its operators.

    Attributes
    ----------
    topography, kernel : Topography, Kernel
        Surface and body.
    level : Level
        Its operators and gap at first touch.
    added, uniform : float
        C(0) that the operator has, and that of the body [m/Pa]; both zero where the surface ends in some direction.
    has_depth, by_depth : bool
        Whether a depth exists, and whether it is prescribed.
    """

    topography: Topography
    kernel: Kernel
    level: Level
    added: float
    uniform: float
    has_depth: bool
    by_depth: bool

    def solved(self, targets: Array, tolerance: float, limit: int, *, fields: bool) -> list[Step]:
        """All steps, each from the one before where that is nearer than a fresh start."""
        steps, before = [], None
        for target in targets:
            if target == 0:
                steps.append(self._untouched(fields=fields))
                continue
            solved = self._solve(float(target), before, tolerance, limit)
            before = solved.state.pressure
            steps.append(self._measured(solved, tolerance, fields=fields))
        return steps

    def _solve(self, target: float, before: Array | None, tolerance: float, limit: int) -> Solved:
        if self.by_depth:
            return at_depth(self.level, target / self.topography.spacing, tolerance, limit, before)
        force = target / (self.kernel.modulus * self.topography.spacing**2)
        return at_force(self.level, force, tolerance, limit, before)

    def _measured(self, solved: Solved, tolerance: float, *, fields: bool) -> Step:
        state, rough, spacing = solved.state, self.topography, self.topography.spacing
        unit = self.kernel.modulus * spacing**2
        cells, mean_pressure = rough.heights.size, state.force * unit / rough.area
        # displacement and depth with the body's own compliance of the mean pressure, or with none where that is infinite
        moved = (self.uniform if self.has_depth else 0.0) - self.added
        rise = moved * mean_pressure
        displacement = np.asarray(state.displacement) * spacing + rise
        depth = state.depth * spacing + rise
        gap = displacement + self.level.height * spacing - depth
        # overlap at the hardness is what has yielded
        plastic = state.contact & ~state.elastic
        gap = np.where(plastic, 0.0, gap)
        sizes = patch_sizes(state.contact, rough.periodic)
        share = np.count_nonzero(state.contact) / cells
        sides = perimeter(state.contact, rough.periodic)
        stiffness, gap_stiffness = self._stiffness(state.elastic, plastic, moved, tolerance)
        numbers = {
            "mean_pressure": mean_pressure,
            "force": state.force * unit,
            "depth": depth if self.has_depth else np.nan,
            "area": share * rough.area,
            "area_fraction": share,
            "area_fraction_corrected": share - STAIRCASE * sides / cells,
            "plastic_fraction": np.count_nonzero(plastic) / cells,
            "mean_gap": float(gap.mean()),
            "max_pressure": float(np.max(state.pressure)) * self.kernel.modulus,
            "stiffness": stiffness if self.has_depth else np.nan,
            "gap_stiffness": gap_stiffness,
            "energy": self._energy(state, mean_pressure),
            "patches": sizes.size,
            "largest_patch": float(sizes.max(initial=0)) * spacing**2,
            "area_error": 2 * (COUNTED * sides) ** 0.5 / cells,
            "mean_gap_error": 0.0,
            "max_pressure_error": self._peak_error(state) * self.kernel.modulus,
            "gap_error": state.gap_error,
            "penetration": state.penetration,
        }
        maps = (np.asarray(state.pressure) * self.kernel.modulus, gap, displacement) if fields else ()
        return Step(numbers, solved.converged, at_border(state.contact, rough.periodic), maps)

    def _peak_error(self, state: State) -> float:
        """Largest pressure less that of its cell [E*]; at a border, the edge of a punch, only the hardness limits it."""
        pressure = np.asarray(state.pressure)
        most = self.level.hardness - float(pressure.max())
        return most if at_border(state.contact, self.topography.periodic) else min(most, _drop(pressure))

    def _energy(self, state: State, mean_pressure: float) -> float:
        """Elastic energy [J]; where both axes repeat, the part of the mean pressure in closed form, as it may be much larger."""
        unit = self.kernel.modulus * self.topography.spacing**3
        if not all(self.topography.periodic):
            return float(np.vdot(state.pressure, state.displacement)) / 2 * unit
        uniform = self.uniform if self.has_depth else 0.0
        pressure, moved = (part - part.mean() for part in (state.pressure, np.asarray(state.displacement)))
        waves = np.vdot(pressure, moved) / 2 * unit
        return float(waves) + uniform * mean_pressure**2 * self.topography.area / 2

    def _stiffness(self, elastic: Flags, plastic: Flags, moved: float, tolerance: float) -> tuple[float, float]:
        """dF/dd and -dF/d(mean gap) [N/m], from the flat punch under the elastic contact."""
        stiffness, closing = flat_stiffness(self.level.inner, elastic, tolerance, plastic)
        if stiffness == 0:
            return 0.0, 0.0
        if elastic.all() and all(self.topography.periodic):
            # flat already: the mean pressure alone moves it
            return (self.topography.area / self.uniform if self.uniform > 0 else np.inf), np.inf
        unit = self.kernel.modulus * self.topography.spacing
        by_depth = 1 / (stiffness * unit) + moved / self.topography.area
        return (1 / by_depth if by_depth > 0 else np.inf), (stiffness * unit / closing if closing > 0 else np.inf)

    def _untouched(self, *, fields: bool) -> Step:
        """Surfaces that touch at one point, without load."""
        numbers = dict.fromkeys(COLUMNS, 0.0)
        gap = self.level.height * self.topography.spacing
        numbers |= {"mean_gap": float(gap.mean())}
        if not self.has_depth:
            numbers |= {"depth": np.nan, "stiffness": np.nan}
        return Step(numbers, True, False, (np.zeros_like(gap), gap, np.zeros_like(gap)) if fields else ())


def _drop(pressure: Array) -> float:
    """Largest pressure less the mean of its four neighbours, of the size of what it is above that of the cell."""
    i, j = np.unravel_index(np.argmax(pressure), pressure.shape)
    ny, nx = pressure.shape
    around = pressure[[i - 1, (i + 1) % ny, i, i], [j, j, j - 1, (j + 1) % nx]]
    return float(pressure[i, j] - around.mean())


def case_of(
    kernel: Kernel, topography: Topography, uniform: float, *, by_depth: bool, hardness: float = float("inf")
) -> Case:
    """Operators and gaps of a surface on a body."""
    (ny, nx), spacing, periodic = topography.shape, topography.spacing, topography.periodic
    # at given force any finite C(0) gives the same pressure: that of the longest wave keeps the numbers of a size
    longest = float(kernel(2 * np.pi / max(topography.size))[0])
    added = uniform if by_depth and np.isfinite(uniform) else longest
    logger.info("%d x %d cells of %.4g m: at most %.0f MB", nx, ny, spacing, required(topography) / 1e6)
    if not all(periodic):
        added, uniform = 0.0, 0.0 if not any(periodic) or np.isfinite(uniform) else np.inf
    height = (topography.heights.max() - topography.heights) / spacing
    level = _level(
        kernel, Grid(nx, ny, spacing), height, periodic, added if all(periodic) else float(uniform == 0), hardness
    )
    return Case(topography, kernel, level, added, uniform, bool(np.isfinite(uniform)), by_depth)


def _level(
    kernel: Kernel, grid: Grid, height: Array, periodic: tuple[bool, bool], uniform: float, hardness: float
) -> Level:
    """Operators on a grid, and on ever wider cells as long as there are many of them; `uniform` as of `periodic_operator`."""
    operator = operator_of(kernel, grid, periodic, uniform)
    coarser = None
    if grid.nx % 2 == grid.ny % 2 == 0 and min(grid.shape) >= 2 * COARSEST:
        (ny, nx) = (n // 2 for n in grid.shape)
        wider = height.reshape(ny, 2, nx, 2).mean(axis=(1, 3)) / 2
        coarser = _level(kernel, Grid(nx, ny, 2 * grid.spacing), wider, periodic, uniform, hardness)
    return Level(operator, operator.single(), height, coarser, hardness / kernel.modulus)


def operator_of(kernel: Kernel, grid: Grid, periodic: tuple[bool, bool], uniform: float) -> Operator:
    """Operator where a surface repeats or ends; `uniform` as of `periodic_operator`."""
    return periodic_operator(kernel, grid, periodic, uniform) if any(periodic) else build_operator(kernel, grid)


def flat_stiffness(
    operator: Operator, contact: Flags, tolerance: float, filled: Flags | bool = False
) -> tuple[float, float]:
    """Stiffness of the flat punch under the cells in contact [E* cells], and what its depth closes the mean gap by.

    Other cells that are `filled` have no gap either.
    """
    # the error of the stiffness is the square of that of the displacement under the punch
    punch, stiffness, _, _ = punch_stiffness(operator, contact, max(SINGLE_FLOOR, tolerance**0.5))
    open_gap = ~(contact | filled)
    return stiffness, float(((1 - operator.apply(punch)) * open_gap).mean())


def required(topography: Topography) -> int:
    """Upper bound of the memory of a solution [bytes]; a test measures it."""
    # bytes per cell where no, one or both axes are doubled
    return topography.heights.size * (240, 190, 170)[sum(topography.periodic)]


def wider(topography: Topography, first: int) -> Topography | None:
    """Every second height, from the first or second one on; None where too few are left. Odd numbers of cells leave a seam."""
    heights = topography.heights[first::2, first::2]
    if min(heights.shape) < FEWEST:
        return None
    return Topography(heights, 2 * topography.spacing, topography.periodic)


def solved_with_errors(
    kernel: Kernel,
    topography: Topography,
    uniform: float,
    targets: Array,
    tolerance: float,
    limit: int,
    *,
    by_depth: bool,
    fields: bool,
    hardness: float = float("inf"),
) -> list[Step]:
    """All steps at depths [m] or forces [N], with the errors that cells twice as wide show; NaN on the smallest grids."""
    others: list[list[Step]] = []
    for first in (0, 1):
        if (surface := wider(topography, first)) is None:
            break
        goals = targets * surface.area / topography.area
        if by_depth:
            # the same plane, seen from a lower summit
            lower, full = float(topography.heights.max() - surface.heights.max()), float(np.ptp(surface.heights))
            goals = np.clip(targets - lower, 0.0, full if uniform == 0 else None)
        case = case_of(kernel, surface, uniform, by_depth=by_depth, hardness=hardness)
        others.append(case.solved(goals, max(tolerance, COARSE), limit, fields=False))
    case = case_of(kernel, topography, uniform, by_depth=by_depth, hardness=hardness)
    steps = case.solved(targets, tolerance, limit, fields=fields)
    return [_with_errors(step, [each[i] for each in others]) for i, step in enumerate(steps)]


def _with_errors(step: Step, coarse: list[Step]) -> Step:
    """The step with the differences to wider cells; a quantity that grows on finer cells is taken to grow by the same factor."""
    found = {}
    names = {
        "area_error": "area_fraction_corrected",
        "mean_gap_error": "mean_gap",
        "max_pressure_error": "max_pressure",
    }
    for error, name in names.items():
        fine, others = step.numbers[name], np.array([each.numbers[name] for each in coarse] or [np.nan])
        growth = np.where(
            (fine > others) & (others > 0) & (name != "mean_gap"), fine / np.maximum(others, ROUNDING), 1.0
        )
        times = 1.0 if error == "area_error" else TWICE
        found[error] = times * float(np.hypot(step.numbers[error], np.abs(growth * (fine - others)).max()))
    return replace(step, numbers=step.numbers | found)


def perimeter(contact: Flags, periodic: tuple[bool, bool]) -> int:
    """Sides of cells between contact and gap; the border of a surface that ends counts as gap."""
    sides = 0
    for axis in (0, 1):
        if periodic[1 - axis]:
            sides += int(np.count_nonzero(contact != np.roll(contact, 1, axis)))
        else:
            rim = [(1, 1) if axis == other else (0, 0) for other in (0, 1)]
            sides += int(np.count_nonzero(np.diff(np.pad(contact, rim), axis=axis)))
    return sides


def patch_sizes(contact: Flags, periodic: tuple[bool, bool]) -> Array:
    """Number of cells of each connected patch, cells joined by their sides, across the border where the surface repeats."""
    labels, count = label(contact)
    pairs = []
    for axis in (0, 1):
        if periodic[1 - axis]:
            ends = np.stack([np.take(labels, end, axis) for end in (0, -1)])
            pairs.append(ends[:, (ends > 0).all(axis=0)])
    if pairs and count:
        first, second = np.concatenate(pairs, axis=1) - 1
        graph = coo_array((np.ones(first.size, dtype=bool), (first, second)), shape=(count, count))
        count, joined = connected_components(graph, directed=False)
        labels = np.concatenate([[0], joined + 1])[labels]
    return np.asarray(np.bincount(labels.ravel(), minlength=count + 1)[1:])


def at_border(contact: Flags, periodic: tuple[bool, bool]) -> bool:
    """Whether the contact reaches a border at which the surface ends."""
    along_x, along_y = periodic
    return bool((not along_x and contact[:, [0, -1]].any()) or (not along_y and contact[[0, -1]].any()))
