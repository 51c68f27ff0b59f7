"""Ratio of boundary elements to the second-order theory along the loading path: smooth, so a few solutions carry a curve.

Over x = ln a (base radius) the logarithms of the ratios are interpolated by a cubic spline through the solutions made so far.
Forces are compared with the series, or with the round base contact where the spline follows that more closely: under stiff films
the series has poles. Radius, area and outline are compared with the base radius a and with a exp(w_ref): w_ref is the w of the
series, damped where it swings far, because it has no meaning there.
Solutions are added where leaving one out changes the spline most, until that estimate meets the tolerance; they are kept, so
that a later curve on the same medium and tip costs nothing new.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch import bem
from flatpunch._validation import Array, Flags
from flatpunch.compliance import Kernel
from flatpunch.contact.correction_cache import CorrectionCache
from flatpunch.contact.expansion import PerturbedContact
from flatpunch.contact.node_spline import between_good, left_out, spline_through
from flatpunch.contact.perturbed import Expansion, Series
from flatpunch.contact.ridges import traced
from flatpunch.contact.tabulated import FORCE_ERROR, OUTLINE_ERROR, TableRows
from flatpunch.indenters.profile import Indenter

_START = np.log(10) / 4
"""First spacing of the solutions in ln a; twice that below beta = 0.1, where ratios move like beta."""
_FINEST, _FINEST_SHAPE = np.log(10) / 16, np.log(10) / 8
"""Finest spacings for the sake of the force and of the outline: outlines of needles and crosses differ from grid to grid."""
_THINNEST = 0.01
"""beta below which a medium is its surface's half-space and the ratios stand still (they move like beta)."""
_TOLERANCE = 1e-6
_ROUNDING = 1e-9
_CAUTION = 2.0
"""What is told as interpolation error over what decides on more solutions (catalogue)."""
_SHAPE_TOLERANCE = 6e-3
"""Interpolation error of the outline that is accepted, over its radius."""
_CROSS = -1.0
"""ln(mean radius/base radius) below which the contact follows the edges alone: that asks for finer grids, not more solutions."""
_GRID_ERROR, _CORNER_GRID_ERROR = 1.2, 3.5
"""Relative force error of the grid times the number of cells, of smooth tips and of those with edges (catalogue)."""
_RIM_ERROR = 1.5
"""Error of the traced outline over the mean radius, times the cells per side: half a cell."""
_CORNER_ERROR, _END_ERROR = 1.5, 3.0
"""The same of tips with edges, and what their ends add per (farthest point/mean radius - 1)^2."""

_FAR = 2.0
"""Swing of w about which it is damped; sharp tips on soft bodies reach 0.8."""

FORCE, RADIUS, AREA, OUTLINE = 0, 1, 2, 3
"""Columns of the ratios; the outline's angles follow from OUTLINE on."""


