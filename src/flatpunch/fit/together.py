"""Many curves of one sample fitted together: parameters that all share, and parameters of each curve.

One curve often determines a combination of modulus and thickness only; curves of different depths, tips or places determine
both. The sum of squares is that of all curves, each over the variance of its own noise, which is estimated with the rest:

    chi^2 = sum_i |r_i(shared, own_i)|^2 / s_i^2,      s_i^2 = |r_i|^2 / (n_i - p_i).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Unpack

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, BadValue, Indices, real
from flatpunch._support.kinds import instance, mapping
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.fit.fitting import about_tilt, setup_of, undetected_tilts
from flatpunch.fit.least_squares.joint import JointObjective
from flatpunch.fit.least_squares.minimum import Minimum, covariance, minimise
from flatpunch.fit.least_squares.setup import Setup
from flatpunch.fit.measured.curve import Curve, CurveError, check_curves
from flatpunch.fit.measured.signal import independent
from flatpunch.fit.models import bounds, check_free, model_of
from flatpunch.fit.parameters.sample import Sample
from flatpunch.fit.parameters.scaling import MODULI, OF
from flatpunch.fit.parameters.settings import Free, FreeNames, Settings, SettingsOf, as_free
from flatpunch.fit.report.estimate import estimated
from flatpunch.fit.report.findings import about_contact, judged
from flatpunch.fit.report.intervals import by_profile
from flatpunch.fit.report.joint import JointResult
from flatpunch.fit.report.result import FitResult
from flatpunch.fit.search import descended
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, Relaxation


@readable
@dataclass(frozen=True)
class Measured:
    """A curve of a joint fit, and how its measurement differs from the others.

    Parameters
    ----------
    curve : Curve
    indenter : Indenter, optional
        Its tip; that of the fit if left out.
    values : mapping of str to float
        Known parameters that differ at its place [SI], {"layers[0].thickness": 2e-6}; starting values of free ones.

    See Also
    --------
    fit_together : Takes them.

    Examples
    --------
    >>> depth = np.linspace(-100e-9, 200e-9, 61)
    >>> curve = fp.Curve(depth=depth, force=0.3 * np.maximum(depth, 0.0) ** 1.5)
    >>> place = fp.Measured(curve, indenter=fp.Sphere(radius=5e-6), values={"layers[0].thickness": 700e-9})
    >>> print(sorted(place.values))
    ['layers[0].thickness']
    """

    curve: Curve
    indenter: Indenter | None = None
    values: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        instance("Measured.curve", self.curve, (Curve,), "a Curve, as `read_curve` returns it")
        if self.indenter is not None:
            check_indenter(self.indenter, "Measured.indenter")
        known = mapping("Measured.values", self.values, "{'layers[0].thickness': 2e-6}")
        given = {name: real(f"values[{name!r}]", value) for name, value in known.items()}
        object.__setattr__(self, "values", given)


@one_blas_thread()
def fit_together(
    curves: Iterable[Curve | Measured],
    medium: Body,
    indenter: Indenter,
    free: FreeNames = (),
    own: FreeNames = (),
    *,
    work_of_adhesion: float | None = None,
    range_of_action: float | None = None,
    relaxation: Relaxation | None = None,
    **settings: Unpack[SettingsOf],
) -> JointResult:
    """Fit one sample to several curves at once.

    Parameters
    ----------
    curves : iterable of Curve or Measured
        Two or more; `Measured` gives a curve its own tip or known values of its place. Names must differ.
    medium, indenter : object
        The case, as for `fit`.
    free : sequence of str, or mapping of str to Free, float or (minimum, maximum)
        Parameters that all curves share.
    own : sequence of str, or mapping
        Parameters that each curve has for itself. Contact point and background always are.
    work_of_adhesion, range_of_action, relaxation, **settings
        As for `fit`; loss is "linear".

    Returns
    -------
    JointResult
        Shared and own values with intervals, one fit for each curve, and whether the curves agree with one sample.

    Raises
    ------
    CurveError
        If a curve cannot be evaluated.
    ValueError, TypeError
        On bad input.

    See Also
    --------
    Measured : A curve with its own tip or values.
    fit : One curve.
    fit.JointResult : What it returns.

    Examples
    --------
    >>> import numpy as np, flatpunch as fp
    >>> layer = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], base=fp.RigidBase())
    >>> z = np.linspace(-3e-7, 6e-7, 400)
    >>> def curve(radius):
    ...     force = np.zeros(400)
    ...     force[z > 0] = fp.indent(layer, fp.Sphere(radius), depth=z[z > 0])["force"]
    ...     return fp.Curve(z, force, name=f"{radius * 1e6:g} um")
    >>> measured = [fp.Measured(curve(r), indenter=fp.Sphere(r)) for r in (1e-6, 10e-6)]
    >>> start = fp.Medium([fp.Layer(2e3, 0.5, 1e-6)], base=fp.RigidBase())
    >>> found = fp.fit_together(measured, start, fp.Sphere(1e-6), free=["layers[0].young", "layers[0].thickness"])
    >>> print(f"{found['layers[0].young']:.0f} Pa, {found['layers[0].thickness'] * 1e6:.2f} um")
    5000 Pa, 2.00 um
    """
    check_curves(curves)
    measured = [m if isinstance(m, Measured) else Measured(m) for m in curves]
    given: SettingsOf = {"quick": True, **settings}
    chosen = Settings(**given)
    shared, each = as_free(free), as_free(own)
    sample = Sample(medium, indenter, work_of_adhesion, range_of_action, relaxation)
    _check(measured, shared, each, chosen)
    problems = [_problem(m, sample, {**shared, **each}, chosen) for m in measured]
    return _joined(problems, list(shared), chosen)


def _check(
    measured: Sequence[Measured], shared: Mapping[str, Free], own: Mapping[str, Free], settings: Settings
) -> None:
    for m in measured:
        if not isinstance(m.curve, Curve):
            raise TypeError(
                f"curves holds a {type(m.curve).__name__}; each must be a Curve, or a Measured(curve, ...)."
            )
    if len(measured) < 2:
        raise BadValue("curves", f"{len(measured)}", "curve: two or more are fitted together; for one use fit.")
    names = [m.curve.name for m in measured]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(
            f"curves: the name {twice[0]!r} is used twice; give each curve its own, Curve(..., name='...')."
        )
    both = sorted(set(shared) & set(own))
    if both:
        raise ValueError(f"{both[0]} is in free and in own; a parameter is shared by all curves, or belongs to each.")
    if not shared:
        raise ValueError("free is empty: no parameter is shared by the curves. Fit them one by one with fit_batch.")
    for m in measured:
        for name in set(m.values) & set(shared):
            raise ValueError(f"{m.curve.name}: {name} is shared by all curves and can have no value of its own.")
        if m.indenter is not None and any(name.startswith("indenter.") for name in shared):
            raise ValueError(
                f"{m.curve.name} has its own indenter, so that its parameters cannot be shared; name them in own."
            )
    if settings.loss != "linear":
        raise BadValue("loss", repr(settings.loss), "does not go with fit_together; it is 'linear'.")


@dataclass(frozen=True, eq=False)
class Problem:
    """One curve of a joint fit: its least-squares problem, and where its own search ended."""

    curve: Curve
    setup: Setup
    x: Array


def _problem(measured: Measured, sample: Sample, free: Mapping[str, Free], settings: Settings) -> Problem:
    """The problem of one curve, from its own best amplitude, contact point and background."""
    here = replace(sample, indenter=sample.indenter if measured.indenter is None else measured.indenter).replaced(
        dict(measured.values)
    )
    # limits and starts of the fit hold where the place says nothing
    wanted = {name: replace(f, start=None) if name in measured.values else f for name, f in free.items()}
    check_free(here, wanted)
    model = model_of(here, wanted, settings.method, settings.finite_strain)
    setup = setup_of(measured.curve, model, bounds(model, wanted), settings)
    x = _amplitude(setup, setup.start(), settings)
    while setup.again is not None and (narrower := setup.again(x)) is not None:
        setup = narrower
        x = _amplitude(setup, x, settings)
    return Problem(measured.curve, setup, x)


def _amplitude(setup: Setup, start: Array, settings: Settings) -> Array:
    """A descent in which the moduli alone are free among the parameters of the sample: one curve determines no more."""
    names, count = setup.objective.names, len(setup.objective.model.free)
    fixed = np.array([j < count and not names[j].endswith(MODULI) for j in range(len(names))])
    held = replace(setup, lower=np.where(fixed, start, setup.lower), upper=np.where(fixed, start, setup.upper))
    return descended(held, start, settings).x


def _joined(problems: Sequence[Problem], shared: Sequence[str], settings: Settings) -> JointResult:
    names, places = _named(problems, shared)
    x, lower, upper = (np.zeros(len(names)) for _ in range(3))
    for j in range(len(shared)):
        x[j] = np.median([p.x[j] for p in problems])
        lower[j], upper[j] = problems[0].setup.lower[j], problems[0].setup.upper[j]
    for p, place in zip(problems, places, strict=True):
        count = len(shared)
        x[place[count:]], lower[place[count:]], upper[place[count:]] = (
            v[count:] for v in (p.x, p.setup.lower, p.setup.upper)
        )
    free = tuple(n for n in names if n.partition(OF)[0] in problems[0].setup.objective.model.free)
    starts = x[: len(free)].copy()
    full = tuple(p.setup.objective for p in problems)
    coarse = tuple(p.setup.coarse if p.setup.coarse is not None else p.setup.objective for p in problems)
    noise = np.array([_noise(p, p.x) for p in problems])
    # fits, each with the noise of the one before; the noise hardly changes after the first
    for _ in range(3):
        problem = JointObjective(coarse, names, places, noise, free, starts)
        found = minimise(problem.evaluate, x, lower, upper)
        x = found.x
        noise = np.array([_noise(p, x[place]) for p, place in zip(problems, places, strict=True)])
    if not found.converged:
        raise CurveError(
            f"no joint minimum found after {found.evaluations} evaluations: the curves determine no common "
            f"{', '.join(shared)}. Give limits and better starts, or fix one."
        )
    objective = JointObjective(full, names, places, noise, free, starts)
    coarse_objective = JointObjective(coarse, names, places, noise, free, starts)
    minimum = _whole(objective, found)
    spread, undetermined = covariance(minimum.normal, ~minimum.at_bound, 1.0)
    doubtful = [i for i, p in enumerate(problems) if p.setup.doubtful and not minimum.at_bound.any()]
    unseen = undetected_tilts(
        minimum.normal, [(full[i], found.x[places[i]], places[i], float(noise[i])) for i in doubtful], settings.loss
    )
    spread = spread + unseen
    result = JointResult(
        objective=objective,
        minimum=minimum,
        estimates={},
        covariance=spread,
        undetermined=undetermined,
        settings=settings,
        bounds=(lower, upper),
        shared=tuple(shared),
        unseen=unseen,
    )
    found_values = estimated(objective, minimum, spread, lower, upper, settings.level)
    result = replace(result, estimates=found_values)
    result = replace(result, estimates=by_profile(result, coarse_objective, unseen))
    alone = [_alone(p, x[place]) for p, place in zip(problems, places, strict=True)]
    parts = tuple(_one_of_many(result, i, p.setup) for i, p in enumerate(problems))
    result = replace(result, results=parts, excess=tuple(alone))
    return replace(result, notes=(*judged(result), *_disagreement(result)))


def _disagreement(result: JointResult) -> tuple[str, ...]:
    """A note about curves that are not of one sample."""
    # probability of curves of one sample to differ as much as these, below which it is worth a note
    if result.agreement >= 1e-3:
        return ()
    worst = max(range(len(result.results)), key=lambda i: result.excess[i][0])
    return (
        "The curves do not agree with one sample: by noise alone they would differ as much in "
        f"{result.agreement:.1g} of the cases, most of it in {result.results[worst].curve.name}. Another thickness or tip "
        "there, an error of calibration, or a sample that is not the same everywhere. Intervals are too small.",
    )


def _named(problems: Sequence[Problem], shared: Sequence[str]) -> tuple[tuple[str, ...], tuple[Indices, ...]]:
    """Names of the joint x, parameters of the sample before contact points and backgrounds; and the places of each curve's x."""
    count = len(problems[0].setup.objective.model.free)
    names = list(shared)
    places: list[list[int]] = [list(range(len(shared))) for _ in problems]
    for nuisance in (False, True):
        for p, place in zip(problems, places, strict=True):
            mine = p.setup.objective.names[count:] if nuisance else p.setup.objective.names[len(shared) : count]
            place += range(len(names), len(names) + len(mine))
            names += [f"{name}{OF}{p.curve.name}" for name in mine]
    return tuple(names), tuple(np.array(place) for place in places)


