"""Curves over time: what a history needs, its positions freed from noise, and where a fit starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import isotonic_regression

from flatpunch._support.checks import Array
from flatpunch.fit.least_squares.objective import contact_range
from flatpunch.fit.least_squares.setup import Setup, enough, held, with_nuisance
from flatpunch.fit.measured.curve import Curve, CurveError, check_saturation
from flatpunch.fit.parameters.settings import Settings
from flatpunch.fit.parameters.unknowns import frame_of
from flatpunch.fit.viscoelastic.model import HistoryModel
from flatpunch.fit.viscoelastic.objective import HistoryObjective

_BINS, _SCANNED = 500, 120
_FREE = 0.05
"""Share of the points, at the start, from which baseline and noise are judged."""
_DIP = (6.0, 0.03)
_CYCLES = 0.05
"""Share of the depth range by which the tip may go down again before it counts as a second cycle."""
_CONTACTS = 24


def history_setup(curve: Curve, model: HistoryModel, limits: tuple[Array, Array], settings: Settings) -> Setup:
    """Approach, hold and retract against a model with memory."""
    part, notes = _checked(curve, settings)
    assert part.time is not None
    spring = part.spring_constant
    position = part.depth if spring is None else part.depth + part.force / spring
    position = _levelled(part, position)
    objective = _binned(part, position, model, settings, _BINS)
    enough(part, objective)
    top = int(np.argmax(position))
    low, high, _ = contact_range(part.depth[: top + 1], part.force[: top + 1])
    slack = high - low
    lowest = max(low - slack, float(part.depth[: max(int(_FREE * top), 3)].mean()))
    lower, upper = with_nuisance(objective, limits, (lowest, high + slack / 3))
    coarse = _binned(part, position, model, settings, _SCANNED)
    used = np.ones(part.depth.size, dtype=bool)
    return Setup(part, used, objective, lower, upper, lambda: _start(coarse, lower, upper, (low, high)), notes)


def _checked(curve: Curve, settings: Settings) -> tuple[Curve, tuple[str, ...]]:
    """Times, no saturation, a rise, no second cycle, no adhesion."""
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
    check_saturation(curve)
    n = curve.force.size
    window = max(n // 200, 1)
    smooth = np.convolve(curve.force, np.full(window, 1 / window), "same")
    far = curve.force[: max(int(_FREE * n), 12)]
    noise = float(1.4826 * np.median(np.abs(np.diff(far))) / np.sqrt(2))
    baseline, top = float(np.median(far)), int(np.argmax(smooth))
    rise = float(smooth[top]) - baseline
    if rise < 6 * noise or top < 3:
        raise CurveError(
            f"{curve.name}: the force rises {max(rise, 0):.3g} N above its start, the noise is {noise:.3g} N. The history must "
            "begin without contact, and press."
        )
    below = np.flatnonzero(smooth[top:] < baseline - max(_DIP[0] * noise, _DIP[1] * rise))
    if not below.size or settings.adhesion == "ignore":
        return curve, ()
    if settings.adhesion == "refuse":
        raise CurveError(
            f"{curve.name}: on the way back the force dips {baseline - smooth[top:].min():.3g} N below its start: the tip is "
            "held. Adhesion of viscoelastic bodies is not solved; adhesion = 'above' fits what comes before."
        )
    back = top + int(np.argmax(smooth[top:] < baseline))
    note = f"Adhesion: the retract is left out from where the force is back at its start ({n - back} points)."
    return curve.taken(slice(0, back)), (note,)


def _levelled(curve: Curve, position: Array) -> Array:
    """Positions that rise once and fall once, with the least squares to the measured ones."""
    window = max(position.size // 200, 1)
    smooth = np.convolve(np.pad(position, window // 2, "edge"), np.full(window, 1 / window), "valid")[: position.size]
    top = int(np.argmax(smooth))
    up = isotonic_regression(position[: top + 1]).x
    down = isotonic_regression(position[top:], increasing=False).x
    result = np.concatenate([up, down[1:]])
    # both sides end at the same position
    result[top] = max(up[-1], down[0])
    off = float(np.abs(result - smooth).max())
    if off > _CYCLES * float(np.ptp(position)):
        raise CurveError(
            f"{curve.name}: the tip goes down more than once (by {off:.3g} m against a single rise and fall). Cut the curve to "
            "its first cycle; one approach, a hold if there is one, and one retract are fitted."
        )
    return np.asarray(result)


def _binned(part: Curve, position: Array, model: HistoryModel, settings: Settings, count: int) -> HistoryObjective:
    """Means over stretches that are short where much happens: in time, in depth, and after the turning point."""
    assert part.time is not None
    time, n = part.time, part.time.size
    steps = np.diff(time, prepend=time[0])
    usual = float(np.median(steps[1:]))
    top = int(np.argmax(position))
    path = np.abs(np.diff(position, prepend=position[0])).cumsum()
    since = np.log1p(np.clip(time - time[top], 0, None) / usual)
    along = np.sum([c / max(float(c[-1]), 1e-300) for c in (time - time[0], path, since)], axis=0)
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
        held=held(settings),
        frame=frame_of(part.depth, part.force),
        spring=part.spring_constant,
    )


def _start(coarse: HistoryObjective, lower: Array, upper: Array, between: tuple[float, float]) -> Array:
    """Scan contact points, then relaxation, then contact points again; the amplitude by linear least squares."""
    names, count = coarse.names, len(coarse.model.free)
    origin, width, span = coarse.frame
    moduli = [j for j in range(count) if names[j].endswith("young")]
    x = np.zeros(len(names))
    x[:count] = coarse.model.start()
    place = names.index("contact") if "contact" in names else None
    if place is not None:
        x[place] = (between[1] - origin) / width
    # without its cantilever a trial costs one history; the tip's own positions do for a start
    loose = coarse
    if coarse.spring is not None:
        loose = replace(coarse, depth=coarse.depth - coarse.force / coarse.spring, spring=None)
        loose = replace(loose, depth=_single(loose.depth))

    def tried(trial: Array) -> tuple[float, Array]:
        trial = np.clip(trial, lower, upper)
        theta, rest = loose.split(trial)
        force = loose.model.history(loose.time, loose.depth - rest["contact"], theta) / span
        data, weight = loose.force / span, loose.counts
        base = "baseline" in names
        mean_f, mean_d = (np.average(c, weights=weight) if base else 0.0 for c in (force, data))
        square = float(weight @ (force - mean_f) ** 2)
        factor = (
            max(float(weight @ ((force - mean_f) * (data - mean_d))) / max(square, 1e-300), 1e-9) if moduli else 1.0
        )
        left = data - mean_d - factor * (force - mean_f)
        end = trial.copy()
        end[moduli] += np.log(factor) / max(len(moduli), 1)
        if base:
            end[names.index("baseline")] = mean_d - factor * mean_f
        return float(weight @ left**2), end

    def best(trials: list[Array]) -> Array:
        return min((tried(t) for t in trials), key=lambda pair: pair[0])[1]

    for turn in range(2):
        if place is not None:
            x = best([_with(x, place, (z - origin) / width) for z in np.linspace(*between, _CONTACTS)])
        if turn == 0:
            x = best([x, *_laws(coarse, x)])
    return np.clip(x, lower, upper)


def _single(depth: Array) -> Array:
    """Depths that rise once and fall once."""
    top = int(np.argmax(depth))
    up, down = isotonic_regression(depth[: top + 1]).x, isotonic_regression(depth[top:], increasing=False).x
    return np.concatenate([up, down[1:]])


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
