"""`fit`: from a curve and a case with free parameters to values with intervals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from flatpunch._validation import Array, real
from flatpunch.fit.curve import Adhesion, Curve, CurveError, approach, check_signal
from flatpunch.fit.forward import ForwardModel
from flatpunch.fit.minimum import Minimum, covariance, minimise
from flatpunch.fit.objective import NUISANCE, Objective, contact_range, frame_of, scanned
from flatpunch.fit.report import judged
from flatpunch.fit.result import Estimate, FitResult
from flatpunch.fit.scaling import external, internal, replaced, slope, value_of

Loss = Literal["linear", "soft_l1", "huber", "cauchy"]
Engine = Literal["lmfit", "normal-equations"]

_SCANNED, _BINS = 100, 400
"""Points to which a curve is averaged for the search of the contact point, and for the first descent."""
_FAR = 1e6
"""A free parameter without limits may leave its start by this factor."""


@dataclass(frozen=True, slots=True)
class Free:
    """A parameter to be fitted.

    Parameters
    ----------
    start : float, optional
        Starting value, SI; the case's own value if left out.
    minimum, maximum : float, optional
        Limits, SI.
    """

    start: float | None = None
    minimum: float | None = None
    maximum: float | None = None


@dataclass(frozen=True, slots=True)
class Settings:
    """How a curve is fitted.

    Parameters
    ----------
    contact : "free" or float
        Contact point: fitted, or given [m] on the curve's own depth axis.
    baseline : "constant", "linear" or "none"
        Force without contact: fitted constant, fitted straight line, or zero.
    loss : "linear", "soft_l1", "huber" or "cauchy"
        Least squares, or a loss that outliers disturb less.
    adhesion : "refuse", "above" or "ignore"
        What to do about a dip below the baseline, see `flatpunch.fit.curve.check_signal`.
    depth_to, force_to : float, optional
        Use the curve up to this tip position [m] or force [N] only.
    method : str
        Contact method, or "auto".
    level : float
        Confidence level of intervals.
    engine : "lmfit" or "normal-equations"
        The second is several times faster and made for batches; the results are the same.
    """

    contact: Literal["free"] | float = "free"
    baseline: Literal["constant", "linear", "none"] = "constant"
    loss: Loss = "linear"
    adhesion: Adhesion = "refuse"
    depth_to: float | None = None
    force_to: float | None = None
    method: str = "auto"
    level: float = 0.95
    engine: Engine = "lmfit"

    def __post_init__(self) -> None:
        choices = {
            "baseline": ("constant", "linear", "none"),
            "loss": ("linear", "soft_l1", "huber", "cauchy"),
            "adhesion": ("refuse", "above", "ignore"),
            "engine": ("lmfit", "normal-equations"),
        }
        for name, known in choices.items():
            if getattr(self, name) not in known:
                raise ValueError(
                    f"{name} = {getattr(self, name)!r} is unknown; it is one of {', '.join(map(repr, known))}."
                )
        if self.contact != "free":
            real("contact", self.contact)
        if not 0 < real("level", self.level) < 1:
            raise ValueError(f"level = {self.level!r} must lie between 0 and 1, such as 0.95.")

    @property
    def nuisance(self) -> tuple[str, ...]:
        """Which of contact, baseline and tilt are fitted."""
        wanted = {
            "contact": self.contact == "free",
            "baseline": self.baseline != "none",
            "tilt": self.baseline == "linear",
        }
        return tuple(name for name in NUISANCE if wanted[name])


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
    wanted = _as_free(free)
    start_values = {name: f.start for name, f in wanted.items() if f.start is not None}
    model = _model(medium, indenter, tuple(wanted), tuple(sorted(start_values.items())), chosen.method)
    return fit_model(curve, model, wanted, chosen)


def _model(
    medium: Any, indenter: Any, free: tuple[str, ...], start: tuple[tuple[str, float], ...], method: str
) -> ForwardModel:
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


def _as_free(free: Any) -> dict[str, Free]:
    if isinstance(free, str):
        raise TypeError(f"free = {free!r} must be a list of names or a mapping from names to limits; write [{free!r}].")
    if not isinstance(free, Mapping):
        if not isinstance(free, Iterable):
            raise TypeError(f"free = {free!r} must be a list of names or a mapping from names to limits.")
        return {str(name): Free() for name in free}
    found = {}
    for name, what in free.items():
        if isinstance(what, Free):
            found[name] = what
        elif what is None:
            found[name] = Free()
        elif isinstance(what, (tuple, list)) and len(what) == 2:
            found[name] = Free(None, *what)
        else:
            found[name] = Free(real(f"free[{name!r}]", what))
    return found


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
    variance, factor = _spread(found, count, settings.loss)
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
    return replace(result, notes=(*notes, *judged(result)))


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
        found = _robust(objective, found, lower, upper, settings.loss)
    if not found.converged:
        raise CurveError(
            f"{name}: no minimum found after {found.evaluations} evaluations, residual "
            f"{np.sqrt(np.mean(found.residual**2)):.2g} of the force range. Fix a parameter, or give limits and a better start."
        )
    return found


def influence(loss: Loss, r: Array) -> tuple[Array, Array]:
    """Derivative psi of a loss over the residual in units of its scale, and the derivative of psi."""
    if loss == "soft_l1":
        root = np.sqrt(1 + r * r)
        return r / root, root**-3
    if loss == "huber":
        return np.clip(r, -1, 1), (np.abs(r) <= 1).astype(float)
    if loss == "cauchy":
        bottom = 1 + r * r
        return r / bottom, (1 - r * r) / bottom**2
    return r, np.ones_like(r)


def robust_scale(residual: Array) -> float:
    """Spread of residuals without regard to outliers."""
    return max(float(1.4826 * np.median(np.abs(residual - np.median(residual)))), 1e-300)


def _robust(objective: Objective, found: Minimum, lower: Array, upper: Array, loss: Loss) -> Minimum:
    """Iteratively reweighted least squares, the scale from the residuals of the step before."""
    base = np.ones_like(found.residual) if objective.weight is None else objective.weight
    x, count = found.x, found.evaluations
    for _ in range(30):
        residual = objective.evaluate(x)[0]
        r = residual / robust_scale(residual)
        psi = influence(loss, r)[0]
        weights = np.sqrt(np.where(np.abs(r) > 1e-8, psi / np.where(r == 0, 1, r), 1.0))
        step = minimise(replace(objective, weight=base * weights).evaluate, x, lower, upper)
        count += step.evaluations
        moved = step.x - x
        x = step.x
        if float(moved @ step.normal @ moved) < 1e-8 * step.cost / residual.size:
            break
    residual, jacobian = objective.evaluate(x)
    return Minimum(x, residual, jacobian @ jacobian.T, step.converged, step.at_bound, count)


def _spread(found: Minimum, count: int, loss: Loss) -> tuple[float, float]:
    """Variance of the noise, and how much larger the variance of a robust estimate is (Huber's formula)."""
    freedom = max(found.residual.size - count, 1)
    if loss == "linear":
        return found.cost / freedom, 1.0
    scale = robust_scale(found.residual)
    psi, bend = influence(loss, found.residual / scale)
    return scale**2, float(np.mean(psi**2) / np.mean(bend) ** 2) * found.residual.size / freedom


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
