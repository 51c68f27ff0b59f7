"""Sentences about a fit: what the data do not determine, residuals that are no noise, and where the contact theory ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import brentq

from flatpunch._support.checks import ROUNDING, TINY, Array
from flatpunch._support.prefixes import text
from flatpunch.contact.curve import percent
from flatpunch.contact.limits import deepest as base_depth
from flatpunch.fits.measured.calibration import PRINTED
from flatpunch.fits.measured.signal import CLEAR, converter_step, spread_of, white_noise
from flatpunch.fits.report.fitted import Fitted, tilt_or_contact
from flatpunch.fits.report.table import Estimate, label, rows_of, unit_of
from flatpunch.indenters import Paraboloid
from flatpunch.indenters.profile import Indenter

WIDE = 0.1
"""Relative standard error that counts as wide."""

TANGLED = 0.98
"""Correlation above which two parameters count as hardly distinguished, if their intervals are wide as well."""

TIMES = 10.0
"""Residuals so many times the noise of the detector are a fit that missed."""

NOTABLE = 0.01
"""Relative change of the force by the shape of the tip that is worth a note; few curves are calibrated better."""

FEW = 30
"""Readings of which neither noise nor correlation is estimated."""


def doubts(result: Fitted) -> tuple[str, ...]:
    """Reasons not to count a fit as one: a value on a limit, a contact outside the data, residuals far above the noise."""
    numbers = {name: each for name, each in result.problem.numbers.items() if name in (*result.problem.free, "contact")}
    found = [f"{label(each)} sits on its limit" for name, each in numbers.items() if result.estimates[name].at_bound]
    if outside := contact_outside(result):
        found.append(outside)
    free = result.residual[result.used & (result.depth < 0)]
    inside = result.residual[result.used & (result.depth >= 0)]
    if free.size > FEW and inside.size:
        noise = white_noise(free, converter_step(result.curve.force))
        misfit = np.sqrt(np.mean(inside**2))
        if misfit > TIMES * noise > 0 and np.abs(inside).max() > 0.1 * np.ptp(result.curve.force):
            found.append(f"the residuals are {misfit / noise:.0f} times the noise")
    return tuple(found)


def contact_outside(result: Fitted) -> str:
    """Whether the data begin in contact, or end before it.

    Instruments that detect the contact themselves begin at it: a contact point within one reading of the first is inside.
    """
    shown = result.depth[result.used]
    if "contact" not in result.estimates or not shown.size:
        return ""
    if shown.max() <= 0:
        return "the contact point is outside the data: nothing is in contact"
    if tilt_or_contact(result):
        return (
            "the data do not show where the contact began: one that began at the first reading, over a background of "
            "another tilt, describes them as well (baseline = 'constant' if there is no tilt)"
        )
    if shown.min() > _spacing(shown):
        return "the contact point is outside the data: they begin in contact, and no baseline is seen"
    return ""


def about_contact(result: Fitted) -> tuple[str, ...]:
    """A note about a contact point that the data do not show."""
    outside = contact_outside(result)
    if not outside and "contact" in result.estimates and result.depth[result.used].min() >= -_spacing(result.depth):
        outside = "the data begin at the contact, and no baseline is seen"
    if not outside:
        return ()
    return (f"{outside[0].upper()}{outside[1:]}. Contact point and modulus follow from the bend of the curve alone.",)


def _spacing(depth: Array) -> float:
    """Usual distance of neighbouring readings, and a little for its rounding [m]."""
    return (1 + PRINTED) * float(np.median(np.abs(np.diff(depth))))


def combinations(names: Sequence[str], undetermined: Array) -> list[list[str]]:
    """Parameters of each combination that changes nothing."""
    return [[name for name, part in zip(names, row, strict=True) if abs(part) > 1e-3] for row in undetermined]


def judged(result: Fitted) -> tuple[str, ...]:
    """What the numbers do not say by themselves."""
    names, free, notes = result.names, result.problem.free, []
    for together in combinations(names, result.undetermined):
        found = f"only a combination of {' and '.join(together)}: every value along it fits equally well"
        if len(together) == 1:
            found = f"nothing about {together[0]}"
        notes.append(f"The data determine {found}. {_fix(together)}.")
    error, table = (
        np.sqrt(np.diag(result.covariance))[: len(free)],
        np.abs(result.correlation[: len(free), : len(free)]),
    )
    wide = {name for name, e in zip(free, error, strict=True) if np.isfinite(e) and e > WIDE}
    nothing = [name for name in free if result.estimates[name].by == "nothing"]
    alike = [[k for k in range(len(free)) if k == j or table[j, k] > TANGLED] for j in range(len(free))]
    together = [
        name
        for j, name in enumerate(free)
        if name not in nothing and any(len(alike[k]) > 1 and {name, free[k]} & wide for k in alike[j])
    ]
    if len(together) > 1:
        places = [free.index(name) for name in together]
        closest = max(table[j, k] for j in places for k in places if j != k)
        notes.append(
            f"The data hardly distinguish {' and '.join(together)}: correlation {closest:.4f}, intervals "
            f"{_intervals(result, together)}. {_fix(together)}, or press deeper."
        )
    if nothing:
        notes.append(
            f"{' and '.join(nothing)} {'is' if len(nothing) == 1 else 'are'} not determined by the data: within the limits every "
            "value fits about as well. The value shown is one of many."
        )
    if poorly := sorted(wide - {*together, *nothing}):
        hardly = "it" if len(poorly) == 1 else "them"
        notes.append(f"Poorly determined: {_intervals(result, poorly)}. The curve hardly depends on {hardly}.")
    limited = [(result.problem.numbers[name], e) for name, e in result.estimates.items() if e.at_bound]
    notes += [
        f"{each.path} = {text(e.value, unit_of(each))} sits on its limit; the other values hold for that limit."
        for each, e in limited
    ]
    notes += correlated(result.memory, result.minimum.residual.size)
    return (*notes, *(outliers(result.minimum.residual) if result.settings.loss == "linear" else ()))


def _fix(names: Sequence[str]) -> str:
    return f"Fix {'it' if len(names) == 1 else 'one of them' if len(names) == 2 else 'all but one'}"


def _intervals(result: Fitted, names: Sequence[str]) -> str:
    rows = rows_of({name: result.estimates[name] for name in names}, result.problem.numbers)
    return ", ".join(f"{row.name} {row.interval}" for row in rows)


def correlated(memory: float, size: int) -> tuple[str, ...]:
    """A note about residuals that are no independent noise, from the correlation of neighbours among so many."""
    # correlation of neighbouring residuals above which intervals that are wider for it need a word
    if memory <= 0.3 or size <= FEW:
        return ()
    factor = np.sqrt((1 + memory) / (1 - memory))
    return (
        f"Neighbouring residuals are correlated ({memory:.2f}): drift, or a model that does not fit. The intervals are wider for "
        f"it by a factor of {factor:.1f}; what a wrong model adds is not in them.",
    )


def outliers(residual: Array) -> tuple[str, ...]:
    """A note about single readings that are far off and make up most of the sum of squares."""
    off = np.abs(residual - np.median(residual))
    far = off > CLEAR * spread_of(off)
    alone = far & ~(np.convolve(far, [1, 0, 1], "same") > 0)
    share = float(np.sum(off[alone] ** 2)) / max(float(off @ off), TINY)
    if share < 0.5:
        return ()
    return (
        f"Outliers: {int(alone.sum())} single readings, more than {CLEAR:.0f} noise levels off, make up {share:.0%} of the sum "
        "of squares and widen the intervals. Drop them, or fit with loss = 'cauchy', which they hardly disturb.",
    )


def tilt_note(other: str, moved: Mapping[str, tuple[float, Estimate]]) -> tuple[str, ...]:
    """A force without contact that is tilted, where a constant was asked for or would move a modulus out of its interval.

    `moved` has by name the modulus over the `other` baseline [Pa], which was not taken, and its estimate.
    """
    asked = other == "linear"
    out = {name: (value, e) for name, (value, e) in moved.items() if asked or not e.low <= value <= e.high}
    if not out:
        return ()
    would = ", ".join(f"{n} = {text(v, 'Pa')} ({v / e.value - 1:+.1%})" for n, (v, e) in out.items())
    taken = "baseline = 'linear' is taken; " if other == "constant" else ""
    return (f"The force without contact is tilted: {taken}with baseline = '{other}' {would}.",)


def limits_of_theory(result: Fitted) -> tuple[str, ...]:
    """What the contact theory says about its own limits at the fitted values of one curve, and whether its tables hold there.

    Notes that take a cold solution for each curve are for fits that are not quick only.
    """
    model, deepest = result.objective.model, float(result.depth.max())
    medium, tip = result.case
    bottom, (setup,) = base_depth(medium), result.problem.setups
    reached = deepest
    if setup.reached is not None:
        # the fitted range may end before
        reached = max(deepest, setup.reached - result.objective.split(result.minimum.x)[1]["contact"])
    if reached >= bottom:
        return (
            f"The deepest point, {text(reached, 'm')}, is beyond the layers, {text(bottom, 'm')} thick on a rigid base: no tip "
            "gets there. Thickness, contact point or calibration are wrong; the fitted values mean nothing.",
        )
    if deepest <= 0:
        return ()
    if result.settings.quick:
        return about_tables(*model.off_once(deepest, result.values))
    first = model.pull_off(result.minimum.x[: len(model.free)])[0] if model.adhesive else 0.0
    depth = np.linspace(first, deepest, 33)[1:]
    exact = model.exact(depth, result.values)
    notes = [*exact.notes.splitlines(), *about_tables(*model.off(exact, depth, result.values))]
    notes += _as_sphere(tip, deepest)
    if model.adhesive:
        notes += _adhesion(result)
    if model.over_time:
        notes += _relaxation(result)
    return tuple(notes)


def about_tables(off: float, left: float) -> tuple[str, ...]:
    """A note about a table of forces that is off by more than interpolation leaves."""
    if off <= left:
        return ()
    return (
        f"At the fitted values the table of forces is off by {percent(off)} of the force at the deepest reading, more than "
        f"{percent(left)}: values may be off by about as much. Give narrower limits, or fit fewer numbers.",
    )


def _as_sphere(tip: Indenter, depth: float) -> list[str]:
    """Whether a sphere of the radius of a paraboloid needs another force: Sneddon's closed form for half-spaces."""
    if not isinstance(tip, Paraboloid):
        return []
    # notation: s = a/R = tanh(y), depth/R = s y, F/(E* R^2) = (1 + s^2) y - s
    x = depth / tip.radius
    y = brentq(lambda y: y * np.tanh(y) - x, 0.0, 1 + x, xtol=ROUNDING)
    s = np.tanh(y)
    less = 1 - ((1 + s**2) * y - s) / (4 / 3 * x * np.sqrt(x))
    if less < NOTABLE:
        return []
    return [
        f"The tip is a paraboloid: at {text(depth, 'm')}, {x:.2g} of its radius, a sphere of this radius needs {100 * less:.1f} "
        "% less force on a half-space, and the modulus would be higher by about as much. If it is a sphere, write "
        "kind = 'sphere' (Python: Sphere)."
    ]


