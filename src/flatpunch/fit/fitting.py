"""`fit`: from a curve and a case with free parameters to values with intervals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any, Unpack

import numpy as np

from flatpunch._support.checks import Array, real
from flatpunch._support.threads import one_blas_thread
from flatpunch.fit.adhesion.model import AdhesiveModel
from flatpunch.fit.adhesion.setup import adhesive_setup
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.elastic.setup import elastic_setup
from flatpunch.fit.least_squares.minimum import SETTLED, SOON, Minimum, covariance, minimise
from flatpunch.fit.least_squares.objective import Objective
from flatpunch.fit.least_squares.robust import noise_variance, reweighted
from flatpunch.fit.least_squares.setup import Setup
from flatpunch.fit.measured.curve import FEWEST, Curve, CurveError
from flatpunch.fit.measured.signal import noise_of
from flatpunch.fit.parameters.sample import Sample
from flatpunch.fit.parameters.scaling import external, internal, plain_limits, slope
from flatpunch.fit.parameters.settings import FitMethod, Free, Settings, SettingsOf, as_free
from flatpunch.fit.report.estimate import Estimate
from flatpunch.fit.report.findings import judged
from flatpunch.fit.report.intervals import by_profile
from flatpunch.fit.report.physics_notes import limits_of_theory
from flatpunch.fit.report.quantities import quantity, unit_of
from flatpunch.fit.report.result import FitResult
from flatpunch.fit.viscoelastic.model import HistoryModel
from flatpunch.fit.viscoelastic.setup import history_setup

_ASTRAY = 3.0
"""Force ranges by which a fit may miss a point before it counts as none."""
_FAR = 1e6
"""A free parameter without limits may leave its start by this factor."""

MISFIT = 0.8
"""Correlation of neighbouring residuals in the contact from which they are the model's and not the detector's."""
_FAINT = 0.01
"""Noise of the tip's position, over the depth, below which taking the position as measured biases nothing."""
_WIDENED = 4
"""Searches with wider and wider limits."""

Model = ForwardModel | AdhesiveModel | HistoryModel