@dataclass(frozen=True, slots=True)
class Ratios:
    """Logarithms of (boundary elements)/(reference) and their derivatives by ln a; shape (n, 3 + angles).

    `error` and `outline_error` are the estimates of the force and of the outline at each point; `traced` is False beside a
    solution whose contact has no outline. Forces are over those of the series, or if `over_base` of its round base.
    """

    values: Array
    slopes: Array
    error: Array
    outline_error: Array
    traced: Flags
    over_base: bool = False


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
        self, kernel: Kernel, indenter: Indenter, expansion: Series, angles: int, cells: int, folder: str | None
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
        table, over_base = self._table(nodes)
        lost = np.isnan(table[:, OUTLINE])
        table[lost, OUTLINE:] = 0.0
        grid = (_CORNER_GRID_ERROR if self.indenter.corners else _GRID_ERROR) / self.cells**2
        rim = 0.0 if self.indenter.corners else _RIM_ERROR / self.cells
        if nodes.size == 1:
            values = np.repeat(table, x.size, axis=0)
            ones = np.ones(x.size)
            return Ratios(values, np.zeros_like(values), grid * ones, rim * ones, np.full(x.size, not lost[0]))
        spline = spline_through(nodes, table)
        frozen = x != np.log(radius)
        slopes = np.where(frozen[:, None], 0.0, spline(x, nu=1))
        left = left_out(nodes, table)
        upper = np.clip(np.searchsorted(nodes, x), 1, nodes.size - 1)
        # between two solutions the worse of them counts, at one of them none
        caution = np.where(np.abs(nodes[:, None] - x).min(axis=0) < _ROUNDING, 0.0, _CAUTION)
        force = caution * np.maximum(left[upper - 1, FORCE], left[upper, FORCE]) + grid
        shape = left[:, OUTLINE:].max(axis=1)
        outline = caution * np.maximum(shape[upper - 1], shape[upper]) + rim
        return Ratios(spline(x), slopes, force, outline, between_good(nodes, ~lost, x), over_base)

    def _table(self, nodes: Array) -> tuple[Array, bool]:
        """Known ratios, and whether those of the force are over the round base, which then is the smoother choice."""
        table = np.array([self.known[node] for node in nodes])
        if nodes.size < 3:
            return table, False
        radius, other = np.exp(nodes), table.copy()
        other[:, FORCE] += np.log(self.expansion.loading(radius).force / self.expansion.unperturbed(radius).force)
        over_base = bool(np.diff([left_out(nodes, part[:, :1]).max() for part in (table, other)]) < 0)
        return (other if over_base else table), over_base

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
        if low == high and not self._self_similar and not self._surrounded(low):
            return self._single(low)
        # one solution beyond each end: where nothing follows, splines and what is left out of them are of little worth
        first, last = int(np.floor(low / _START)) - 1, int(np.ceil(high / _START)) + 1
        start = np.arange(first, last + 1) * _START
        if self.indenter.exponent is not None:
            quiet = start < np.log(0.1 * self.kernel.length)
            start = start[~quiet | (np.arange(start.size) % 2 == 1) | (start == start[-1])]
        if self._self_similar:
            start = np.zeros(1)
        start = self._possible(start)
        if start[0] > low:
            start = np.concatenate([[low], start])
        self._solve(start)
        while True:
            nodes = np.array(sorted(n for n in self.known if start[0] - 1e-9 <= n <= start[-1] + 1e-9))
            if nodes.size == 1:
                return nodes
            if nodes.size == 2:
                self._solve(np.array([nodes.mean()]))
                continue
            table = np.nan_to_num(self._table(nodes)[0])
            wrong = left_out(nodes, table)
            shape = np.where(table[:, RADIUS] < _CROSS, 0.0, wrong[:, OUTLINE:].max(axis=1))
            split = np.zeros(nodes.size - 1, dtype=bool)
            for error, tolerance, finest in (
                (wrong[:, FORCE], rtol, _FINEST),
                (shape, _SHAPE_TOLERANCE, _FINEST_SHAPE),
            ):
                split |= (np.maximum(error[1:], error[:-1]) > tolerance) & (np.diff(nodes) > 1.5 * finest)
            split &= (nodes[1:] > low) & (nodes[:-1] < high)
            if not split.any():
                return nodes
            self._solve((nodes[1:] + nodes[:-1])[split] / 2)

    def _surrounded(self, x: float) -> bool:
        """Whether there are solutions close by on both sides."""
        known = np.array(list(self.known))
        near = known[np.abs(known - x) < _START]
        return bool((near < x).any() and (near > x).any())

    def _single(self, x: float) -> Array:
        """One position and what the slope there takes: for a single step that is worth more than a range."""
        nodes = np.union1d(self._possible(np.array([x - _START / 2, x + _START / 2])), x)
        self._solve(nodes)
        return nodes

    def _possible(self, nodes: Array) -> Array:
        """Positions within the tip's reach and beyond its flat end, where there is a contact of that size."""
        reach = np.log(self.indenter.reach) - 1e-3 if np.isfinite(self.indenter.reach) else np.inf
        nodes = np.unique(np.minimum(nodes, reach))
        depth = self.expansion.descent(np.exp(nodes)).depth
        return np.asarray(nodes[depth > _ROUNDING * depth.max()])

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
        shapes = reference_outline(self.expansion, contact, phi)
        half_widths = [(float(np.abs(a * np.cos(phi)).max()), float(np.abs(a * np.sin(phi)).max())) for a in shapes]
        found = self._boundary_elements(contact.depth, half_widths)
        self.notes |= dict.fromkeys(note for solution in found if not solution.converged for note in solution.notes)
        traces = [traced(self.kernel, self.indenter, solution, self.angles) for solution in found]
        area = np.array([trace.area for trace in traces])
        radius = np.array([trace.radius for trace in traces])
        force = np.array([solution.force for solution in found])
        measures = [force / contact.force, radius / contact.radius, area / (np.pi * contact.radius**2)]
        outlines = np.array([trace.contour for trace in traces]) / shapes
        return np.log(np.column_stack([*measures, outlines]))

    def _boundary_elements(self, depths: Array, half_widths: list[tuple[float, float]]) -> list[bem.Solution]:
        """Solutions at depths, shape (n,); threads would wait for each other, as the arrays are small."""
        options: dict[str, Any] = {"grid": self.cells, "tolerance": _TOLERANCE, "angles": self.angles}
        try:
            return bem.solve(self.kernel, self.indenter, depths=depths, half_widths=half_widths, **options)
        except bem.ContactTouchesEdge:
            # under stiff films the series may expect outlines far off: then each contact is looked for by itself
            alone = [bem.solve(self.kernel, self.indenter, depths=depth, **options) for depth in depths]
            return [solutions[0] for solutions in alone]