def _adhesion(result: Fitted) -> list[str]:
    """Whether the tip held on for longer than the theory allows."""
    model, loaded = result.objective.model, np.zeros(result.used.size, dtype=bool)
    loaded[result.objective.part_loaded] = True
    held = result.depth[result.used & loaded]
    limit = model.pull_off(result.minimum.x[: len(model.free)])[0]
    # pull-off of the model this share of the adhesive depth away from that of the data is worth a word
    if not held.size or held.min() >= limit - 0.05 * abs(limit):
        return []
    return [
        f"The tip held on down to {text(float(held.min()), 'm')}; at the fitted values it lets go at {text(limit, 'm')} at "
        "the latest. Something else than JKR adhesion holds it: tethers, a viscous sample, a meniscus."
    ]


def _relaxation(result: Fitted) -> list[str]:
    """Relaxation times that the curve is too short or too coarse for."""
    notes, time = [], result.objective.time
    longest, shortest = float(np.ptp(time)), float(np.median(np.diff(time)))
    for name, estimate in result.estimates.items():
        if not (name.startswith("relaxation.") and result.problem.numbers[name].number.unit == "s"):
            continue
        found = f"{name} = {text(estimate.value, 's')}"
        if estimate.value > longest:
            notes.append(
                f"{found} is longer than the curve ({text(longest, 's')}): the slope of the relaxation is measured, not where "
                "it ends. Hold for longer, or fit a power law."
            )
        elif estimate.value < 2 * shortest:
            notes.append(
                f"{found} is hardly longer than the steps of the curve ({text(shortest, 's')}): faster relaxation cannot be "
                "distinguished from an elastic response."
            )
    return notes
