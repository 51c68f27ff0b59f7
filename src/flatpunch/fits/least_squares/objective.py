"""Residuals of a curve against the forward model, and their derivatives.

    r = w (B + M(z - z0; theta) - F)

z0 contact point, B the background (`flatpunch.fits.parameters.unknowns`). Behind a cantilever of stiffness k the noise of F has
moved the tip by -noise/k as well: known exactly is the piezo's position z + F/k. There r is the difference to the force that the
model has at that position,

    r = B + M(z - (r - B')/k - z0; theta) - F,

solved point by point by Newton's method, dr = dM/(1 + M'/k). B' is the background without its constant: tilt, interference
and drag are read by the detector and move no tip; the constant only shifts the contact point.

A force that is smooth within a stretch of the curve loses nothing by its mean, and few points cost little (`blocked`): the
background is a straight line and needs few stretches; over the contact a stretch of 1/200 of its depth errs by (1/200)^2/24 of
the curvature, 1e-6 of the force. Curves with drag in their background are not averaged.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import TINY, Array, Indices
from flatpunch.fits.measured.curve import Curve
from flatpunch.fits.parameters.unknowns import Unknowns


@dataclass(frozen=True, eq=False, kw_only=True)
class Objective(Unknowns):
    """Least-squares problem in x, see `Unknowns`.

    Points are in contact where their depth is positive, unless `loaded` says which are (indices): adhesive contacts hold on
    to negative depths. `part_loaded` is the same over all points of the curve that is shown. `softest` is the stiffness dF/dd
    [N/m] below which an adhesive contact is continued by its tangent; above -k the depth then is a function of the piezo's
    position.
    """

    loaded: Indices | None = None
    part_loaded: Indices | None = None
    softest: float | None = None
    white: Array | None = None
    """Factors (n,) or a lower triangular factor (n, n) that make residuals independent and alike; in the place of `counts`."""

    def __post_init__(self) -> None:
        Unknowns.__post_init__(self)
        if self.spring is not None:
            object.__setattr__(self, "position", self.depth + self.force / self.spring)

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Residuals, shape (n,), and derivatives, shape (parameters, n), both over the force range."""
        theta, rest = self.split(x)
        _, width, span, *_ = self.frame
        moving = self.background(rest, self.position, self.speed)
        depth = self.depth - rest["contact"]
        if self.spring is not None:
            depth += moving / self.spring
        residual, block, stiffness, by_theta = self._residual(depth, rest["baseline"] + moving - self.force, theta)
        jacobian = np.zeros((x.size, depth.size))
        count = theta.size
        jacobian[:count, block] = by_theta / span
        for j, name in enumerate(self.nuisance, start=count):
            if name == "contact":
                jacobian[j, block] = stiffness * (-width / span)
            else:
                jacobian[j] = self.column(name, rest, self.position, self.speed)
        if self.spring is not None:
            give = self._give(stiffness)
            for j, name in enumerate(self.names):
                shifts = name in ("contact", "baseline") or j < count
                if shifts:
                    jacobian[j, block] /= give
        residual = residual / span
        if self.white is not None:
            residual, jacobian = self.whitened(residual), self.whitened(jacobian)
        root = None if self.counts is None or self.white is not None else np.sqrt(self.counts)
        for weight in (self.weight, root):
            if weight is not None:
                residual *= weight
                jacobian *= weight
        return residual, jacobian

    def residuals(self, x: Array) -> Array:
        """Residuals over the force range, shape (n,)."""
        return self.evaluate(x)[0]

    def _residual(self, depth: Array, straight: Array, theta: Array) -> tuple[Array, slice | Indices, Array, Array]:
        """Residual [N], the points in contact, and stiffness and derivatives of M there."""
        # the residuals of the evaluation before are where Newton's method starts
        spring = self.spring
        residual = np.zeros_like(depth) if spring is None else self._before.get(depth.size, np.zeros_like(depth))
        at = depth if spring is None else depth - residual / spring
        fresh = not residual.any()
        softest = () if self.softest is None else (self.softest,)
        # turns of Newton's method behind a cantilever at most; two are usual
        for turn in range(8):
            block = _touching(at) if self.loaded is None else self.loaded
            force, stiffness, by_theta = self.model.evaluate(at[block], theta, *softest)
            miss = straight - residual
            miss[block] += force
            if spring is None:
                return miss, block, stiffness, by_theta
            step = miss.copy()
            step[block] /= self._give(stiffness)
            residual = residual + step
            at = depth - residual / spring
            # what is left is of second order but of one sign: it must vanish beside the error of a mean
            left = miss - step if fresh and turn == 0 else step
            # Newton's method behind a cantilever ends with a step this small against the residuals; the next would be its
            # square
            if np.abs(left).max() < 1e-2 * np.sqrt(np.mean(residual**2)):
                break
        if np.abs(residual).max() < self.frame[2]:
            self._before[depth.size] = residual
        else:
            # lost on a trial beyond an instability: nothing to start the next evaluation from
            self._before.pop(depth.size, None)
        return residual, block, stiffness, by_theta

    def _give(self, stiffness: Array) -> Array:
        """How much faster the piezo moves than the tip."""
        assert self.spring is not None
        return 1 + stiffness / self.spring

    def gives(self, x: Array) -> Array:
        """How many times larger than a residual the difference in force at the measured position of the tip is, shape (n,)."""
        theta, rest = self.split(x)
        depth = self.depth - rest["contact"]
        if self.spring is not None:
            depth = depth + self.background(rest, self.position, self.speed) / self.spring
        inside = depth > 0
        result = np.ones(depth.size)
        if self.spring is not None and inside.any():
            result[inside] = self._give(self.model.evaluate(depth[inside], theta)[1])
        return result

    def over(self, curve: Curve, x: Array) -> Array:
        """Fitted force at all points of the curve that is shown [N]."""
        theta, rest = self.split(x)
        inside, result = self._shown(curve, rest)
        touching = inside > 0 if self.part_loaded is None else self.part_loaded
        if inside[touching].size:
            result[touching] += self.model.evaluate(inside[touching], theta)[0]
        return np.asarray(result)

    def indentation(self, curve: Curve, x: Array) -> Array:
        """Indentation depth at all points of the curve that is shown [m]."""
        return self._shown(curve, self.split(x)[1])[0]

    def _shown(self, curve: Curve, rest: dict[str, float]) -> tuple[Array, Array]:
        speed = None
        if rest.get("drag"):
            speed = curve.meta["speed"]
        moving = self.background(rest, curve.position, speed)
        inside = curve.depth - rest["contact"]
        if self.spring is not None:
            inside = inside + moving / self.spring
        return inside, np.asarray(rest["baseline"] + moving)

    def whitened(self, rows: Array) -> Array:
        """Rows (..., n) with independent entries."""
        assert self.white is not None
        return np.asarray(rows * self.white if self.white.ndim == 1 else rows @ self.white.T)

    def first(self, end: int, white: Array) -> Objective:
        """Return the problem of the first readings, whitened by the same rows of a factor."""
        return replace(
            self,
            depth=self.depth[:end],
            force=self.force[:end],
            speed=None if self.speed is None else self.speed[:end],
            white=white[:end] if white.ndim == 1 else white[:end, :end],
            counts=None,
            weight=None,
            _before={},
        )

    def touch(self, x: Array) -> int:
        """The first reading in contact, of ascending positions."""
        rest = self.split(x)[1]
        bent = 0.0 if self.spring is None else rest["baseline"] / self.spring
        return int(np.searchsorted(self.position, rest["contact"] + bent))

    def contact_force(self, x: Array) -> Array:
        """Force of the contact at the positions of the readings [N]."""
        rest = self.split(x)[1]
        bare = replace(self, white=None, counts=None, weight=None, _before={})
        background = rest["baseline"] + self.background(rest, self.position, self.speed)
        return np.asarray(bare.residuals(x) * self.frame.span + self.force - background)

    def averaged(self, index: Indices) -> Objective:
        """Return the problem on means over the points with the same index, all of which are in contact or none."""
        size = np.bincount(index).astype(float)
        filled = size > 0
        loaded = None if self.loaded is None else np.unique((np.cumsum(filled) - 1)[index[self.loaded]])
        columns = {
            name: (np.bincount(index, c) / np.maximum(size, 1))[filled]
            for name in ("depth", "force", "speed")
            if (c := getattr(self, name)) is not None
        }
        return replace(self, **columns, loaded=loaded, counts=size[filled], weight=None, _before={})


def _touching(depth: Array) -> slice | Indices:
    """Points in contact: a slice where they are one stretch to the end, as a mask costs as much as the model."""
    inside = depth > 0
    start = int(np.argmax(inside)) if inside.any() else depth.size
    return slice(start, None) if inside[start:].all() else np.flatnonzero(inside)


CONTACT = 200
FREE = CONTACT // 4
"""Stretches over the contact and over the background before it; half as many move E by up to 0.24 and 0.02 standard errors."""


def blocked(objective: Objective, contact: float) -> Objective:
    """The problem on block means, fine from somewhat before `contact` (a position) on; itself where that saves nothing."""
    if objective.depth.size < 3 * (CONTACT + FREE) or "drag" in objective.nuisance:
        return objective
    position = objective.position
    first, last = float(position.min()), float(position.max())
    begin = min(max(contact - 0.3 * (last - contact), first), last)
    free = np.minimum((position - first) * (FREE / max(begin - first, TINY)), FREE - 1)
    inside = FREE + np.minimum((position - begin) * (CONTACT / max(last - begin, TINY)), CONTACT - 1)
    return objective.averaged(np.where(position < begin, free, inside).astype(np.intp))
