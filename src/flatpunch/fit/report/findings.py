"""Fitted values in words: units, summary, and what the data do not determine."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.measured.signal import converter_step, noise_of
from flatpunch.fit.report.estimate import interval_text
from flatpunch.fit.report.likelihood import tilt_or_contact
from flatpunch.fit.report.memory import correlated
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
    noted = set()
    for j in range(len(free)):
        for k in range(j):
            # correlation from which two parameters count as hardly distinguished, if their intervals are wide as well
            if abs(table[j, k]) > 0.98 and {names[j], names[k]} & wide:
                noted |= {names[j], names[k]}
                first, second = (interval_text(result.estimates[n], n) for n in (names[k], names[j]))
                notes.append(
                    f"The data hardly distinguish {names[k]} and {names[j]}: correlation {table[j, k]:.4f}, intervals "
                    f"{first} and {second}. Fix one of them, or press deeper."
                )
    for name in free:
        if result.estimates[name].by == "nothing":
            noted.add(name)
            notes.append(
                f"{name} is not determined by the data: within its limits every value fits about as well. The value shown is "
                "one of many."
            )
    for name in sorted(wide - noted):
        interval = interval_text(result.estimates[name], name)
        notes.append(f"{name} is poorly determined: {interval}. The curve hardly depends on it.")
    notes += [
        f"{name} = {quantity(e.value, unit_of(name))} sits on its limit; the other values hold for that limit."
        for name, e in result.estimates.items()
        if e.at_bound
    ]
    notes += correlated(result.memory, result.minimum.residual.size)
    return tuple(notes)


def about_contact(result: FitResult) -> tuple[str, ...]:
    """A note about a contact point that the data do not show."""
    outside = contact_outside(result) or (
        "the data begin at the contact, and no baseline is seen" if without_baseline(result) else ""
    )
    if not outside:
        return ()
    return (f"{outside[0].upper()}{outside[1:]}. Contact point and modulus follow from the bend of the curve alone.",)
