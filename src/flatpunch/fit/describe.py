"""What a case file of a fit asks for, and how long it takes, in lines for people."""

from __future__ import annotations

from collections.abc import Iterator

from flatpunch.contact.default import EXACT
from flatpunch.files import describe_sample
from flatpunch.files.describe import takes
from flatpunch.fit.adhesion.model import adhesive_method
from flatpunch.fit.case import DRIFTING, FitCase, plan_of
from flatpunch.fit.elastic.model import method_for
from flatpunch.fit.parameters.scaling import scaling
from flatpunch.fit.parameters.unknowns import NUISANCE
from flatpunch.fit.report.quantities import between, quantity, unit_of

_MEMORY = 300e6
"""Memory of the program with the libraries of a fit [bytes]."""


def describe_fit(case: FitCase) -> Iterator[str]:
    """Yield lines that say what a case would fit."""
    settings = case.settings
    yield from describe_sample(
        case.title, case.medium, case.indenter, case.work_of_adhesion, case.range_of_action, case.relaxation
    )
    for i, (name, free) in enumerate(case.free.items()):
        unit = unit_of(name)
        limits = between(free.minimum, free.maximum, unit)
        own = ", for each curve" if name in case.own else ""
        yield f"{'Fitted' if i == 0 else '':<9} {name}, from {quantity(case.sample.value(name), unit)}{limits}{own}"
    if case.correct:
        yield f"Reported  {_reported(case)}"
    elif not case.free:
        yield "Fitted    nothing of the case; write { fit = ... } in place of a value"
    for i, entry in enumerate(case.curves):
        others = [f"{name} = {quantity(value, unit_of(name))}" for name, value in entry["values"].items()]
        tip = [f"{entry['indenter']!r}"] if entry["indenter"] is not None else []
        yield f"{'Curves' if i == 0 else '':<9} {', '.join([entry['path'].name, *tip, *others])}"
    given = settings.contact
    contact = f"free{between(*given, 'm')}" if isinstance(given, tuple) else given
    contact = quantity(contact, "m") if isinstance(contact, float) else contact
    yield f"Curve     contact {contact}, baseline {settings.baseline}, loss {settings.loss}, segment {_segment(case)}"
    method = adhesive_method(case.indenter, settings.method) if case.work_of_adhesion is not None else None
    chosen = method or method_for(case.indenter, settings.method)
    name = chosen if isinstance(chosen, str) else chosen.name
    exact = case.indenter.round and name != "bem"
    series = name in ("second-order", "fourth-order")
    if case.film:
        yield "Method    stiffness of a flat punch of the contact area, for `flatpunch fit-film`"
    else:
        yield f"Method    {EXACT if exact else name}"
    forces = (
        "exact" if exact or case.film else "known to some tenths of a per cent" if series else "as good as the method"
    )
    yield f"Expected  forces of the model {forces}; the result has intervals of its values"
    yield f"Takes     {takes(_MEMORY, _seconds(case))}"
    if case.plan:
        for i, line in enumerate(plan_of(case).summary().splitlines()):
            yield f"{'Planned' if i == 0 else '':<9} {line}"


def _seconds(case: FitCase) -> float:
    """Time of the first curve: tables over the shape of the problem, with six nodes along each of its free numbers."""
    if case.work_of_adhesion is not None or case.relaxation is not None:
        return 1.0
    free = [name for name in case.free if name not in NUISANCE]
    if case.correct and not free:
        free = [DRIFTING]
    shapes = len(scaling(case.medium, case.indenter, free).coordinates)
    return _table_seconds(case) * 6.0**shapes


def _table_seconds(case: FitCase) -> float:
    """Time of one table over five decades of depth, in orders of magnitude; 130 contacts by boundary elements."""
    method = method_for(case.indenter, case.settings.method)
    name = method if isinstance(method, str) else method.name
    if name == "bem":
        return 60.0
    return 0.3 if case.indenter.round else 15.0 if name == "refined" else 3.0


def _reported(case: FitCase) -> str:
    found = case.correct
    model = f", formula {found['model']}" if found["model"] else ""
    return f"{quantity(found['reported'], 'Pa')} at a depth of {quantity(found['depth'], 'm')}{model}, for `flatpunch correct`"


def _segment(case: FitCase) -> str:
    if case.settings.segment != "auto":
        return case.settings.segment
    return "retract" if case.work_of_adhesion is not None else "both" if case.relaxation is not None else "approach"
