"""Draws from the posterior of a fit by emcee: an ensemble of walkers that is blind to scales and correlations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import Array, BadValue, shown, whole
from flatpunch._support.progress import Report, reporting
from flatpunch._support.threads import one_blas_thread
from flatpunch.fits.least_squares.problem import Problem
from flatpunch.fits.parameters.sample import BESIDE, CALIBRATION, Scale
from flatpunch.fits.report.findings import correlated
from flatpunch.fits.report.fitted import Fitted
from flatpunch.fits.report.log_posterior import LogPosterior, at_once, parts_of
from flatpunch.fits.report.posterior import LogNormal, Posterior, Prior


@dataclass(frozen=True, slots=True)
class _Chains:
    """How the chains are run.

    Attributes
    ----------
    walkers : int
        Chains; they propose steps to each other, so there must be several times as many as parameters.
    shortest, length : float
        Autocorrelation times that are kept at least, for few draws and for many: estimates of these times need as many (50 is
        emcee's advice for one number).
    burned : float
        Share of the steps that are dropped at the beginning.
    block : int
        Steps between looks at the autocorrelation.
    longest : int
        Steps after which a chain that is still too short is given up, with a note.
    """

    walkers: int = 64
    shortest: float = 20.0
    length: float = 50.0
    burned: float = 0.2
    block: int = 250
    longest: int = 20_000


_CHAINS = _Chains()
_FAR = float(np.log(1e6))
"""Internal limits of a number that has a prior only: a factor of a million either way."""
_TAIL = 0.01
"""Share of the draws that is left out for their range, and of this range that is next to a limit."""


@one_blas_thread()
def draw(
    result: Fitted, draws: int, priors: Mapping[str, Prior] | None, seed: int, progress: bool | Report | None
) -> Posterior:
    """Draw from the posterior of a fit; see `FitResult.posterior`."""
    count = whole("draws", draws, 1, "It is the number of draws that are returned.", most=10_000_000)
    whole("seed", seed, 0, "It starts the random numbers.")
    if result.settings.loss != "linear":
        raise BadValue(
            "loss",
            repr(result.settings.loss),
            "has no posterior: it is no likelihood. Fit with loss='linear', which takes the noise as normal, and "
            "leave outliers out.",
        )
    density, x = _density(result, dict(priors or {}))
    rng = np.random.default_rng(seed)
    middle, root = density.parabola(x)
    with reporting("Posterior", progress) as report:
        for sampled in (density.quick(x, middle, root), density):
            found = _sampled(sampled, _starts(sampled, middle, root, rng), count, rng, report)
            if _alike(density, sampled, found.positions):
                break
    positions = _moved(found.positions, result, density, rng)
    values = np.column_stack([s.external(c) for s, c in zip(density.scales.values(), positions.T, strict=True)])
    return Posterior(
        ", ".join(each.curve.name for each in result.results),
        density.numbers,
        values,
        found.logarithms,
        density.priors,
        found.times,
        np.minimum(found.kept / found.times, len(values)),
        found.acceptance,
        result.settings.level,
        (*found.notes, *_notes(result, density, found.positions, values)),
    )


def _moved(positions: Array, result: Fitted, density: LogPosterior, rng: np.random.Generator) -> Array:
    """Draws with errors by a tilt of the baseline that the data do not exclude, as far as they stay within the limits."""
    if result.unseen is None or not result.unseen.any():
        return positions
    places, moved = [density.names.index(name) for name in result.names], positions.copy()
    moved[:, places] += rng.multivariate_normal(np.zeros(len(places)), result.unseen, len(moved), method="eigh")
    inside = np.all((moved >= density.lower) & (moved <= density.upper), axis=1, keepdims=True)
    return np.where(inside, moved, positions)


def draws_held(problem: Problem) -> bool:
    """Whether numbers of the case that were held, and the calibration, can be drawn as well."""
    return len(problem.setups) == 1 and at_once(problem.parts[0])


def _density(result: Fitted, given: dict[str, Prior]) -> tuple[LogPosterior, Array]:
    """The density, and where the fit ended."""
    problem, x, assumed = result.problem, result.minimum.x, {}
    for name, prior in given.items():
        if not isinstance(prior, Prior):
            raise TypeError(
                f"priors[{shown(name)}] = {shown(prior)} must be Normal(mean, std), LogNormal(median, relative) or "
                "Uniform(low, high)."
            )
    alone = draws_held(problem)
    if alone:
        problem, x = _extended(problem, x, given)
        alone = at_once(problem.parts[0])
    if alone:
        k = result.curve.spring_constant
        assumed = ({} if k is None else {"spring_constant": float(k)}) | {"sensitivity": 1.0}
        for name, relative in result.curve.meta.get("calibration", {}).items():
            if name in assumed:
                given.setdefault(name, LogNormal(assumed[name], relative))
    drawn = [name for name in CALIBRATION if name in given and name in assumed]
    names = (*problem.names, *drawn)
    for name in given:
        if name in CALIBRATION and name not in assumed:
            why = (
                "the curve has no spring constant; give it as Curve(..., spring_constant=) or in [curve]"
                if alone
                else "only fits of a single curve without adhesion and relaxation draw the calibration"
            )
            raise ValueError(f"priors: {name} cannot be drawn: {why}.")
        if name not in names:
            raise ValueError(
                f"priors: {shown(name)} was not fitted; a prior goes here with {', '.join(names)}. Fit it as well."
            )
    scales, parts = problem.scales | {n: Scale("logarithm", unit=assumed[n]) for n in drawn}, parts_of(problem, x)
    x = np.append(x, [scales[name].internal(given[name].centre) for name in drawn])
    lower, upper = (np.append(b, [far] * len(drawn)) for b, far in zip(problem.bounds, (-_FAR, _FAR), strict=True))
    numbers = problem.numbers | {name: BESIDE[name] for name in drawn}
    return _supported(LogPosterior(parts, numbers, scales, lower, upper, given)), x


def _extended(problem: Problem, x: Array, given: Mapping[str, Prior]) -> tuple[Problem, Array]:
    """The problem with numbers of the case free that have a prior and were held in the fit."""
    (setup,) = problem.setups
    model, place = setup.objective.model, len(setup.objective.model.free)
    added = [name for name in given if name not in problem.names and name not in CALIBRATION]
    known = model.numbers
    for name in added:
        if name not in known:
            raise ValueError(
                f"priors: {shown(name)} is no parameter of this fit; it has "
                f"{', '.join(dict.fromkeys([*problem.names, *known, *CALIBRATION]))}."
            )
    if not added:
        return problem, x
    medium, indenter = model.case(model.externals(x[:place]))
    wider = replace(model, medium=medium, indenter=indenter, free=(*model.free, *added))
    start, pairs = wider.start(), [(model.scales[name], wider.scales[name]) for name in model.free]
    ends = np.array([wider.ends(name) for name in added]).T
    ends = np.where(np.isfinite(ends), ends, start[place:] + np.array([[-_FAR], [_FAR]]))
    # numbers without a range are in units of their values
    lower, upper = (
        np.concatenate(
            [[new.internal(old.external(v)) for (old, new), v in zip(pairs, b, strict=False)], end, b[place:]]
        )
        for b, end in zip(problem.bounds, ends, strict=True)
    )
    x = np.append(start, x[place:])
    objective = replace(setup.objective, model=wider, _before={})
    return Problem.of([replace(setup, objective=objective, lower=lower, upper=upper)], [x], 0), x


def _supported(density: LogPosterior) -> LogPosterior:
    lower, upper = density.lower.copy(), density.upper.copy()
    for name, prior in density.priors.items():
        j, scale = density.names.index(name), density.scales[name]
        ends, (low, high) = scale.external(np.array([lower[j], upper[j]])), prior.support
        if not (low < ends[1] and high > ends[0]):
            raise ValueError(
                f"priors: {name} = {prior} allows no value between the limits of the fit, {ends[0]:.6g} and {ends[1]:.6g}."
            )
        lower[j] = scale.internal(low) if low > ends[0] else lower[j]
        upper[j] = scale.internal(high) if high < ends[1] else upper[j]
    return replace(density, lower=lower, upper=upper)


@dataclass(frozen=True, eq=False)
class _Found:
    """Thinned draws (internal), ln of their density, autocorrelation times, kept steps of all walkers, acceptance, notes."""

    positions: Array
    logarithms: Array
    times: Array
    kept: int
    acceptance: float
    notes: tuple[str, ...]


def _sampled(density: LogPosterior, state: Array, draws: int, rng: np.random.Generator, report: Report) -> _Found:
    import emcee

    chains = _CHAINS
    walkers, count = state.shape
    # not emcee's DESnookerMove, whose draws are too narrow: 0.85 of the standard deviation of a normal density of four parameters
    moves = [emcee.moves.DEMove(), emcee.moves.KDEMove(), emcee.moves.StretchMove()]
    sampler = emcee.EnsembleSampler(walkers, count, density, vectorize=True, moves=moves)
    sampler.random_state = np.random.RandomState(rng.integers(np.iinfo(np.int32).max)).get_state()
    length = min(chains.length, max(chains.shortest, draws / walkers))
    steps, needed, notes = 0, np.inf, []
    while steps < min(needed, chains.longest):
        state = sampler.run_mcmc(state, chains.block)
        steps = sampler.iteration
        dropped: int = round(chains.burned * steps)
        times = sampler.get_autocorr_time(discard=dropped, quiet=True, tol=0)
        times = np.maximum(np.nan_to_num(times, nan=float(steps)), 1.0)
        needed = max(length * float(times.max()), draws / walkers) / (1 - chains.burned)
        report(min(steps, round(needed)), round(needed))
    if steps < needed:
        notes.append(
            f"The chains are {(steps - dropped) / float(times.max()):.0f} autocorrelation times long in place of "
            f"{length:.0f}: quantiles are uncertain. Narrow a prior or the limits of what the curve does not determine."
        )
    chosen = np.linspace(steps - 1, dropped, min(-(-draws // walkers), steps - dropped)).round().astype(int)[::-1]
    return _Found(
        sampler.get_chain()[chosen].reshape(-1, count)[:draws],
        sampler.get_log_prob()[chosen].ravel()[:draws],
        times,
        (steps - dropped) * walkers,
        float(np.mean(sampler.acceptance_fraction)),
        tuple(notes),
    )


def _starts(density: LogPosterior, middle: Array, root: Array, rng: np.random.Generator) -> Array:
    """Positions of the walkers, normal about the middle; those beyond a limit are put anywhere before it."""
    fast = all(part.fast for part in density.parts)
    walkers = max(_CHAINS.walkers * fast, 4 * middle.size)
    # limits that nobody set are far away
    low, high = np.maximum(density.lower, middle - _FAR), np.minimum(density.upper, middle + _FAR)
    middle = np.clip(middle, low + 1e-3 * (high - low), high - 1e-3 * (high - low))
    starts = middle + rng.normal(size=(walkers, middle.size)) @ root.T
    for end, beyond in ((low, starts <= low), (high, starts >= high)):
        starts = np.where(beyond, end + (middle - end) * rng.uniform(1e-3, 1, size=starts.shape), starts)
    return np.asarray(starts)


def _alike(density: LogPosterior, sampled: LogPosterior, positions: Array) -> bool:
    """Whether the likelihood that was sampled (on block means, or of a quadratic model) is the true one, at some of the draws."""
    some = positions[:: max(len(positions) // 50, 1)]
    if all(a.objective is b.objective for a, b in zip(density.parts, sampled.parts, strict=True)) or len(some) < 2:
        return True
    # a tenth in ln of the likelihood changes no quantile by more than its own scatter
    return bool(np.std(density.likelihood(some) - sampled.likelihood(some)) < 0.1)


def _notes(result: Fitted, density: LogPosterior, positions: Array, values: Array) -> list[str]:
    notes = list(correlated(result.memory, result.minimum.residual.size))
    spread, (low, high) = np.std(values, axis=0), np.quantile(positions, [_TAIL / 2, 1 - _TAIL / 2], axis=0)
    near = _TAIL * (high - low)
    ended = (low - density.lower > near) & (density.upper - high > near)
    for j, name in enumerate(density.names):
        prior = density.priors.get(name)
        if prior is not None and name not in CALIBRATION and spread[j] > 0.5 * prior.spread:
            notes.append(
                f"{name}: the posterior is {100 * spread[j] / prior.spread:.0f} % as wide as the prior; the curve adds little to "
                "what was known."
            )
        elif prior is None and name in result.problem.free and not ended[j]:
            notes.append(
                f"{name} is not determined by the curve: its draws reach a limit of the fit. Give a prior, or narrower limits."
            )
    return notes
