"""Draws from the posterior of a fit by emcee: an ensemble of walkers that is blind to scales and correlations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import TINY, Array, BadValue, shown, whole
from flatpunch._support.progress import Report, reporting
from flatpunch._support.threads import one_blas_thread
from flatpunch.fit.elastic import ensemble
from flatpunch.fit.least_squares.objective import Objective
from flatpunch.fit.measured.curve import Curve
from flatpunch.fit.measured.signal import memory_of
from flatpunch.fit.parameters.priors import LogNormal, Normal, Prior, Uniform
from flatpunch.fit.parameters.scaling import internal, parameter_names, plain_limits
from flatpunch.fit.report.likelihood import Fitted
from flatpunch.fit.report.log_posterior import CALIBRATION, LogPosterior, parts_of
from flatpunch.fit.report.memory import correlated
from flatpunch.fit.report.posterior import Posterior


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
_FAR = 14.0
"""Internal limits of a number that has a prior only: a factor 1e6 either way."""


@one_blas_thread()
def draw(
    result: Fitted,
    curves: Sequence[Curve],
    draws: int,
    priors: Mapping[str, Prior] | None,
    seed: int,
    progress: bool | Report | None,
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
    density, x = _density(result, curves, dict(priors or {}))
    rng = np.random.default_rng(seed)
    middle, root = _parabola(density, x)
    quick = density.on_blocks(x) if density.fast else density.quadratic(middle, root)
    with reporting("Posterior", progress) as report:
        found = _sampled(quick, _starts(quick, middle, root, rng), count, rng, report)
        if not _alike(density, quick, found.positions):
            found = _sampled(density, _starts(density, middle, root, rng), count, rng, report)
    positions = _moved(found.positions, result, density, rng)
    values = np.column_stack(
        [density.external(name, column)[0] for name, column in zip(density.names, positions.T, strict=True)]
    )
    name = ", ".join(curve.name for curve in curves)
    notes = (*found.notes, *_notes(result, density, found.positions, values))
    return Posterior(
        name,
        density.names,
        values,
        found.logarithms,
        density.priors,
        found.times,
        np.minimum(found.kept / found.times, len(values)),
        found.acceptance,
        result.settings.level,
        notes,
    )


def _moved(positions: Array, result: Fitted, density: LogPosterior, rng: np.random.Generator) -> Array:
    """Draws with errors by a tilt of the baseline that the data do not exclude, as far as they stay within the limits."""
    if result.unseen is None or not result.unseen.any():
        return positions
    places, moved = [density.names.index(name) for name in result.names], positions.copy()
    moved[:, places] += rng.multivariate_normal(np.zeros(len(places)), result.unseen, len(moved), method="eigh")
    inside = np.all((moved >= density.lower) & (moved <= density.upper), axis=1, keepdims=True)
    return np.where(inside, moved, positions)


@dataclass(frozen=True, eq=False)
class _Found:
    """Thinned draws (internal), ln of their density, autocorrelation times, kept steps of all walkers, acceptance, notes."""

    positions: Array
    logarithms: Array
    times: Array
    kept: int
    acceptance: float
    notes: tuple[str, ...]


def _density(result: Fitted, curves: Sequence[Curve], given: dict[str, Prior]) -> tuple[LogPosterior, Array]:
    """The density, and where the fit ended."""
    objective = result.objective
    (lower, upper), x = result.bounds, result.minimum.x
    for name, prior in given.items():
        if not isinstance(prior, (Normal, LogNormal, Uniform)):
            raise TypeError(
                f"priors[{shown(name)}] = {shown(prior)} must be Normal(mean, std), LogNormal(median, relative) or "
                "Uniform(low, high)."
            )
    quick = False
    if len(curves) == 1 and ensemble.applies(objective):
        quick = True
        objective, lower, upper, x = _extended(objective, lower, upper, x, given)
    assumed = _assumed(curves, quick)
    for name, relative in curves[0].meta.get("calibration", {}).items() if quick else ():
        if name in assumed and name not in given:
            given[name] = LogNormal(assumed[name], relative)
    names = tuple(objective.names) + tuple(name for name in CALIBRATION if name in given)
    _check_names(given, names, assumed, objective)
    more, parts = len(names) - x.size, parts_of(objective, x)
    x = np.append(x, [np.log(given[name].centre / assumed[name]) for name in names[x.size :]])
    lower, upper = np.append(lower, [-_FAR] * more), np.append(upper, [_FAR] * more)
    density = LogPosterior(parts, names, lower, upper, objective.scales(), assumed, given)
    return _supported(density), x


def _extended(
    objective: Objective, lower: Array, upper: Array, x: Array, given: Mapping[str, Prior]
) -> tuple[Objective, Array, Array, Array]:
    """The problem with numbers of the case free that have a prior and were held in the fit."""
    model = objective.model
    added = [name for name in given if name not in objective.names and name not in CALIBRATION]
    known = parameter_names(model.medium, model.indenter)
    for name in added:
        if name not in known:
            raise ValueError(
                f"priors: {shown(name)} is no parameter of this fit; it has "
                f"{', '.join(dict.fromkeys([*objective.names, *known, *CALIBRATION]))}."
            )
    if not added:
        return objective, lower, upper, x
    values = model.externals(x[: len(model.free)])
    medium, indenter = model.case(values)
    wider = replace(model, medium=medium, indenter=indenter, free=(*model.free, *added))
    place = len(model.free)
    start = np.array([internal(name, wider.value(name)) for name in added])
    limits = [plain_limits(name) or (s - _FAR, s + _FAR) for name, s in zip(added, start, strict=True)]
    lower, upper = (np.insert(b, place, [pair[i] for pair in limits]) for i, b in enumerate((lower, upper)))
    return replace(objective, model=wider, _before={}), lower, upper, np.insert(x, place, start)


def _assumed(curves: Sequence[Curve], quick: bool) -> dict[str, float]:
    """Values of the calibration that may be drawn."""
    if not quick:
        return {}
    k = curves[0].spring_constant
    return ({} if k is None else {"spring_constant": float(k)}) | {"sensitivity": 1.0}


def _check_names(
    given: Mapping[str, Prior], names: Sequence[str], assumed: Mapping[str, float], objective: object
) -> None:
    for name in given:
        if name in CALIBRATION and name not in assumed:
            why = (
                "the curve has no spring constant; give it as Curve(..., spring_constant=) or in [curve]"
                if ensemble.applies(objective)
                else "only fits of a single curve without adhesion and relaxation draw the calibration"
            )
            raise ValueError(f"priors: {name} cannot be drawn: {why}.")
        if name not in names:
            raise ValueError(
                f"priors: {shown(name)} was not fitted; a prior goes here with {', '.join(names)}. Fit it as well."
            )


def _supported(density: LogPosterior) -> LogPosterior:
    """The density with limits where the priors end."""
    lower, upper = density.lower.copy(), density.upper.copy()
    for name, prior in density.priors.items():
        j = density.names.index(name)
        ends = density.external(name, np.array([lower[j], upper[j]]))[0]
        low, high = prior.support
        if not (low < ends[1] and high > ends[0]):
            raise ValueError(
                f"priors: {name} = {prior} allows no value between the limits of the fit, {ends[0]:.6g} and {ends[1]:.6g}."
            )
        lower[j], upper[j] = (
            max(lower[j], _internal(density, name, low)) if low > ends[0] else lower[j],
            min(upper[j], _internal(density, name, high)) if high < ends[1] else upper[j],
        )
    return replace(density, lower=lower, upper=upper)


def _internal(density: LogPosterior, name: str, value: float) -> float:
    if name in density.scales:
        offset, unit = density.scales[name]
        return (value - offset) / unit
    if name in density.assumed:
        return float(np.log(value / density.assumed[name]))
    return internal(name, value)


def _sampled(density: LogPosterior, state: Array, draws: int, rng: np.random.Generator, report: Report) -> _Found:
    """Run the chains until they are long enough."""
    import emcee

    chains = _CHAINS
    walkers, count = state.shape
    # not emcee's DESnookerMove, whose draws are too narrow: 0.85 of the standard deviation of a normal density of four parameters
    moves = [(emcee.moves.DEMove(), 0.5), (emcee.moves.KDEMove(), 0.3), (emcee.moves.StretchMove(), 0.2)]
    sampler = emcee.EnsembleSampler(walkers, count, density, vectorize=True, moves=moves)
    sampler.random_state = np.random.RandomState(rng.integers(2**31)).get_state()
    while True:
        state = sampler.run_mcmc(state, chains.block)
        steps = sampler.iteration
        dropped: int = round(chains.burned * steps)
        times = emcee.autocorr.integrated_time(sampler.get_chain(discard=dropped), quiet=True, tol=0)
        times = np.maximum(np.nan_to_num(times, nan=float(steps)), 1.0)
        length = min(chains.length, max(chains.shortest, draws / walkers))
        needed = max(length * float(times.max()), draws / walkers) / (1 - chains.burned)
        report(min(steps, round(needed)), round(needed))
        if steps >= needed or steps >= chains.longest:
            break
    notes: tuple[str, ...] = ()
    if steps < needed:
        notes = (
            f"The chains are {(steps - dropped) / float(times.max()):.0f} autocorrelation times long in place of "
            f"{length:.0f}: quantiles are uncertain. Narrow a prior or the limits of what the curve does not determine.",
        )
    each = -(-draws // walkers)
    chosen = np.linspace(steps - 1, dropped, min(each, steps - dropped)).round().astype(int)[::-1]
    positions = sampler.get_chain()[chosen].reshape(-1, count)[:draws]
    logarithms = sampler.get_log_prob()[chosen].ravel()[:draws]
    acceptance = float(np.mean(sampler.acceptance_fraction))
    return _Found(positions, logarithms, times, (steps - dropped) * walkers, acceptance, notes)


def _parabola(density: LogPosterior, x: Array) -> tuple[Array, Array]:
    """Most probable parameters and a root of their covariance, from the slopes of the residuals at x and the priors."""
    step = 1e-4  # internal parameters are of order one
    eye = step * np.eye(x.size)
    # where nothing is known positions spread by a factor 20 of a logarithmic parameter
    information, shift = np.diag(np.full(x.size, 1 / 3.0**2)), np.zeros(x.size)
    for part in density.parts:
        r = density.residuals(part, np.vstack([x, x + eye, x - eye]))
        slopes = (r[1 : x.size + 1] - r[x.size + 1 :]) / (2 * step)
        variance = (float(r[0] @ r[0]) + part.within) / max(part.count - x.size, 1)
        information += slopes @ slopes.T / max(variance, TINY)
    for name, prior in density.priors.items():
        j = density.names.index(name)
        ends = density.external(name, np.array([density.lower[j], density.upper[j]]))[0]
        place = _internal(density, name, float(np.clip(prior.centre, *ends)))
        weight = float(density.external(name, np.array([place]))[1][0] / prior.spread) ** 2
        information[j, j] += weight
        shift[j] = weight * (place - x[j])
    scale = 1 / np.sqrt(np.diag(information))
    root = np.linalg.inv(np.linalg.cholesky(information * scale[:, None] * scale)).T * scale[:, None]
    return x + root @ root.T @ shift, root


def _starts(density: LogPosterior, middle: Array, root: Array, rng: np.random.Generator) -> Array:
    """Positions of the walkers, normal about the middle; those beyond a limit are put anywhere before it."""
    walkers = max(_CHAINS.walkers, 4 * middle.size) if density.fast else 5 * middle.size
    # limits that nobody set are far away
    low, high = np.maximum(density.lower, middle - _FAR), np.minimum(density.upper, middle + _FAR)
    middle = np.clip(middle, low + 1e-3 * (high - low), high - 1e-3 * (high - low))
    starts = middle + rng.normal(size=(walkers, middle.size)) @ root.T
    for end, beyond in ((low, starts <= low), (high, starts >= high)):
        anywhere = end + (middle - end) * rng.uniform(1e-3, 1, size=starts.shape)
        starts = np.where(beyond, anywhere, starts)
    return np.asarray(starts)


def _alike(density: LogPosterior, quick: LogPosterior, positions: Array) -> bool:
    """Whether the likelihood that was sampled (on block means, or of a quadratic model) is the true one, at some of the draws."""
    some = positions[:: max(len(positions) // 50, 1)]
    if all(a.objective is b.objective for a, b in zip(density.parts, quick.parts, strict=True)) or len(some) < 2:
        return True
    # a tenth in ln of the likelihood changes no quantile by more than its own scatter
    return bool(np.std(density.likelihood(some) - quick.likelihood(some)) < 0.1)


def _notes(result: Fitted, density: LogPosterior, positions: Array, values: Array) -> list[str]:
    """What the numbers do not say by themselves."""
    residual = result.minimum.residual
    notes = list(correlated(memory_of(residual), residual.size))
    spread = np.std(values, axis=0)
    for j, name in enumerate(density.names):
        prior = density.priors.get(name)
        if prior is not None and name not in CALIBRATION and spread[j] > 0.5 * prior.spread:
            notes.append(
                f"{name}: the posterior is {100 * spread[j] / prior.spread:.0f} % as wide as the prior; the curve adds little to "
                "what was known."
            )
        elif prior is None and name in result.objective.model.free and not _ends(density, j, positions[:, j]):
            notes.append(
                f"{name} is not determined by the curve: its draws reach a limit of the fit. Give a prior, or narrower limits."
            )
    return notes


def _ends(density: LogPosterior, j: int, positions: Array) -> bool:
    """Whether the draws of an internal parameter stay away from its limits."""
    low, high = np.quantile(positions, [0.005, 0.995])
    near = 0.01 * (high - low)
    return bool(low - density.lower[j] > near and density.upper[j] - high > near)