def end_error(indenter: Indenter, contour: Array, radius: Array, cells: int) -> Array:
    """Error over the mean radius of outlines that edges draw into points, shape (n,); they are lost over some cells."""
    if not indenter.corners:
        return np.zeros_like(radius)
    with np.errstate(invalid="ignore", divide="ignore"):
        far = np.max(contour, axis=1) / radius - 1
    return np.asarray((_CORNER_ERROR + _END_ERROR * np.where(np.isfinite(far), far, 1.0) ** 2) / cells)


def reference_outline(expansion: Expansion, contact: PerturbedContact, phi: Array) -> Array:
    """What outlines are compared with, shape (n, p) [m]: smooth in the base radius even through the poles of w."""
    size = np.where(contact.size > 0, contact.size, 1.0)[:, None]
    with np.errstate(divide="ignore"):
        w = np.log(expansion.outline(contact, phi) / size)
    damped = np.where(contact.size[:, None] > 0, w, 0.0) / (1 + (contact.swing[:, None] / _FAR) ** 2)
    return np.asarray(contact.radius[:, None] * np.exp(damped))


def tabulated(table: TableRows, radius: Array) -> Ratios:
    """Ratios at base radii > 0 from the table of standard tips; those of its first node below it."""
    x = np.maximum(np.log(radius), table.nodes[0])
    spline = spline_through(table.nodes, table.rows)
    slopes = np.where((x > table.nodes[0])[:, None], spline(x, nu=1), 0.0)
    ones = np.ones(radius.size)
    return Ratios(spline(x), slopes, FORCE_ERROR * ones, OUTLINE_ERROR * ones, np.ones(radius.size, dtype=bool))


@lru_cache(maxsize=32)
def correction(
    kernel: Kernel, indenter: Indenter, expansion: Series, angles: int, cells: int, folder: str | None = None
) -> Correction:
    """The corrections of a medium and an indenter; solutions already made are shared."""
    return Correction(kernel, indenter, expansion, angles, cells, folder)
