"""Viscoelastic fits: the force over time for a measured history of the depth, what such a curve needs, and where a fit starts.

The elastic curve comes from the tables of `ForwardModel`, the memory from `flatpunch.contact.viscoelastic`, for any history;
curves have one or more cycles of approach, hold and retract. Behind a cantilever of stiffness k the position p of the piezo is
known, and the depth follows from the force itself,

    d(t) = p(t) - F[d](t)/k,

solved for the whole history by Newton's method with the response of the present moment alone, K times the mean of psi over the
step; what the past contributes is smaller and makes it converge in a few turns.

Derivatives of the residuals are central differences. A history cannot be cut into points of their own as a curve over depth can:
what was before is remembered. It is averaged over some hundred stretches of time, each with the weight of the readings in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import ClassVar

import numpy as np

from flatpunch._support.checks import TINY, Array
from flatpunch.contact.finite_strain.correction import REMEDY
from flatpunch.contact.viscoelastic.depth_history import force_of_depth
from flatpunch.fits.elastic.model import ForwardModel
from flatpunch.fits.elastic.setup import DIP, Approached, approached
from flatpunch.fits.least_squares.drag import with_speed
from flatpunch.fits.least_squares.minimum import differences, tried
from flatpunch.fits.least_squares.problem import Setup, contact_ends, enough, with_nuisance
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.cycles import levelled, smoothed, turns
from flatpunch.fits.measured.orientation import FALLS
from flatpunch.fits.measured.signal import SHARE, spread_of
from flatpunch.fits.parameters.sample import Sample
from flatpunch.fits.parameters.settings import FitMethod, Settings
from flatpunch.fits.parameters.unknowns import ExactForce, FreeParameters, Unknowns, frame_of
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
            # derivatives are taken by differences of 1e-4
            if np.abs(miss).max() < 1e-8 * width:
                break
            moves.append(miss / (1 + present * elastic.stiffness(np.maximum(depth, 0.0)) / spring))
            ends.append(depth + moves[-1])
            depth = _accelerated(moves[-5:], ends[-5:])
        return depth, force

    def force(self, depth: Array, values: Mapping[str, float] | None = None) -> Array:
        """Elastic force at depths: psi = 1."""
        known = {n: v for n, v in (values or {}).items() if n in self.elastic.free}
        return self.elastic.force(depth, known)

    def exact(self, depth: Array, values: Mapping[str, float]) -> ExactForce:
        """Elastic force without tables, with the notes of the method; relaxation excludes the remedy of large strain."""
        found = self.elastic.exact(depth, {n: v for n, v in values.items() if n in self.elastic.free})
        return found._replace(notes=found.notes.replace(f"{REMEDY} up to there", "").replace(REMEDY, ""))

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
    model: ForwardModel
    theta: Array

    def force(self, depth: Array) -> Array:
        return self._at(depth)[0]

    def stiffness(self, depth: Array) -> Array:
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


_BINS = 500
_SCANNED = _BINS // 4
"""Stretches of time that a history is averaged over, and those of the scan; half as many halve the time of a fit."""
_TRIED = 5
"""Values of each number of a relaxation that a fit may begin from."""


def history_setup(curve: Curve, model: HistoryModel, limits: tuple[Array, Array], settings: Settings) -> Setup:
    """Approach, hold and retract against a model with memory."""
    _check_times(curve, settings)
    # contact point, background and sign of the force by the elastic model of the approach
    plain = [name in model.elastic.free for name in model.free]
    elastic = (limits[0][: len(plain)][plain], limits[1][: len(plain)][plain])
    made = approached(curve, model.elastic, elastic, replace(settings, drag=0.0))
    found, contact = made.found, made.contact
    turned, notes = found.turned, found.notes
    if made.upright < 0:
        notes += (FALLS,)
    part, more = _without_adhesion(made, settings)
    tilted = settings.baseline == "auto" and made.fit.noise.background.tilt
    if settings.baseline == "auto":
        settings = replace(settings, baseline="linear" if tilted else "constant")
    part, speed = with_speed(part, settings)
    at = turns(part.position)
    if len(at) > 1:
        more += (f"{(len(at) + 1) // 2} loading cycles are fitted together.",)
    position = levelled(part.position, at)
    objective = _binned(part, position, model, settings, _BINS, turned, speed)
    enough(part, objective)
    end = float(part.depth[: at[0] + 1].max())
    # contact points are tried this far about that of the elastic approach, over its depth: relaxation bends the curve
    reach = 0.5 * (end - contact)
    between = (contact - reach, min(contact + reach, end))
    ends = contact_ends(settings, turned, float(part.depth.min()), end)
    between = (max(between[0], ends[0]), min(between[1], ends[1]))
    lower, upper = with_nuisance(objective, limits, ends)
    coarse = _binned(part, position, model, settings, _SCANNED, turned, speed)
    return Setup(
        part,
        np.ones(part.depth.size, dtype=bool),
        objective,
        lower,
        upper,
        lambda: _start(coarse, lower, upper, between),
        settings,
        (*notes, *more),
        tilted=tilted,
    )


def _check_times(curve: Curve, settings: Settings) -> None:
    if curve.time is None:
        why = curve.meta.get("no time")
        raise CurveError(
            f"{curve.name}: relaxation is fitted to the force over time, and the curve has no times. "
            + (f"{why} " if why else "")
            + "Name the column, columns = { time = '...' } and units = { time = 's' }, or pass Curve(..., time=...)."
        )
    if settings.depth_to is not None or settings.force_to is not None:
        raise ValueError("depth_to and force_to do not go with relaxation: what was before is remembered.")
    steps = np.diff(curve.time)
    if (steps < 0).any() or not steps.any():
        i = int(np.argmin(steps))
        raise CurveError(
            f"{curve.name}: time must grow; it goes from {curve.time[i]:.6g} s to {curve.time[i + 1]:.6g} s at row {i + 1}."
        )


def _without_adhesion(made: Approached, settings: Settings) -> tuple[Curve, tuple[str, ...]]:
    """The cycles as far as no adhesion is seen on the way back: below the background by more than it does before the contact."""
    found, curve = made.found, made.found.whole
    top, n = found.end - 1, curve.force.size
    smooth = smoothed(made.over(curve))
    before = smooth[: top + 1][curve.depth[: top + 1] < made.contact]
    spread = spread_of(before) if before.size else made.fit.record.noise
    below = np.flatnonzero(smooth[top:] < -max(DIP * spread, 2 * SHARE * float(smooth[: top + 1].max())))
    if not below.size or settings.adhesion == "ignore":
        return curve, ()
    if settings.adhesion == "refuse":
        begin = min(found.leaves, top + 1 + int(below[0]))
        if begin <= top + 1:
            raise CurveError(
                f"{curve.name}: on the way back the force dips {-smooth[top:].min():.3g} N below its start: the tip is held, and "
                "without a hold before it the approach alone shows little of the relaxation. Adhesion of viscoelastic bodies is "
                "not solved; adhesion = 'above' fits the retract as well, down to the start of the dip."
            )
        note = (
            f"Adhesion: the retract dips {-smooth[top:].min():.3g} N below the start of the curve and is left out ({n - begin} "
            "points); approach and hold are fitted without adhesion, which is approximate: the adhesive force is small there, "
            "not zero. adhesion = 'above' fits the retract down to the dip."
        )
        return curve.taken(slice(0, begin)), (note,)
    back = top + int(np.argmax(smooth[top:] < 0))
    note = f"Adhesion: the retract is left out from where the force is back at its start ({n - back} points)."
    return curve.taken(slice(0, back)), (note,)


def _binned(
    part: Curve,
    position: Array,
    model: HistoryModel,
    settings: Settings,
    count: int,
    turned: float,
    speed: Array | None = None,
) -> HistoryObjective:
    """Means over stretches that are short where much happens: in time, in depth, and after the turning point."""
    assert part.time is not None
    time, n = part.time, part.time.size
    steps = np.diff(time, prepend=time[0])
    usual = float(np.median(steps[1:]))
    path = np.abs(np.diff(position, prepend=position[0])).cumsum()
    starts = time[[*turns(position)[::2]]]
    lasting = np.diff(starts, append=time[-1])
    since = np.sum(
        [np.log1p(np.clip(time - t, 0, most) / usual) for t, most in zip(starts, lasting, strict=True)], axis=0
    )
    along = np.sum([c / max(float(c[-1]), TINY) for c in (time - time[0], path, since)], axis=0)
    index = np.minimum((along / 3 * count).astype(int), count - 1) if n > count else np.arange(n)
    # readings at the same time are one
    index = np.unique(index, return_inverse=True)[1]
    if n <= count:
        index = np.unique(time, return_inverse=True)[1]
    size = np.bincount(index).astype(float)
    means = {name: np.bincount(index, c) / size for name, c in (("t", time), ("z", position), ("f", part.force))}
    return HistoryObjective(
        model=model,
        time=means["t"],
        depth=means["z"],
        force=means["f"],
        counts=size,
        nuisance=settings.nuisance,
        held=settings.held,
        frame=frame_of(part.depth, part.force, part.position, speed),
        turned=turned,
        spring=part.spring_constant,
        once=len(turns(position)) == 1,
        speed=None if speed is None else np.bincount(index, speed) / size,
    )


def _start(coarse: HistoryObjective, lower: Array, upper: Array, between: tuple[float, float]) -> Array:
    """Scan contact points, then relaxations, then contact points again."""
    # without its cantilever a trial costs one history; the tip's own positions do for a start
    loose = coarse
    if coarse.spring is not None:
        loose = replace(coarse, depth=coarse.depth - coarse.force / coarse.spring, spring=None)
        loose = replace(loose, depth=levelled(loose.depth, turns(loose.depth)))
    moduli = coarse.model.moduli

    def force(theta: Array, contacts: Array) -> Array:
        return np.array([loose.model.history(loose.time, loose.depth - contact, theta) for contact in contacts])

    def best(thetas: list[Array], ends: tuple[float, float]) -> tuple[Array, Array, float]:
        x = np.clip(tried(loose, thetas, ends, force, moduli)[0], lower, upper)
        theta, rest = loose.split(x)
        return x, theta, rest["contact"]

    _, theta, contact = best([coarse.model.start()], between)
    _, theta, _ = best([theta, *_laws(coarse, theta)], (contact, contact))
    return best([theta], between)[0]


def _laws(objective: HistoryObjective, theta: Array) -> list[Array]:
    usual, whole = float(np.median(np.diff(objective.time))), float(np.ptp(objective.time))
    known = {
        "relaxation.time": np.log(np.geomspace(2 * usual, whole, _TRIED)),
        "relaxation.equilibrium": (np.arange(_TRIED) + 0.5) / _TRIED,
        "relaxation.exponent": 2.0 ** -np.arange(1.0, _TRIED + 1),
    }
    places = [j for j, name in enumerate(objective.model.free) if name in known]
    trials = []
    for values in product(*(known[objective.model.free[j]] for j in places)):
        trials.append(theta.copy())
        trials[-1][places] = values
    return trials
