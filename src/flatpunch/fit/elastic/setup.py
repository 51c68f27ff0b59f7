"""From a curve and a model to a least-squares problem: which part of the curve, which points, limits, where to start.

The order matters: the position determines the approach, the scan of contact points the background, and only then is the force
judged (sign, noise, saturation, adhesion), over its background.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flatpunch._support.checks import Array, Flags
from flatpunch._support.prefixes import text
from flatpunch.contact.finite_strain.caps import place_of
from flatpunch.fit.elastic.broken import before_break
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.elastic.plastic import HARD, plastic_cycles
from flatpunch.fit.elastic.problem import Problem
from flatpunch.fit.elastic.retract import FreeOfContact, free_of_contact
from flatpunch.fit.least_squares.scan import Scan
from flatpunch.fit.least_squares.setup import Setup, cut
from flatpunch.fit.least_squares.speed import before_turn, no_drag, shows_drag
from flatpunch.fit.measured.approach import Approach, approach_of
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.drops import breaks
from flatpunch.fit.parameters.settings import Settings

_BOTH_ENDS = (
    "The tip is in contact at both ends of the curve: its depth was taken with its sign turned, and the approach is the "
    "second part."
)

_SOLIDS = 1e-3, 1e13
"""Moduli between which those of all solids lie [Pa], a thousand times below the softest gels and ten times above diamond."""


def elastic_setup(curve: Curve, model: ForwardModel, limits: tuple[Array, Array], settings: Settings) -> Setup:
    """The approach of a curve against a model without adhesion."""
    return _setup(approach_of(curve, settings.direction), model, limits, settings)


def _setup(
    found: Approach, model: ForwardModel, limits: tuple[Array, Array], settings: Settings, *, again: bool = False
) -> Setup:
    """The problem of an approach; once more with what follows it where the tip is in contact at both ends of the curve."""
    part = before_turn(cut(found.signed(found.pressing).part, settings, found.turned, found.pressing), settings)
    # drag that the approach does not show is a constant there, and is left to the baseline
    shown = settings.drag != "free" or shows_drag([part], settings)
    if not shown and found.retract is None:
        raise no_drag(part, settings, ", and there is no retraction")
    problem = Problem(part, model, limits, settings if shown else replace(settings, drag=0.0), found.turned)
    problem = replace(problem, upright=found.pressing)
    problem, scan, broken = before_break(problem)
    return _from_contact(problem, scan, found, settings, broken, shown=shown, again=again)


def known_contact(found: Approach, problem: Problem, scan: Scan) -> Setup | None:
    """The problem of an approach whose best contact is known; None where a drop or the sign of the force comes first."""
    if breaks(problem.part.force) or problem.presses_downwards(scan):
        return None
    return _from_contact(problem, scan, found, problem.settings)


def _from_contact(
    problem: Problem,
    scan: Scan,
    found: Approach,
    settings: Settings,
    broken: tuple[str, ...] = (),
    *,
    shown: bool = True,
    again: bool = False,
) -> Setup:
    """The problem of an approach from its best contact: what is judged over its background."""
    problem, scan = problem.tilted_where_needed(scan)
    part, model, limits = problem.part, problem.model, problem.limits
    _check_moduli(problem, scan)
    signed, notes = found.signed(problem.upright), found.notes
    if problem.upright < 0:
        notes += ("The force falls while the tip presses; it was taken with its sign turned (positive when pressing).",)
    if problem.hardest(scan) >= HARD and plastic_cycles(signed.whole):
        problem.refuse_plastic(scan, signed)
    problem.check_contact(scan)
    if problem.withdraws(scan):
        if found.turns and not again:
            # counted the other way, the tip approaches in the second part
            other = _setup(found.backwards(), model, limits, settings, again=True)
            return replace(other, notes=(_BOTH_ENDS, *other.notes))
        problem.check_as_read()
        raise CurveError(
            f"{part.name}: the force changes where the curve begins and rests where it ends: this is a retract. Give "
            "the approach, or the whole cycle; direction = 'growing' or 'falling' overrides which way the depth goes on the "
            "approach."
        )
    if not shown:
        # where the tip slows down before it turns, drag bends the force: it is judged over the drag that the retraction shows
        free = _without_contact(problem, scan, signed, settings)
        if free is None:
            raise no_drag(part, settings, ", and the retraction has no part without contact to compare with")
        problem = replace(problem, settings=replace(settings, drag=free.drag))
        scan = problem.scan()
    problem, scan, keep, more = problem.judged(scan)
    if problem.whole:
        # what lies before a drop may be elastic, whatever the drop leaves behind
        more += problem.refuse_plastic(scan, signed)
    if settings.drag == "free":
        problem, scan, keep = _with_retract(problem, scan, keep, signed, settings)
    setup = problem.setup(scan, keep, (*notes, *broken, *more))
    if model.finite_strain is None:
        return setup
    return replace(setup, again=lambda x: _in_strain_table(setup, found, problem, settings, x))


def _in_strain_table(setup: Setup, found: Approach, problem: Problem, settings: Settings, x: Array) -> Setup | None:
    """The problem without the readings beyond the table of large strains; None where all are inside."""
    model = problem.model
    parameters, background = setup.objective.split(x)
    place = place_of(*model.case(model.externals(parameters)))
    beyond = setup.objective.depth > background["contact"] + place.deepest
    if not beyond.any():
        return None
    before = setup.part.depth[: np.flatnonzero(setup.used)[np.argmax(beyond)]]
    if not before.size:
        raise CurveError(
            f"{setup.part.name}: begins deeper than {text(place.deepest, 'm')}; {place.end} Leave finite_strain out."
        )
    inside = _setup(found, model, problem.limits, replace(settings, depth_to=found.turned * before.max()))
    note = f"Readings deeper than {text(place.deepest, 'm')} are left out: {place.end}"
    return replace(inside, notes=(*inside.notes, note))


def _without_contact(problem: Problem, scan: Scan, found: Approach, settings: Settings) -> FreeOfContact | None:
    """What the parts of approach and retraction without contact show of the drag; None if they do not."""
    objective, part = problem.objective(), problem.part
    rest = {**objective.split(scan.x)[1], "drag": 0.0}
    before = problem.before(scan, part)
    return free_of_contact(found, part, before, lambda c: objective.background(rest, c.position, None), settings)


def _with_retract(
    problem: Problem, scan: Scan, keep: Flags, found: Approach, settings: Settings
) -> tuple[Problem, Scan, Flags]:
    """The problem with the retraction's points without contact, which distinguish drag from the baseline; else as it is."""
    part = problem.part
    free = _without_contact(problem, scan, found, settings)
    if free is None:
        return problem, scan, keep
    size = part.depth.size
    whole = found.cycle.taken(np.append(np.arange(size), free.points))
    whole = replace(whole, meta=dict(whole.meta))
    longer = replace(problem, part=whole, settings=settings, speed=free.speed)
    kept = np.append(keep, np.ones(free.points.size, dtype=bool))
    rest = problem.objective().split(scan.x)[1]
    if part.spring_constant is not None:
        rest["contact"] += (free.drag - rest["drag"]) * float(np.median(free.speed[:size])) / part.spring_constant
    rest |= {"drag": free.drag, "baseline": free.level}
    target = longer.objective(kept)
    scales = target.scales()
    x = [(rest[name] - scales[name][0]) / scales[name][1] for name in target.nuisance]
    return longer, replace(scan, x=np.append(scan.x[: len(problem.model.free)], x)), kept


def _check_moduli(problem: Problem, scan: Scan) -> None:
    """Refuse a force that no solid under this tip would give, before the descent looks for one."""
    young = [float(np.exp(scan.x[j])) for j in problem.moduli]
    if all(_SOLIDS[0] < each < _SOLIDS[1] for each in young):
        return
    tip = ", ".join(" ".join(line.split()) for line in str(problem.model.indenter).splitlines())
    raise CurveError(
        f"{problem.part.name}: under this tip the curve asks for a modulus of about {young[0]:.2g} Pa, which no solid has. "
        f"Check the size of the tip ({tip}) and the units of depth and force."
    )
