"""Smooth curves through boundary element solutions over x = ln d, and what they are expected to err by between these."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from flatpunch._support.checks import Array, Indices
from flatpunch.contact.refined.reference import BASE, NOTHING, TheoryAt
from flatpunch.contact.refined.splines import leading, left_out_of_hermite, off_smoother, settled_slopes
from flatpunch.indenters.geometry.flat_end import beside_flat_end

FEWEST = 5
"""Solutions below which leaving one out tells little, over ranges of some spacings."""
_CAUTION = 1.3
"""What is told as interpolation error over what leaving a solution out tells, which decides on more of them (catalogue)."""
_DISPUTE = 0.7
"""Error of the force over the difference between the two best curves, through five solutions: few may please one by chance."""
_FLAT, _FLAT_MOST = 300.0, 1.0
"""Distance in ln d over the noise of slopes, and at most, from which on values tell slopes as well beside the edge of a flat end:
forces scatter by some 0.5 over the number of cells a side there."""
_PUNCH = 1.1
"""dln F/dln d up to which the contact is that end, and force in proportion to depth."""
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class ForcePart:
    """A smooth curve that is added to column `form` of a theory's forces.

    Both estimates of its error in each gap between the nodes, shape (gaps,), are infinite where it does not hold: `error` is what
    leaving out a solution tells, `spread` what a smoother curve does.
    """

    form: int
    curve: Callable[..., Array]
    error: Array
    spread: Array

    @property
    def wrong(self) -> Array:
        """The larger of both in each gap."""
        return np.asarray(np.maximum(self.error, self.spread))


@dataclass(frozen=True, slots=True)
class ForceCurve:
    """ln F over x = ln d: in each gap between solutions a theory's and the smooth curve that are trusted most there.

    All pass through the same values and slopes. `chosen` are the numbers of the part for each gap and of the next best, which is
    the same where there is no other; shape (2, gaps).
    """

    nodes: Array
    parts: tuple[ForcePart, ...]
    chosen: Indices

    @classmethod
    def of(cls, nodes: Array, parts: list[ForcePart]) -> ForceCurve:
        """The parts with the least error in each gap and in those beside it: in one gap many may please by chance."""
        wrong = np.array([part.wrong for part in parts])
        beside = np.pad(np.where(np.isfinite(wrong), wrong, 0.0), ((0, 0), (1, 1)))
        around = np.maximum(wrong, np.maximum(beside[:, :-2], beside[:, 2:]))
        best, after = np.argsort(around, axis=0, kind="stable")[[0, min(1, len(parts) - 1)]]
        holds = np.isfinite(wrong[after, np.arange(wrong.shape[1])])
        return cls(nodes, tuple(parts), np.stack([best, np.where(holds, after, best)]))

    def at(self, x: Array, theory: Array, nu: int = 0) -> Array:
        """ln F at x, or its derivative, where the theory has forces or growths `theory`, shape (n, forms)."""
        gap = self._gap(x)
        best, after = (self._by(chosen[gap], x, theory, nu) for chosen in self.chosen)
        # between solutions the round contact may turn back
        return np.where(np.isfinite(best), best, after)

    def estimate(self, x: Array, theory: Array) -> Array:
        """Estimated error at x, shape (n,): none at a solution but for what curves may differ by."""
        if self.nodes.size == 1:
            return np.zeros_like(x)
        gap = self._gap(x)
        error, spread = self._of_best("error")[gap], self._of_best("spread")[gap]
        solved = np.abs(self.nodes[:, None] - x).min(axis=0) < _ROUNDING
        worse = np.where(solved, 0.0, np.maximum(_CAUTION * error, spread))
        return np.asarray(np.maximum(worse, self._dispute(x, theory)))

    def wrong(self, middles: Array, theory: Array) -> Array:
        """What decides on another solution in gaps with these middles: the error without caution, and the dispute there."""
        return np.asarray(np.maximum(self._of_best("wrong")[self._gap(middles)], self._dispute(middles, theory)))

    def _of_best(self, name: str) -> Array:
        """An estimate of the part chosen in each gap."""
        values = np.array([getattr(part, name) for part in self.parts])
        return np.asarray(np.take_along_axis(values, self.chosen[:1], axis=0)[0])

    def _dispute(self, x: Array, theory: Array) -> Array:
        """Estimated error from the difference to the next best curve."""
        gap = self._gap(x)
        one, two = (self._by(chosen[gap], x, theory, 0) for chosen in self.chosen)
        difference = np.nan_to_num(np.abs(one - two), nan=np.inf)
        return np.asarray(_DISPUTE * min(1.0, FEWEST / self.nodes.size) * difference)

    def _gap(self, x: Array) -> Indices:
        return np.clip(np.searchsorted(self.nodes, x) - 1, 0, self.chosen.shape[1] - 1)

    def _by(self, chosen: Indices, x: Array, theory: Array, nu: int) -> Array:
        """Curves of the numbers `chosen` at x, shape (n,)."""
        values = np.empty_like(x)
        for number, part in enumerate(self.parts):
            here = chosen == number
            if here.any():
                values[here] = part.curve(x[here], nu) + theory[here, part.form]
        return values


def line(x: float, value: float, slope: float) -> Callable[..., Array]:
    """Curve through one solution."""
    return lambda at, nu=0: np.full_like(at, slope) if nu else value + slope * (at - x)


def _far_enough(nodes: Array, growth: Array, noise: float, theory: TheoryAt) -> Indices:
    """Numbers of the solutions that curves go through: under flat ends those next to others would spoil what slopes know."""
    beside = beside_flat_end(theory.indenter, theory.at(nodes).radius) & (growth < _PUNCH)
    close = min(_FLAT * noise, _FLAT_MOST)
    kept = [0]
    for i in range(1, nodes.size):
        if not beside[i] or nodes[i] - nodes[kept[-1]] > close:
            kept.append(i)
    if kept[-1] != nodes.size - 1 and len(kept) > 1:
        # the last one in the place of the one it is next to
        kept[-1] = nodes.size - 1
    if len(kept) == 2 < nodes.size:
        # curves through two tell nothing of what they err by
        kept.insert(1, int(np.abs(nodes[1:-1] - (nodes[0] + nodes[-1]) / 2).argmin()) + 1)
    return np.array(kept)


def force_curve(
    nodes: Array, force: Array, growth: Array, noise: float, theory: TheoryAt, *, similar: bool = False
) -> ForceCurve:
    """The curves through solutions that leaving one out changes least.

    Parameters
    ----------
    nodes : array, shape (n,)
        Positions ln d of the solutions.
    force, growth : array, shape (n,)
        Their ln F and dln F/dln d.
    noise : float
        Error of the latter.
    theory : TheoryAt
        What they are compared with.
    similar : bool
        Whether a single solution serves every size.
    """
    kept = _far_enough(nodes, growth, noise, theory)
    nodes, force, growth = nodes[kept], force[kept], growth[kept]
    there = theory.at(nodes)
    if nodes.size == 1:
        slope = 0.0 if similar else float(growth[0] - there.growth[0, BASE])
        only = line(float(nodes[0]), float(force[0] - there.force[0, BASE]), slope)
        return ForceCurve.of(nodes, [ForcePart(BASE, only, np.zeros(1), np.zeros(1))])
    between, turning = theory.at((nodes[1:] + nodes[:-1]) / 2), theory.turning(there.radius)
    held: dict[int, Array] = {}
    # slopes as the ratios to either have them, weighted by how well they are known
    total, weight, least = np.zeros((3, nodes.size))
    for form in (BASE, NOTHING):
        ratios, growths = force - there.force[:, form], growth - there.growth[:, form]
        good, inside = np.isfinite(ratios) & np.isfinite(growths), np.isfinite(between.force[:, form])
        if form != NOTHING:
            good, inside = good & (there.radius < turning), inside & (between.radius < turning)
        count = leading(good, inside)
        if count > 1:
            held[form] = ratios[:count]
            slopes, doubt = settled_slopes(nodes[:count], ratios[:count], growths[:count], noise)
            share = 1 / np.maximum(doubt, _ROUNDING) ** 2
            total[:count] += share * (slopes + there.growth[:count, form])
            weight[:count] += share
            least[:count] = np.maximum(least[:count], share)
    settled, doubts = total / weight, 1 / np.sqrt(least)
    parts = []
    for form, ratios in held.items():
        count = ratios.size
        slopes = settled[:count] - there.growth[:count, form]
        beside = left_out_of_hermite(nodes[:count], ratios, slopes, doubts[:count])
        error, spread = np.full((2, nodes.size - 1), np.inf)
        error[: count - 1] = np.maximum(beside[1:], beside[:-1])
        spread[: count - 1] = off_smoother(nodes[:count], ratios, slopes)
        curve = scipy.interpolate.CubicHermiteSpline(nodes[:count], ratios, slopes)
        parts.append(ForcePart(form, curve, error, spread))
    return ForceCurve.of(nodes, parts)
