"""A few boundary element solutions along the loading path, and the smooth curves through them.

Over x = ln d the logarithm of the force is interpolated by its values and slopes (dF/dd is known to each solution), that of
radius, area and outline by its values. What is interpolated are ratios to the round contact of the mean profile where these are
smooth, and the quantities themselves where they are not (theory_forms.py), gap by gap.
Solutions are added where leaving one out changes the curve most, or where another curve through them differs most, until these
estimates meet the tolerance; they are kept, so that a later curve on the same medium and tip costs nothing new.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.bem.curves import SHARED_CELLS
from flatpunch.compliance import Kernel
from flatpunch.contact.boundary_elements import error as cell_error
from flatpunch.contact.boundary_elements.expected_box import boxes_between, level_line
from flatpunch.contact.perturbation.perturbed_contact import PathPoint, PerturbedContact
from flatpunch.contact.refined.cache import CorrectionCache
from flatpunch.contact.refined.depth_range import depth_range
from flatpunch.contact.refined.force_curve import FEWEST, ForceCurve, force_curve
from flatpunch.contact.refined.one_solution import CHANGE, FORCE, GROWTH, OUTLINE, RADIUS, Case, solved_row
from flatpunch.contact.refined.reference import BASE, Theory, TheoryAt, forces
from flatpunch.contact.refined.round_series import RoundSeries
from flatpunch.contact.refined.shape_curve import ShapeCurve, shape_curve
from flatpunch.contact.refined.spacing import Spacing
from flatpunch.contact.refined.splines import between_good
from flatpunch.indenters.geometry.edges import sectors
from flatpunch.indenters.profile import Indenter
from flatpunch.parallel.team import call_helpers, shared_out

_FAR_APART, _CLOSE, _CLOSER, _CLOSEST_CHANGE = 1 / 2, 1 / 4, 1 / 8, 1 / 16
"""Gaps, in spacings, above which solutions lie far apart, or are close, or closer still, where contacts change quickly."""
_GROWING = 0.27
"""By how much ln of the farthest or nearest point over the mean radius rises in gaps in which contacts change quickly."""
_THINNEST = 0.01
"""beta below which a medium is its surface's half-space and ratios to the round contact stand still (they move like beta)."""
_DECADES = 9
"""Decades of depth below the largest at which the ratios of tips with lengths of their own stand still."""
_SLOPE_NOISE, _CORNER_SLOPE_NOISE = 0.25, 0.8
"""Error of dln F/dln d times the cells per side, of smooth tips and of those with edges (0.05 to 0.3 and 0.1 to 1 found)."""
_SHAPE_TOLERANCE, _CLOSE_TOLERANCE, _CLOSER_TOLERANCE = 5e-3, 8e-3, 1.5e-2
"""Interpolation error of the outline that is accepted, over its radius, between solutions that lie far apart, that are close, and
that are closer: leaving one out of these tells up to five times too much."""
_FAR_OFF = 0.1
"""The same from which on gaps between solutions that lie far apart are quartered at once: fewer rounds, fewer waits for them."""
_AFTER = 1 / 3
"""Where in the rest of a gap the rise after a kink is solved for too, as long as solutions are not closer."""
_USUAL, _CLOSEST, _EACH = 2, 1 / 8, 3
"""Solutions that interpolation usually takes over those it begins with, gaps, in spacings, below which scatter counts, and
solutions for one prescribed force or radius."""
_MARGIN, _LOWEST = 0.1, 1.0
"""By how much ln d of a curve's contacts may lie beyond that of round ones of equal force or radius, and how much farther down
radii are looked for."""
_ROUNDING = 1e-9
_KEPT = 4
"""Sets of solutions whose curves are kept, half a megabyte each."""


@dataclass(frozen=True, slots=True)
class Refined:
    """Refined contacts, shape (n,) each; `shape` has the columns of a solution from RADIUS on, shape (n, 2 + angles).

    `error` and `shape_error` are the estimates of force and outline; `traced` is False beside a solution whose contact has no
    outline.
    """

    force: Array
    stiffness: Array
    shape: Array
    error: Array
    shape_error: Array
    traced: Flags


