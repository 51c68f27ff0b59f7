"""Ratio of boundary elements to the second-order theory along the loading path: smooth, so a few solutions carry a curve.

Over x = ln a (base radius) the logarithms of the ratios of force, mean radius, area and outline are interpolated by a cubic
spline through the solutions made so far. Solutions are added where leaving one out changes the spline most, until that
estimate meets the tolerance; they are kept, so that a later curve on the same medium and tip costs nothing new.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline

from flatpunch import bem
from flatpunch._validation import Array, Flags
from flatpunch.compliance import Kernel
from flatpunch.contact.correction_cache import CorrectionCache
from flatpunch.contact.perturbed import Expansion
from flatpunch.contact.tabulated import FORCE_ERROR, OUTLINE_ERROR, TableRows
from flatpunch.indenters.profile import Indenter

_START = np.log(10) / 4
"""First spacing of the solutions in ln a; twice that below beta = 0.1, where ratios move like beta."""
_FINEST = np.log(10) / 16
_THINNEST = 0.01
"""beta below which a medium is its surface's half-space and the ratios stand still (they move like beta)."""
_TOLERANCE = 1e-6
_CAUTION = 2.0
"""What is told as the force's interpolation error over what decides on more solutions (catalogue)."""
_RADIUS_TOLERANCE = 4e-3
"""Interpolation error of the mean radius that is accepted."""
_GRID_ERROR, _CORNER_GRID_ERROR = 1.2, 3.5
"""Relative force error of the grid times the number of cells, of smooth tips and of those with edges (catalogue)."""
_RIM_ERROR, _CORNER_ERROR = 1.5, 10.0
"""Error of the traced outline over the mean radius, times the cells per side: of smooth tips half a cell, and of edges, where the
outline has cusps, three."""

FORCE, RADIUS, AREA, OUTLINE = 0, 1, 2, 3
"""Columns of the ratios; the outline's angles follow from OUTLINE on."""


@dataclass(frozen=True, slots=True)
class Ratios:
    """Logarithms of (boundary elements)/(second order) and their derivatives by ln a; shape (n, 3 + angles).

    `error` and `outline_error` are the estimates of the force and of the outline at each point; `traced` is False beside a
    solution whose contact has no outline.
    """

    values: Array
    slopes: Array
    error: Array
    outline_error: Array
    traced: Flags


