"""What a judgement says to people: where the fitted range ends, what the background does, and why there is no contact."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import TINY
from flatpunch._support.prefixes import text
from flatpunch.fits.judge.fitted import SURE, Fit
from flatpunch.fits.judge.readings import FEWEST, SHARE
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.signal import CLEAR
from flatpunch.fits.parameters.settings import Settings

_CAUSES = {
    (True, -1): "a breakthrough, a slip or a pop-in",
    (True, 1): "a jump or a second contact",
    (False, -1): "a saturated detector, a held or withdrawn load, or yield",
    (False, 1): "a stiffer layer below, a second contact, or a model that is not this body",
}
"""Usual causes of a step or a bend of the force below or above the model."""


def about_range(fit: Fit, part: Curve, last: int, turned: float, settings: Settings) -> list[str]:
    """Where the fitted range ends and why, and what departs within it."""
    notes = []
    if (found := fit.departure) is not None and last < part.depth.size:
        off = found.off / max(fit.most, TINY)
        side = -1 if off < 0 else 1
        notes.append(
            f"From a depth of {text(turned * float(part.depth[last]), 'm')} on ({part.depth.size - last} of {part.depth.size} "
            f"readings) the model does not describe the force, which is {abs(off):.1%} of the fitted force "
            f"{'below' if side < 0 else 'above'} it: usually {_CAUSES[found.step, side]}. What lies before it is fitted; "
            "depth_to = '...' overrides."
        )
    if fit.noise.error:
        notes.append(
            f"The model misses the force by about {fit.noise.error:.0%} of its largest value; the intervals contain this as "
            "noise, not what a wrong model adds."
        )
    if (inside := fit.tested).any():
        far, step, size = fit.departures.largest(inside, fit.force[: fit.end])
        size /= fit.most
        if far > CLEAR and abs(size) > SHARE / 2:
            notes.append(
                f"Within the fitted range the force {'jumps' if step else 'bends away from the model'} by {size:+.1%} of its "
                f"largest value ({far:.0f} standard deviations): usually {_CAUSES[step, -1 if size < 0 else 1]}."
            )
    return notes


def about_background(fit: Fit) -> list[str]:
    """Waves and drift of the force without contact."""
    background = fit.noise.background
    if not background.size:
        return []
    over = background.size / max(fit.most, TINY)
    if background.memory and not background.smooth:
        over *= np.sqrt(min(background.memory / 2, float(fit.record.x[max(fit.touch - 1, 0)])))
    does = "waves" if background.smooth else "drifts" if background.memory else "scatters"
    return [
        f"The force without contact {does} by about {over:.1%} of the rise (interference, "
        "drift, long-range forces). It is fitted as a random process of this size, which widens the intervals."
    ]


def no_contact(part: Curve, fit: Fit | None, settings: Settings) -> CurveError:
    """Refusal of a record in which no contact stands out of the background, or one of too few readings does."""
    if fit is not None and fit.gain >= SURE and fit.inside < FEWEST:
        return CurveError(
            f"{part.name}: {fit.inside} of {part.force.size} readings are in contact and described by this model; a fit needs "
            f"{FEWEST} or more. Press deeper, or record more readings."
        )
    seen = "" if fit is None else f", of which {fit.inside} rise by {text(fit.most * fit.record.range, 'N')}"
    foot = " The force beyond rises by more than this contact explains." if fit is not None and fit.foot else ""
    begun = "The data begin in contact, and no baseline is seen. " if fit is not None and fit.touch <= 2 else ""
    tilted = settings.baseline == "linear" or (settings.baseline == "auto" and begun != "")
    straight = "A force that grows along a straight line is taken for a tilt; choose baseline = 'constant' where there is none. "
    return CurveError(
        f"{part.name}: no contact is to be seen: the background alone (baseline = {settings.baseline!r}) describes the "
        f"{part.force.size} readings{seen}, as well.{foot} {begun}{straight if tilted else ''}Press deeper, average, or check "
        "which column is the force; `flatpunch read FILE --plot PICTURE` draws the curve."
    )
