"""What a planned measurement can determine: standard errors before any curve is measured (Fisher's information).

The curve does not exist yet, its derivatives do: with J the derivatives of its readings by all that will be fitted and s their
noise, no unbiased estimate scatters less than s^2 (J J^T)^-1, and least squares reach it. J comes from the pressure of the
contact alone (`flatpunch.sensitivities`), so that nothing is tabulated or fitted.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Unpack

import numpy as np
from scipy.interpolate import make_interp_spline

from flatpunch._support.checks import TINY, Array, follows, positive, shown, whole
from flatpunch._support.declared import Place
from flatpunch._support.prefixes import text
from flatpunch._support.threads import one_blas_thread
from flatpunch.contact.curve import FEW_ANGLES, Control
from flatpunch.contact.indentation import indent
from flatpunch.contact.methods import FirstOrder
from flatpunch.fits.adhesion.model import AdhesiveModel
from flatpunch.fits.elastic.model import method_for
from flatpunch.fits.elastic.table import DEGREE
from flatpunch.fits.least_squares.minimum import covariance
from flatpunch.fits.parameters.sample import BESIDE, Sample, Scale
from flatpunch.fits.parameters.settings import FreeNames, Options, Settings, as_free, options_of
from flatpunch.fits.report.findings import TANGLED, combinations
from flatpunch.fits.report.plans import POORLY, Plan, PlanScan
from flatpunch.fits.report.posterior import Prior
from flatpunch.fits.report.table import unit_of
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.sensitivities.gradient import gradients
from flatpunch.sensitivities.parameters import parameters


def plan_scan(
    medium: Body, tips: Mapping[str, Indenter], free: FreeNames, *, depths: Sequence[float], **rest: Any
) -> PlanScan:
    """Plan curves with several tips to several depths.

    Parameters
    ----------
    medium : object
        The sample with the values that are expected.
    tips : mapping
        Name -> indenter.
    free : sequence of str, or mapping
        Parameters to fit, as in `fit`.
    depths : sequence of float
        Largest depths [m].
    **rest
        As for `planned`.

    Returns
    -------
    PlanScan

    See Also
    --------
    flatpunch.fits.planned : One curve.
    flatpunch.fits.PlanScan : What it returns.

    Examples
    --------
    >>> from flatpunch.fits import plan_scan
    >>> gel = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], base=fp.RigidBase())
    >>> tips = {"cone": fp.Cone(0.3), "bead": fp.Sphere(5e-6)}
    >>> print(len(plan_scan(gel, tips, ["layers[0].young"], depths=[2e-7, 5e-7], noise=2e-11).rows()))
    4
    """
    if not follows(tips, Mapping) or not tips:
        raise TypeError(f"tips = {shown(tips)} must be a mapping of names to indenters, {{'bead': Sphere(5e-6)}}.")
    wanted = [positive("depths", depth, unit="m") for depth in depths]
    found: dict[tuple[str, float], Plan | str] = {}
    for name, tip in tips.items():
        for depth in wanted:
            try:
                found[name, depth] = planned(medium, tip, free, depth=depth, **rest)
            except ValueError as error:
                # deeper than a tip or a layer allows
                found[name, depth] = str(error)
    if all(isinstance(plan, str) for plan in found.values()):
        raise ValueError(str(next(iter(found.values()))))
    return PlanScan(tuple(tips), tuple(wanted), found)


@one_blas_thread()
def planned(
    medium: Body,
    indenter: Indenter,
    free: FreeNames,
    *,
    depth: float,
    noise: float,
    points: int = 1000,
    before: float | None = None,
    spring_constant: float | None = None,
    priors: Mapping[str, Prior] | None = None,
    **options: Unpack[Options],
) -> Plan:
    """How well a planned curve will determine the parameters of a case.

    Parameters
    ----------
    medium, indenter : object
        The case with the values that are expected.
    free : sequence of str, or mapping
        Parameters to fit, as in `fit`.
    depth : float
        Largest indentation depth [m].
    noise : float
        Standard deviation of the force readings [N], independent of each other.
    points : int
        Readings of the whole curve, evenly over the tip position.
    before : float, optional
        Tip path without contact [m]; half the depth by default.
    spring_constant : float, optional
        Of the cantilever [N/m], whose bending the noise moves as well.
    priors : mapping of str to Normal, LogNormal or Uniform, optional
        What is known of free parameters beforehand, as for `FitResult.posterior`; a uniform prior counts by its variance.
    **options
        `contact`, `baseline`, `method` and, for the retract of a sticking tip, `work_of_adhesion` with `range_of_action` or
        `strength` as in `fit`, which leaves out readings next to the instability of a cantilever; the baseline "auto" counts as
        "linear" where nothing sticks.

    Returns
    -------
    Plan
        Standard errors, correlations, and what is not determined.

    Raises
    ------
    ValueError, TypeError
        On bad input.

    See Also
    --------
    flatpunch.fits.Plan : What it returns.
    flatpunch.sensitivity : The derivatives behind it.
    flatpunch.fit : Once the curve is measured.

    Notes
    -----
    Errors are those of small noise, a parabola: where they exceed some ten per cent they are an order of magnitude, and the
    posterior of a measured curve has the true shape. Derivatives are exact under round tips; for others the force is that of the
    fit's method, and its relative derivatives are those of the round tip of the same mean profile, good to some per cent.

    Examples
    --------
    >>> from flatpunch.fits import planned
    >>> layer = fp.Medium([fp.Layer(5e3, 0.5, 2e-6)], base=fp.RigidBase())
    >>> plan = planned(layer, fp.Sphere(5e-6), ["layers[0].young", "layers[0].thickness"], depth=5e-7, noise=2e-11)
    >>> plan.judgement("layers[0].young")
    'determined'
    """
    physics, chosen = options_of(options)
    if chosen.baseline == "auto" and physics.work_of_adhesion is None:
        # intervals with a constant include a tilt that the data do not exclude, on average as much as one that is fitted
        chosen = replace(chosen, baseline="linear")
    names = tuple(as_free(free))
    if not names:
        raise ValueError("free is empty: name the parameters that will be fitted.")
    sample = Sample(medium, indenter, physics)
    sample.check(names)
    unplanned = {
        "drag": "drag" in chosen.nuisance,
        "relaxation": sample.relaxing,
        "finite_strain": physics.finite_strain,
    }
    for name in (name for name, given in unplanned.items() if given):
        raise ValueError(f"{name} is not planned; leave it out.")
    deepest = positive("depth", depth, "It is the largest indentation depth [m].", unit="m")
    scatter = positive("noise", noise, "It is the standard deviation of the force readings [N].", unit="N")
    count = whole(
        "points", points, len(names) + len(chosen.nuisance) + 1, "It is the number of readings.", most=10_000_000
    )
    path = positive("before", deepest / 2 if before is None else before, "It is the path without contact.", unit="m")
    spring = None if spring_constant is None else positive("spring_constant", spring_constant, unit="N/m")
    readings = np.linspace(-path, deepest, count)
    stiffness, by_theta = _curve(sample, names, readings, chosen, spring)
    rows = dict(zip(names, by_theta, strict=True))
    columns = {"contact": -stiffness, "baseline": np.ones(count), "tilt": readings - readings[0]}
    jacobian = np.array([rows[name] if name in rows else columns[name] for name in (*names, *chosen.nuisance)])
    if spring is not None:
        give = 1 + stiffness / spring
        jacobian[[name != "tilt" for name in (*names, *chosen.nuisance)]] /= give
    title = f"{count} readings to a depth of {text(deepest, 'm')}, noise {text(scatter, 'N')}"
    return _judged(sample, names, chosen, jacobian / scatter, dict(priors or {}), title)


def _curve(
    sample: Sample, names: tuple[str, ...], readings: Array, settings: Settings, spring: float | None
) -> tuple[Array, Array]:
    """Stiffness [N/m] and derivatives by the internal parameters at the readings."""
    stiffness, by_theta = np.zeros(readings.size), np.zeros((len(names), readings.size))
    if sample.adhesive:
        model = AdhesiveModel(sample, names)
        theta = model.start()
        # fits leave out what is near the instability of a cantilever
        snap = None if spring is None else model.about_to_snap(theta, float(readings.max()), spring)
        inside = readings >= model.pull_off(theta)[0] if snap is None else readings > snap[0]
        _, stiffness[inside], by_theta[:, inside] = model.evaluate(readings[inside], theta)
        return stiffness, by_theta
    inside = readings > 0
    # contacts between which ln F and its derivatives, smooth over ln d, are interpolated
    nodes = readings.max() * np.geomspace(1e-3, 1, 48)
    known = {each.path: each for each in parameters(sample.medium, sample.indenter)}
    # a group moves all its members at their ratios
    moved = [sample.numbers.members.get(name, (name,)) for name in names]
    wanted = [known[name] for each in moved for name in each]
    found = gradients(sample.medium, sample.indenter, Control("depth", nodes), FirstOrder(), wanted)
    units = np.array([_slope(sample.numbers[each.path]) for each in wanted])
    first = np.cumsum([0, *map(len, moved[:-1])])
    relative = np.array([np.add.reduceat(each.force * units, first) / each.contact.force for each in found])
    method = method_for(sample.indenter, settings.method)
    forces = indent(sample.medium, sample.indenter, depth=nodes, method=method, angles=FEW_ANGLES)["force"].values
    spline = make_interp_spline(np.log(nodes), np.column_stack([np.log(forces), relative]), k=DEGREE)
    # below the first node, a thousandth of the depth, the curve is a power law
    at = np.log(np.maximum(readings[inside], nodes[0]))
    values, steps = spline(at), spline(at, nu=1)[:, 0]
    below = np.minimum(np.log(readings[inside]) - np.log(nodes[0]), 0.0)
    force = np.exp(values[:, 0] + steps * below)
    stiffness[inside] = force * steps / readings[inside]
    by_theta[:, inside] = (values[:, 1:] * force[:, None]).T
    return stiffness, by_theta


def _judged(
    sample: Sample, names: tuple[str, ...], settings: Settings, scaled: Array, priors: Mapping[str, Prior], title: str
) -> Plan:
    """Information, covariance and notes."""
    all_names, rest = (*names, *settings.nuisance), len(settings.nuisance)
    values = np.append([sample.value(name) for name in names], np.zeros(rest))
    units = np.append([_slope(sample.numbers[name]) for name in names], np.ones(rest))
    information = scaled @ scaled.T
    for name, prior in priors.items():
        if not follows(prior, Prior) or name not in all_names:
            raise ValueError(
                f"priors: {shown(name)} = {shown(prior)} must be Normal, LogNormal or Uniform, of one of {', '.join(all_names)}."
            )
        j = all_names.index(name)
        information[j, j] += (units[j] / prior.spread) ** 2
    spread, undetermined = covariance(information, np.ones(len(all_names), dtype=bool), 1.0)
    errors = np.sqrt(np.diag(spread)) * np.abs(units)
    known = {**sample.numbers, **BESIDE}
    plan = Plan({name: known[name] for name in all_names}, values, errors, spread, undetermined, title)
    alone = np.abs(units) / np.sqrt(np.maximum(np.diag(information), TINY))
    notes = list(_notes(plan, len(names), alone))
    if not sample.indenter.round and not sample.adhesive:
        notes.append(
            "Relative derivatives are those of the round tip of the same mean profile: errors hold to some per cent."
        )
    return replace(plan, notes=tuple(notes))


def _slope(number: Place) -> float:
    """Derivative of a number by its internal value."""
    scale = Scale.of(number)
    return float(scale.slope(scale.internal(number.value)))


def _notes(plan: Plan, count: int, alone: Array) -> Iterator[str]:
    """Parameters without effect, whose standard errors `alone` are known; combinations that change nothing; tangled pairs."""
    for name, value, error in zip(plan.names[:count], plan.values, alone, strict=False):
        if error > POORLY * (abs(value) if unit_of(plan.numbers[name]) else 1.0):
            yield f"{name} has hardly any effect on the curve: with all else known it would still be undetermined. Leave it out."
    for together in combinations(plan.names, plan.undetermined):
        if len(together) > 1:
            yield (
                f"Only a combination of {' and '.join(together)} can be determined, whatever the noise. Hold one of them, or "
                "measure it otherwise."
            )
    for j, k in zip(*np.tril_indices(count, -1), strict=True):
        pair, tangled = (plan.names[k], plan.names[j]), float(plan.correlation[j, k])
        if abs(tangled) > TANGLED and any(plan.judgement(name) != "determined" for name in pair):
            yield (
                f"{pair[0]} and {pair[1]} are hardly distinguished: correlation {tangled:.4f}. Hold one of them, give it a "
                "prior, or press deeper."
            )
