"""What a case file of a fit asks for, in lines for people, and how long it takes."""

from __future__ import annotations

from collections.abc import Iterator

from flatpunch._support.prefixes import text
from flatpunch.contact.default import EXACT, method_of
from flatpunch.files import describe_sample
from flatpunch.files.descriptions import takes
from flatpunch.fits.adhesion.model import AdhesiveModel, adhesive_method
from flatpunch.fits.adhesion.tables import BranchFamily, flat_end
from flatpunch.fits.case import DRIFTING, FitCase, plan_of
from flatpunch.fits.elastic.model import method_for
from flatpunch.fits.elastic.table import KNOTS
from flatpunch.fits.parameters.sample import NUISANCE
from flatpunch.fits.parameters.scaling import scaling
from flatpunch.fits.parameters.settings import segments
from flatpunch.fits.report.table import between, unit_of

_MEMORY = 300e6
"""Memory of the program with the libraries of a fit [bytes]."""


def describe_fit(case: FitCase) -> Iterator[str]:
    """Yield lines that say what a case would fit."""
    settings = case.settings
    yield from describe_sample(case.title, case.medium, case.indenter, case.physics)
    for i, (name, free) in enumerate(case.free.items()):
        unit = unit_of(case.sample.numbers[name])
        limits = between(free.minimum, free.maximum, unit)
        own = ", for each curve" if name in case.own else ""
        yield f"{'Fitted' if i == 0 else '':<9} {name}, from {text(case.sample.value(name), unit)}{limits}{own}"
    if case.correct:
        yield f"Reported  {_reported(case)}"
    elif not case.free:
        yield "Fitted    nothing of the case; write { fit = ... } in place of a value"
    for i, entry in enumerate(case.curves):
        others = [f"{n} = {text(value, unit_of(case.sample.numbers[n]))}" for n, value in entry["values"].items()]
        tip = [f"{entry['indenter']!r}"] if entry["indenter"] is not None else []
        yield f"{'Curves' if i == 0 else '':<9} {', '.join([entry['path'].name, *tip, *others])}"
    given = settings.contact
    contact = f"free{between(*given, 'm')}" if isinstance(given, tuple) else given
    contact = text(contact, "m") if isinstance(contact, float) else contact
    default = segments(case.sample.adhesive, case.sample.relaxing)[0]
    segment = default if settings.segment == "auto" else settings.segment
    yield f"Curve     contact {contact}, baseline {settings.baseline}, loss {settings.loss}, segment {segment}"
    method = adhesive_method(case.indenter, settings.method) if case.sample.adhesive else None
    chosen = method or method_for(case.indenter, settings.method)
    name = method_of(chosen).name
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
    yield f"Takes     {takes(_MEMORY, seconds_of(case))}"
    if case.plan:
        for i, line in enumerate(plan_of(case).summary().splitlines()):
            yield f"{'Planned' if i == 0 else '':<9} {line}"


def seconds_of(case: FitCase) -> float:
    """Time of the first curves: tables over the shape of the problem, with six nodes along each of its free numbers."""
    if case.sample.relaxing:
        return 1.0
    free = [name for name in case.free if name not in NUISANCE]
    if case.sample.adhesive:
        # curves of one family share its tables
        families = {AdhesiveModel(sample, tuple(free)).family for sample in case.samples}
        return sum(_adhesive_table(family) * float(KNOTS) ** len(family.coordinates) for family in families)
    if case.correct and not free:
        free = [DRIFTING]
    shapes = len(scaling(case.medium, case.indenter, free).coordinates)
    method = method_for(case.indenter, case.settings.method)
    name = method_of(method).name
    # a table over five decades of depth, in orders of magnitude; 130 contacts by boundary elements
    table = 60.0 if name == "bem" else 0.3 if case.indenter.round else 15.0 if name == "refined" else 3.0
    return table * float(KNOTS) ** shapes


def _adhesive_table(family: BranchFamily) -> float:
    """Time of a table [s]: with a range of action contacts are searched over c, those over a flat end at each step of the fit."""
    if not family.by_range:
        return 0.3
    return 10.0 if flat_end(family.indenter) else 2.0


def _reported(case: FitCase) -> str:
    found = case.correct
    model = f", formula {found['model']}" if found["model"] else ""
    return f"{text(found['reported'], 'Pa')} at a depth of {text(found['depth'], 'm')}{model}, for `flatpunch correct`"
