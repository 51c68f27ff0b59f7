"""The search for the minimum of one curve: descents, limits that are widened, weights behind a cantilever."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch.fit.least_squares.minimum import SETTLED, SOON, Minimum, minimise
from flatpunch.fit.least_squares.robust import reweighted
from flatpunch.fit.least_squares.setup import Setup
from flatpunch.fit.measured.curve import CurveError
from flatpunch.fit.measured.signal import memory_of
from flatpunch.fit.models import FAR
from flatpunch.fit.parameters.scaling import plain_limits
from flatpunch.fit.parameters.settings import Free, Settings


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
        note = (
            f"The {len(free)} parameters are poorly determined: the search ended after {found.evaluations} contacts, at "
            "values that describe the curve within its noise. Others do as well; fix a parameter, or press deeper."
        )
        setup = replace(setup, notes=(*setup.notes, note))
    return setup, found


def _along_a_valley(setup: Setup, found: Minimum) -> bool:
    """Whether a search that costs a contact a step ended where only noise is left: neighbouring residuals are independent."""
    if getattr(setup.objective.model, "tabulated", True):
        return False
    left = found.residual
    return bool(memory_of(left) < 2 / np.sqrt(left.size))


def _why_not(setup: Setup, found: Minimum) -> str:
    """Reason of a search that found no minimum, and what to do."""
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
    settled, steps = (SOON if settings.quick else SETTLED), 200
    if not getattr(objective.model, "tabulated", True):
        # each step solves the contact, and valleys that hardly end would cost hundreds: they are reported instead
        settled, steps = 1e-2, 20
    if coarse is None or coarse is objective:
        found = minimise(objective.evaluate, start, setup.lower, setup.upper, settled=settled, steps=steps)
    else:
        found = minimise(coarse.evaluate, start, setup.lower, setup.upper, settled=settled, steps=steps)
        if settings.quick:
            residual, jacobian = objective.evaluate(found.x)
            found = replace(found, residual=residual, normal=jacobian @ jacobian.T)
        else:
            found = minimise(objective.evaluate, found.x, setup.lower, setup.upper, settled=settled, steps=steps)
    if settings.loss != "linear":
        found = reweighted(objective, found, setup.lower, setup.upper, settings.loss)
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
        elif name in free and plain_limits(name) is None:
            if below and free[name].minimum is None:
                lower[j] -= np.log(FAR)
                changed = True
            if not below and free[name].maximum is None:
                upper[j] += np.log(FAR)
                changed = True
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
