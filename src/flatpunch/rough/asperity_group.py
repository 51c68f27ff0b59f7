"""All asperities at once: each sinks into what the others press down, by Newton's method with products of matrices alone."""

from __future__ import annotations

import operator
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg import lu_factor, lu_solve
from scipy.optimize import brentq
from scipy.sparse.linalg import LinearOperator, gmres

from flatpunch._support.checks import ROUNDING, Array
from flatpunch.rough.asperity_laws import Interactions, Law, blocks

_STEPS = 60
"""Most steps of Newton's method; five are usual."""

_LINEAR = 1e-3
"""Relative residual of the linear equations of a step: each gains three digits for a few products of matrices."""

_EXACT = 1e-9
"""Relative residual of the stiffness."""

_FEW, _MOST = 6, 10
"""Products of a solution above which the matrix is factorised anew; most restarts of 20 products, and most halvings of a step
that does not bring the equations nearer."""


@dataclass(frozen=True, slots=True)
class State:
    """What laws give at all depths, zero without contact: forces, stiffnesses, radii, d ln a/dd, moments, radius of curvature.

    Moments are mean r^2 and r^4 of punch (s, s4) and contact (m, m4), in powers of length.
    """

    force: Array
    stiffness: Array
    radius: Array
    growth: Array
    s: Array
    s4: Array
    m: Array
    m4: Array
    curved: Array


@dataclass(frozen=True, slots=True)
class Point:
    """Depths of all asperities and of the highest below the undeformed surface [m], the state, and where the equations stand.

    `moved` is how far contacts move downwards along x and y [m], shape (2, n), `own` the derivative of depth plus depth taken by
    the own depth, `short` and `missing` what depths [m] and the force [N] lack, `size` the largest of them, relative.
    """

    depths: Array
    depth: float
    at: State
    moved: Array
    own: Array
    short: Array
    missing: float
    size: float


@dataclass(frozen=True, slots=True)
class Pressed:
    """Depths of all asperities [m] with their state, depth of the highest [m], dF/dd [N/m]."""

    depths: Array
    at: State
    depth: float
    stiffness: float
    converged: bool


