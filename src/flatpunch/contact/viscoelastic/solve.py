"""Viscoelastic contact for a history of depth or force: checks, choice of the solution, and the result as a curve.

C(k) of a body whose layers all relax alike is the elastic one over psi, at every wavenumber; so is everything built from
it. On an elastic substrate that is not so: the shape of C(k) itself changes with time.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flatpunch._support.checks import Array, Indices, values
from flatpunch.compliance import compliance
from flatpunch.contact.curve import Control, Curve, few
from flatpunch.contact.viscoelastic.elastic import AREA, RADIUS, STIFFNESS, ElasticCurve, Solve, elastic_curve
from flatpunch.contact.viscoelastic.monotone import last_rise, one_cycle
from flatpunch.contact.viscoelastic.series import COARSE, ExponentialSeries, exponential_series, mean_decay
from flatpunch.contact.viscoelastic.springs import Springs
from flatpunch.indenters.profile import Indenter
from flatpunch.media import HalfSpace, Medium, PowerLawHalfSpace, RigidBase, underlying
from flatpunch.media.relaxation import Relaxation

_SPLITS = 16
"""Pieces, each half as long as the next, into which the step of the first touch is split: K begins there like a root of d."""


def solve(
    medium: Any,
    indenter: Indenter,
    control: Control,
    time: Array,
    relaxation: Relaxation,
    phi: Array,
    method: Solve,
    options: dict[str, Any],
) -> Curve:
    """Follow a history.

    Parameters
    ----------
    medium : HalfSpace, PowerLawHalfSpace, or Medium on a RigidBase
        The body; its moduli times psi(t) are those that relax.
    indenter : Indenter
        The indenter.
    control : Control
        Depths [m] (any sign; the surface is at 0) or forces [N] at the given times, linear in between. A first value that is not
        zero is a sudden step.
    time : ndarray, shape (n,)
        Times [s], ascending.
    relaxation : Relaxation
        psi(t).
    phi : ndarray, shape (p,)
        Polar angles of the outline [rad].
    method : callable
        `solve` of an elastic contact method, and its `options`.

    Returns
    -------
    Curve
        With the extra array `time` [s] and `contact_depth` [m], the depth of the elastic contact of the same extent.
    """
    check_medium(medium)
    check_history(control, time)
    kernel = compliance(medium)
    shortest, longest = float(np.diff(time).min()), float(time[-1] - time[0])
    series = exponential_series(relaxation, shortest, longest)
    coarse = exponential_series(relaxation, shortest, longest, COARSE)
    target = np.maximum(control.values, 0.0)
    if not target.any():
        raise ValueError(f"{control.name} is nowhere positive, so there is never a contact.")
    if control.name == "depth":
        deepest = float(target.max())
    else:
        deepest = _deepest(medium, indenter, float(target.max()), series, time, phi, method, options)
    elastic = elastic_curve(method, kernel, indenter, deepest, phi, options)
    if control.name == "depth":
        force, contact = _by_depth(time, control.values, relaxation, (series, coarse), elastic)
        depth = control.values
    else:
        depth, force, contact = _by_force(time, target, (series, coarse), elastic, deepest)
    return _curve(time, depth, force, contact, elastic, relaxation, phi)


def check_medium(medium: Any) -> None:
    """Refuse bodies whose compliance changes its shape with time."""
    medium = underlying(medium)
    alike = isinstance(medium, (HalfSpace, PowerLawHalfSpace)) or (
        isinstance(medium, Medium) and (isinstance(medium.base, RigidBase) or not medium.layers)
    )
    if not alike:
        raise ValueError(
            f"relaxation goes with a half-space or with layers on a RigidBase, not with this {type(medium).__name__}: on an "
            "elastic substrate (or against an elastic body) part of the system does not relax, so that the shape of its "
            "compliance changes with time and neither Lee-Radok nor Ting holds. Take a rigid base where the substrate is much "
            "stiffer."
        )


def check_history(control: Control, time: Array) -> None:
    """Times ascending, one value each."""
    if time.size < 2 or time.size != control.values.size:
        raise ValueError(
            f"time has {time.size} values and {control.name} {control.values.size}; a history needs two or more times and as "
            "many values."
        )
    if (np.diff(time) <= 0).any():
        i = int(np.argmax(np.diff(time) <= 0))
        raise ValueError(f"time[{i + 1}] = {time[i + 1]:.6g} s must be after time[{i}] = {time[i]:.6g} s.")


def history_control(*, depth: object, force: object, radius: object) -> Control:
    """Depth or force of a history; depths may be negative (not yet in contact), forces not."""
    if radius is not None or (depth is None) == (force is None):
        raise ValueError("Give exactly one of depth and force with time and relaxation: its value at each time.")
    if force is None:
        return Control("depth", few("depth", values("depth", depth, minimum=-np.inf, unit="m")))
    return Control("force", few("force", values("force", force, unit="N")))


def _by_depth(
    time: Array,
    depth: Array,
    relaxation: Relaxation,
    series: tuple[ExponentialSeries, ExponentialSeries],
    elastic: ElasticCurve,
) -> tuple[Array, Array]:
    """Force and contact depth; `series` is psi finely and coarsely."""
    fine, at = refined(time, depth)
    pressed = np.maximum(np.interp(fine, time, depth), 0.0)
    if (np.diff(pressed[last_rise(pressed) :]) <= 0).all():
        force, contact = one_cycle(fine, pressed, relaxation, series[0], elastic)
    else:
        # the true depth, also above the surface: a free spring may stand below it
        springs = Springs(elastic, series[1], float(depth.max()))
        _, force, contact = springs.follow(fine, np.interp(fine, time, depth), by_force=False)
    force, contact = force[at], contact[at]
    if depth[0] > 0:
        # a sudden step: the series stands for psi from the first time step on
        force[0] = float(relaxation(np.zeros(1))[0]) * elastic.force(depth[:1])[0]
    return force, contact


def _by_force(
    time: Array,
    force: Array,
    series: tuple[ExponentialSeries, ExponentialSeries],
    elastic: ElasticCurve,
    deepest: float,
) -> tuple[Array, Array, Array]:
    fine, at = refined(time, force)
    loads = np.interp(fine, time, force)
    elastic_force = grown_force(fine, loads, series[0])
    if (np.diff(elastic_force) >= 0).all():
        depth = elastic.depth_of(elastic_force[at], deepest)
        return depth, force, depth
    depth, _, contact = Springs(elastic, series[1], deepest).follow(fine, loads, by_force=True)
    return depth[at], force, contact[at]


def grown_force(time: Array, force: Array, series: ExponentialSeries) -> Array:
    """F_el(d(t)) of a growing contact under a force history: F = int psi(t - t') dF_el(t') step by step, linear in between."""
    z = np.diff(time)[:, None] * series.rates
    decay, gain = np.exp(-z), mean_decay(z)
    total = series.constant + gain @ series.weights
    result = np.empty_like(time)
    result[0] = current = force[0] / series.initial
    memory = current * np.ones(series.rates.size)
    for n in range(time.size - 1):
        memory = memory * decay[n]
        change = (force[n + 1] - series.constant * current - series.weights @ memory) / total[n]
        memory += change * gain[n]
        result[n + 1] = current = current + change
    return result


def refined(time: Array, value: Array) -> tuple[Array, Indices]:
    """Times with the moments of touching and leaving added and the steps after each touch split; indices of the given ones."""
    extra = []
    crossing = np.flatnonzero((value[:-1] <= 0) != (value[1:] <= 0))
    for i in crossing:
        at = time[i] - value[i] * (time[i + 1] - time[i]) / (value[i + 1] - value[i])
        if value[i + 1] > 0:
            extra.append(at + (time[i + 1] - at) * 0.5 ** np.arange(_SPLITS))
        extra.append(np.array([at]))
    if value[0] > 0:
        extra.append(time[0] + (time[1] - time[0]) * 0.5 ** np.arange(_SPLITS))
    fine = np.unique(np.concatenate([time, *extra]))
    return fine, np.asarray(np.searchsorted(fine, time))


def _deepest(
    medium: Any,
    indenter: Indenter,
    force: float,
    series: ExponentialSeries,
    time: Array,
    phi: Array,
    method: Solve,
    options: dict[str, Any],
) -> float:
    """Depth that no creep under at most this force exceeds: the elastic one with the modulus left at the end."""
    left = float(series(np.array([time[-1] - time[0]]))[0])
    control = Control("force", np.array([force / left]))
    return float(method(compliance(medium), indenter, control, phi[:1], **options).depth[0])


def _curve(
    time: Array,
    depth: Array,
    force: Array,
    contact: Array,
    elastic: ElasticCurve,
    relaxation: Relaxation,
    phi: Array,
) -> Curve:
    radius, area, stiffness = elastic.at(contact, RADIUS, AREA, STIFFNESS)
    first = float(relaxation(np.zeros(1))[0])
    notes = elastic.notes
    if not np.isfinite(first):
        notes += ("The stiffness is infinite: this relaxation has no instantaneous modulus.",)
    with np.errstate(invalid="ignore"):
        stiffness = np.where(contact > 0, stiffness * first, 0.0)
    return Curve(
        depth=depth,
        force=force,
        radius=radius,
        area=area,
        stiffness=stiffness,
        contour=elastic.contour(contact, radius, phi.size),
        valid=contact < elastic.sound,
        notes=notes,
        extra={
            "time": (("step",), time, "s", "time"),
            "contact_depth": (("step",), contact, "m", "depth of the elastic contact of the same extent"),
        },
    )
