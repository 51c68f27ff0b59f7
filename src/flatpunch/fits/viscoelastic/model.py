"""Forward model of a viscoelastic fit: force over time for a measured history of the depth.

The elastic curve comes from the tables of `ForwardModel`, the memory from `flatpunch.contact.viscoelastic`, for any history;
`setup` takes curves of one or more cycles of approach, hold and retract. Behind a cantilever of stiffness k the position p
of the piezo is known, and the depth follows from the force itself,

    d(t) = p(t) - F[d](t)/k,

solved for the whole history by Newton's method with the response of the present moment alone, K times the mean of psi over the
step; what the past contributes is smaller and makes it converge in a few turns.

Derivatives of the residuals are central differences. A history cannot be cut into points of their own as a curve over depth can:
what was before is remembered. It is averaged over some hundred stretches of time, each with the weight of the readings in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.contact.viscoelastic.depth_history import force_of_depth
from flatpunch.fits.elastic.model import ForwardModel
from flatpunch.fits.least_squares.minimum import differences
from flatpunch.fits.measured.curve import Curve
from flatpunch.fits.parameters.free_parameters import ExactForce, FreeParameters
from flatpunch.fits.parameters.sample import Sample
from flatpunch.fits.parameters.settings import FitMethod
from flatpunch.fits.parameters.unknowns import Unknowns
from flatpunch.media import Relaxation


@dataclass(frozen=True)
class HistoryModel(FreeParameters):
    """Force over time of one medium and tip, as a function of the free parameters.

    Parameters
    ----------
    sample : Sample
        The case with its relaxation.
    free : tuple of str
        Names such as "layers[0].young", "relaxation.time".
    method : str or method
        Contact method, or "auto".
    """

    sample: Sample
    free: tuple[str, ...] = ()
    method: FitMethod = "auto"
    over_time: ClassVar[bool] = True
    elastic: ForwardModel = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        self.sample.check(self.free)
        plain = tuple(name for name in self.free if not name.startswith("relaxation."))
        elastic = ForwardModel(self.sample.medium, self.sample.indenter, plain, self.method)
        object.__setattr__(self, "elastic", elastic)
        object.__setattr__(self, "method", elastic.method)

    @property
    def tabulated(self) -> bool:
        """Whether elastic forces come from a table."""
        return self.elastic.tabulated

    @property
    def knots(self) -> Mapping[str, tuple[float, float]]:
        """Those of the elastic force."""
        return self.elastic.knots

    def relaxation(self, theta: Array) -> Relaxation:
        """The relaxation function at internal parameters."""
        law = {n: v for n, v in self.externals(theta).items() if n.startswith("relaxation.")}
        found = self.sample.replaced(law).physics.relaxation
        assert isinstance(found, Relaxation)
        return found

    def history(self, time: Array, depth: Array, theta: Array) -> Array:
        """Force [N] over times [s], ascending, for any depths [m], linear in between and negative without contact."""
        if not (depth > 0).any():
            return np.zeros_like(depth)
        elastic = _Elastic(self.elastic, self._elastic_theta(theta))
        return force_of_depth(time, depth, self.relaxation(theta), elastic).force

    def behind(
        self, time: Array, piezo: Array, spring: float, theta: Array, guess: Array | None, *, once: bool = True
    ) -> tuple[Array, Array]:
        """Depth and force behind a cantilever of k [N/m], for positions of its base over the contact point [m] at times [s].

        `guess` has depths to start from. The tip rises `once` and falls once: what of a trial does not is then levelled.
        """
        depth = piezo.copy() if guess is None else guess
        law, elastic = self.relaxation(theta), _Elastic(self.elastic, self._elastic_theta(theta))
        step = np.diff(time, prepend=time[0] - (time[1] - time[0]))
        present = law.integral(step) / step
        width = float(np.ptp(piezo))
        moves: list[Array] = []
        ends: list[Array] = []
        # turns at most for the depth behind a cantilever; five to ten are usual
        for _ in range(40):
            depth = unimodal(depth) if once else depth
            force = self.history(time, depth, theta)
            miss = piezo - force / spring - depth
            # depth behind a cantilever, over its range, at which the iteration ends: derivatives are taken by differences of
            # 1e-4
            if np.abs(miss).max() < 1e-8 * width:
                break
            moves.append(miss / (1 + present * elastic.stiffness(np.maximum(depth, 0.0)) / spring))
            ends.append(depth + moves[-1])
            # turns that Anderson's mixing combines
            depth = _accelerated(moves[-5:], ends[-5:])
        return depth, force

    def force(self, depth: Array, values: Mapping[str, float] | None = None) -> Array:
        """Elastic force at depths: psi = 1."""
        known = {n: v for n, v in (values or {}).items() if n in self.elastic.free}
        return self.elastic.force(depth, known)

    def exact(self, depth: Array, values: Mapping[str, float]) -> ExactForce:
        """Elastic force without tables, with the notes of the method."""
        return self.elastic.exact(depth, {n: v for n, v in values.items() if n in self.elastic.free})

    def _elastic_theta(self, theta: Array) -> Array:
        return np.array([t for n, t in zip(self.free, theta, strict=True) if n in self.elastic.free])


def unimodal(depth: Array) -> Array:
    """Depths with what breaks the rise to the largest and the fall after it levelled."""
    top = int(np.argmax(depth))
    up = np.maximum.accumulate(depth[: top + 1])
    return np.concatenate([up, np.minimum.accumulate(depth[top:])[1:]])


def _accelerated(moves: list[Array], ends: list[Array]) -> Array:
    """Anderson's mixing of the last turns: the combination of them with the least move, if they were linear."""
    if len(moves) < 2:
        return ends[-1]
    by_move = np.stack([moves[-1] - m for m in moves[:-1]], axis=1)
    by_end = np.stack([ends[-1] - e for e in ends[:-1]], axis=1)
    return np.asarray(ends[-1] - by_end @ np.linalg.lstsq(by_move, moves[-1], rcond=1e-10)[0])


