"""Curves over time: what a history needs, its positions freed from noise, and where a fit starts."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from flatpunch._support.checks import TINY, Array
from flatpunch.fits.elastic.setup import DIP, Approached, approached
from flatpunch.fits.least_squares.problem import Setup, contact_ends, enough, with_nuisance
from flatpunch.fits.least_squares.speed import with_speed
from flatpunch.fits.least_squares.starts import tried
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.cycles import levelled, smoothed, turns
from flatpunch.fits.measured.signal import spread_of
from flatpunch.fits.parameters.settings import Settings
from flatpunch.fits.parameters.unknowns import frame_of
from flatpunch.fits.viscoelastic.model import HistoryModel, HistoryObjective

_BINS, _SCANNED = 500, 120
"""Stretches of time that a history is averaged over, and those of the scan; half as many halve the time of a fit."""


def history_setup(curve: Curve, model: HistoryModel, limits: tuple[Array, Array], settings: Settings) -> Setup:
    """Approach, hold and retract against a model with memory."""
    _check_times(curve, settings)
    made = _elastic_approach(curve, model, limits, settings)
    found, contact = made.found, made.contact
    turned, notes = found.turned, found.notes
    if made.upright < 0:
        notes += ("The force falls while the tip presses; it was taken with its sign turned (positive when pressing).",)
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
    outermost = float(part.depth.min())
    ends = contact_ends(settings, turned, outermost, end)
    between = (max(between[0], ends[0]), min(between[1], ends[1]))
    lower, upper = with_nuisance(objective, limits, ends)
    coarse = _binned(part, position, model, settings, _SCANNED, turned, speed)
    used = np.ones(part.depth.size, dtype=bool)
    return Setup(
        part,
        used,
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


def _elastic_approach(curve: Curve, model: HistoryModel, limits: tuple[Array, Array], settings: Settings) -> Approached:
    """Contact point, background and sign of the force by the elastic model of the approach."""
    plain = [name in model.elastic.free for name in model.free]
    elastic = (limits[0][: len(plain)][plain], limits[1][: len(plain)][plain])
    return approached(curve, model.elastic, elastic, replace(settings, drag=0.0))


def _without_adhesion(made: Approached, settings: Settings) -> tuple[Curve, tuple[str, ...]]:
    """The cycles as far as no adhesion is seen on the way back: below the background by more than it does before the contact."""
    found, curve = made.found, made.found.whole
    top, n = found.end - 1, curve.force.size
    smooth = smoothed(made.over(curve))
    before = smooth[: top + 1][curve.depth[: top + 1] < made.contact]
    spread = spread_of(before) if before.size else made.fit.record.noise
    below = np.flatnonzero(smooth[top:] < -max(DIP * spread, 0.03 * float(smooth[: top + 1].max())))
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
    """Relaxations to try: times from a few steps to the whole curve, shares and exponents."""
    usual, whole = float(np.median(np.diff(objective.time))), float(np.ptp(objective.time))
    known = {
        "relaxation.time": np.log(np.geomspace(2 * usual, whole, 6)),
        "relaxation.equilibrium": (np.arange(4) + 0.5) / 4,
        "relaxation.exponent": 2.0 ** -np.arange(1, 6),
    }
    places = [j for j, name in enumerate(objective.model.free) if name in known]
    trials = []
    for values in product(*(known[objective.model.free[j]] for j in places)):
        trials.append(theta.copy())
        trials[-1][places] = values
    return trials