class Correction:
    """Boundary element solutions of one indenter on one medium.

    Parameters
    ----------
    kernel, indenter, series
        Medium, indenter, and the round contacts that stand beside their solutions.
    angles : int
        Polar angles of the outline.
    cells : int
        Cells per side of the boundary element grids.
    folder : str, optional
        Where solutions are kept on disk.
    """

    def __init__(
        self, kernel: Kernel, indenter: Indenter, series: RoundSeries, angles: int, cells: int, folder: str | None
    ) -> None:
        self.kernel, self.indenter, self.series = kernel, indenter, series
        self.phi, self.cells = np.asarray(np.arange(angles) * (2 * np.pi / angles)), cells
        self.theory = TheoryAt(kernel, indenter, series)
        self.spacing = Spacing(kernel, indenter, series.base)
        self._cache = CorrectionCache(Path(folder), kernel, indenter, angles, cells) if folder is not None else None
        # what lies through the same solutions serves call after call
        self._force_curve = lru_cache(maxsize=_KEPT)(self._new_force_curve)
        self._shape_curve = lru_cache(maxsize=_KEPT)(self._new_shape_curve)
        self._rough = lru_cache(maxsize=_KEPT)(self._gaps_to_halve)
        self.known: dict[float, Array] = self._cache.load() if self._cache else {}
        self.notes: dict[str, None] = {}

    def loading(
        self, contact: PathPoint | PerturbedContact, rtol: float, nodes: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Force [N], dF/dd [N/m] and estimated error of the interpolated force beside round contacts, shape (n,) each.

        If positions of solutions are given nothing is solved, and outside these ratios to the round contacts stand still.
        """
        at = self._clipped(np.log(contact.depth), nodes)
        return self._loading(contact, at, self._nodes(at, rtol) if nodes is None else nodes)

    def mean_radius(self, contact: PathPoint | PerturbedContact, rtol: float, nodes: Array | None = None) -> Array:
        """Mean radii [m] beside round contacts, shape (n,), by themselves; `nodes` as for `loading`."""
        x = np.log(contact.depth)
        at = self._clipped(x, nodes)
        curve = self._shape_curve(tuple(self._nodes(at, rtol) if nodes is None else nodes))
        still, following = self._standing_still(contact, at, at != x)
        return np.asarray(np.exp(curve.sizes(at)[:, 0] + curve.change(at, still) + following))

    def reaching(self, column: int, wanted: Array, guess: Array, rtol: float) -> Array | None:
        """Positions of solutions that carry contacts whose columns (FORCE, RADIUS) have the `wanted` values.

        Parameters
        ----------
        column : int
            FORCE or RADIUS.
        wanted : array, shape (2,)
            Least and largest value of F/E* [m^2] or a0 [m].
        guess : array, shape (2,)
            Depths at which these are expected [m].
        rtol : float
            Wanted relative interpolation error of the force.

        Returns
        -------
        ndarray, shape (n,) or None
            ln d. None if one solution serves every depth, or if the values are not reached.
        """
        if self._self_similar:
            return None
        least, most = (float(end) for end in np.log(wanted))
        low, high = float(np.log(guess[0])) - _MARGIN, float(np.log(guess[1])) + _MARGIN
        # radii hardly above that of a flat end have no depth to be found
        lowest = max(self._least, low - _LOWEST) if column == RADIUS else self._least
        while True:
            # the more solutions there are, the better the ends are known
            ends = depth_range(
                lambda: {at: float(row[column]) for at, row in self.known.items()},
                lambda first, last: self._solve(self._missing(first, last, rtol)),
                self.spacing.far,
                (least, most),
                (low, high),
                lowest,
            )
            if ends is None:
                return None
            low, high = ends
            new = self._missing(low, high, rtol)
            if not new.size:
                return self._more(low, high, rtol)[0]
            self._solve(new)

    def _missing(self, low: float, high: float, rtol: float) -> Array:
        """Positions of solutions that are wanted at and between two positions, as far as the known ones tell."""
        every = np.array(sorted(self.known))
        new = self.spacing.missing(every, low, high)
        first, last = max(low, every.min(initial=np.inf)), min(high, every.max(initial=-np.inf))
        if first <= last and np.all((new < first) | (new > last)):
            # what will be wanted between known ones anyway does not wait until the ends are known
            nodes, more = self._more(first, last, rtol)
            new = np.append(new, more)
            if nodes.size >= _EACH and np.isin(more, (low, high)).any():
                # ends that move as they are known better would never get there: the gap around them closes from both sides
                left, right = nodes[np.searchsorted(nodes, low) - 1 :][:2]
                if abs((left + right) / 2 - low) > (right - left) / 8:
                    new = np.append(new, (left + right) / 2)
        return new

    def sparse(self, depth: Array) -> bool:
        """Whether contacts at about these depths are far fewer than the solutions that carry all between them."""
        if self._self_similar or depth.size < 2:
            return False
        known, x = np.array(sorted(self.known)), np.log(depth)
        return bool(_EACH * depth.size <= _USUAL * self.spacing.missing(known, float(x.min()), float(x.max())).size)

    def _loading(self, contact: PathPoint | PerturbedContact, at: Array, nodes: Array) -> tuple[Array, Array, Array]:
        """The same at known positions, shape (n,), from known solutions."""
        curve = self._force_curve(tuple(nodes))
        theory, rates = forces(contact)
        frozen = at != np.log(contact.depth)
        there = np.array(theory)
        if frozen.any():
            there[frozen] = self._theory_at(at[frozen]).force
        logarithm, slope, error = curve.at(at, there), curve.at(at, rates, 1), curve.estimate(at, there)
        # ratios to the round contact stand still there, whatever is interpolated elsewhere
        logarithm[frozen] += theory[frozen, BASE] - there[frozen, BASE]
        slope[frozen] = rates[frozen, BASE]
        force = np.exp(logarithm)
        return force, force * slope / contact.depth, error

    def at(
        self, contact: PerturbedContact, rtol: float, nodes: Array | None = None, *, exactly: bool = False
    ) -> Refined:
        """Refined contacts beside round ones, interpolated to `rtol` in force; `nodes` as for `loading`.

        The first call over a range costs a boundary element solution per 3/8 of a decade of the radius, and more as it takes;
        with `exactly` one per contact, where that is no more.
        """
        x = np.log(contact.depth)
        at = self._clipped(x, nodes)
        if nodes is None:
            nodes = self._own_nodes(at) if exactly and self._few(at) else self._nodes(at, rtol)
        force, stiffness, error = self._loading(contact, at, nodes)
        curve = self._shape_curve(tuple(nodes))
        still, following = self._standing_still(contact, at, at != x)
        shape, dispute = curve.blended(at, still)
        wrong = np.maximum(curve.estimate(at), dispute)
        shape += following[:, None]
        rows = np.array([self.known[node][: OUTLINE + 1] for node in nodes])
        traced = between_good(nodes, np.isfinite(rows[:, OUTLINE]), at)
        outline = np.where(traced[:, None], shape[:, 2:] - shape[:, :1], np.nan)
        added = np.interp(at, nodes, np.abs(rows[:, CHANGE]))
        error += cell_error.force_error(outline, self.cells, added, edges=bool(self.indenter.corners))
        shape_error = np.maximum(wrong, cell_error.outline_error(outline, self.cells))
        return Refined(force, stiffness, shape, error, shape_error, traced)

    def _standing_still(self, contact: PathPoint | PerturbedContact, at: Array, frozen: Flags) -> tuple[Array, Array]:
        """ln a of round contacts at positions, and how much further it is where ratios to them stand still, shape (n,)."""
        radius = np.log(contact.radius)
        still = np.array(radius)
        if frozen.any():
            still[frozen] = np.log(self._theory_at(at[frozen]).radius)
        return still, radius - still

    def _theory_at(self, x: Array) -> Theory:
        """Theory where ratios stand still, which is at one depth or a few."""
        places, index = np.unique(x, return_inverse=True)
        theory = self.theory.at(places)
        return Theory(theory.force[index], theory.growth[index], theory.radius[index])

    def _new_force_curve(self, known: tuple[float, ...]) -> ForceCurve:
        """Curves through the forces."""
        rows = np.array([self.known[node] for node in known])
        noise = (_CORNER_SLOPE_NOISE if self.indenter.corners else _SLOPE_NOISE) / self.cells
        force, growth = rows[:, FORCE] + np.log(self.kernel.modulus), rows[:, GROWTH]
        return force_curve(np.array(known), force, growth, noise, self.theory, similar=self._self_similar)

    def _new_shape_curve(self, known: tuple[float, ...]) -> ShapeCurve:
        """Curves through radii, areas and outlines."""
        nodes = np.array(known)
        radius = self.theory.at(nodes).radius
        turned = radius >= self.theory.turning(radius) if nodes.size > 1 else np.zeros(1, dtype=bool)
        return shape_curve(
            nodes, np.array([self.known[node][RADIUS:] for node in known]), np.log(radius), turned, self._sectors
        )

    @property
    def _self_similar(self) -> bool:
        """Whether one solution serves every size: neither tip nor medium has a length."""
        return self.indenter.exponent is not None and bool(self.kernel.homogeneous or self.kernel.exponent)

    def _clipped(self, x: Array, nodes: Array | None = None) -> Array:
        """Positions ln d at which to interpolate; the theory carries on from there."""
        if self._self_similar:
            return np.full_like(x, next(iter(self.known), x.max()))
        if nodes is not None:
            return np.clip(x, nodes[0], nodes[-1])
        if self.indenter.exponent is not None:
            return np.maximum(x, self._least)
        return np.asarray(np.maximum(x, x.max() - _DECADES * np.log(10)))

    @property
    def _least(self) -> float:
        """ln d below which a tip without a length touches nothing but the surface's half-space."""
        return self.spacing.depth_of(_THINNEST * self.kernel.length) if self.indenter.exponent is not None else -np.inf

    def _few(self, x: Array) -> bool:
        """Whether solutions at x are no more than interpolation would take, and far enough apart for curves through them."""
        known, new = np.array(sorted(self.known)), self._unknown(x)
        if np.any(self.spacing.between(np.union1d(known, new)) < _CLOSEST):
            return False
        return new.size <= _USUAL * self.spacing.missing(known, float(x.min()), float(x.max())).size

    def _own_nodes(self, x: Array) -> Array:
        """Positions of the solutions at x and between them, made where they are not known."""
        self._solve(self._unknown(x), alone=True)
        known = np.array(sorted(self.known))
        return np.asarray(known[(known > x.min() - _ROUNDING) & (known < x.max() + _ROUNDING)])

    def _unknown(self, x: Array) -> Array:
        """Those of the positions x at which there is no solution, each once."""
        places = np.unique(x)
        if not self.known:
            return places
        return np.asarray(places[np.abs(places[:, None] - np.array(list(self.known))).min(axis=1) > _ROUNDING])

    def _nodes(self, x: Array, rtol: float) -> Array:
        """Positions of the solutions that carry x, shape (n,), added until the estimate is below rtol."""
        low, high = float(x.min()), float(x.max())
        self._solve(self.spacing.missing(np.array(sorted(self.known)), low, high))
        while True:
            nodes, more = self._more(low, high, rtol)
            if not more.size:
                return nodes
            self._solve(more)

    def _more(self, low: float, high: float, rtol: float) -> tuple[Array, Array]:
        """Positions of known solutions that carry all between two positions, and of more that they want for that."""
        every, none = np.array(sorted(self.known)), np.empty(0)
        first = int(np.searchsorted(every, low + _ROUNDING)) - 1
        last = int(np.searchsorted(every, high - _ROUNDING))
        nodes = self.spacing.apart(every[first : last + 1])
        if nodes.size == 1:
            return nodes, none
        if nodes.size == 2 and nodes[0] < low - _ROUNDING and nodes[1] > high + _ROUNDING:
            # one gap holds it all: it is narrow enough with the help of its neighbours, or solved for itself
            around = np.array([x for x in every[max(first - 1, 0) : last + 2] if not self.spacing.far(x, low)])
            rough = around.size < _EACH or self._rough(tuple(around), rtol)[np.searchsorted(around, nodes[0])]
            return around, np.unique([low, high]) if rough else none
        middles, gaps = (nodes[1:] + nodes[:-1]) / 2, self.spacing.between(nodes)
        if nodes.size == 2 or (nodes.size < FEWEST and gaps.max() > _FAR_APART):
            return nodes, middles[[np.argmax(gaps)]]
        split = self._rough(tuple(nodes), rtol)
        if not split.any():
            return nodes, none
        shape = self._shape_curve(tuple(nodes))
        kinks, kinked = shape.kinks, np.isfinite(shape.kinks)
        # and where the steep rise after a kink begins, as long as it is not well known
        beyond = kinks + _AFTER * (nodes[1:] - kinks)
        wide = split & kinked & (gaps > _CLOSER)
        # what is wrong by far is so in both halves
        far = split & ~kinked & (gaps > _FAR_APART) & (shape.error > _FAR_OFF)
        quarters = np.concatenate([(nodes[:-1] + middles)[far] / 2, (middles + nodes[1:])[far] / 2])
        return nodes, np.concatenate([np.where(kinked, kinks, middles)[split], beyond[wide], quarters])

    def _gaps_to_halve(self, known: tuple[float, ...], rtol: float) -> Flags:
        """Whether gaps between solutions should be halved, shape (nodes - 1,)."""
        nodes = np.array(known)
        gaps, middles = self.spacing.between(nodes), (nodes[1:] + nodes[:-1]) / 2
        theory, curve, shape = self.theory.at(middles), self._force_curve(known), self._shape_curve(known)
        rows = np.array([self.known[node] for node in known])
        # needles set in, or what lies between them comes into contact
        beside = [rows[:, OUTLINE:][:, self._sectors == kind] for kind in np.unique(self._sectors)]
        ends = np.array([end for rays in beside for end in (rays.max(axis=1), rays.min(axis=1))])
        grown = np.diff(ends - rows[:, RADIUS]).max(axis=0)
        apart = np.diff(np.isfinite(rows[:, -1]))
        changing = (grown > _GROWING) | apart
        wrong = np.maximum(shape.error, shape.blended(middles, np.log(theory.radius))[1])
        rough = (curve.wrong(middles, theory.force) > rtol) & (gaps > _CLOSE)
        rough |= (wrong > _SHAPE_TOLERANCE) & (gaps > _FAR_APART)
        rough |= (wrong > _CLOSE_TOLERANCE) & (gaps > np.where(changing, _CLOSER, _CLOSE))
        rough |= (wrong > _CLOSER_TOLERANCE) & (gaps > np.where(changing, _CLOSEST_CHANGE, _CLOSER))
        return np.asarray(rough)

    def _solve(self, positions: Array, *, alone: bool = False) -> None:
        """Boundary element solutions at new positions ln d; `alone` where there is no curve between them."""
        if not positions.size:
            return
        self.known.update(zip(positions.tolist(), self.solutions(positions, alone=alone), strict=True))
        if self._cache:
            self._cache.save(self.known)

    def solutions(self, positions: Array, *, alone: bool = False) -> Array:
        """Rows of solutions at positions ln d, shape (n, 5 + angles); NaN for missing outlines."""
        outlines = {x: row[OUTLINE:] for x, row in self.known.items()}
        boxes = boxes_between(positions, outlines, self.theory.at(positions).radius, self._level_line, self.phi)
        places = [(*place, alone) for place in zip(np.exp(positions).tolist(), *boxes, strict=True)]
        found = shared_out(solved_row, self._case, places, helped=self.cells <= SHARED_CELLS)
        self.notes |= dict.fromkeys(note for _, notes in found for note in notes)
        return np.array([row for row, _ in found])

    def call_helpers(self, contacts: int) -> None:
        """Let other processes load boundary elements meanwhile, for a curve of so many contacts of which nothing is known."""
        if not self.known and not self._self_similar and self.cells <= SHARED_CELLS:
            call_helpers(solved_row.__module__, self._case, contacts)

    @cached_property
    def _sectors(self) -> Indices:
        return sectors(self.indenter, self.phi)

    @cached_property
    def _level_line(self) -> Array:
        return level_line(self.indenter, self.phi)

    @cached_property
    def _case(self) -> Case:
        # the flat punches known of a medium are not needed for this, and may be many
        kernel = replace(self.kernel, solution=None, cache={})
        return Case(kernel, self.indenter, self.phi.size, self.cells)


@lru_cache(maxsize=32)
def correction(
    kernel: Kernel, indenter: Indenter, series: RoundSeries, angles: int, cells: int, folder: str | None = None
) -> Correction:
    """The solutions of a medium and an indenter; those already made are shared."""
    return Correction(kernel, indenter, series, angles, cells, folder)
