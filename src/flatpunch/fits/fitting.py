"""`fit`: from a curve and a case with free parameters, by a search for the least squares, to values with intervals."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from typing import Unpack

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, real
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.threads import one_blas_thread
from flatpunch.fits.adhesion.model import AdhesiveModel
from flatpunch.fits.adhesion.setup import adhesive_setup
from flatpunch.fits.adhesion.tables import branch_tables
from flatpunch.fits.elastic.model import ForwardModel, table_of
from flatpunch.fits.elastic.setup import elastic_setup
from flatpunch.fits.least_squares.minimum import ROUGH, SETTLED, SOON, Minimum, minimise, reweighted
from flatpunch.fits.least_squares.problem import Problem, Setup
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.signal import memory_of
from flatpunch.fits.parameters.sample import Sample
from flatpunch.fits.parameters.settings import (
    FitMethod,
    Free,
    FreeNames,
    Options,
    Settings,
    SettingsOf,
    as_free,
    check_segment,
    options_of,
    segments,
)
from flatpunch.fits.parameters.unknowns import FAR
from flatpunch.fits.report.errors import about_curve, reported
from flatpunch.fits.report.findings import judged, limits_of_theory
from flatpunch.fits.report.result import FitResult
from flatpunch.fits.report.sampling import draws_held
from flatpunch.fits.viscoelastic import HistoryModel, history_setup
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body

OFF = 0.1
"""Share of a known thickness for which the change of the moduli is noted; few thicknesses are measured better."""


Model = ForwardModel | AdhesiveModel | HistoryModel


def model_of(sample: Sample, free: Mapping[str, Free], method: FitMethod) -> Model:
    """The forward model of a case, kept for the next curve; starting values in `free` differ from those of the sample."""
    sample.check(free)
    starts = {name: real(name, f.start) for name, f in free.items() if f.start is not None}
    return _made(sample.replaced(starts), tuple(free), method)


def forget_models() -> None:
    """Forget all models and their tables, which grow with the curves that they have seen.

    Interpolation moves results by up to the tables' 1e-9; after this call they are those of a new process, to the last digit.
    """
    _made.cache_clear()
    table_of.cache_clear()
    branch_tables.cache_clear()


@byte_cached
def _made(sample: Sample, free: tuple[str, ...], method: FitMethod) -> Model:
    if sample.adhesive:
        return AdhesiveModel(sample, free, method)
    if sample.relaxing:
        return HistoryModel(sample, free, method)
    return ForwardModel(sample.medium, sample.indenter, free, method, sample.physics.finite_strain)


@one_blas_thread()
def fit(
    curve: Curve,
    medium: Body,
    indenter: Indenter,
    free: FreeNames = (),
    **options: Unpack[Options],
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
        "relaxation.time", ...; see `flatpunch.fits.parameter_names` and `flatpunch.fits.Sample`.
    **options
        What acts beside elasticity, each known or where to start, as for `indent`: work_of_adhesion [J/m^2] (the retract is
        fitted), range_of_action [m] or strength [Pa] in its place, relaxation (the force over time of ramp,
        hold and retract is fitted; the curve needs times), finite_strain. And how to fit, the fields of `Settings`: contact,
        baseline, loss, adhesion, depth_to, force_to, method, level, quick, segment, direction, drag.

    Returns
    -------
    FitResult
        Values, intervals, correlations, notes about what the data do not determine, and the fitted curve.

    Raises
    ------
    CurveError
        If the curve cannot be evaluated; the message says why.
    ValueError, TypeError
        On bad input.

    See Also
    --------
    fit_batch : Many curves.
    correct : From a modulus that was reported for a half-space.
    plot_fit : The picture.

    Examples
    --------
    >>> gel, tip = fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6)
    >>> depth = np.linspace(-2e-7, 4e-7, 300)
    >>> force = np.zeros(300)
    >>> force[depth > 0] = fp.indent(gel, tip, depth=depth[depth > 0]).force
    >>> curve = fp.Curve(depth=depth, force=force + 1e-11 * np.random.default_rng(0).normal(size=300))
    >>> start = fp.HalfSpace(young=2e3, poisson=0.5)
    >>> result = fp.fit(curve, start, tip, ["base.young"])
    >>> print(f"{result['base.young'] / 1e3:.2f} kPa")
    5.00 kPa
    """
    physics, chosen = options_of(options)
    wanted = as_free(free)
    return fit_model(curve, model_of(Sample(medium, indenter, physics), wanted, chosen.method), wanted, chosen)


