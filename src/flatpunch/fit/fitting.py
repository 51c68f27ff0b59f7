"""`fit`: from a curve and a case with free parameters to values with intervals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from flatpunch._validation import Array, real
from flatpunch.fit.curve import Curve, CurveError, approach, check_signal
from flatpunch.fit.forward import ForwardModel
from flatpunch.fit.minimum import Minimum, covariance, minimise
from flatpunch.fit.objective import Objective, contact_range, frame_of, scanned
from flatpunch.fit.report import judged
from flatpunch.fit.result import Estimate, FitResult
from flatpunch.fit.robust import noise_variance, reweighted
from flatpunch.fit.scaling import external, internal, replaced, slope, value_of
from flatpunch.fit.settings import Free, Settings, as_free

_SCANNED, _BINS = 100, 400
"""Points to which a curve is averaged for the search of the contact point, and for the first descent."""
_FAR = 1e6
"""A free parameter without limits may leave its start by this factor."""


def fit(curve: Curve, medium: Any, indenter: Any, free: Any = (), **settings: Any) -> FitResult:
    """Fit parameters of a medium and a tip to a measured curve.

    Parameters
    ----------
    curve : Curve
        Measured force over tip position, with its baseline; cut to the approach here.
    medium, indenter : object
        The case: known values, and starting values of the free ones.
    free : sequence of str, or mapping of str to Free, float or (minimum, maximum)
        Parameters to fit: "layers[0].young", "layers[0].thickness", "base.poisson", "indenter.radius", ...; see
        `flatpunch.fit.parameter_names`.
    **settings
        Fields of `Settings`: contact, baseline, loss, adhesion, depth_to, force_to, method, level, engine.

    Returns
    -------
    FitResult
        Values, intervals, correlations, notes about what the data cannot tell, and the fitted curve.

    Raises
    ------
    CurveError
        If the curve cannot be evaluated; the message says why.
    ValueError, TypeError
        On bad input.
    """
    chosen = Settings(**settings)
    wanted = as_free(free)
    start_values = {name: f.start for name, f in wanted.items() if f.start is not None}
    model = model_of(medium, indenter, tuple(wanted), tuple(sorted(start_values.items())), chosen.method)
    return fit_model(curve, model, wanted, chosen)


def model_of(
    medium: Any, indenter: Any, free: tuple[str, ...], start: tuple[tuple[str, float], ...], method: str
) -> ForwardModel:
    """The forward model of a case, kept for the next curve.

    Parameters
    ----------
    medium, indenter : object
        The case.
    free : tuple of str
        What is fitted.
    start : tuple of (name, value)
        Starting values that differ from the case's.
    method : str
        Contact method.
    """
    try:
        return _kept(medium, indenter, free, start, method)
    except TypeError:
        return ForwardModel(*_started(medium, indenter, start), free, method)


@lru_cache(maxsize=64)
def _kept(
    medium: Any, indenter: Any, free: tuple[str, ...], start: tuple[tuple[str, float], ...], method: str
) -> ForwardModel:
    return ForwardModel(*_started(medium, indenter, start), free, method)


def _started(medium: Any, indenter: Any, start: tuple[tuple[str, float], ...]) -> tuple[Any, Any]:
    return replaced(medium, indenter, dict(start))


def fit_ranges(
    curve: Curve,
    medium: Any,
    indenter: Any,
    free: Any = (),
    *,
    shares: Iterable[float] = (0.3, 0.45, 0.6, 0.8, 1.0),
    **settings: Any,
) -> list[FitResult]:
    """Fit the same curve up to several depths: what a right model finds does not depend on the range.

    Parameters
    ----------
    curve, medium, indenter, free, **settings
        As for `fit`.
    shares : iterable of float
        Depths up to which is fitted, over the largest depth of the whole fit.

    Returns
    -------
    list of FitResult
        One for each share that leaves enough points; the last is the whole curve if 1 is among the shares.
    """
    whole = fit(curve, medium, indenter, free, **settings)
    contact, deepest = whole["contact"] if "contact" in whole.estimates else 0.0, float(whole.depth.max())
    results = []
    for share in shares:
        if share >= 1:
            results.append(whole)
            continue
        try:
            results.append(fit(curve, medium, indenter, free, **{**settings, "depth_to": contact + share * deepest}))
        except CurveError:
            # too little force above the noise
            continue
    return results


def fit_model(curve: Curve, model: ForwardModel, free: Mapping[str, Free], settings: Settings) -> FitResult:
    """Fit with a forward model at hand; what `fit` and batches do for each curve."""
    part, keep, notes = prepared(curve, settings)
    used = part.taken(keep) if not keep.all() else part
    lower, upper = _bounds(model, free)
    objective = Objective(
        model=model,
        depth=used.depth,
        force=used.force,
        nuisance=settings.nuisance,
        held={
            "contact": 0.0 if settings.contact == "free" else float(settings.contact),
            "baseline": 0.0,
            "tilt": 0.0,
        },
        frame=frame_of(used.depth, used.force),
        spring=used.spring_constant,
    )
    count = len(objective.names)
    if used.depth.size <= count:
        raise CurveError(f"{curve.name}: {used.depth.size} points cannot determine {count} parameters.")
    low, high, _ = contact_range(used.depth, used.force)
    origin, width, _ = objective.frame
    slack = high - low
    loose = {
        "contact": ((low - slack - origin) / width, (high + slack / 3 - origin) / width),
        "baseline": (-10.0, 10.0),
        "tilt": (-10.0, 10.0),
    }
    lower = np.append(lower, [loose[name][0] for name in objective.nuisance])
    upper = np.append(upper, [loose[name][1] for name in objective.nuisance])
    found = _searched(objective, model, curve.name, lower, upper, settings)
    polished = None
    if settings.engine == "lmfit" and count:
        from flatpunch.fit.lmfit_engine import polish

        polished, found = polish(objective, found, lower, upper, settings.loss)
    variance, factor = noise_variance(found, count, settings.loss)
    inside = ~found.at_bound
    spread, undetermined = covariance(found.normal, inside, variance * factor)
    estimates = _estimates(objective, found, spread, lower, upper, settings.level)
    result = FitResult(
        curve=part,
        used=keep,
        objective=objective,
        minimum=found,
        estimates=estimates,
        covariance=spread,
        undetermined=undetermined,
        noise=float(np.sqrt(variance)) * objective.frame[2],
        settings=settings,
        bounds=(lower, upper),
        lmfit=polished,
        notes=notes,
    )
    return replace(result, notes=(*notes, *judged(result), *_limits(result)))


def _limits(result: FitResult) -> tuple[str, ...]:
    """What the contact theory says about its own limits at the fitted values; single fits only, as it costs a cold solution."""
    deepest = float(result.depth.max())
    if result.settings.engine != "lmfit" or deepest <= 0:
        return ()
    return tuple(result.objective.model.exact(deepest * np.geomspace(0.05, 1, 8), result.values)[1].splitlines())


def prepared(curve: Curve, settings: Settings) -> tuple[Curve, Any, tuple[str, ...]]:
    """The approach, which of its points are used, and notes."""
    if not isinstance(curve, Curve):
        raise TypeError(f"curve = {type(curve).__name__} must be a Curve(depth, force), or read with read_curve(path).")
    part = approach(_cut(curve, settings))
    keep, notes = check_signal(part, settings.adhesion)
    return part, keep, notes


def _cut(curve: Curve, settings: Settings) -> Curve:
    """The curve before it first reaches `force_to` or `depth_to`."""
    end = curve.depth.size
    for name, column, limit in (
        ("force_to", curve.force, settings.force_to),
        ("depth_to", curve.depth, settings.depth_to),
    ):
        if limit is not None:
            beyond = column > real(name, limit)
            if beyond.any():
                end = min(end, int(np.argmax(beyond)))
    return curve if end == curve.depth.size else curve.taken(slice(0, end))


def _bounds(model: ForwardModel, free: Mapping[str, Free]) -> tuple[Array, Array]:
    """Limits in internal parameters."""
    lower, upper = [], []
    for name, start in zip(model.free, model.start(), strict=True):
        limits = free[name]
        if name.endswith("poisson"):
            low, high = -0.99, 0.5
        else:
            low, high = start - np.log(_FAR), start + np.log(_FAR)
        if limits.minimum is not None:
            low = internal(name, _limit(name, "minimum", limits.minimum))
        if limits.maximum is not None:
            high = internal(name, _limit(name, "maximum", limits.maximum))
        if not low <= start <= high or low == high:
            value = value_of(model.medium, model.indenter, name)
            raise ValueError(
                f"{name}: the start {value:.6g} must lie between minimum {limits.minimum} and maximum {limits.maximum}."
            )
        lower.append(low)
        upper.append(high)
    return np.array(lower), np.array(upper)


def _limit(name: str, which: str, value: float) -> float:
    value = real(f"{name} {which}", value)
    if not name.endswith("poisson") and value <= 0:
        raise ValueError(f"{name} {which} = {value!r} must be > 0.")
    return min(value, 0.5) if name.endswith("poisson") else value


def _searched(
    objective: Objective, model: ForwardModel, name: str, lower: Array, upper: Array, settings: Settings
) -> Minimum:
    """Scan, descend on block means, then on all points."""
    low, high, first = contact_range(objective.depth, objective.force)
    coarse = objective.binned(_BINS, first)
    moduli = [j for j, free in enumerate(model.free) if free.endswith("young")]
    start = np.clip(scanned(objective.binned(_SCANNED, first), model.start(), moduli, (low, high)), lower, upper)
    if coarse.depth.size < objective.depth.size:
        start = minimise(coarse.evaluate, start, lower, upper, settled=0.05).x
    found = minimise(objective.evaluate, start, lower, upper)
    if settings.loss != "linear":
        found = reweighted(objective, found, lower, upper, settings.loss)
    if not found.converged:
        raise CurveError(
            f"{name}: no minimum found after {found.evaluations} evaluations, residual "
            f"{np.sqrt(np.mean(found.residual**2)):.2g} of the force range. Fix a parameter, or give limits and a better start."
        )
    return found


def _estimates(
    objective: Objective, found: Minimum, spread: Array, lower: Array, upper: Array, level: float
) -> dict[str, Estimate]:
    """Values with standard errors and intervals, SI; intervals are symmetric in the internal parameters."""
    from scipy.stats import t as student

    quantile = float(student.ppf((1 + level) / 2, max(objective.depth.size - found.x.size, 1)))
    count = len(objective.model.free)
    start = objective.model.start()
    estimates = {}
    for j, name in enumerate(objective.names):
        error = float(np.sqrt(spread[j, j]))
        x, reach = float(found.x[j]), quantile * error
        if j < count:
            low, high = (float(np.clip(x + s * reach, lower[j], upper[j])) for s in (-1, 1))
            value = external(name, x)
            unit = abs(slope(name, value))
            estimate = Estimate(
                value, error * unit, external(name, low), external(name, high), external(name, start[j])
            )
        else:
            offset, unit = objective.scales()[name]
            estimate = Estimate(
                offset + unit * x, unit * error, offset + unit * (x - reach), offset + unit * (x + reach)
            )
        estimates[name] = replace(estimate, at_bound=bool(found.at_bound[j]))
    return estimates