@dataclass(frozen=True, slots=True)
class Group:
    """Asperities with their laws, whether they are round, their distances below the highest [m], and their interactions."""

    laws: list[Law]
    kind: Array
    round: Array
    lower: Array
    between: Interactions

    def state(self, depths: Array) -> State:
        """What laws give at all depths."""
        n = depths.size
        found = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((n, 5))
        for i, law in enumerate(self.laws):
            mine = np.flatnonzero((self.kind == i) & (depths > 0))
            if mine.size:
                for values, own in zip(found, law(depths[mine]), strict=True):
                    values[mine] = own
        return State(*found[:4], *(found[4] * found[2][:, None] ** np.array([2, 4, 2, 4, 2])).T)

    def _sunk(self, at: State) -> tuple[Array, Array, Array]:
        """Depths taken by the neighbours [m]; how far contacts move [m] and derivatives by the own depths, as of `Point`."""
        force, between = at.force, self.between
        lap, lap_m = (between.lap @ each for each in (force, force * at.m))
        twice, twice_m, twice_m4 = (between.twice @ each for each in (force, force * at.m, force * at.m4))
        second, fourth = at.s * lap + lap_m, at.s4 * twice + 4 * at.s * twice_m + twice_m4
        gradients = between.gradients(force)
        moved = at.curved * gradients
        uphill = between.couples(force * moved) - (gradients * moved).sum(axis=0) / 2
        # d(F m) = K s dd, and s, s4 grow with the contact
        own = 1 + at.growth * (at.s * lap / 2 + (4 * at.s4 * twice + 8 * at.s * twice_m) / 64)
        return between.g @ force + second / 4 + fourth / 64 + uphill, moved, own

    def change(self, point: Point) -> Array:
        """Derivatives of depths plus depths taken, by all depths, shape (n, n), where contacts stay at their places."""
        between, at, n = self.between, point.at, self.lower.size
        found = np.empty((n, n))
        for rows in blocks(n):
            s, s4 = at.s[rows, None], at.s4[rows, None]
            part = between.g[rows] + (s + at.s) / 4 * between.lap[rows]
            part += (s4 + 4 * s * at.s + at.s4) / 64 * between.twice[rows]
            for x, by in zip(between.places.T, point.moved, strict=True):
                part += (by - by[rows, None]) * (x[rows, None] - x) * between.pull[rows]
            found[rows] = part * at.stiffness
        found.flat[:: n + 1] += point.own
        return found

    def solve(self, target: float, *, by_depth: bool) -> tuple[Group, Pressed]:
        """All depths at the depth of the highest asperity, or at a total force; and the group with the laws that they need."""
        if target == 0:
            return self, Pressed(-self.lower, self.state(-self.lower), 0.0, 0.0, True)
        group, equations = self, _Equations(self)
        depths, depth = self._start(target, by_depth=by_depth)
        now = self._point(depths, depth, target, by_depth=by_depth)
        for _ in range(_STEPS):
            deeper = group._reaching(now.depths) if now.size <= _LINEAR else group
            if deeper is not group:
                group, now = deeper, deeper._point(now.depths, now.depth, target, by_depth=by_depth)
            equations.move(now)
            if now.size <= ROUNDING:
                stiffness = float(now.at.stiffness @ equations.raised(_EXACT))
                return group, Pressed(now.depths, now.at, now.depth, stiffness, True)
            change, rise = equations.step(by_depth=by_depth)
            before = now
            for halvings in range(_MOST):
                share = 0.5**halvings
                depths, depth = before.depths + share * change, before.depth + share * rise
                now = group._point(depths, depth, target, by_depth=by_depth)
                if now.size < before.size:
                    break
        return group, Pressed(now.depths, now.at, now.depth, np.nan, False)

    def _point(self, depths: Array, depth: float, target: float, *, by_depth: bool) -> Point:
        """Everything at depths."""
        at = self.state(depths)
        taken, moved, own = self._sunk(at)
        short = depth - self.lower - depths - taken
        missing = 0.0 if by_depth else target - float(at.force.sum())
        size = max(float((np.abs(short) / (abs(depth) + self.lower)).max()), abs(missing) / target)
        return Point(depths, depth, at, moved, own, short, missing, size)

    def _reaching(self, depths: Array) -> Group:
        """Itself, or the group with laws tabulated up to the largest depths."""
        deepest = [float(depths[self.kind == i].max()) for i in range(len(self.laws))]
        laws = [law.reaching(each) for law, each in zip(self.laws, deepest, strict=True)]
        return self if all(map(operator.is_, laws, self.laws)) else replace(self, laws=laws)

    def _start(self, target: float, *, by_depth: bool) -> tuple[Array, float]:
        """Depths of all asperities, as if the others sank none of them, and of the highest, at about a depth or a force.

        Far deeper contacts would overlap, from where Newton's method does not find back.
        """
        alone = target if by_depth else float(np.exp(max(law.last for law in self.laws)))

        def lacks(alone: float) -> float:
            return target - float(self.state(alone - self.lower).force.sum())

        def sinks() -> float:
            at = self.state(alone - self.lower)
            return float(at.force @ self._sunk(at)[0]) / float(at.force.sum())

        if by_depth:
            while alone + sinks() > target:
                alone /= 2
            return alone - self.lower, target
        while lacks(alone) > 0:
            alone *= 2
        alone = float(brentq(lacks, 0.0, alone, xtol=ROUNDING * alone, rtol=_LINEAR))
        return alone - self.lower, alone + sinks()

    def errors(self, pressed: Pressed) -> tuple[Array, Array]:
        """Errors of the depths [m]: what is left out of the interactions, and with what errors of neighbours change.

        Twice the size of the last term of the series and of the next one, summed over the neighbours without their signs, and to
        second order from the mean and the difference of the curvatures of the depressed surface along two directions, over
        that of the tip, which also change the way uphill. Tips that are not round act as round ones: the second term as well.
        """
        found = np.zeros(pressed.depths.size)
        touching, at, depths, between = pressed.depths > 0, pressed.at, pressed.depths, self.between
        force, s, s4, m, m4 = at.force, at.s, at.s4, at.m, at.m4
        # mean r^6, as if the next ratio of moments were the last one
        s6, m6 = (np.divide(by**2, of, out=np.zeros_like(of), where=touching) for by, of in ((s4, s), (m4, m)))
        loads = np.column_stack([force, force * m, force * m4, force * m6])
        uphill = at.curved * (between.gradients(force) ** 2).sum(axis=0)
        for rows in blocks(found.size):
            # along the radius and across it: G'' and G'/r
            skew = at.curved[rows] * (np.abs(between.lap[rows] - 2 * between.pull[rows]) @ force)
            mean = at.curved[rows] * (between.lap[rows] @ force) / 2
            lap, twice, thrice = (np.abs(each[rows]) @ loads for each in (between.lap, between.twice, between.thrice))
            a, a4 = s[rows], s4[rows]
            second = (a * lap[:, 0] + lap[:, 1]) / 4
            fourth = (a4 * twice[:, 0] + 4 * a * twice[:, 1] + twice[:, 2]) / 64
            sixth = (s6[rows] * thrice[:, 0] + 9 * a4 * thrice[:, 1] + 9 * a * thrice[:, 2] + thrice[:, 3]) / 2304
            curved = depths[rows] * (skew**2 + mean**2) / 2 + uphill[rows] * (np.abs(mean) + skew / 2)
            not_round = ~self.round[self.kind[rows]]
            found[rows] = 2 * (fourth + sixth) + np.where(not_round, second, 0.0) + curved
        own = np.where(touching, found, 0.0)
        for rows in blocks(found.size):
            found[rows] = own[rows] + (between.g[rows] ** 2 @ (at.stiffness * own) ** 2) ** 0.5
        return own, np.where(touching, found, 0.0)


