"""Case files of a fit: like those of `solve`, with { fit = "5 kPa", min = ..., max = ... } where a value is looked for.

Two more tables: [fit] says how to fit, [curve] how to read the curve; both may be left out, and so may [control].
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from flatpunch._support.declared import Place
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch.contact.physics import ELASTIC, Physics
from flatpunch.files import CaseError
from flatpunch.files.cases import ContactTable, case_text, parsed
from flatpunch.files.tables.fields import validated
from flatpunch.fits.adhesion.model import adhesive_method
from flatpunch.fits.cases import (
    CorrectTable,
    CurveTable,
    FilmTable,
    FitTable,
    OneCurveTable,
    PlanTable,
    PosteriorTable,
    freed,
    prior_of,
    split,
    value_in_si,
)
from flatpunch.fits.elastic.model import method_for
from flatpunch.fits.fitting import fit_ranges
from flatpunch.fits.half_space.formulas import layer_on_top
from flatpunch.fits.measured.curve import Curve
from flatpunch.fits.measured.files.readers import read_curve
from flatpunch.fits.parameters.sample import BESIDE, CALIBRATION, Sample
from flatpunch.fits.parameters.settings import Free, Settings, check_segment, segments
from flatpunch.fits.parameters.unknowns import check_free
from flatpunch.fits.plan import plan_scan, planned
from flatpunch.fits.report.plans import Plan, PlanScan
from flatpunch.fits.report.posterior import Prior
from flatpunch.fits.report.result import FitResult
from flatpunch.fits.report.table import unit_of
from flatpunch.fits.together import Measured, sample_at
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, HalfSpace
from flatpunch.media.material import young_and_poisson

DRIFTING = "layers[0].young"
"""What `drift` follows over the depth."""


@readable
@dataclass(frozen=True)
class FitCase:
    """What a case file of a fit asks for, SI.

    Parameters
    ----------
    title : str
        One line.
    medium, indenter : object
        Known values, and starting values of the free ones.
    free : mapping of str to Free
        What is fitted.
    settings : Settings
        How.
    reading : mapping
        Keyword arguments of `read_curve`.
    physics : Physics
        Adhesion, relaxation and large strain, as arguments of `fit`.
    film : mapping
        Tip and machine of a nanoindentation test, from [film].
    curves : tuple of mapping
        Curves of a joint fit, from [[curves]]: "path", "indenter", "values" and "reading" of each.
    own : tuple of str
        Free parameters that each of these curves has for itself.
    correct : mapping
        What `correct` takes besides medium and indenter, from [correct]: reported modulus, depth, model.
    priors : mapping of str to Normal, LogNormal or Uniform
        What is known beforehand, from [priors].
    posterior : mapping
        "draws" and "seed", from [posterior].
    plan : mapping
        Arguments of `planned`, from [plan]; empty without one.

    See Also
    --------
    flatpunch.fits.read_fit_case : Makes it.

    Examples
    --------
    >>> from flatpunch.fits import read_fit_case
    >>> path = fp.files.shipped_cases()[0].parent / "fit" / "thin_gel.toml"
    >>> case = read_fit_case(path)
    >>> print(case.title)
    Thin gel under a bead
    """

    title: str
    medium: Body
    indenter: Indenter
    free: Mapping[str, Free]
    settings: Settings
    reading: Plain = field(default_factory=dict)
    physics: Physics = ELASTIC
    film: Plain = field(default_factory=dict)
    curves: tuple[Plain, ...] = ()
    own: tuple[str, ...] = ()
    correct: Plain = field(default_factory=dict)
    priors: Mapping[str, Prior] = field(default_factory=dict)
    posterior: Plain = field(default_factory=dict)
    plan: Plain = field(default_factory=dict)

    @property
    def sample(self) -> Sample:
        """Medium, tip and what goes with them."""
        return Sample(self.medium, self.indenter, self.physics)

    @property
    def samples(self) -> list[Sample]:
        """The sample at the place of each of `curves`; otherwise that of the case."""
        return [sample_at(self.sample, curve["indenter"], curve["values"]) for curve in self.curves] or [self.sample]

    @property
    def arguments(self) -> Plain:
        """What `fit` takes by name, after the curve, medium, indenter and free."""
        return {**self.physics.given, **asdict(self.settings)}


class FitCaseTable(ContactTable):
    """The whole file."""

    method: str = "auto"
    fit: FitTable | None = None
    curve: CurveTable | None = None
    film: FilmTable | None = None
    correct: CorrectTable | None = None
    curves: list[OneCurveTable] = Field(default=[])
    priors: Plain = Field(default={})
    posterior: PosteriorTable | None = None
    plan: PlanTable | None = None

    def build(self, folder: Path) -> FitCase:
        """Return the case, still without free parameters."""
        method: Any = self.method  # a text until it is checked here
        settings = Settings(method=method, **(self.fit.built if self.fit else {}))
        method_for(self.indenter.built, method)
        case = FitCase(
            self.title,
            self.body(),
            self.indenter.built,
            {},
            settings,
            self.curve.built if self.curve else {},
            self.physics,
            self.film.built if self.film else {},
            correct=self.correct.built if self.correct else {},
            posterior=self.posterior.built if self.posterior else {},
            plan=self.plan.built if self.plan else {},
        )
        # whether its parts go together
        sample = case.sample
        if sample.adhesive:
            adhesive_method(sample.indenter, method)
        check_segment(settings.segment, segments(sample.adhesive, sample.relaxing))
        curves = tuple(_with_values(i, curve.built, sample) for i, curve in enumerate(self.curves))
        known = {**sample.numbers, **{name: BESIDE[name] for name in (*settings.nuisance, *CALIBRATION)}}
        for name in self.priors.keys() - known.keys():
            raise ValueError(f"priors: {name} is not part of this case; it has {', '.join(known)}.")
        return replace(case, curves=curves, priors={name: prior_of(known[name], t) for name, t in self.priors.items()})


def read_fit_case(path: str | Path) -> FitCase:
    """Read and check the case file of a fit.

    Parameters
    ----------
    path : path
        TOML file.

    Returns
    -------
    FitCase

    Raises
    ------
    CaseError
        If the file is unreadable or describes no fit; all problems found are listed.

    See Also
    --------
    flatpunch.fit : Takes what it holds.
    flatpunch.read_case : A case to be solved.

    Examples
    --------
    >>> from flatpunch.fits import read_fit_case
    >>> path = fp.files.shipped_cases()[0].parent / "fit" / "thin_gel.toml"
    >>> case = read_fit_case(path)
    >>> print(sorted(case.free))
    ['layers[0].young']
    """
    path = Path(path)
    return fit_case_from(parsed(case_text(path), path), path)


def fit_case_from(data: Plain, path: Path) -> FitCase:
    """Check the tables of a case file of a fit; messages call it `path`, and files that it names are beside it."""
    plain, wanted = split(data)

    def built(data: Plain) -> FitCase:
        found: FitCase = validated(FitCaseTable, data, path, folder=path.parent).built
        return found

    case = built(plain)
    try:
        names = {place: freed(plain, place, each, lambda data: built(data).sample) for place, each in wanted.items()}
        own = tuple(name for place, (name, _) in names.items() if wanted[place].get("each"))
        free = dict(names.values())
        case = replace(case, free={name: free[name] for name in case.sample.numbers if name in free}, own=own)
        check_free(case.sample, case.free)
        _check_curves(case)
        _check_knowledge(case)
    except CaseError:
        raise
    except ValueError as error:
        raise CaseError(f"{path}: {error}") from None
    return case


def _with_values(place: int, curve: Plain, sample: Sample) -> Plain:
    """A curve of a joint fit with its values in SI."""
    for name in curve["values"].keys() - sample.numbers.keys():
        raise ValueError(
            f"curves[{place}].values: {name} is not part of this case; it has {', '.join(sample.numbers)}."
        )
    values = {name: value_in_si(sample.numbers[name], value, name) for name, value in curve["values"].items()}
    return {**curve, "values": values}


def _check_curves(case: FitCase) -> None:
    """Refuse what only a joint fit has a use for, and curves whose parameters the case does not have."""
    if case.own and not case.curves:
        raise ValueError(f"{case.own[0]} has each = true, which goes with two or more tables [[curves]].")
    if len(case.curves) == 1:
        raise ValueError(
            "curves has one entry; two or more are fitted together. Give a single one on the command line."
        )
    for sample in case.samples:
        sample.check(case.free)


def _check_knowledge(case: FitCase) -> None:
    """Refuse priors of what is not there, and plans of what cannot be planned."""
    for name, prior in case.priors.items():
        if name in case.sample.numbers and name not in case.free:
            _check_prior(case.sample.numbers[name], prior)
    if case.plan and (case.sample.relaxing or case.curves or case.film):
        raise ValueError(
            "[plan] is for a single curve of an elastic or adhesive contact; leave it out of fits of relaxation, of several "
            "curves and of films."
        )
    if case.plan and not case.free:
        raise ValueError("[plan] needs something to be fitted: write { fit = ... } in place of a value.")


def check_draws(case: FitCase) -> None:
    """Refuse priors that the posterior of the fit has no use for."""
    if not (case.sample.adhesive or case.sample.relaxing or case.curves):
        return
    # each of several curves has its own contact point and background
    drawn = [name for name in case.free if name not in case.own] + list(() if case.curves else case.settings.nuisance)
    for name in case.priors.keys() - set(drawn):
        raise ValueError(
            f"priors: {name} is not drawn: numbers that are held, and the calibration, are in the posterior of a single curve "
            f"without adhesion and relaxation only; here these are {', '.join(drawn)}. Fit it as well, or leave its prior out."
        )


def _check_prior(number: Place, prior: Prior) -> None:
    """Refuse a prior that excludes what the case holds for known: draws would look for a contact that nobody has described."""
    place, centre = np.array(number.value), np.array(prior.centre)
    missed = 2 * float(prior.logarithm(centre) - prior.logarithm(place))
    # standard deviations: ten are no accident
    if missed > 100:
        unit = unit_of(number)
        raise ValueError(
            f"priors: {number.path} is {text(prior.centre, unit)} ± {text(prior.spread, unit)}, but the case has "
            f"{text(number.value, unit)}. Check the units, or give the case the value of the prior."
        )


def plan_of(case: FitCase) -> Plan | PlanScan:
    """What the planned curve of a case will determine, or those of all its tips and depths."""
    spring = {"spring_constant": case.reading["spring_constant"]} if "spring_constant" in case.reading else {}
    plan = dict(case.plan)
    depth, tips = plan.pop("depth"), plan.pop("indenters", {})
    rest = {
        **spring,
        **plan,
        "priors": {name: prior for name, prior in case.priors.items() if name in (*case.free, *case.settings.nuisance)},
        **replace(case.physics, finite_strain=None).given,
        "contact": case.settings.contact,
        "baseline": case.settings.baseline,
    }
    if not tips and not isinstance(depth, list):
        return planned(case.medium, case.indenter, case.free, depth=depth, **rest)
    depths = depth if isinstance(depth, list) else [depth]
    return plan_scan(case.medium, {"that of the case": case.indenter, **tips}, case.free, depths=depths, **rest)


def read_measured(case: FitCase) -> list[Measured]:
    """Read the curves of a joint fit, CurveError if one cannot be read; curves of the same name get their number."""
    found: list[Measured] = []
    for entry in case.curves:
        reading = {**case.reading, **entry["reading"]}
        curve = read_curve(entry["path"], **reading)
        alike = sum(m.curve.name.partition(" #")[0] == curve.name for m in found)
        curve = replace(curve, name=f"{curve.name} #{alike + 1}") if alike else curve
        found.append(Measured(curve, entry["indenter"], entry["values"]))
    return found


def drift(curve: Curve, case: FitCase) -> tuple[list[FitResult], list[FitResult]]:
    """Fit up to several depths, with the case and with a half-space of the top layer's Poisson ratio, as `fit_ranges` does.

    The modulus is "layers[0].young", which must be free, and "base.young" of the half-space.
    """
    if DRIFTING not in case.free:
        raise ValueError(f"--drift shows {DRIFTING}, which is not fitted in this case.")
    _, top = layer_on_top(case.medium)
    layered = fit_ranges(curve, case.medium, case.indenter, case.free, **case.arguments)
    body = HalfSpace(*young_and_poisson(top))
    return layered, fit_ranges(curve, body, case.indenter, ["base.young"], **case.arguments)