@one_blas_thread()
def fit(
    curve: Curve,
    medium: Any,
    indenter: Any,
    free: Any = (),
    *,
    work_of_adhesion: float | None = None,
    range_of_action: float | None = None,
    relaxation: Any = None,
    **settings: Unpack[SettingsOf],
) -> FitResult:
    """Fit parameters of a medium and a tip to a measured curve.

    Parameters
    ----------
    curve : Curve
        Measured force over tip position, with its baseline; cut to the part that is fitted here.
    medium, indenter : object
        The case: known values, and starting values of the free ones.
    free : sequence of str, or mapping of str to Free, float or (minimum, maximum)
        Parameters to fit: "layers[0].young", "layers[0].thickness", "base.poisson", "indenter.radius", "work_of_adhesion",
        "relaxation.time", ...; see `flatpunch.fit.parameter_names` and `flatpunch.fit.Sample`.
    work_of_adhesion : float, optional
        w [J/m^2], or where to start: the contact is adhesive (JKR) and the retract is fitted.
    range_of_action : float, optional
        Gap up to which the adhesive traction acts [m]; the notes then say whether JKR theory holds.
    relaxation : StandardLinearSolid, Prony or PowerLawRelaxation, optional
        The medium relaxes, or where to start: the force over time of ramp, hold and retract is fitted; the curve needs times.
    **settings
        Fields of `Settings`: contact, baseline, loss, adhesion, depth_to, force_to, method, level, engine, segment.

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
    sample = Sample(medium, indenter, work_of_adhesion, range_of_action, relaxation)
    return fit_model(curve, model_of(sample, wanted, chosen.method), wanted, chosen)


def model_of(sample: Sample, free: Mapping[str, Free], method: FitMethod) -> Model:
    """The forward model of a case, kept for the next curve.

    Parameters
    ----------
    sample : Sample
        The case.
    free : mapping of str to Free
        What is fitted, with starting values that differ from the case's.
    method : str or method
        Contact method.
    """
    for name in free:
        sample.check(name)
    starts = {name: real(name, f.start) for name, f in free.items() if f.start is not None}
    started = sample.replaced(starts)
    try:
        return _kept(started, tuple(free), method)
    except TypeError:
        return _made(started, tuple(free), method)


@lru_cache(maxsize=64)
def _kept(sample: Sample, free: tuple[str, ...], method: FitMethod) -> Model:
    return _made(sample, free, method)


def _made(sample: Sample, free: tuple[str, ...], method: FitMethod) -> Model:
    if sample.work_of_adhesion is not None:
        return AdhesiveModel(sample, free, method)
    if sample.relaxation is not None:
        return HistoryModel(sample, free, method)
    return ForwardModel(sample.medium, sample.indenter, free, method)


@one_blas_thread()
def fit_ranges(
    curve: Curve,
    medium: Any,
    indenter: Any,
    free: Any = (),
    *,
    shares: Iterable[float] = (0.3, 0.45, 0.6, 0.8, 1.0),
    **settings: Unpack[SettingsOf],
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
            part: SettingsOf = {**settings, "depth_to": contact + share * deepest}
            results.append(fit(curve, medium, indenter, free, **part))
        except CurveError:
            # too little force above the noise
            continue
    return results


@one_blas_thread()
def fit_model(curve: Curve, model: Model, free: Mapping[str, Free], settings: Settings) -> FitResult:
    """Fit with a forward model at hand; what `fit` and batches do for each curve."""
    if not isinstance(curve, Curve):
        raise TypeError(f"curve = {type(curve).__name__} must be a Curve(depth, force), or read with read_curve(path).")
    setup = _setup(curve, model, bounds(model, free), settings)
    setup, found = _searched(setup, curve.name, free, settings)
    if setup.again is not None and (narrower := setup.again(found.x)) is not None:
        setup, found = _searched(narrower, curve.name, free, settings)
    setup, found = _unweighted(setup, found, curve.name, free, settings)
    objective, count = setup.objective, len(setup.objective.names)
    polished = None
    if settings.engine == "lmfit" and count:
        from flatpunch.fit.least_squares.lmfit_engine import polish

        polished, found = polish(objective, found, setup.lower, setup.upper, settings.loss)
    if isinstance(model, AdhesiveModel) or settings.engine == "lmfit":
        _follows(setup, found, curve.name)
    variance, factor = noise_variance(found, count, settings.loss)
    inside = ~found.at_bound
    spread, undetermined = covariance(found.normal, inside, variance * factor)
    if curve.meta.get("calibration"):
        spread = spread + _calibration(curve, model, free, settings, found)
    result = FitResult(
        curve=setup.part,
        used=setup.used,
        objective=objective,
        minimum=found,
        estimates=_estimates(objective, found, spread, setup.lower, setup.upper, settings.level),
        covariance=spread,
        undetermined=undetermined,
        noise=float(np.sqrt(variance)) * objective.frame[2],
        settings=settings,
        bounds=(setup.lower, setup.upper),
        lmfit=polished,
        notes=setup.notes,
    )
    result = replace(result, estimates=by_profile(result, setup.coarse))
    return replace(result, notes=(*setup.notes, *judged(result), *limits_of_theory(result)))


def _calibration(curve: Curve, model: Model, free: Mapping[str, Free], settings: Settings, found: Minimum) -> Array:
    """Covariance that an uncertain calibration adds: the fit is repeated with each constant one standard deviation larger.

    A larger spring constant makes forces larger and leaves the tip where it was; a larger sensitivity makes deflections larger.
    """
    added = np.zeros((found.x.size, found.x.size))
    for name, relative in curve.meta["calibration"].items():
        force, k = curve.force * (1 + relative), curve.spring_constant
        other = replace(curve, force=force, meta={**curve.meta, "calibration": {}})
        if k is not None:
            k = k * (1 + relative) if name == "spring_constant" else k
            other = replace(other, depth=curve.position - force / k, spring_constant=k)
        moved = fit_model(other, model, free, replace(settings, engine="normal-equations"))
        count = len(model.free)
        shift = np.zeros(found.x.size)
        shift[:count] = moved.minimum.x[:count] - found.x[:count]
        added += np.outer(shift, shift)
    return added


def _setup(curve: Curve, model: Model, limits: tuple[Array, Array], settings: Settings) -> Setup:
    if isinstance(model, AdhesiveModel):
        if settings.segment == "approach":
            raise ValueError("segment = 'approach' does not go with work_of_adhesion; it is 'retract' or 'both'.")
        return adhesive_setup(curve, model, limits, settings)
    if isinstance(model, HistoryModel):
        if settings.segment not in ("auto", "both"):
            raise ValueError(
                f"segment = {settings.segment!r} does not go with relaxation: what was before is remembered."
            )
        return history_setup(curve, model, limits, settings)
    if settings.segment not in ("auto", "approach"):
        raise ValueError(
            f"segment = {settings.segment!r} goes with work_of_adhesion or relaxation; without them the approach is fitted."
        )
    return elastic_setup(curve, model, limits, settings)


def check_free(sample: Sample, free: Mapping[str, Free]) -> None:
    """Refuse limits that a start does not lie between, without making a model.

    Raises
    ------
    ValueError
        Which, and what they are.
    """
    for name, what in free.items():
        _between(name, what.start if what.start is not None else sample.value(name), what)


def bounds(model: Model, free: Mapping[str, Free]) -> tuple[Array, Array]:
    """Limits in internal parameters."""
    starts = model.externals(model.start())
    pairs = [_between(name, starts[name], free[name]) for name in model.free]
    return np.array([low for low, _ in pairs]), np.array([high for _, high in pairs])


def _between(name: str, start: float, limits: Free) -> tuple[float, float]:
    begin = internal(name, start)
    low, high = plain_limits(name) or (begin - np.log(_FAR), begin + np.log(_FAR))
    if limits.minimum is not None:
        low = internal(name, _limit(name, "minimum", limits.minimum))
    if limits.maximum is not None:
        high = internal(name, _limit(name, "maximum", limits.maximum))
    # the start has been there and back
    slack = 1e-12 * max(1.0, abs(begin))
    if not low - slack <= begin <= high + slack or low == high:
        unit = unit_of(name)
        words = [quantity(v, unit) if v is not None else "none" for v in (start, limits.minimum, limits.maximum)]
        raise ValueError(f"{name}: the start {words[0]} must lie between minimum {words[1]} and maximum {words[2]}.")
    return low, high


def _limit(name: str, which: str, value: float) -> float:
    value = real(f"{name} {which}", value)
    plain = plain_limits(name)
    if plain is None and value <= 0:
        raise ValueError(f"{name} {which} = {value!r} must be > 0.")
    return float(np.clip(value, *plain)) if plain else value


def _searched(setup: Setup, name: str, free: Mapping[str, Free], settings: Settings) -> tuple[Setup, Minimum]:
    """Descend from the start; limits that nobody set are widened where the search ends on one."""
    start = setup.start()
    for _ in range(_WIDENED):
        found = _descended(setup, start, settings)
        wider = _wider(setup, found, free, settings)
        if wider is None:
            break
        setup, start = wider, found.x
    if not found.converged:
        raise CurveError(
            f"{name}: no minimum found after {found.evaluations} evaluations, residual "
            f"{np.sqrt(np.mean(found.residual**2)):.2g} of the force range. Fix a parameter, or give limits and a better start."
        )
    return setup, found


def _unweighted(
    setup: Setup, found: Minimum, name: str, free: Mapping[str, Free], settings: Settings
) -> tuple[Setup, Minimum]:
    """Behind a cantilever, where the misfit of the contact is no noise: the force over the tip's positions, equally weighted.

    The weights of a cantilever's noise hold for noise. They count the deep points less, and where the misfit is the model's
    they would decide which part of the curve the model is fitted to.
    """
    objective = setup.objective
    if not isinstance(objective, Objective) or objective.spring is None or objective.loaded is not None:
        return setup, found
    theta, rest = objective.split(found.x)
    inside = objective.depth > rest["contact"]
    r = found.residual[inside]
    if r.size < 2 * FEWEST or not float(r[1:] @ r[:-1]) > MISFIT * float(r @ r):
        return setup, found
    noise = noise_of(np.diff(objective.force[~inside])) / np.sqrt(2)
    if noise / objective.spring > _FAINT * float(objective.depth.max() - rest["contact"]):
        # the measured positions scatter too much to be taken as they are
        return setup, found
    plain = replace(
        setup,
        objective=replace(objective, plain=True, _before={}),
        coarse=None if setup.coarse is None else replace(setup.coarse, plain=True, _before={}),
        start=lambda: found.x,
    )
    weighted = ", ".join(
        f"{n} = {quantity(external(n, float(t)), unit_of(n))}" for n, t in zip(objective.model.free, theta, strict=True)
    )
    note = (
        "The misfit of the contact is no noise of the detector: the force is fitted over the tip's position with equal weights. "
        f"With the weights of a cantilever's noise: {weighted}."
    )
    return _searched(replace(plain, notes=(*setup.notes, note)), name, free, settings)


def _descended(setup: Setup, start: Array, settings: Settings) -> Minimum:
    settled = SOON if settings.engine == "normal-equations" else SETTLED
    objective, coarse = setup.objective, setup.coarse
    if coarse is None or coarse is objective:
        found = minimise(objective.evaluate, start, setup.lower, setup.upper, settled=settled)
    else:
        found = minimise(coarse.evaluate, start, setup.lower, setup.upper, settled=settled)
        if settings.engine == "normal-equations":
            residual, jacobian = objective.evaluate(found.x)
            found = replace(found, residual=residual, normal=jacobian @ jacobian.T)
        else:
            found = minimise(objective.evaluate, found.x, setup.lower, setup.upper, settled=settled)
    if settings.loss != "linear":
        found = reweighted(objective, found, setup.lower, setup.upper, settings.loss)
    return found


def _wider(setup: Setup, found: Minimum, free: Mapping[str, Free], settings: Settings) -> Setup | None:
    """The same with wider limits where the minimum sits on one that nobody set; None if there is no such limit."""
    names, lower, upper = setup.objective.names, setup.lower.copy(), setup.upper.copy()
    low_set, high_set = settings.contact_limits
    changed = False
    for j in np.flatnonzero(found.at_bound):
        below, name = bool(found.x[j] <= lower[j]), names[j]
        if name == "contact":
            # beyond the last point nothing is in contact
            if below and low_set is None and high_set is None:
                lower[j] -= 2 * (1 + abs(lower[j]))
                changed = True
        elif name in free and plain_limits(name) is None:
            if below and free[name].minimum is None:
                lower[j] -= np.log(_FAR)
                changed = True
            if not below and free[name].maximum is None:
                upper[j] += np.log(_FAR)
                changed = True
    return replace(setup, lower=lower, upper=upper) if changed else None


def _follows(setup: Setup, found: Minimum, name: str) -> None:
    """Refuse a minimum whose curve is nowhere near the data: behind a soft cantilever a stiff sample shows as little."""
    off = (setup.objective.over(setup.part, found.x) - setup.part.force)[setup.used]
    if not np.abs(off).max() < _ASTRAY * float(np.ptp(setup.part.force)):
        raise CurveError(
            f"{name}: no curve of this model comes near the data: the fit ran off to values at which the force is off by "
            f"{np.abs(off).max():.3g} N. Check spring constant, sensitivity and units, or give limits and a better start."
        )


@lru_cache(maxsize=1024)
def half_width(level: float, freedom: int) -> float:
    """Half width of a two-sided interval in standard errors."""
    from scipy.stats import t as student

    return float(student.ppf((1 + level) / 2, freedom))


def _estimates(
    objective: Any, found: Minimum, spread: Array, lower: Array, upper: Array, level: float
) -> dict[str, Estimate]:
    """Values with standard errors and intervals, SI; intervals are symmetric in the internal parameters."""
    quantile = half_width(level, max(objective.depth.size - found.x.size, 1))
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