@dataclass(slots=True)
class _Equations:
    """Linear equations at a point, solved in a few products by the factors of the matrix at an earlier point."""

    group: Group
    point: Point = field(init=False)
    matrix: Array = field(init=False)
    factors: tuple[Array, Array] | None = None
    unit: Array | None = None
    products: int = 0

    def move(self, point: Point) -> None:
        """Go on to another point."""
        self.point, self.matrix = point, self.group.change(point)

    def _product(self, change: Array) -> Array:
        at, between = self.point.at, self.group.between
        by = change.ravel()
        return np.asarray(
            self.matrix @ by + between.couples(at.force * at.curved * between.gradients(at.stiffness * by))
        )

    def _solved(self, right: Array, residual: float, start: Array | None = None) -> Array:
        if self.factors is None or self.products > _FEW:
            self.factors = lu_factor(self.matrix.astype(np.float32), overwrite_a=True, check_finite=False)
        factors, self.products = self.factors, 0

        def counted(_: float) -> None:
            self.products += 1

        found, _ = gmres(
            LinearOperator(self.matrix.shape, self._product, dtype=float),
            right,
            start,
            rtol=residual,
            atol=0.0,
            M=LinearOperator(self.matrix.shape, lambda v: lu_solve(factors, v.astype(np.float32)), dtype=float),
            maxiter=_MOST,
            callback=counted,
            callback_type="pr_norm",
        )
        return np.asarray(found)

    def raised(self, residual: float) -> Array:
        """Changes of all depths where the plane of all asperities sinks by one."""
        self.unit = self._solved(np.ones(self.point.short.size), residual, self.unit)
        return self.unit

    def step(self, *, by_depth: bool) -> tuple[Array, float]:
        """Changes of all depths and of the depth of the highest [m]."""
        change = self._solved(self.point.short, _LINEAR)
        if by_depth:
            return change, 0.0
        unit, stiffness = self.raised(_LINEAR), self.point.at.stiffness
        rise = (self.point.missing - float(stiffness @ change)) / float(stiffness @ unit)
        return change + rise * unit, rise
