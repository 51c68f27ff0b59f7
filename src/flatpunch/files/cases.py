"""Case files: TOML with units, checked field by field, turned into a medium, an indenter and the steps to solve."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import Field

from flatpunch._support.checks import ANGLES, Array, BadValue, shown, whole
from flatpunch._support.messages import brief
from flatpunch._support.paths import Plain
from flatpunch._support.readable import readable
from flatpunch._support.reading import Unreadable, as_path, shown_path, text_content
from flatpunch.compliances.tangential import check_held
from flatpunch.contact import METHODS, Method, method_of
from flatpunch.contact.curve import control_from
from flatpunch.contact.default import adhesive_method
from flatpunch.contact.finite_strain.correction import checked as place_in_table
from flatpunch.contact.histories import check_free_layer
from flatpunch.contact.physics import ELASTIC, Physics
from flatpunch.contact.receding import depths_held_down
from flatpunch.contact.result import check_outlines
from flatpunch.contact.slip.steps import check_tip
from flatpunch.contact.viscoelastic import check_each, check_medium
from flatpunch.files.tables.design import DesignCase, DesignTable
from flatpunch.files.tables.fields import CaseError, Count, Length, Pressure, WorkOfAdhesion, validated
from flatpunch.files.tables.indenters import IndenterTable
from flatpunch.files.tables.media import CaseRelaxationTable, MaterialTable, RelaxationTable, SampleTable
from flatpunch.files.tables.steps import ControlTable, HistoryTable, SlipTable
from flatpunch.files.tables.stress import StressCase, StressTable
from flatpunch.files.units import decimal_point
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, underlying

DEEPEST = 30
"""Brackets within brackets, and parts of a dotted key; case files have four."""

_TOKEN = re.compile(
    # a text that is not closed is a token to its end: the parser refuses it, and each of its quotes would begin another search
    r'"""(?:[^"\\]|\\.|"(?!""))*+(?:"{3,5})?'
    r"|'''(?:[^']|'(?!''))*+(?:'{3,5})?"
    r'|"(?:[^"\\\n]|\\.)*+"?'
    r"|'[^'\n]*+'?"
    r"|\#[^\n]*"
    r"|(?P<open>[\[{])|(?P<close>[\]}])|(?P<dot>\.)|(?P<end>[=\n,])",
    re.DOTALL,
)


def check_nesting(text: str) -> None:
    """Refuse text that is nested deeper than any case file, by a ValueError with the line."""
    depth = dots = 0
    for token in _TOKEN.finditer(text):
        kind = token.lastgroup
        depth = depth + 1 if kind == "open" else max(depth - 1, 0) if kind == "close" else depth
        dots = dots + 1 if kind == "dot" else 0 if kind in ("end", "open", "close") else dots
        if depth > DEEPEST or dots > DEEPEST:
            what = "brackets" if depth > DEEPEST else "dots"
            line = text.count("\n", 0, token.start()) + 1
            raise ValueError(f"line {line} is nested deeper than {DEEPEST} levels of {what}. Case files have four.")


@readable
@dataclass(frozen=True)
class Case:
    """What a case file asks for, in SI units.

    Parameters
    ----------
    title : str
        One line for tables and pictures.
    medium : object
        The pressed body.
    indenter : object
        What is pressed into it.
    control : {"depth", "force", "radius"}
        The quantity that is given.
    values : ndarray of shape (steps,)
        Its values [m] or [N].
    method : str, method or None
        Contact method, passed on to `indent`; None leaves the choice to it.
    angles : int
        Number of polar angles of the contour.
    physics : Physics
        Adhesion, relaxation and large strain, as arguments of `indent`.
    time : ndarray of shape (steps,) or None
        Times of a history [s].
    stress : StressCase or None
        Points, friction and strengths for stresses at the last step.
    slip : dict or None
        Friction, and what is prescribed along the surface, as arguments of `partial_slip` at the last step.
    design : DesignCase or None
        What a design varies and what for.
    source : tuple of Path and str, or None
        The case file and its text.

    See Also
    --------
    flatpunch.read_case : Makes it.
    flatpunch.indent : Solves it.

    Examples
    --------
    >>> path = next(path for path in fp.files.shipped_cases() if path.stem == "indenter_on_cartilage")
    >>> case = fp.read_case(path)
    >>> print(case.control, case.values.size)
    depth 60
    """

    title: str
    medium: Any
    indenter: Indenter
    control: str
    values: Array
    method: str | Method | None
    angles: int
    physics: Physics = ELASTIC
    time: Array | None = None
    stress: StressCase | None = None
    slip: Plain | None = None
    design: DesignCase | None = None
    source: tuple[Path, str] | None = field(default=None, repr=False, compare=False)

    @property
    def arguments(self) -> Plain:
        """What `indent` takes by name to solve the case, after medium and indenter."""
        times = {} if self.time is None else {"time": self.time}
        return {self.control: self.values, "method": self.method, "angles": self.angles, **times, **self.physics.given}


LARGEST = 5_000_000
"""Largest case file [bytes]."""


class ContactTable(SampleTable):
    """Bodies, tip, and what is prescribed: what case files of contacts and of fits share."""

    title: str = ""
    angles: Count = 360
    indenter: IndenterTable
    control: ControlTable | None = None
    work_of_adhesion: WorkOfAdhesion | None = None
    range_of_action: Length | None = None
    strength: Pressure | None = None
    history: HistoryTable | None = None
    relaxation: RelaxationTable | None = None
    material: MaterialTable | None = None
    stress: StressTable | None = None
    slip: SlipTable | None = None
    design: DesignTable | None = None
    vary: dict[str, str] = Field(default={})  # read by `sweep`, together with the rest of the file

    @property
    def physics(self) -> Physics:
        """What acts beside elasticity."""
        for name in ("history", "stress", "slip", "design"):
            if self.material is not None and getattr(self, name) is not None:
                raise ValueError(f"[material] finite_strain does not go with {name}; leave one of them out.")
        return Physics(
            self.work_of_adhesion,
            self.range_of_action,
            self.strength,
            None if self.relaxation is None else self.relaxation.built,
            None if self.material is None else self.material.finite_strain,
        )


class CaseTable(ContactTable):
    """The whole file."""

    # wider than in the class it extends: fits take one relaxation, cases one for each body as well
    relaxation: CaseRelaxationTable | None = None

    method: str | None = None

    def build(self, folder: Path) -> Case:
        """Return the case."""
        if self.method is not None and self.method not in METHODS:
            raise BadValue("method", shown(self.method), f"is unknown; it is one of {', '.join(map(repr, METHODS))}.")
        whole("angles", self.angles, 8, "The outline is sampled at that many polar angles.", most=ANGLES)
        medium: Any = self.pressed()
        self._check_what_is_prescribed()
        physics = self.physics
        if medium.free:
            others = {"stress": self.stress, "slip": self.slip, "design": self.design, **physics.given}
            check_free_layer(self.indenter.built, None if self.method is None else method_of(self.method), others)
        if self.slip is not None:
            check_held(underlying(medium))
            check_tip(self.indenter.built)
        if self.history is not None:
            return self._history(medium, physics, self.history)
        control, steps = self._steps()
        check_outlines(self.angles, steps.size)
        method = self.method
        if physics.work_of_adhesion is not None:
            method = adhesive_method(None if method is None else method_of(method), self.indenter.built).name
        stress = None if self.stress is None else self.stress.built
        indenter = self.indenter.built
        if medium.free:
            given = {name: steps if name == control else None for name in ("depth", "force", "radius")}
            depths_held_down(medium, indenter, control_from(**given))
        place_in_table(physics, medium, indenter, control)
        return Case(
            self.title,
            medium,
            indenter,
            control,
            steps,
            method,
            self.angles,
            physics,
            stress=stress,
            slip=None if self.slip is None else self.slip.built,
            design=None if self.design is None else self.design.case(medium, indenter, stress),
        )

    def _steps(self) -> tuple[str, Array]:
        """What is prescribed and its steps: those of [control], else those at which [design] prescribes something."""
        if self.control is not None:
            name, steps = self.control.built
            return name, steps
        assert self.design is not None
        place = self.design.built.control
        return place.name, place.values

    def _check_what_is_prescribed(self) -> None:
        """Control or history, and what goes with either."""
        designed = self.design is not None and self.design.built is not None
        if (self.control is None) == (self.history is None) and not (self.control is None and designed):
            found = "none" if self.control is None else "both"
            raise ValueError(
                "give either a table [control] with one of depth, force and radius, or a table [history] with times; found "
                f"{found}."
            )
        if (self.history is None) != (self.relaxation is None):
            lone = "relaxation" if self.history is None else "history"
            raise ValueError(
                f"[history] and [relaxation] go together: the history of a body that relaxes; found [{lone}] alone."
            )
        if self.history is not None and self.stress is not None:
            raise ValueError("[stress] and [history] do not go together: stresses are those of an elastic contact.")
        if self.slip is not None and (self.history is not None or self.work_of_adhesion is not None):
            lone = "work_of_adhesion" if self.history is None else "[history]"
            raise ValueError(
                f"[slip] and {lone} do not go together: slip is that of elastic contacts without adhesion."
            )
        if self.history is not None and self.design is not None:
            raise ValueError("[design] and [history] do not go together: designs are those of elastic contacts.")

    def _history(self, medium: Body, physics: Physics, table: HistoryTable) -> Case:
        history, indenter, relaxation = table.built, self.indenter.built, physics.relaxation
        if isinstance(relaxation, tuple):
            check_each(medium, indenter, None if self.method is None else method_of(self.method), relaxation)
        else:
            check_medium(medium)
        check_outlines(self.angles, history.time.size)
        if self.method == "bem":
            raise ValueError("method = 'bem' does not go with [history]; choose a fast method or 'refined'.")
        return Case(
            self.title,
            medium,
            indenter,
            history.control,
            history.values,
            self.method,
            self.angles,
            physics,
            time=history.time,
        )


def read_case(path: str | Path) -> Case:
    """Read and check a case file.

    Parameters
    ----------
    path : path
        TOML file. Files it names are looked for in its folder.

    Returns
    -------
    Case
        Medium, indenter and steps in SI units.

    Raises
    ------
    CaseError
        If the file is unreadable or describes no case. All problems found are listed, one a line.

    See Also
    --------
    indent : Solves it.
    sweep : Over ranges of its values.
    files.describe : In words.

    Examples
    --------
    >>> path = next(path for path in fp.files.shipped_cases() if path.stem == "indenter_on_cartilage")
    >>> case = fp.read_case(path)
    >>> print(case.title)
    Sphere on articular cartilage, stiffer with depth, on bone
    """
    path = as_path("path", path)
    text = case_text(path)
    return replace(case_from(parsed(text, path), path), source=(path, text))


_OF_FITS = ("fit", "curve", "curves", "film", "priors", "posterior", "plan", "correct")
"""Tables of case files that are not solved but fitted, or corrected."""


def is_fit_case(path: str | Path) -> bool:
    """Whether a case file looks for something: a value { fit = ... }, or a table such as [fit], [curve] or [correct]."""
    try:
        data = parsed(case_text(path), Path(path))
    except CaseError:
        # the reader reports unreadable files
        return False
    return _belongs_to_fits(data)


def _belongs_to_fits(data: Plain) -> bool:
    return any(name in data for name in _OF_FITS) or _looks_for(data)


def _refuse_fits(data: Plain, path: Path) -> None:
    """Say which command a case file belongs to that is not solved."""
    for name in ("surface", "asperities"):
        if name in data:
            raise CaseError(f"{path} has a table [{name}]: solve it with `flatpunch rough {path}`.")
    if not _belongs_to_fits(data):
        return
    if "correct" in data and not _looks_for(data):
        raise CaseError(
            f"{path} corrects a reported modulus (table [correct]), so there is nothing to solve: use `flatpunch correct {path}`."
        )
    command = "fit-film CURVE" if "film" in data else "fit" if "curves" in data else "fit CURVE"
    raise CaseError(
        f"{path} looks for values, so there is nothing to solve: fit it to a measured curve with `flatpunch {command} {path}`."
    )


def _looks_for(value: object) -> bool:
    if isinstance(value, dict):
        return "fit" in value or any(_looks_for(v) for v in value.values())
    return isinstance(value, list) and any(_looks_for(v) for v in value)


def case_text(path: str | Path) -> str:
    """Return the text of a case file."""
    try:
        return text_content(Path(path), LARGEST)
    except Unreadable as error:
        raise CaseError(f"{shown_path(path)}: {error}. Give the path of a case file in TOML.") from None


def parsed(text: str, path: Path) -> Plain:
    """Return the tables of a case file; `path` is what messages call it."""
    try:
        check_nesting(text)
        return tomllib.loads(text)
    except (ValueError, RecursionError, MemoryError) as error:
        # beside errors of TOML: integers of thousands of digits
        reason = brief(str(error)) or type(error).__name__
        raise CaseError(f"{path}: not valid TOML: {reason}. {_remedy(text, reason)}") from None


def _remedy(text: str, reason: str) -> str:
    """What to write in the place of a line that is no TOML."""
    place = re.search(r"at line (\d+)", reason)
    line = text.splitlines()[int(place[1]) - 1] if place and int(place[1]) <= len(text.splitlines()) else ""
    given = re.fullmatch(
        r"\s*([\w.-]+)\s*=\s*([+-]?[\d.,]+(?:[eE][+-]?\d+)?)\s*([^\d\s#,\]}\"'][^#,\]}\"']*)?(?:#.*)?", line
    )
    if not given:
        return "Texts and quantities stand in quotation marks."
    name, number, unit = given[1], given[2], (given[3] or "").strip()
    point = decimal_point(number) or number
    comma = "; the decimal sign is a point" if point != number else ""
    return f"Write {name} = " + (f'"{point} {unit}", in quotation marks{comma}.' if unit else f"{point}{comma}.")


def case_from(data: Plain, path: Path) -> Case:
    """Check the tables of a case file and return the case; files that they name are looked for beside `path`."""
    _refuse_fits(data, path)
    case: Case = validated(CaseTable, data, path, folder=path.parent, adhesive="work_of_adhesion" in data).built
    return case