def _noise(problem: Problem, x: Array) -> float:
    """Standard deviation of independent readings that would be as certain as those of one curve, over its force range."""
    residual = problem.setup.objective.evaluate(x)[0]
    variance = residual @ residual / max(residual.size - x.size, 1) * residual.size / max(independent(residual), 1.0)
    # data without noise have rounding
    return max(float(np.sqrt(variance)), ROUNDING)


def _whole(objective: JointObjective, found: Minimum) -> Minimum:
    """The minimum with the residuals of all readings; normal matrix block by block."""
    size = found.x.size
    normal, residuals = np.zeros((size, size)), []
    for part, place, s in zip(objective.parts, objective.places, objective.noise, strict=True):
        residual, jacobian = part.evaluate(found.x[place])
        residuals.append(residual / s)
        normal[np.ix_(place, place)] += jacobian @ jacobian.T / s**2
    return replace(found, residual=np.concatenate(residuals), normal=normal)


def _alone(problem: Problem, x: Array) -> tuple[float, int]:
    """Fall of the sum of squares of one curve, over its noise alone, when it need not agree with the others; its parameters."""
    setup = problem.setup
    coarse = setup.coarse if setup.coarse is not None else setup.objective
    start = coarse.evaluate(x)[0]
    found = minimise(coarse.evaluate, x, setup.lower, setup.upper)
    noise = _noise(problem, found.x)
    return max(float(start @ start) - found.cost, 0.0) / noise**2, len(setup.objective.model.free)


def _one_of_many(joint: JointResult, index: int, setup: Setup) -> FitResult:
    """The fit of one curve at the joint values, with intervals of the joint fit."""
    places, objective = joint.objective.places[index], joint.objective.parts[index]
    x = joint.minimum.x[places]
    residual, jacobian = objective.evaluate(x)
    scale = float(np.sqrt(residual @ residual / max(residual.size - x.size, 1)))
    names = [joint.names[j] for j in places]
    result = FitResult(
        curve=setup.part,
        used=setup.used,
        objective=objective,
        minimum=Minimum(x, residual, jacobian @ jacobian.T, True, joint.minimum.at_bound[places], 0),
        estimates={name.partition(OF)[0]: joint.estimates[name] for name in names},
        covariance=joint.covariance[np.ix_(places, places)],
        undetermined=np.zeros((0, places.size)),
        noise=scale * float(objective.frame[2]),
        settings=joint.settings,
        bounds=(joint.bounds[0][places], joint.bounds[1][places]),
        notes=setup.notes,
    )
    tilt = about_tilt(setup, x, result, joint.shared) if setup.tilted else ()
    return replace(result, notes=(*setup.notes, *tilt, *about_contact(result)))
