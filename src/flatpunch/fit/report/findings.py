"""Fitted values in words: units, summary, and what the data do not determine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.measured.signal import converter_step, noise_of
from flatpunch.fit.report.estimate import Estimate, interval_text
from flatpunch.fit.report.likelihood import tilt_or_contact
from flatpunch.fit.report.memory import correlated, outliers
from flatpunch.fit.report.plan import TANGLED
from flatpunch.fit.report.quantities import label, quantity, unit_of

if TYPE_CHECKING:
    from flatpunch.fit.report.joint import JointResult
    from flatpunch.fit.report.result import FitResult

WIDE = 0.1
"""Relative standard error that counts as wide."""

TIMES = 10.0
"""Residuals so many times the noise of the detector are a fit that missed."""


def doubts(result: FitResult) -> tuple[str, ...]:
    """Reasons not to count a fit as one: a value on a limit, a contact outside the data, residuals far above the noise."""
    found = [
        f"{label(name)} sits on its limit"
        for name, e in result.estimates.items()
        if e.at_bound and (name == "contact" or name in result.objective.model.free)
    ]
    outside = contact_outside(result)
    if outside:
        found.append(outside)
    free = result.residual[result.used & (result.depth < 0)]
    inside = result.residual[result.used & (result.depth >= 0)]
    if free.size > 30 and inside.size:
        noise = noise_of(np.diff(free), converter_step(result.curve.force)) / np.sqrt(2)
        if np.sqrt(np.mean(inside**2)) > TIMES * noise > 0 and np.abs(inside).max() > 0.1 * np.ptp(result.curve.force):
            found.append(f"the residuals are {np.sqrt(np.mean(inside**2)) / noise:.0f} times the noise")
    return tuple(found)


def contact_outside(result: FitResult) -> str:
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


def _spacing(depth: Array) -> float:
    """Usual distance of neighbouring readings, and a little for its rounding [m]."""
    return 1.01 * float(np.median(np.abs(np.diff(depth))))


def without_baseline(result: FitResult) -> bool:
    """Whether no reading was taken before the contact."""
    return "contact" in result.estimates and bool(result.depth[result.used].min() >= -_spacing(result.depth))


def judged(result: FitResult | JointResult) -> tuple[str, ...]:
    """Sentences about what the numbers do not say by themselves."""
    names, free = result.names, result.objective.model.free
    notes = []
    for row in result.undetermined:
        tangled = [names[i] for i in np.flatnonzero(np.abs(row) > 1e-3)]
        notes.append(
            f"The data determine only a combination of {' and '.join(tangled)}: every value along it fits equally well. Fix "
            f"{'one of them' if len(tangled) == 2 else 'all but one'}."
            if len(tangled) > 1
            else f"The data say nothing about {tangled[0]}. Fix it."
        )
    error = np.sqrt(np.diag(result.covariance))
    table = result.correlation
    wide = {name for name, e in zip(names, error, strict=True) if name in free and np.isfinite(e) and e > WIDE}
    alike = [[k for k in range(len(free)) if k == j or abs(table[j, k]) > TANGLED] for j in range(len(free))]
    tangled = [
        names[j] for j in range(len(free)) if any(len(alike[k]) > 1 and {names[j], names[k]} & wide for k in alike[j])
    ]
    nothing = [name for name in free if result.estimates[name].by == "nothing"]
    together = [name for name in tangled if name not in nothing]
    if len(together) > 1:
        closest = max(abs(table[names.index(a), names.index(b)]) for a in together for b in together if a != b)
        found = ", ".join(f"{name} {interval_text(result.estimates[name], name)}" for name in together)
        notes.append(
            f"The data hardly distinguish {' and '.join(together)}: correlation {closest:.4f}, intervals {found}. Fix "
            f"{'one of them' if len(together) == 2 else 'all but one'}, or press deeper."
        )
    if nothing:
        notes.append(
            f"{' and '.join(nothing)} {'is' if len(nothing) == 1 else 'are'} not determined by the data: within the limits every "
            "value fits about as well. The value shown is one of many."
        )
    poorly = sorted(wide - {*together, *nothing})
    if poorly:
        found = ", ".join(f"{name} {interval_text(result.estimates[name], name)}" for name in poorly)
        hardly = "it" if len(poorly) == 1 else "them"
        notes.append(f"Poorly determined: {found}. The curve hardly depends on {hardly}.")
    notes += [
        f"{name} = {quantity(e.value, unit_of(name))} sits on its limit; the other values hold for that limit."
        for name, e in result.estimates.items()
        if e.at_bound
    ]
    notes += correlated(result.memory, result.minimum.residual.size)
    if result.settings.loss == "linear":
        notes += outliers(result.minimum.residual)
    return tuple(notes)


def about_contact(result: FitResult) -> tuple[str, ...]:
    """A note about a contact point that the data do not show."""
    outside = contact_outside(result) or (
        "the data begin at the contact, and no baseline is seen" if without_baseline(result) else ""
    )
    if not outside:
        return ()
    return (f"{outside[0].upper()}{outside[1:]}. Contact point and modulus follow from the bend of the curve alone.",)


def tilt_note(other: str, moved: Mapping[str, tuple[float, Estimate]]) -> tuple[str, ...]:
    """A force without contact that is tilted, where a constant was asked for or would move a modulus out of its interval.

    `moved` has by name the modulus over the `other` baseline [Pa], which was not taken, and its estimate.
    """
    asked = other == "linear"
    out = {name: (value, e) for name, (value, e) in moved.items() if asked or not e.low <= value <= e.high}
    if not out:
        return ()
    would = ", ".join(f"{n} = {quantity(v, 'Pa')} ({v / e.value - 1:+.1%})" for n, (v, e) in out.items())
    taken = "baseline = 'linear' is taken; " if other == "constant" else ""
    return (f"The force without contact is tilted: {taken}with baseline = '{other}' {would}.",)
