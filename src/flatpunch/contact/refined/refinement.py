"""The adaptive loop: where along a curve boundary elements are solved.

A curve begins with a few evenly spaced solutions over ln d. Each gap between two of them is halved, and the solution at its
middle measures the error that the curve had there. Both halves are halved again as long as that miss exceeds the tolerance. The
miss is also the reported interpolation error of both halves. Solutions are kept, so that later curves on the same medium and
tip add only what lies outside.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from flatpunch._support.byte_cache import PROCESS, byte_cached
from flatpunch._support.checks import Array, BadValue
from flatpunch._support.prefixes import text
from flatpunch.bem import NotConverged
from flatpunch.bem.curves import SHARED_CELLS
from flatpunch.compliances import Kernel
from flatpunch.contact.boundary_elements.expected_box import POWER, boxes_between, level_line
from flatpunch.contact.curve import NOTABLE_OUTLINE, ControlName
from flatpunch.contact.exact import punch_stiffness
from flatpunch.contact.refined.interpolation import Interpolation, RoundReference
from flatpunch.contact.refined.sample import Case, Sample, SampleCache, solved
from flatpunch.indenters.profile import Indenter
from flatpunch.parallel.engine import shared_out


class Gap(NamedTuple):
    """Gap between two solutions.

    Its ends in ln d, and the errors at the midpoint it came from, beyond the error of the cells: ln F, its slope
    times the width of the gap, and the outline over the mean radius; infinite where the gap came from no other.
    """

    left: float
    right: float
    force: float = np.inf
    slope: float = np.inf
    outline: float = np.inf

    @property
    def missed(self) -> tuple[float, float]:
        """Interpolation errors to report, of force and outline."""
        # error of the force over the miss of its slope at the middle times the width of a half gap; 1/15 if all slopes err alike
        return max(self.force, self.slope / 4), self.outline

    def rough(self, rtol: float) -> bool:
        """Whether it should be halved."""
        unknown = not np.isfinite(self.force)
        # the outline may miss by 5 % of the mean radius; 2 % take half as many solutions again. Gaps of a tenth are not halved:
        # contacts that change abruptly would be solved without end
        return unknown or (self.right - self.left > 1 / 10 and (self.force > rtol or self.outline > NOTABLE_OUTLINE))


class Refinement:
    """Boundary element solutions of one indenter on one medium, kept in a folder if one is given."""

    def __init__(self, kernel: Kernel, indenter: Indenter, angles: int, cells: int, folder: str | None) -> None:
        self.reference = RoundReference(kernel, indenter)
        # punches known of the medium are not needed for the solutions, and may be many
        self._case = Case(replace(kernel, solution=None), indenter, angles, cells)
        self._phi = np.asarray(np.arange(angles) * (2 * np.pi / angles))
        self._cache = SampleCache(Path(folder), kernel, indenter, angles, cells) if folder is not None else None
        self.samples: dict[float, Sample] = {}
        self.gaps: list[Gap] = []
        if self._cache:
            self.samples, gaps = self._cache.load()
            self.gaps = [Gap(*row) for row in gaps]
        self._curve: tuple[tuple[Gap, ...], Interpolation] | None = None

    @property
    def self_similar(self) -> bool:
        """Whether one solution serves every size: neither tip nor medium has a length."""
        kernel = self._case.kernel
        return self._case.indenter.exponent is not None and bool(kernel.homogeneous or kernel.exponent)

    def along_depths(self, x: Array, rtol: float) -> Interpolation:
        """Contacts at positions x = ln d, each solved by itself where that takes no more solutions than a curve."""
        if self.self_similar:
            return self._single(float(x.max()))
        x = np.unique(np.maximum(x, self._least(float(x.max()))))
        low, high = float(x[0]), float(x[-1])
        if not self._covered(low, high, rtol):
            if x.size <= 1 + 2 * np.ceil((high - low) / self._spacing):
                self.solve(x.tolist())
                return self._interpolation(x, np.zeros((x.size - 1, 2)))
            self._cover(low, high, rtol)
        return self.curve()

    def enclosing(self, quantity: ControlName, wanted: Array, rtol: float) -> Interpolation:
        """Contacts that enclose all wanted values of ln F/E* ("force") or ln a0 ("radius")."""
        ends = np.array([wanted.min(), wanted.max()])
        guess = self.reference.position(quantity, ends)
        if self.self_similar:
            return self._single(float(guess[1]))
        low, high = self._ends(quantity, ends, guess, self._least(float(guess[1])))
        if low == high:
            return self._single(low)
        self._cover(low, high, rtol)
        return self.curve()

    def curve(self) -> Interpolation:
        """The curve through the solutions at the ends of all gaps."""
        gaps = tuple(self.gaps)
        if self._curve is None or self._curve[0] != gaps:
            nodes = np.array([gap.left for gap in gaps] + [gaps[-1].right])
            self._curve = gaps, self._interpolation(nodes, np.array([gap.missed for gap in gaps]))
        return self._curve[1]

    def solve(self, positions: Iterable[float]) -> None:
        """Add the solutions at positions ln d that are not known."""
        new = np.array(sorted({x for x in positions if x not in self.samples}))
        if not new.size:
            return
        outlines = {x: sample.shape[2:] for x, sample in self.samples.items()}
        radius = np.exp(self.reference.at(new)[2])
        boxes = boxes_between(new, outlines, radius, level_line(self._case.indenter, self._phi), self._phi)
        places = list(zip(np.exp(new).tolist(), *boxes, strict=True))
        found = shared_out(solved, self._case, places, helped=self._case.cells <= SHARED_CELLS)
        self.samples.update(zip(new.tolist(), found, strict=True))
        PROCESS.grown(sum(sample.shape.nbytes for sample in found))
        if self._cache:
            self._cache.save(self.samples, self.gaps)

    def _covered(self, low: float, high: float, rtol: float) -> bool:
        inside = bool(self.gaps) and self.gaps[0].left <= low and self.gaps[-1].right >= high
        return inside and not any(gap.rough(rtol) for gap in self._between(low, high))

    def _between(self, low: float, high: float) -> list[Gap]:
        return [gap for gap in self.gaps if gap.right > low and gap.left < high]

    def _cover(self, low: float, high: float, rtol: float) -> None:
        self._extend(low, high)
        while rough := [gap for gap in self._between(low, high) if gap.rough(rtol)]:
            before, middles = self.curve(), [(gap.left + gap.right) / 2 for gap in rough]
            self.solve(middles)
            halves = {gap: self._halved(gap, x, before) for gap, x in zip(rough, middles, strict=True)}
            self.gaps = [half for gap in self.gaps for half in halves.get(gap, (gap,))]
        if self._cache:
            self._cache.save(self.samples, self.gaps)

    def _halved(self, gap: Gap, middle: float, before: Interpolation) -> tuple[Gap, Gap]:
        """Both halves of a gap, with what the curve before has missed at its middle."""
        predicted, found = before.at(np.array([middle])), self.samples[middle]
        # differences within the error of the cells are reported with it, and are not reduced by closer solutions
        force = max(abs(float(predicted.force[0]) - found.force) - found.force_error, 0.0)
        # an error that all slopes share cancels in the force at the middle and shows in its slope there
        slope = abs(float(predicted.growth[0]) - found.growth) * (middle - gap.left)
        outline = shape_difference(predicted.shape[0], found.shape)
        outline -= min(found.shape_error, outline) if found.outlined else 0.0
        return Gap(gap.left, middle, force, slope, outline), Gap(middle, gap.right, force, slope, outline)

    def _extend(self, low: float, high: float) -> None:
        """Add gaps, no wider than the first spacing, until they reach from `low` to `high`."""
        first, last = (self.gaps[0].left, self.gaps[-1].right) if self.gaps else (high, high)
        # a little less depth later on costs nothing new
        before = self._pieces(min(low, first - self._spacing / 4) if self.gaps else low, first) if low < first else []
        after = self._pieces(last, high) if high > last else []
        self.solve([x for gap in before + after for x in gap[:2]])
        self.gaps = before + self.gaps + after

    def _pieces(self, low: float, high: float) -> list[Gap]:
        nodes = np.linspace(low, high, int(np.ceil((high - low) / self._spacing)) + 1).tolist()
        return [Gap(left, right) for left, right in pairwise(nodes)]

    def _ends(self, quantity: ControlName, wanted: Array, guess: Array, least: float) -> tuple[float, float]:
        """Positions of solutions between which all wanted values lie; `least` where smaller ones need no solution."""
        known = sorted({x for gap in self.gaps for x in gap[:2]})
        for _ in range(40):
            values = [self._value(quantity, x) for x in known]
            above = [x for x, value in zip(known, values, strict=True) if value >= wanted[1]]
            below = [
                x for x, value in zip(known, values, strict=True) if value <= wanted[0] and x <= min(above, default=x)
            ]
            if above and (below or known[0] <= least):
                return max(below, default=known[0]), min(above)
            new = set(np.maximum(guess, least).tolist()) if not known else set()
            if known and not above:
                new.add(known[-1] + self._step(quantity, known[-2:], wanted[1]))
            if known and not below and known[0] > least:
                new.add(max(known[0] + self._step(quantity, known[1::-1], wanted[0]), least))
            self.solve(sorted(new))
            if lost := [x for x in new if not self.samples[x].converged]:
                raise NotConverged(
                    f"boundary elements do not converge at a depth of {text(float(np.exp(lost[0])), 'm')} on the way there "
                    f"({self.samples[lost[0]].notes[0]}). Prescribe a smaller {quantity}, or take method='second-order'."
                )
            known = sorted({*known, *new})
        scale, unit = (self._case.kernel.modulus, "N") if quantity == "force" else (1.0, "m")
        asked, most = (text(float(scale * np.exp(value)), unit) for value in (wanted[1], max(values)))
        raise BadValue(
            quantity,
            asked,
            f"is not reached: the largest is {most} at a depth of {text(float(np.exp(known[-1])), 'm')}. "
            "Prescribe the depth instead, or choose method='bem'.",
        )

    def _step(self, quantity: ControlName, beside: list[float], wanted: float) -> float:
        """How far beyond the last of the positions beside it a value is expected, and a little farther."""
        *before, last = beside
        value, growth = self._value(quantity, last), 1 / (self._case.indenter.exponent or 1.0)
        if quantity == "force":
            growth = self.samples[last].growth
        elif before:
            growth = float(np.clip((value - self._value(quantity, before[0])) / (last - before[0]), 0.1, 10.0))
        step = (wanted - value) / growth
        # how far in ln d a solution is placed beyond where it should enclose a prescribed force or radius
        return max(-self._spacing, min(step + float(np.copysign(0.01, step)), self._spacing))

    def _value(self, quantity: ControlName, x: float) -> float:
        sample = self.samples[x]
        value: float = sample.force if quantity == "force" else sample.shape[0]
        return value

    def _single(self, x: float) -> Interpolation:
        """The one solution that serves every size, solved at x if there is none."""
        at = next(iter(self.samples)) if self.self_similar and self.samples else x
        self.solve([at])
        return self._interpolation(np.array([at]), np.zeros((0, 2)))

    def _interpolation(self, nodes: Array, missed: Array) -> Interpolation:
        return Interpolation(self.reference, nodes, tuple(self.samples[x] for x in nodes.tolist()), missed)

    def _least(self, top: float) -> float:
        """ln d below which ratios to the round contact are constant, where the largest is `top`."""
        kernel, indenter = self._case.kernel, self._case.indenter
        if indenter.exponent is None:
            # decades of depth below the largest at which the ratios of tips with lengths of their own are constant
            return top - float(np.log(1e6))
        # what a medium changes of punches this small, over its length, grows in proportion to their radius
        tiny = 1e-4 * kernel.length
        (stiffness,) = punch_stiffness(kernel, np.array([tiny]))
        departure = abs(float(stiffness) / (2 * kernel.modulus * tiny) - 1)
        # departure from a half-space, at the farthest point of the contact, below which ratios are constant to about as much; at
        # most a hundred times that radius
        size = 1e-4 * tiny / max(departure, 1e-6) * np.exp(-POWER * level_line(indenter, self._phi).max())
        return float(self.reference.position("radius", np.log([size]))[0])

    @cached_property
    def _spacing(self) -> float:
        # widest first gap in ln d over the exponent of a power-law tip; twice as wide, a miss may be small by chance
        return 1.2 * (self._case.indenter.exponent or 1.0)


def shape_difference(one: Array, other: Array) -> float:
    """Largest distance of two outlines over the mean radius, across them; of the mean radii where one has no outline.

    Shapes are those of `Sample`. Rays beside a narrow contact lobe meet its flank at an angle, so the distance along rays is
    reduced by the slope of the outline.
    """
    if not (np.isfinite(one).all() and np.isfinite(other).all()):
        return float(abs(one[0] - other[0]))
    slope = (np.roll(other[2:], -1) - np.roll(other[2:], 1)) * (other.size - 2) / (4 * np.pi)
    apart = np.abs(np.exp(one[2:]) - np.exp(other[2:])) / np.hypot(1.0, slope)
    return float(apart.max() / np.exp(other[0]))


@byte_cached
def refinement(kernel: Kernel, indenter: Indenter, angles: int, cells: int, folder: str | None = None) -> Refinement:
    """The solutions of a medium and an indenter; those already made are shared."""
    return Refinement(kernel, indenter, angles, cells, folder)
