"""From a minimum to values with intervals: noise, rounding of a digitised force, calibration, and tilts that nothing shows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.paths import Plain
from flatpunch.fits.least_squares.minimum import (
    SOON,
    Minimum,
    covariance,
    influence,
    minimise,
    noise_variance,
    robust_scale,
)
from flatpunch.fits.least_squares.problem import Problem, Setup
from flatpunch.fits.measured.signal import converter_step, independent
from flatpunch.fits.parameters.sample import NUISANCE
from flatpunch.fits.parameters.settings import Settings
from flatpunch.fits.parameters.unknowns import Unknowns
from flatpunch.fits.report.findings import about_contact, tilt_note
from flatpunch.fits.report.fitted import by_profile
from flatpunch.fits.report.result import FitResult
from flatpunch.fits.report.table import Estimate, half_width


def reported(problem: Problem, found: Minimum, settings: Settings) -> FitResult:
    """Values with intervals at a minimum; residuals of several curves are over the noise of each."""
    variance = 1.0
    if len(problem.setups) == 1:
        noise, factor = noise_variance(found, found.x.size, settings.loss)
        variance = noise * factor * found.residual.size / max(independent(found.residual), 1.0)
    inside = ~found.at_bound
    spread, undetermined = covariance(found.normal, inside, variance)
    doubtful = [i for i, setup in enumerate(problem.setups) if setup.doubtful and inside.all()]
    unseen = _covariance(_undetected_tilts(problem, found, doubtful, settings), found)
    others = chain(_calibrations(problem, found), _other_backgrounds(problem, found), _roundings(problem, found))
    shared = unseen + _covariance(others, found)
    spread = spread + shared
    result = FitResult(
        problem=problem,
        minimum=found,
        estimates=_estimated(problem, found, spread, settings.level),
        covariance=spread,
        undetermined=undetermined,
        settings=settings,
        unseen=unseen,
    )
    return replace(result, estimates=by_profile(result, shared))


def about_curve(result: FitResult, shared: Sequence[str] = ()) -> tuple[str, ...]:
    """Notes of the fit of one curve, which may share parameters with others: how it was read, its background and contact."""
    (setup,) = result.problem.setups
    tilt = _about_tilt(setup, result, shared) if setup.tilted else ()
    return (*setup.notes, *tilt, *about_contact(result))


def _estimated(problem: Problem, found: Minimum, spread: Array, level: float) -> dict[str, Estimate]:
    reach = half_width(level, max(found.residual.size - found.x.size, 1)) * np.sqrt(np.diag(spread))
    (lower, upper), estimates = problem.bounds, {}
    for j, (name, scale) in enumerate(problem.scales.items()):
        x, error, free = float(found.x[j]), float(np.sqrt(spread[j, j])), name in problem.free
        ends = x + reach[j] * np.array([-1, 1])
        low, high = sorted(map(float, scale.external(np.clip(ends, lower[j], upper[j]) if free else ends)))
        start = float(scale.external(problem.start[j])) if free else np.nan
        stderr = error * abs(float(scale.slope(x)))
        estimates[name] = Estimate(float(scale.external(x)), stderr, low, high, start, bool(found.at_bound[j]))
    return estimates


def _covariance(shifts: Iterable[Array], found: Minimum) -> Array:
    """Covariance of independent errors from the shifts of x by one standard deviation of each; of those that are known."""
    added = np.zeros_like(found.normal)
    for shift in shifts:
        if np.isfinite(shift).all():
            added += np.outer(shift, shift)
    return added


def _roundings(problem: Problem, found: Minimum) -> Iterator[Array]:
    """Shifts by the rounding of a digitised force without contact, which is one error of many readings of a curve.

    A force x that is rounded to steps q, with noise s before the rounding, is off in the mean by
    sum_j (-1)^j q/(pi j) exp(-2 pi^2 j^2 s^2/q^2) sin(2 pi j x/q); its variance is taken over all x. Where the force rises the
    errors of neighbours change sign and average out.
    """
    for setup, objective, place, noise in zip(
        problem.setups, problem.parts, problem.places, problem.noise, strict=True
    ):
        step = converter_step(setup.part.force)
        if not step or objective.model.over_time:
            continue
        own = found.x[place]
        if objective.model.adhesive:
            free = np.ones(objective.depth.size, dtype=bool)
            free[objective.loaded] = False
        else:
            free = objective.depth <= objective.split(own)[1]["contact"]
        if not free.any():
            continue
        # readings that alternate between two levels have up to q^2/4 without showing s
        s = max(float(np.var(objective.force[free])) - step**2 / 4, 0.0)
        j = np.arange(1, 100)
        variance = float(np.sum((step / (np.pi * j)) ** 2 / 2 * np.exp(-((2 * np.pi * j / step) ** 2) * s)))
        pushed = np.zeros(found.x.size)
        pushed[place] = objective.evaluate(own)[1][:, free].sum(axis=1) / (objective.frame.span * noise**2)
        yield np.asarray(np.sqrt(variance) * (covariance(found.normal, ~found.at_bound, 1.0)[0] @ pushed))


def _calibrations(problem: Problem, found: Minimum) -> Iterator[Array]:
    """Shifts by uncertain calibrations: the fit is repeated with each constant one standard deviation larger.

    A larger spring constant makes forces larger and leaves the tip where it was; a larger sensitivity makes deflections larger.
    Curves of the same constants have one cantilever, whose errors they share.
    """
    count = len(problem.free)
    cantilevers: dict[tuple[str, float, float | None], list[int]] = {}
    for i, setup in enumerate(problem.setups):
        for name, relative in setup.part.meta.get("calibration", {}).items():
            cantilevers.setdefault((name, relative, setup.part.spring_constant), []).append(i)
    for (name, relative, _), mine in cantilevers.items():
        setups = list(problem.coarse.setups)
        for i in mine:
            setups[i] = replace(setups[i], objective=_recalibrated(setups[i], name, 1 + relative))
        moved = minimise(replace(problem, setups=tuple(setups)).evaluate, found.x, *problem.bounds, settled=SOON)
        shift = np.zeros(found.x.size)
        shift[:count] = moved.x[:count] - found.x[:count]
        yield shift


def _recalibrated(setup: Setup, name: str, factor: float) -> Unknowns:
    """The problem of a curve with a constant of the calibration that is larger by a factor."""
    objective, k = setup.objective, setup.part.spring_constant
    force = objective.force * factor
    changed: Plain = {}
    if k is not None:
        stiffer = k * factor if name == "spring_constant" else k
        if objective.spring is not None:
            changed["spring"] = stiffer
        if not objective.model.over_time:
            # the base of the cantilever stays where it was; histories are fitted over its position
            changed["depth"] = objective.depth + objective.force / k - force / stiffer
    return replace(objective, force=force, _before={}, **changed)


def _undetected_tilts(problem: Problem, found: Minimum, curves: Sequence[int], settings: Settings) -> Iterator[Array]:
    """Shifts by tilts of the baselines of some curves: for each a step to the minimum with a tilt.

    The data do not ask for it. By `loss` outliers move a tilt as little as the other unknowns.
    """
    inverse = covariance(found.normal, np.ones(found.x.size, dtype=bool), 1.0)[0]
    for i in curves:
        tilted, places = _with_tilt(problem.parts[i]), problem.places[i]
        place = tilted.names.index("tilt")
        residual, jacobian = (
            each / problem.noise[i] for each in tilted.evaluate(np.insert(found.x[places], place, 0.0))
        )
        if settings.loss != "linear":
            scale = robust_scale(residual)
            psi, bend = influence(settings.loss, residual / scale)
            residual = scale * psi / np.mean(bend)
        column, along = jacobian[place], np.zeros(found.x.size)
        along[places] = np.delete(jacobian, place, axis=0) @ column
        # infinite where the curve says nothing about a parameter, or the tilt is one of its shapes
        with np.errstate(invalid="ignore", divide="ignore"):
            shift = inverse @ along * (column @ residual) / (column @ column - along @ inverse @ along)
        yield shift


def _other_backgrounds(problem: Problem, found: Minimum) -> Iterator[Array]:
    """Shifts by other backgrounds, which the readings before the contact allow: a step to the minimum of each."""
    for i, setup in enumerate(problem.setups):
        if setup.other is None:
            continue
        place, gradient, normal = problem.places[i], np.zeros(found.x.size), found.normal.copy()
        for objective, sign in ((setup.objective, -1), (setup.other, 1)):
            residual, jacobian = objective.evaluate(found.x[place])
            normal[np.ix_(place, place)] += sign * jacobian @ jacobian.T / problem.noise[i] ** 2
        gradient[place] = jacobian @ residual / problem.noise[i] ** 2
        yield covariance(normal, ~found.at_bound, 1.0)[0] @ gradient


def _with_tilt(objective: Unknowns) -> Unknowns:
    names = tuple(n for n in NUISANCE if n in objective.names or n == "tilt")
    return replace(objective, nuisance=names, _before={})


def _about_tilt(setup: Setup, result: FitResult, shared: Sequence[str]) -> tuple[str, ...]:
    """Moduli over the other baseline, a constant or a straight line, where they are outside their intervals.

    Shared parameters that are no moduli stay as they are: one curve of many determines no more.
    """
    objective, straight = setup.objective, setup.settings.baseline == "linear"
    x, lower, upper = result.minimum.x, setup.lower, setup.upper
    if not straight:
        objective = _with_tilt(objective)
        place = objective.names.index("tilt")
        x, lower, upper = (np.insert(v, place, e) for v, e in ((x, 0.0), (lower, -np.inf), (upper, np.inf)))
    flat = np.array([straight and name == "tilt" for name in objective.names])
    moduli = {objective.model.free[j] for j in objective.model.moduli}
    held = flat | np.array([name in shared and name not in moduli for name in objective.names])
    other = minimise(objective.evaluate, np.where(flat, 0.0, x), lower, upper, fixed=held, settled=SOON).x
    values = objective.model.externals(other[: len(objective.model.free)])
    moved = {name: value for name, value in values.items() if name in moduli}
    return tilt_note("constant" if straight else "linear", {n: (v, result.estimates[n]) for n, v in moved.items()})
