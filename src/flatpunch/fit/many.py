"""Rows of a table for curves that are fitted side by side: judged and reported as the fit of one curve, from a known minimum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.paths import Plain
from flatpunch.fit.elastic.many import Found, at_once, plain
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.elastic.problem import Problem
from flatpunch.fit.elastic.setup import known_contact
from flatpunch.fit.fitting import result_of
from flatpunch.fit.least_squares.minimum import Minimum
from flatpunch.fit.least_squares.objective import Objective
from flatpunch.fit.least_squares.scan import Scan
from flatpunch.fit.measured.approach import Approach
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.models import bounds
from flatpunch.fit.parameters.settings import Free, Settings
from flatpunch.fit.report.findings import doubts


def plain_rows(
    curves: Sequence[Curve], model: ForwardModel, free: Mapping[str, Free], settings: Settings
) -> list[Plain | None]:
    """Rows as of `FitResult.row`, of a case that `elastic.many` supports; None for curves that must be fitted one by one."""
    limits, approaches = bounds(model, free), [plain(curve) for curve in curves]
    level = replace(settings, baseline="constant") if settings.baseline == "auto" else settings
    problems = {
        i: Problem(each.part, model, limits, settings, each.turned)
        for i, each in enumerate(approaches)
        if each is not None
    }
    flat = _found(problems, model, level)
    asking = {}
    if settings.baseline == "auto":
        asking = {i: problems[i] for i, each in flat.items() if problems[i].asks(_scan(problems[i].objective(), each))}
    tilted = _found(asking, model, replace(settings, baseline="linear"))
    return [
        _row(curve, approach, problems[i], flat[i], tilted.get(i), free) if approach is not None and i in flat else None
        for i, (curve, approach) in enumerate(zip(curves, approaches, strict=True))
    ]


def _found(problems: Mapping[int, Problem], model: ForwardModel, settings: Settings) -> dict[int, Found]:
    """What is found side by side over one baseline."""
    found = at_once([problem.part for problem in problems.values()], model, settings)
    return {i: each for i, each in zip(problems, found, strict=True) if each is not None}


def _row(
    curve: Curve, approach: Approach, problem: Problem, flat: Found, tilted: Found | None, free: Mapping[str, Free]
) -> Plain | None:
    if tilted is not None:
        linear = replace(problem, settings=replace(problem.settings, baseline="linear"))
        problem = replace(problem, line=_scan(linear.objective(), tilted))
    try:
        setup = known_contact(approach, problem, _scan(problem.objective(), flat))
        found = tilted if setup is not None and setup.settings.baseline != flat.baseline else flat
        if (
            setup is None
            or found is None
            or not isinstance(setup.objective, Objective)
            or setup.part is not problem.part
            or not setup.used.all()
        ):
            return None
        x = _internal(setup.objective, found)
        if not ((setup.lower < x) & (x < setup.upper)).all() or (
            setup.again is not None and setup.again(x) is not None
        ):
            return None
        residual, jacobian = setup.objective.evaluate(x)
        minimum = Minimum(x, residual, jacobian @ jacobian.T, True, np.zeros(x.size, dtype=bool), 1)
        result = result_of(curve, problem.model, free, setup, minimum)
    except CurveError:
        return None
    return None if doubts(result) else result.row()


def _scan(objective: Objective, found: Found) -> Scan:
    """The best contact, as a scan finds it."""
    return Scan(_internal(objective, found), *found.costs, settled=True)


def _internal(objective: Objective, found: Found) -> Array:
    """Modulus, contact and baseline in the unknowns of a problem."""
    scales = objective.scales()
    rest = [(v - scales[n][0]) / scales[n][1] for n, v in zip(objective.nuisance, found.x[1:], strict=True)]
    return np.append(found.x[0], rest)