class Correction:
    """Corrections of one indenter on one medium.

    Parameters
    ----------
    kernel, indenter, expansion
        Medium, indenter, and their second-order series.
    angles : int
        Polar angles of the outline.
    cells : int
        Cells per side of the boundary element grids.
    folder : str, optional
        Where solutions are kept on disk.
    """

    def __init__(
        self, kernel: Kernel, indenter: Indenter, expansion: Expansion, angles: int, cells: int, folder: str | None
    ) -> None:
        self.kernel, self.indenter, self.expansion = kernel, indenter, expansion
        self.angles, self.cells = angles, cells
        self._cache = CorrectionCache(Path(folder), kernel, indenter, angles, cells) if folder is not None else None
        self.known: dict[float, Array] = self._cache.load() if self._cache else {}
        self.notes: dict[str, None] = {}

    def at(self, radius: Array, rtol: float) -> Ratios:
        """Ratios at base radii > 0, shape (n,), interpolated to `rtol` in force.

        The first call over a range costs one boundary element solution per half decade and as many more as it takes.
        """
        x = self._clipped(np.log(radius))
        nodes = self._refine(float(x.min()), float(x.max()), rtol)
        table = np.array([self.known[node] for node in nodes])
        lost = np.isnan(table[:, OUTLINE])
        table[lost, OUTLINE:] = 0.0
        grid = (_CORNER_GRID_ERROR if self.indenter.corners else _GRID_ERROR) / self.cells**2
        rim = (_CORNER_ERROR if self.indenter.corners else _RIM_ERROR) / self.cells
        if nodes.size == 1:
            values = np.repeat(table, x.size, axis=0)
            ones = np.ones(x.size)
            return Ratios(values, np.zeros_like(values), grid * ones, rim * ones, np.full(x.size, not lost[0]))
        spline = _spline(nodes, table)
        frozen = x != np.log(radius)
        slopes = np.where(frozen[:, None], 0.0, spline(x, nu=1))
        left = _left_out(nodes, table)
        upper = np.clip(np.searchsorted(nodes, x), 1, nodes.size - 1)
        # between two solutions the worse of them counts
        force = _CAUTION * np.maximum(left[upper - 1, FORCE], left[upper, FORCE]) + grid
        shape = left[:, OUTLINE:].max(axis=1)
        outline = np.maximum(shape[upper - 1], shape[upper]) + rim
        return Ratios(spline(x), slopes, force, outline, _beside(nodes, ~lost, x))

    @property
    def _self_similar(self) -> bool:
        """Whether one solution serves every size: neither tip nor medium has a length."""
        return self.indenter.exponent is not None and bool(self.kernel.homogeneous or self.kernel.exponent)

    @property
    def _thin_end(self) -> float:
        """ln a below which the ratios of power-law tips stand still; other tips have lengths of their own."""
        return float(np.log(_THINNEST * self.kernel.length)) if self.indenter.exponent is not None else -np.inf

    def _clipped(self, x: Array) -> Array:
        """Positions ln a at which to look the ratios up."""
        return np.zeros_like(x) if self._self_similar else np.maximum(x, self._thin_end)

    def _refine(self, low: float, high: float, rtol: float) -> Array:
        """Positions of the solutions that carry [low, high], added until the estimate is below rtol."""
        first, last = int(np.floor(low / _START)), int(np.ceil(high / _START))
        start = np.arange(first, max(last, first) + 1) * _START
        if self.indenter.exponent is not None:
            quiet = start < np.log(0.1 * self.kernel.length)
            start = start[~quiet | (np.arange(start.size) % 2 == 0) | (start == start[-1])]
        if self._self_similar:
            start = np.zeros(1)
        reach = np.log(self.indenter.reach) - 1e-3 if np.isfinite(self.indenter.reach) else np.inf
        self._solve(np.unique(np.minimum(start, reach)))
        while True:
            nodes = np.array(sorted(n for n in self.known if start[0] - 1e-9 <= n <= start[-1] + 1e-9))
            if nodes.size == 1:
                return nodes
            if nodes.size == 2:
                self._solve(np.array([nodes.mean()]))
                continue
            table = np.array([self.known[node] for node in nodes])
            wrong = _left_out(nodes, np.nan_to_num(table))
            score = np.maximum(wrong[:, FORCE] / rtol, wrong[:, RADIUS] / _RADIUS_TOLERANCE)
            split = (np.maximum(score[1:], score[:-1]) > 1) & (np.diff(nodes) > _FINEST)
            if not split.any():
                return nodes
            self._solve((nodes[1:] + nodes[:-1])[split] / 2)

    def _solve(self, positions: Array) -> None:
        """Boundary element solutions at new positions ln a, as ratios to the second-order theory."""
        new = np.array([x for x in positions if x not in self.known])
        if not new.size:
            return
        self.known.update(zip(new.tolist(), self.solutions(new), strict=True))
        if self._cache:
            self._cache.save(self.known)

    def solutions(self, positions: Array) -> Array:
        """Ratios at positions ln a, one boundary element solution each, shape (n, 3 + angles); NaN for missing outlines."""
        contact = self.expansion.evaluate(np.exp(positions))
        phi = np.asarray(np.arange(self.angles) * (2 * np.pi / self.angles))
        shapes = self.expansion.outline(contact, phi)
        half_widths = [(float(np.abs(a * np.cos(phi)).max()), float(np.abs(a * np.sin(phi)).max())) for a in shapes]
        found = self._boundary_elements(contact.depth, half_widths)
        self.notes |= dict.fromkeys(note for solution in found if not solution.converged for note in solution.notes)
        # a contact without an outline has the radius of a disc of its area
        area = np.array([solution.area for solution in found])
        radius = np.array([solution.radius for solution in found])
        radius = np.where(np.isfinite(radius), radius, np.sqrt(area / np.pi))
        force = np.array([solution.force for solution in found])
        measures = [force / contact.force, radius / contact.mean_radius, area / contact.area]
        outlines = np.array([solution.outline.contour for solution in found]) / shapes
        return np.log(np.column_stack([*measures, outlines]))

    def _boundary_elements(self, depths: Array, half_widths: list[tuple[float, float]]) -> list[bem.Solution]:
        options: dict[str, Any] = {"grid": self.cells, "tolerance": _TOLERANCE, "angles": self.angles}
        try:
            return bem.solve(self.kernel, self.indenter, depths=depths, half_widths=half_widths, **options)
        except bem.ContactTouchesEdge:
            # under stiff films the series may expect outlines far off: then each contact is looked for by itself
            alone = [bem.solve(self.kernel, self.indenter, depths=depth, **options) for depth in depths]
            return [solutions[0] for solutions in alone]


def tabulated(table: TableRows, radius: Array) -> Ratios:
    """Ratios at base radii > 0 from the table of standard tips; those of its first node below it."""
    x = np.maximum(np.log(radius), table.nodes[0])
    spline = _spline(table.nodes, table.rows)
    slopes = np.where((x > table.nodes[0])[:, None], spline(x, nu=1), 0.0)
    ones = np.ones(radius.size)
    return Ratios(spline(x), slopes, FORCE_ERROR * ones, OUTLINE_ERROR * ones, np.ones(radius.size, dtype=bool))


def _spline(nodes: Array, table: Array) -> CubicSpline:
    """Spline through the solutions: not-a-knot cubic, lower degree where there are few."""
    if nodes.size > 3:
        return CubicSpline(nodes, table)
    return make_interp_spline(nodes, table, k=nodes.size - 1)


def _left_out(nodes: Array, table: Array) -> Array:
    """Estimated error of the spline beside each node: what leaving the node out changes there, over five; shape of table.

    Leaving a node out doubles the local spacing, so the error of a cubic grows sixteenfold where it is resolved; five is on
    the safe side. At the ends, where leaving out extrapolates, the neighbour's value stands.
    """
    wrong = np.zeros_like(table)
    for i in range(1, nodes.size - 1):
        rest = np.arange(nodes.size) != i
        wrong[i] = np.abs(_spline(nodes[rest], table[rest])(nodes[i]) - table[i]) / 5
    wrong[0], wrong[-1] = wrong[1], wrong[-2]
    return wrong


def _beside(nodes: Array, good: Flags, x: Array) -> Flags:
    """Whether both nodes around each point are good, or the one node it coincides with."""
    upper = np.clip(np.searchsorted(nodes, x), 1, nodes.size - 1)
    at = np.abs(nodes[upper] - x) < 1e-9
    return np.asarray((good[upper - 1] | at) & (good[upper] | (np.abs(nodes[upper - 1] - x) < 1e-9)))


@lru_cache(maxsize=32)
def correction(
    kernel: Kernel, indenter: Indenter, expansion: Expansion, angles: int, cells: int, folder: str | None = None
) -> Correction:
    """The corrections of a medium and an indenter; solutions already made are shared."""
    return Correction(kernel, indenter, expansion, angles, cells, folder)
