"""Curves over time: what a history needs, its positions freed from noise, and where a fit starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flatpunch._support.checks import TINY, Array
from flatpunch.fit.elastic.setup import DIP, Approached, approached
from flatpunch.fit.least_squares.problem import Setup, enough, with_nuisance
from flatpunch.fit.least_squares.speed import check_drag, speed_of
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.cycles import levelled, smoothed, turns
from flatpunch.fit.measured.signal import spread_of
from flatpunch.fit.parameters.scaling import MODULI
from flatpunch.fit.parameters.settings import Settings
from flatpunch.fit.parameters.unknowns import frame_of
from flatpunch.fit.viscoelastic.model import HistoryModel, HistoryObjective

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
    speed = speed_of(part, settings)
    if speed is not None:
        check_drag(part, settings)
        part.meta["speed"] = speed
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
    asked = settings.contact_limits(turned)
    ends = (outermost if asked[0] is None else asked[0], end if asked[1] is None else asked[1])
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
    """Scan contact points, then relaxation, then contact points again; the amplitude by linear least squares."""
    names, count = coarse.names, len(coarse.model.free)
    origin, width, span, level, *_ = coarse.frame
    moduli = [j for j in range(count) if names[j].endswith(MODULI)]
    x = np.zeros(len(names))
    x[:count] = coarse.model.start()
    place = names.index("contact") if "contact" in names else None
    if place is not None:
        x[place] = (between[1] - origin) / width
    # without its cantilever a trial costs one history; the tip's own positions do for a start
    loose = coarse
    if coarse.spring is not None:
        loose = replace(coarse, depth=coarse.depth - coarse.force / coarse.spring, spring=None)
        loose = replace(loose, depth=levelled(loose.depth, turns(loose.depth)))

    linear = [n for n in names if n in ("baseline", "tilt", "drag")]
    root = np.sqrt(loose.counts)

    def tried(trial: Array) -> tuple[float, Array]:
        trial = np.clip(trial, lower, upper)
        theta, rest = loose.split(trial)
        force = loose.model.history(loose.time, loose.depth - rest["contact"], theta) / span
        fixed = level if "baseline" in linear else rest["baseline"]
        data = (loose.force - fixed) / span
        rows = [coarse.column(n, rest, coarse.depth, coarse.speed) for n in linear]
        if moduli:
            rows.append(force)
        else:
            data = data - force
        if not rows:
            return float(loose.counts @ data**2), trial
        columns = np.array(rows) * root
        found = np.linalg.lstsq(columns.T, root * data, rcond=None)[0]
        left = root * data - found @ columns
        end = trial.copy()
        if moduli:
            factor = max(float(found[-1]), 1e-9)
            end[moduli] += np.log(factor) / len(moduli)
            if found[-1] <= 0:
                left = root * data
        for name, value in zip(linear, found, strict=False):
            end[names.index(name)] = value
        return float(left @ left), end

    def best(trials: list[Array]) -> Array:
        return min((tried(t) for t in trials), key=lambda pair: pair[0])[1]

    for turn in range(2):
        if place is not None:
            # contact points of a scan
            x = best([_with(x, place, (z - origin) / width) for z in np.linspace(*between, 24)])
        if turn == 0:
            x = best([x, *_laws(coarse, x)])
    return np.clip(x, lower, upper)


def _laws(objective: HistoryObjective, x: Array) -> list[Array]:
    """Relaxations to try: times from a few steps to the whole curve, shares and exponents."""
    names = objective.names
    usual, whole = float(np.median(np.diff(objective.time))), float(np.ptp(objective.time))
    single = {name: j for j, name in enumerate(names) if name in ("relaxation.time", "relaxation.equilibrium")}
    trials = []
    if single:
        for time in np.geomspace(2 * usual, whole, 6) if "relaxation.time" in single else [None]:
            for share in (0.1, 0.3, 0.6, 0.85) if "relaxation.equilibrium" in single else [None]:
                trial = x
                if time is not None:
                    trial = _with(trial, single["relaxation.time"], float(np.log(time)))
                if share is not None:
                    trial = _with(trial, single["relaxation.equilibrium"], share)
                trials.append(trial)
    if "relaxation.exponent" in names:
        trials += [_with(x, names.index("relaxation.exponent"), v) for v in (0.03, 0.1, 0.2, 0.35, 0.55)]
    return trials


def _with(x: Array, place: int, value: float) -> Array:
    y = x.copy()
    y[place] = value
    return y
