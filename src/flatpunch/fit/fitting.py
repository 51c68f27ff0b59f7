"""`fit`: from a curve and a case with free parameters to values with intervals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Unpack

import numpy as np

from flatpunch._support.checks import Array, BadValue, Indices
from flatpunch._support.threads import one_blas_thread
from flatpunch.fit.adhesion.model import AdhesiveModel
from flatpunch.fit.adhesion.setup import adhesive_setup
from flatpunch.fit.elastic.setup import elastic_setup
from flatpunch.fit.least_squares.minimum import SOON, Minimum, covariance, minimise
from flatpunch.fit.least_squares.objective import Objective
from flatpunch.fit.least_squares.robust import influence, noise_variance, robust_scale
from flatpunch.fit.least_squares.setup import Setup
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.signal import converter_step, independent
from flatpunch.fit.models import Model, bounds, model_of
from flatpunch.fit.parameters.sample import Sample
from flatpunch.fit.parameters.scaling import MODULI, external
from flatpunch.fit.parameters.settings import Free, FreeNames, Loss, Settings, SettingsOf, as_free
from flatpunch.fit.parameters.unknowns import NUISANCE, Unknowns
from flatpunch.fit.report.estimate import estimated
from flatpunch.fit.report.findings import about_contact, judged, tilt_note
from flatpunch.fit.report.intervals import by_profile
from flatpunch.fit.report.physics_notes import limits_of_theory
from flatpunch.fit.report.result import FitResult
from flatpunch.fit.search import follows, searched
from flatpunch.fit.viscoelastic.model import HistoryModel
from flatpunch.fit.viscoelastic.setup import history_setup
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, Relaxation


@one_blas_thread()
def fit(
    curve: Curve,
    medium: Body,
    indenter: Indenter,
    free: FreeNames = (),
    *,
    work_of_adhesion: float | None = None,
    range_of_action: float | None = None,
    relaxation: Relaxation | None = None,
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
        Largest gap across which the adhesive traction acts [m]; the notes then state whether JKR theory holds.
    relaxation : StandardLinearSolid, Prony or PowerLawRelaxation, optional
        The medium relaxes, or where to start: the force over time of ramp, hold and retract is fitted; the curve needs times.
    **settings
        Fields of `Settings`: contact, baseline, loss, adhesion, depth_to, force_to, method, level, quick, segment.

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
    chosen = Settings(**settings)
    wanted = as_free(free)
    sample = Sample(medium, indenter, work_of_adhesion, range_of_action, relaxation)
    return fit_model(curve, model_of(sample, wanted, chosen.method, chosen.finite_strain), wanted, chosen)


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
    >>> from flatpunch.fit import fit_ranges
    >>> free = {"layers[0].young": fp.Free(2e3)}
    >>> fits = fit_ranges(curve, gel, fp.Sphere(radius=5e-6), free, shares=[0.5, 1.0])
    >>> print([f"{each['layers[0].young'] / 1e3:.2f} kPa" for each in fits])
    ['5.00 kPa', '5.00 kPa']
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
    setup = setup_of(curve, model, bounds(model, free), settings)
    setup, found = searched(setup, curve.name, free, setup.settings)
    while setup.again is not None and (narrower := setup.again(found.x)) is not None:
        setup, found = searched(narrower, curve.name, free, setup.settings)
    return result_of(curve, model, free, setup, found)


def result_of(curve: Curve, model: Model, free: Mapping[str, Free], setup: Setup, found: Minimum) -> FitResult:
    """Result of a fit from its minimum: values, intervals and notes."""
    settings = setup.settings
    objective, count = setup.objective, len(setup.objective.names)
    if isinstance(model, AdhesiveModel) or not settings.quick:
        follows(setup, found, curve.name)
    variance, factor = noise_variance(found, count, settings.loss)
    factor *= found.residual.size / max(independent(found.residual), 1.0)
    inside = ~found.at_bound
    spread, undetermined = covariance(found.normal, inside, variance * factor)
    shared = _rounding(setup, found) + other_background(setup, found)
    if curve.meta.get("calibration"):
        shared = shared + _calibration(curve, model, free, settings, found)
    tilts = [(objective, found.x, np.arange(found.x.size), 1.0)] if setup.doubtful and inside.all() else []
    unseen = undetected_tilts(found.normal, tilts, settings.loss)
    shared = shared + unseen
    spread = spread + shared
    result = FitResult(
        curve=setup.part,
        used=setup.used,
        objective=objective,
        minimum=found,
        estimates=estimated(objective, found, spread, setup.lower, setup.upper, settings.level),
        covariance=spread,
        undetermined=undetermined,
        noise=float(np.sqrt(variance)) * objective.frame[2],
        settings=settings,
        bounds=(setup.lower, setup.upper),
        notes=setup.notes,
        unseen=unseen,
    )
    result = replace(result, estimates=by_profile(result, setup.coarse, shared))
    tilt = about_tilt(setup, found.x, result) if setup.tilted else ()
    notes = (*setup.notes, *tilt, *about_contact(result), *judged(result), *limits_of_theory(result))
    return replace(result, notes=notes)


def about_tilt(setup: Setup, x: Array, result: FitResult, shared: Sequence[str] = ()) -> tuple[str, ...]:
    """Moduli over the other baseline, a constant or a straight line, where they are outside their intervals.

    Shared parameters that are no moduli stay as they are: one curve of many determines no more.
    """
    objective, straight = setup.objective, setup.settings.baseline == "linear"
    lower, upper = setup.lower, setup.upper
    if not straight:
        objective = with_tilt(objective)
        place = objective.names.index("tilt")
        x, lower, upper = (np.insert(v, place, e) for v, e in ((x, 0.0), (lower, -np.inf), (upper, np.inf)))
    flat = np.array([straight and name == "tilt" for name in objective.names])
    held = flat | np.array([name in shared and not name.endswith(MODULI) for name in objective.names])
    other = minimise(objective.evaluate, np.where(flat, 0.0, x), lower, upper, fixed=held, settled=SOON).x
    moved = {n: external(n, float(t)) for n, t in zip(objective.model.free, other, strict=False) if n.endswith(MODULI)}
    return tilt_note("constant" if straight else "linear", {n: (v, result.estimates[n]) for n, v in moved.items()})


def with_tilt(objective: Unknowns) -> Unknowns:
    """The problem with a tilt of the baseline beside its other unknowns."""
    names = tuple(n for n in NUISANCE if n in objective.names or n == "tilt")
    return replace(objective, nuisance=names, _before={})


def _rounding(setup: Setup, found: Minimum) -> Array:
    """Covariance from the rounding of a digitised force without contact, which is one error of many readings.

    A force x that is rounded to steps q, with noise s before the rounding, is off in the mean by
    sum_j (-1)^j q/(pi j) exp(-2 pi^2 j^2 s^2/q^2) sin(2 pi j x/q); its variance is taken over all x. Where the force rises the
    errors of neighbours change sign and average out.
    """
    objective, none = setup.objective, np.zeros((found.x.size, found.x.size))
    step = converter_step(setup.part.force)
    if not step or not isinstance(objective, Objective):
        return none
    free = np.ones(objective.depth.size, dtype=bool)
    if objective.loaded is None:
        free = objective.depth <= objective.split(found.x)[1]["contact"]
    else:
        free[objective.loaded] = False
    if not free.any():
        return none
    # readings that alternate between two levels have up to q^2/4 without showing s
    s = max(float(np.var(objective.force[free])) - step**2 / 4, 0.0)
    j = np.arange(1, 6)
    variance = float(np.sum((step / (np.pi * j)) ** 2 / 2 * np.exp(-((2 * np.pi * j / step) ** 2) * s)))
    pushed = objective.evaluate(found.x)[1][:, free].sum(axis=1)
    shift = covariance(found.normal, ~found.at_bound, 1.0)[0] @ pushed / objective.frame.span
    return np.asarray(variance * np.outer(shift, shift)) if np.isfinite(shift).all() else none


def undetected_tilts(
    normal: Array, curves: Iterable[tuple[Unknowns, Array, Indices, float]], loss: Loss = "linear"
) -> Array:
    """Covariance that tilts of the baselines add: for each a step to the minimum with a tilt, which the data do not ask for.

    `normal` is the normal matrix of the fit, shape (p, p). Each curve has its problem and minimum x, the places of its
    parameters in the fit, and the noise that the fit divides by. By `loss` outliers move a tilt as little as the other
    unknowns.
    """
    added, inverse = np.zeros_like(normal), covariance(normal, np.ones(len(normal), dtype=bool), 1.0)[0]
    for objective, x, places, noise in curves:
        tilted = with_tilt(objective)
        place = tilted.names.index("tilt")
        residual, jacobian = (each / noise for each in tilted.evaluate(np.insert(x, place, 0.0)))
        if loss != "linear":
            scale = robust_scale(residual)
            psi, bend = influence(loss, residual / scale)
            residual = scale * psi / np.mean(bend)
        column, along = jacobian[place], np.zeros(len(normal))
        along[places] = np.delete(jacobian, place, axis=0) @ column
        # infinite where the curve says nothing about a parameter, or the tilt is one of its shapes
        with np.errstate(invalid="ignore", divide="ignore"):
            shift = inverse @ along * (column @ residual) / (column @ column - along @ inverse @ along)
        if np.isfinite(shift).all():
            added += np.outer(shift, shift)
    return added


def other_background(setup: Setup, found: Minimum) -> Array:
    """Covariance that another background adds which the data allow as well: a step to its minimum."""
    if setup.other is None:
        return np.zeros_like(found.normal)
    residual, jacobian = setup.other.evaluate(found.x)
    inverse = covariance(jacobian @ jacobian.T, ~found.at_bound, 1.0)[0]
    shift = inverse @ (jacobian @ residual)
    return np.outer(shift, shift) if np.isfinite(shift).all() else np.zeros_like(found.normal)


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
        moved = fit_model(other, model, free, replace(settings, quick=True))
        count = len(model.free)
        shift = np.zeros(found.x.size)
        shift[:count] = moved.minimum.x[:count] - found.x[:count]
        added += np.outer(shift, shift)
    return added


def setup_of(curve: Curve, model: Model, limits: tuple[Array, Array], settings: Settings) -> Setup:
    """Least-squares problem of a curve and a model; ValueError for a segment that does not go with the model."""
    if isinstance(model, AdhesiveModel):
        if settings.segment == "approach":
            raise ValueError("segment = 'approach' does not go with work_of_adhesion; it is 'retract' or 'both'.")
        return adhesive_setup(curve, model, limits, settings)
    if isinstance(model, HistoryModel):
        if settings.segment not in ("auto", "both"):
            raise BadValue(
                "segment", repr(settings.segment), "does not go with relaxation: what was before is remembered."
            )
        return history_setup(curve, model, limits, settings)
    if settings.segment not in ("auto", "approach"):
        raise BadValue(
            "segment",
            repr(settings.segment),
            "goes with work_of_adhesion or relaxation; without them the approach is fitted.",
        )
    return elastic_setup(curve, model, limits, settings)
