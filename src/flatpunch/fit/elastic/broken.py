"""The approach before the first drop of its force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flatpunch.fit.elastic.problem import Problem
from flatpunch.fit.least_squares.scan import Scan
from flatpunch.fit.measured.curve import FEWEST, Curve
from flatpunch.fit.measured.drops import Drop, breaks, fall_near
from flatpunch.fit.measured.signal import CLEAR


def before_break(whole: Problem) -> tuple[Problem, Scan, tuple[str, ...]]:
    """The problem and its contact, before the first drop of the force that the readings before it confirm; a note."""
    later = None
    for at in breaks(whole.part.force) if whole.straight and whole.uncut else ():
        if at < FEWEST or np.ptp(whole.part.force[:at]) == 0:
            continue
        problem, scan = replace(whole, part=whole.part.taken(slice(0, at))).pressed()
        # a tilt without a contact is none
        line = problem.linear.scan().without if whole.settings.baseline == "auto" else scan.without
        curve = whole.part if problem.upright == whole.upright else whole.part.turned(force=-1.0)
        over = problem.over(scan, curve)[0]
        # a dip is a contact of the other sign
        if not scan.over(line) > CLEAR**2 or over.max() < -over.min():
            continue
        if (drop := fall_near(over, at)) is not None:
            return _before(problem, drop, curve)
        if later is None and (drop := problem.drop(scan, curve)) is not None and drop.at >= at:
            later = problem, drop, curve
    return (*whole.pressed(), ()) if later is None else _before(*later)


def _before(problem: Problem, drop: Drop, curve: Curve) -> tuple[Problem, Scan, tuple[str, ...]]:
    """The problem and its contact before a drop of a curve, or before an earlier one that the rest shows; a note."""
    problem = replace(problem, part=curve.taken(slice(0, drop.at + 1)), whole=False)
    scan = problem.scan()
    if (earlier := problem.drop(scan, problem.part)) is not None:
        return _before(problem, earlier, curve)
    return problem, scan, (drop.note(curve.depth[drop.at] * problem.turned, True),)