@one_blas_thread()
def fit_ranges(
    curve: Curve,
    medium: Body,
    indenter: Indenter,
    free: FreeNames = (),
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
        Largest depths of the fits, over the largest depth of the whole fit.

    Returns
    -------
    list of FitResult
        One for each share that leaves enough points; the last is the whole curve if 1 is among the shares.

    See Also
    --------
    flatpunch.fit : One range.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> depth = np.linspace(-200e-9, 400e-9, 121)
    >>> force = np.where(depth > 0, fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.maximum(depth, 1e-12)).force, 0.0)
    >>> force += 1e-12 * np.random.default_rng(0).normal(size=force.size)
    >>> curve = fp.Curve(depth=depth + 50e-9, force=force)
    >>> from flatpunch.fits import fit_ranges
    >>> free = {"layers[0].young": fp.Free(2e3)}
    >>> fits = fit_ranges(curve, gel, fp.Sphere(radius=5e-6), free, shares=[0.5, 1.0])
    >>> print([f"{each['layers[0].young'] / 1e3:.2f} kPa" for each in fits])
    ['5.00 kPa', '5.00 kPa']
    """
    whole = fit(curve, medium, indenter, free, **settings)
    contact, deepest = whole["contact"] if "contact" in whole.estimates else 0.0, float(whole.depth.max())
    deepest *= whole.problem.parts[0].turned
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
def fit_model(
    curve: Curve, model: Model, free: Mapping[str, Free], settings: Settings, measured: Collection[str] = ()
) -> FitResult:
    """Fit with a forward model at hand; what `fit` and batches do for each curve, of which some numbers are `measured`."""
    if not isinstance(curve, Curve):
        raise TypeError(f"curve = {type(curve).__name__} must be a Curve(depth, force), or read with read_curve(path).")
    setup = setup_of(curve, model, model.bounds(free), settings)
    setup, found = searched(setup, curve.name, free, setup.settings)
    while setup.again is not None and (narrower := setup.again(found.x)) is not None:
        setup, found = searched(narrower, curve.name, free, setup.settings)
    return result_of(curve, model, setup, found, measured)


def result_of(curve: Curve, model: Model, setup: Setup, found: Minimum, measured: Collection[str] = ()) -> FitResult:
    """Result of a fit from its minimum: values, intervals and notes."""
    if model.adhesive:
        follows(setup, found, curve.name)
    start = found.x.copy()
    start[: len(model.free)] = model.start()
    result = reported(Problem.of([setup], [start], 0), found, setup.settings)
    return replace(
        result,
        notes=(*about_curve(result), *judged(result), *about_thicknesses(result, measured), *limits_of_theory(result)),
    )


def about_thicknesses(result: FitResult, measured: Collection[str] = ()) -> tuple[str, ...]:
    """How far moduli are off where a thickness that is given for all curves is off by `OFF`, if that is out of their intervals.

    The fit is repeated with each such thickness; `measured` are the names of those that are given for each curve.
    """
    problem, found, notes = result.problem, result.minimum, []
    model = problem.parts[0].model
    moduli = [j for j, name in enumerate(problem.free) if problem.numbers[name].number.unit == "Pa"]
    for name, number in model.numbers.items():
        if number.number.what != "thickness" or name in model.free or name in measured:
            continue
        setups = [
            replace(each, objective=replace(each.objective, model=_thicker(each, name), _before={}))
            for each in problem.coarse.setups
        ]
        moved = minimise(replace(problem, setups=tuple(setups)).evaluate, found.x, *problem.bounds, settled=SOON)
        for free, value in ((problem.free[j], float(problem.external(j, moved.x[j]))) for j in moduli):
            e = result.estimates[free]
            if moved.converged and not e.low <= value <= e.high:
                change, low, high = (end / e.value - 1 for end in (value, e.low, e.high))
                notes.append(
                    f"{free} changes by {change:+.1%} where {name} is {OFF:.0%} larger than the {text(number.value, 'm')} given; "
                    f"its interval, {low:+.1%} to {high:+.1%}, takes the thickness as known. Measure it; "
                    f"{'' if draws_held(problem) else 'fitted as well, '}with a prior of it the posterior contains its "
                    "uncertainty (posterior(priors=...), or [priors] and --posterior)."
                )
    return tuple(notes)


def _thicker(setup: Setup, name: str) -> Model:
    """The model of a curve with a thickness larger by `OFF`."""
    model = setup.objective.model
    sample = model.sample.replaced({name: (1 + OFF) * model.numbers[name].value})
    return model_of(sample, {free: Free() for free in model.free}, setup.settings.method)


def setup_of(curve: Curve, model: Model, limits: tuple[Array, Array], settings: Settings) -> Setup:
    """Least-squares problem of a curve and a model; ValueError for a segment that does not go with the model."""
    check_segment(settings.segment, segments(model.adhesive, model.over_time))
    if isinstance(model, AdhesiveModel):
        return adhesive_setup(curve, model, limits, settings)
    if isinstance(model, HistoryModel):
        return history_setup(curve, model, limits, settings)
    return elastic_setup(curve, model, limits, settings)


def searched(setup: Setup, name: str, free: Mapping[str, Free], settings: Settings) -> tuple[Setup, Minimum]:
    """Descend from the start; limits that nobody set are widened where the search ends on one."""
    start = setup.start()
    # searches with wider and wider limits
    for _ in range(4):
        found = descended(setup, start, settings)
        wider = _wider(setup, found, free, settings)
        if wider is None:
            break
        setup, start = wider, found.x
    if not found.converged:
        if not _along_a_valley(setup, found):
            raise CurveError(f"{name}: {_why_not(setup, found)}")
        setup = replace(setup, notes=(*setup.notes, unfinished(len(free), found)))
    return setup, found


def _along_a_valley(setup: Setup, found: Minimum) -> bool:
    """Whether a search that costs a contact a step ended where only noise is left: neighbouring residuals are independent."""
    left = found.residual
    return not setup.objective.model.tabulated and bool(memory_of(left) < 2 / np.sqrt(left.size))


def unfinished(count: int, found: Minimum) -> str:
    """A note about a search for `count` parameters that was given up."""
    return (
        f"The {count} parameters are poorly determined: the search ended after {found.evaluations} contacts of a curve, at "
        "values that describe the data about as well as others do. Fix a parameter, or press deeper."
    )


def effort(tabulated: bool, quick: bool = False) -> Plain:
    """How long is searched; where each step solves the contact, valleys that hardly end would cost hundreds: they are noted."""
    return {"settled": SOON if quick else SETTLED} if tabulated else {"settled": ROUGH, "steps": 20}


def _why_not(setup: Setup, found: Minimum) -> str:
    if "contact" in setup.objective.names:
        inside = setup.objective.indentation(setup.part, found.x)[setup.used]
        if inside.min() > 0:
            return (
                "the data begin in contact, no baseline is seen, and the curve bends too little to show where the contact began: "
                f"contact point and modulus run off together ({text(float(inside.min()), 'm')} before the first reading "
                "so far). Record from "
                "further out, or give the contact point, contact = '...', and baseline = 'none' where the force begins at zero."
            )
        if inside.max() <= 0:
            return (
                "the contact point is outside the data: the search ran beyond the deepest reading, and nothing is in contact. "
                "Press deeper, or give limits, contact = { min = ..., max = ... }."
            )
    misfit = float(np.sqrt(np.mean(found.residual**2)))
    return (
        f"no minimum found after {found.evaluations} evaluations, residual {misfit:.2g} of the force range. Fix a parameter, "
        "or give limits and a better start."
    )


def descended(setup: Setup, start: Array, settings: Settings) -> Minimum:
    """Least squares from a start: on block means first, then on all readings (batches stay with the means)."""
    objective, coarse = setup.objective, setup.coarse
    bounds, how = (setup.lower, setup.upper), effort(objective.model.tabulated, settings.quick)
    found = minimise((coarse or objective).evaluate, start, *bounds, **how)
    if coarse is not None and coarse is not objective:
        if settings.quick:
            residual, jacobian = objective.evaluate(found.x)
            found = replace(found, residual=residual, normal=jacobian @ jacobian.T)
        else:
            found = minimise(objective.evaluate, found.x, *bounds, **how)
    if settings.loss != "linear":
        found = reweighted(objective, found, *bounds, settings.loss)
    return found


def _wider(setup: Setup, found: Minimum, free: Mapping[str, Free], settings: Settings) -> Setup | None:
    """A setup with wider limits where the minimum sits on one that nobody set; None if there is no such limit."""
    names, lower, upper = setup.objective.names, setup.lower.copy(), setup.upper.copy()
    low_set, high_set = settings.contact_limits(1.0)
    changed = False
    for j in np.flatnonzero(found.at_bound):
        below, name = bool(found.x[j] <= lower[j]), names[j]
        if name == "contact":
            # beyond the last point nothing is in contact
            if below and low_set is None and high_set is None:
                lower[j] -= 2 * (1 + abs(lower[j]))
                changed = True
        elif name in free:
            least, most = setup.objective.model.ends(name)
            if below and free[name].minimum is None and lower[j] > least:
                lower[j], changed = max(lower[j] - np.log(FAR), least), True
            if not below and free[name].maximum is None and upper[j] < most:
                upper[j], changed = min(upper[j] + np.log(FAR), most), True
    return replace(setup, lower=lower, upper=upper) if changed else None


def follows(setup: Setup, found: Minimum, name: str) -> None:
    """Refuse a minimum whose curve is nowhere near the data: behind a soft cantilever a stiff sample shows as little."""
    off = (setup.objective.over(setup.part, found.x) - setup.part.force)[setup.used]
    # force ranges by which a fit may miss a point before it counts as none
    if not np.abs(off).max() < 3.0 * float(np.ptp(setup.part.force)):
        raise CurveError(
            f"{name}: no curve of this model comes near the data: the fit ran off to values at which the force is off by "
            f"{np.abs(off).max():.3g} N. Check spring constant, sensitivity and units, or give limits and a better start."
        )
