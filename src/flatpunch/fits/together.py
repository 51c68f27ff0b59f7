"""Many curves of one sample fitted together: parameters that all share, and parameters of each curve.

One curve often determines a combination of modulus and thickness only; curves of different depths, tips or places determine
both. The sum of squares is that of all curves, each over the variance of its own noise, which is estimated with the rest:

    chi^2 = sum_i |r_i(shared, own_i)|^2 / s_i^2,      s_i^2 = |r_i|^2 / (n_i - p_i).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Unpack

import numpy as np

from flatpunch._support.checks import ROUNDING, TINY, Array, BadValue, instance, mapping, real
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.fits.fitting import Model, about_thicknesses, descended, effort, model_of, setup_of, unfinished
from flatpunch.fits.least_squares.minimum import minimise
from flatpunch.fits.least_squares.problem import Problem, Setup
from flatpunch.fits.measured.curve import Curve, CurveError, check_curves
from flatpunch.fits.measured.signal import independent
from flatpunch.fits.parameters.sample import OF, Sample
from flatpunch.fits.parameters.settings import Free, FreeNames, Options, Settings, as_free, options_of
from flatpunch.fits.parameters.unknowns import check_free
from flatpunch.fits.report.errors import about_curve, reported
from flatpunch.fits.report.findings import judged, limits_of_theory
from flatpunch.fits.report.result import FitResult
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body


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
    **options: Unpack[Options],
) -> FitResult:
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
    **options
        As for `fit`; loss is "linear".

    Returns
    -------
    FitResult
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
    fits.FitResult : What it returns.

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
    physics, chosen = options_of(options)
    shared, each = as_free(free), as_free(own)
    sample = Sample(medium, indenter, physics)
    _check(measured, shared, each, chosen)
    models = [_model(m, sample, {**shared, **each}, chosen) for m in measured]
    # where each curve begins need not be its minimum
    alone = [_alone(m.curve, *model, replace(chosen, quick=True)) for m, model in zip(measured, models, strict=True)]
    return _joined(
        Problem.of([setup for setup, _ in alone], [x for _, x in alone], len(shared)),
        chosen,
        {name for m in measured for name in m.values},
    )


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


def sample_at(sample: Sample, indenter: Indenter | None, values: Mapping[str, float]) -> Sample:
    """A sample at the place of one curve, with its own tip, if it has one, and values."""
    return (sample if indenter is None else replace(sample, indenter=indenter)).replaced(values)


def _model(
    measured: Measured, sample: Sample, free: Mapping[str, Free], settings: Settings
) -> tuple[Model, tuple[Array, Array]]:
    """The model of one curve and its limits."""
    here = sample_at(sample, measured.indenter, measured.values)
    # limits and starts of the fit hold where the place says nothing
    wanted = {name: replace(f, start=None) if name in measured.values else f for name, f in free.items()}
    check_free(here, wanted)
    model = model_of(here, wanted, settings.method)
    return model, model.bounds(wanted)


def _alone(curve: Curve, model: Model, limits: tuple[Array, Array], settings: Settings) -> tuple[Setup, Array]:
    """The problem of one curve, and its own best amplitude, contact point and background."""
    setup = setup_of(curve, model, limits, settings)
    x = _amplitude(setup, setup.start(), settings)
    while setup.again is not None and (narrower := setup.again(x)) is not None:
        setup = narrower
        x = _amplitude(setup, x, settings)
    return setup, x


def _amplitude(setup: Setup, start: Array, settings: Settings) -> Array:
    """A descent in which the moduli alone are free among the parameters of the sample: one curve determines no more."""
    model, count = setup.objective.model, len(setup.objective.names)
    fixed = np.isin(np.arange(count), np.setdiff1d(np.arange(len(model.free)), model.moduli))
    held = replace(setup, lower=np.where(fixed, start, setup.lower), upper=np.where(fixed, start, setup.upper))
    return descended(held, start, settings).x


def _joined(problem: Problem, settings: Settings, measured: Collection[str]) -> FitResult:
    coarse, x, noise = problem.coarse, problem.start, _noises(problem, problem.start)
    # fits, each with the noise of the one before, until it stays within a per cent
    for _ in range(3):
        found = minimise(replace(coarse, noise=noise).evaluate, x, *problem.bounds, **effort(problem.tabulated))
        x, before, noise = found.x, noise, _noises(problem, found.x)
        if np.abs(noise / before - 1).max() < 0.01:
            break
    if not found.converged and problem.tabulated:
        raise CurveError(
            f"no joint minimum found after {found.evaluations} evaluations: the curves determine no common "
            f"{', '.join(n for n in problem.free if OF not in n)}. Give limits and better starts, or fix one."
        )
    notes = () if found.converged else (unfinished(len(problem.free), found),)
    problem = replace(problem, noise=noise)
    result = reported(problem, problem.at(found), settings)
    parts = tuple(_one_of(result, i) for i in range(len(problem.setups)))
    result = replace(result, parts=parts, excess=tuple(_excess(each) for each in parts))
    return replace(
        result, notes=(*notes, *judged(result), *about_thicknesses(result, measured), *_disagreement(result))
    )


def _noises(problem: Problem, x: Array) -> Array:
    """Standard deviation of independent readings that would be as certain as those of each curve, over its force range."""
    pairs = zip(problem.parts, problem.places, strict=True)
    return np.array([_noise(part.evaluate(x[places])[0], places.size) for part, places in pairs])


def _noise(residual: Array, count: int, fall: float = 0.0) -> float:
    """The same of one curve, whose sum of squares is lower by `fall`."""
    variance = (residual @ residual - fall) / max(residual.size - count, 1)
    # data without noise have rounding
    return max(float(np.sqrt(np.maximum(variance, 0.0) * residual.size / max(independent(residual), 1.0))), ROUNDING)


def _excess(alone: FitResult) -> tuple[float, int]:
    """Fall of the sum of squares of one curve, over its noise, when it need not agree with the others; its parameters.

    The fall is that of the linear problem at the joint values.
    """
    residual, jacobian = alone.objective.evaluate(alone.minimum.x)
    unit = np.sqrt(np.maximum(np.sum(jacobian**2, axis=1), TINY))
    step = np.linalg.lstsq((jacobian / unit[:, None]).T, residual, rcond=ROUNDING)[0]
    fall = float(residual @ (step @ (jacobian / unit[:, None])))
    return fall / _noise(residual, len(unit), fall) ** 2, len(alone.problem.free)


def _disagreement(result: FitResult) -> tuple[str, ...]:
    # probability of curves of one sample to differ as much as these, below which it is worth a note
    if result.agreement >= 1e-3:
        return ()
    worst = max(range(len(result.results)), key=lambda i: result.excess[i][0])
    return (
        "The curves do not agree with one sample: by noise alone they would differ as much in "
        f"{result.agreement:.1g} of the cases, most of it in {result.results[worst].curve.name}. Another thickness or tip "
        "there, an error of calibration, or a sample that is not the same everywhere. Intervals are too small.",
    )


def _one_of(joint: FitResult, i: int) -> FitResult:
    """The fit of one curve at the joint values, with intervals of the joint fit and its own notes."""
    setup, places = joint.problem.setups[i], joint.problem.places[i]
    x = joint.minimum.x[places]
    alone = Problem.of([setup], [joint.problem.start[places]], 0)
    names = [joint.names[j] for j in places]
    result = FitResult(
        problem=alone,
        minimum=alone.at(replace(joint.minimum, x=x, at_bound=joint.minimum.at_bound[places])),
        estimates={name.partition(OF)[0]: joint.estimates[name] for name in names},
        covariance=joint.covariance[np.ix_(places, places)],
        undetermined=np.zeros((0, places.size)),
        settings=joint.settings,
    )
    return replace(result, notes=(*about_curve(result, joint.shared), *limits_of_theory(result)))