@dataclass(frozen=True)
class _Elastic:
    """The elastic curve at given parameters, as the memory integrals want it."""

    model: ForwardModel
    theta: Array

    def force(self, depth: Array) -> Array:
        """F_el(d), zero without contact [N]."""
        return self._at(depth)[0]

    def stiffness(self, depth: Array) -> Array:
        """dF_el/dd [N/m]."""
        return self._at(depth)[1]

    def _at(self, depth: Array) -> tuple[Array, Array]:
        result = np.zeros((2, depth.size))
        live = depth > 0
        if live.any():
            result[:, live] = self.model.evaluate(depth[live], self.theta)[:2]
        return result[0], result[1]


_STEP = 1e-4
"""Parameters are of order one: central differences then err by 1e-8 of the third derivative, rounding by 1e-5 of the first."""


@dataclass(frozen=True, eq=False, kw_only=True)
class HistoryObjective(Unknowns):
    """Least-squares problem in x, see `Unknowns`.

    `depth` holds tip positions; with a `spring` it holds the positions of the cantilever's base instead, and the tip's are part
    of the answer. `once` says that positions rise once and fall once.
    """

    model: HistoryModel
    time: Array
    counts: Array
    once: bool = True

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Residuals, shape (n,), and derivatives, shape (parameters, n), both over the force range."""
        return self.residuals(x), differences(self.residuals, x, _STEP)

    def residuals(self, x: Array) -> Array:
        """Residuals over the force range, shape (n,)."""
        residual = (self._force(x) - self.force) / self.frame[2] * np.sqrt(self.counts)
        return residual if self.weight is None else residual * self.weight

    def _force(self, x: Array) -> Array:
        theta, rest = self.split(x)
        straight = rest["baseline"] + self.background(rest, self.depth, self.speed)
        if self.spring is None:
            return np.asarray(straight + self.model.history(self.time, self.depth - rest["contact"], theta))
        # tilt and drag are read by the detector and move no tip, see `flatpunch.fits.least_squares.objective`
        piezo = self.depth - rest["contact"] - rest["baseline"] / self.spring
        depth, force = self.model.behind(
            self.time, piezo, self.spring, theta, self._before.get("depth"), once=self.once
        )
        self._before["depth"] = depth
        return np.asarray(straight + force)

    def over(self, curve: Curve, x: Array) -> Array:
        """Fitted force at all points of the curve that is shown [N]."""
        assert curve.time is not None
        return np.interp(curve.time, self.time, self._force(x))

    def indentation(self, curve: Curve, x: Array) -> Array:
        """Indentation depth at all points of the curve that is shown [m]."""
        rest = self.split(x)[1]
        inside = curve.depth - rest["contact"]
        if curve.spring_constant is None:
            return np.asarray(inside)
        moving = self.background(rest, curve.position, curve.meta.get("speed"))
        return np.asarray(inside + moving / curve.spring_constant)
