"""All asperities at once: each sinks into what the others press down, by Newton's method with products of matrices alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from flatpunch._support.checks import ROUNDING, Array
from flatpunch.rough.asperity_laws import Interactions, Law

_STEPS = 60
"""Most steps of Newton's method; ten are usual."""

_LINEAR = 1e-3
"""Relative residual of the linear equations of a step: each gains three digits for a few products of matrices."""

_EXACT = 1e-9
"""Relative residual of the stiffness."""

_FEW, _MOST = 6, 10
"""Products of a solution above which the matrix is factorised anew; most restarts of 20 products, and most halvings of a step
that does not bring the equations nearer."""


@dataclass(frozen=True, slots=True)
class Pressed:
    """Depths of all asperities below the surface that the others have pressed down [m], depth of the highest, dF/dd [N/m]."""

    depths: Array
    depth: float
    stiffness: float
    converged: bool


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

    def _coupled(self, at: State, force: Array, r2: Array, r4: Array) -> Array:
        """Depths taken by forces whose pressures have the moments r2 and r4 [m]."""
        lap = self.between.lap @ np.column_stack([force, force * r2])
        twice = self.between.twice @ np.column_stack([force, force * r2, force * r4])
        second = (at.s * lap[:, 0] + lap[:, 1]) / 4
        return self.between.g @ force + second + (at.s4 * twice[:, 0] + 4 * at.s * twice[:, 1] + twice[:, 2]) / 64

    def sunk(self, at: State) -> tuple[Array, list[Array], list[Array]]:
        """Depths taken by the neighbours [m]; gradients of the surface, and how far contacts move downwards, along x and y."""
        gradients = [slope @ at.force for slope in self.between.slopes]
        moved = [at.curved * gradient for gradient in gradients]
        uphill = sum(
            slope @ (at.force * by) - gradient * by / 2
            for slope, by, gradient in zip(self.between.slopes, moved, gradients, strict=True)
        )
        return self._coupled(at, at.force, at.m, at.m4) + uphill, gradients, moved

    def _change(self, at: State, moved: list[Array]) -> LinearOperator:
        """Derivatives of depths plus depths taken, by all depths."""
        lap, twice = self.between.lap @ at.force, self.between.twice @ np.column_stack([at.force, at.force * at.m])
        # d(F m) = K s dd, and s, s4 grow with the contact
        own = 1 + at.growth * (at.s * lap / 2 + (4 * at.s4 * twice[:, 0] + 8 * at.s * twice[:, 1]) / 64)

        def product(change: Array) -> Array:
            by = change.ravel()
            force = at.stiffness * by
            found = own * by + self._coupled(at, force, at.s, at.s4)
            for slope, place in zip(self.between.slopes, moved, strict=True):
                sideways = slope @ np.column_stack([force, place * force])
                found += sideways[:, 1] - place * sideways[:, 0] + slope @ (at.force * at.curved * sideways[:, 0])
            return np.asarray(found)

        return LinearOperator((own.size, own.size), matvec=product, dtype=float)

    def solve(self, target: float, start: Pressed | None, *, by_depth: bool) -> Pressed:
        """All depths at the depth of the highest asperity, or at a total force."""
        if target == 0:
            return Pressed(-self.lower, 0.0, 0.0, True)
        deepest = float(np.exp(max(law.last for law in self.laws)))
        begin = deepest / 2 if start is None else start.depth
        depth = target if by_depth else begin
        depths = depth - self.lower
        if start is not None:
            depths = np.where(start.depths > 0, start.depths, depths)
        at, short, missing = self._missing(depths, depth, target, by_depth=by_depth)
        nearby = _Nearby()
        for _ in range(_STEPS):
            change, rise = self._step(at, short, missing, nearby, by_depth=by_depth)
            if max(np.abs(change).max(), abs(rise)) <= ROUNDING * deepest:
                return Pressed(depths, depth, self._stiffness(at, nearby), True)
            before, share = _size(short, missing, target, deepest, by_depth=by_depth), 1.0
            for _ in range(_MOST):
                trial = depths + share * change, depth + share * rise
                found = self._missing(*trial, target, by_depth=by_depth)
                if _size(*found[1:], target, deepest, by_depth=by_depth) < before:
                    break
                share /= 2
            (depths, depth), (at, short, missing) = trial, found
        return Pressed(depths, depth, np.nan, False)

    def _missing(self, depths: Array, depth: float, target: float, *, by_depth: bool) -> tuple[State, Array, float]:
        """State, and what depths and force lack [m], [N]."""
        at = self.state(depths)
        short = depth - self.lower - depths - self.sunk(at)[0]
        return at, short, 0.0 if by_depth else target - float(at.force.sum())

    def _step(self, at: State, short: Array, missing: float, nearby: _Nearby, *, by_depth: bool) -> tuple[Array, float]:
        """Changes of all depths and of the depth of the highest."""
        change, total = self._change(at, self.sunk(at)[2]), float(at.stiffness.sum())
        if by_depth:
            return nearby.solved(self, at, change, short, _LINEAR), 0.0
        if total == 0:
            # without contact nothing is known of the force: down to the highest
            rise = float(self.lower.max() + np.exp(self.laws[0].last)) / 2
            return short + rise, rise
        # the response to a rise of the plane is that of the depths to a common shortage
        closing, unit = (nearby.solved(self, at, change, each, _LINEAR) for each in (short, np.ones(short.size)))
        rise = (missing - float(at.stiffness @ closing)) / float(at.stiffness @ unit)
        return closing + rise * unit, rise

    def _stiffness(self, at: State, nearby: _Nearby) -> float:
        change = self._change(at, self.sunk(at)[2])
        return float(at.stiffness @ nearby.solved(self, at, change, np.ones(at.force.size), _EXACT))

    def near(self, at: State) -> NDArray[np.float32]:
        """The matrix of `_change`, in single precision, shape (n, n)."""
        low = np.float32
        lap, twice = self.between.lap.astype(low), self.between.twice.astype(low)
        found = self.between.g.astype(low)
        found += (at.s[:, None] + at.s).astype(low) * lap / 4
        found += (at.s4[:, None] + 4 * at.s[:, None] * at.s + at.s4).astype(low) * twice / 64
        for gradient, place in zip(self.between.slopes, self.sunk(at)[2], strict=True):
            slope = gradient.astype(low)
            found += (place - place[:, None]).astype(low) * slope
            found += (slope * (at.force * at.curved).astype(low)) @ slope
        found *= at.stiffness.astype(low)
        found.flat[:: at.s.size + 1] += 1
        return found

    def errors(self, pressed: Pressed) -> Array:
        """Errors of the depths [m]: what is left out of the interactions.

        Twice the size of the last term of the series and of the next one, summed over the neighbours without their signs, and to
        second order from the difference of the curvatures of the depressed surface along two directions, over
        that of the tip. Tips that are not round act as round ones: the second term as well.
        """
        found = np.zeros(pressed.depths.size)
        chosen = np.flatnonzero(pressed.depths > 0)
        if chosen.size < 2:
            return found
        at, depths = self.state(pressed.depths), pressed.depths[chosen]
        force, s, s4, m, m4, curved = (each[chosen] for each in (at.force, at.s, at.s4, at.m, at.m4, at.curved))
        not_round = ~self.round[self.kind[chosen]]
        # mean r^6, as if the next ratio of moments were the last one
        s6, m6 = s4**2 / s, m4**2 / m
        for rows, _, r, (_, lap, twice, thrice, slope) in self.between.blocks(chosen):
            skew = curved[rows] * (np.abs(lap - 2 * slope / r) @ force)
            lap, twice, thrice = (np.abs(each) for each in (lap, twice, thrice))
            a, a4 = s[rows], s4[rows]
            second = (a * (lap @ force) + lap @ (force * m)) / 4
            fourth = (a4 * (twice @ force) + 4 * a * (twice @ (force * m)) + twice @ (force * m4)) / 64
            sixth = s6[rows] * (thrice @ force) + 9 * a4 * (thrice @ (force * m)) + 9 * a * (thrice @ (force * m4))
            sixth = (sixth + thrice @ (force * m6)) / 2304
            left_out = 2 * (fourth + sixth) + np.where(not_round[rows], second, 0.0)
            found[chosen[rows]] = left_out + depths[rows] * skew**2 / 2
        return found


@dataclass(slots=True)
class _Nearby:
    """Factors of the matrix of an earlier state, by which equations are solved in a few products."""

    factors: tuple[Array, Array] | None = None
    products: int = 0

    def solved(self, group: Group, at: State, equations: LinearOperator, right: Array, residual: float) -> Array:
        """Solution of linear equations."""
        if self.factors is None or self.products > _FEW:
            self.factors = lu_factor(group.near(at), overwrite_a=True, check_finite=False)
        factors, self.products = self.factors, 0

        def counted(_: float) -> None:
            self.products += 1

        inverse = LinearOperator(equations.shape, lambda v: lu_solve(factors, v.astype(np.float32)), dtype=float)
        found, _ = gmres(
            equations,
            right,
            rtol=residual,
            atol=0.0,
            M=inverse,
            maxiter=_MOST,
            callback=counted,
            callback_type="pr_norm",
        )
        return np.asarray(found)


def _size(short: Array, missing: float, target: float, deepest: float, *, by_depth: bool) -> float:
    """How far the equations are from being met."""
    return max(float(np.abs(short).max()) / deepest, 0.0 if by_depth else abs(missing) / target)
