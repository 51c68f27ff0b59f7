"""Case files of a fit: like those of `solve`, with { fit = "5 kPa", min = ..., max = ... } where a value is looked for.

Two more tables: [fit] says how to fit, [curve] how to read the curve; both may be left out, and so may [control].
"""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from flatpunch.files import CaseError, describe_sample
from flatpunch.files import units as si
from flatpunch.files.cases import case_text, parsed
from flatpunch.files.tables.fields import Count, Force, Length, Number, Switch, Table, WorkOfAdhesion, validated
from flatpunch.files.tables.indenters import IndenterTable
from flatpunch.files.tables.media import BaseTable, BodyTable, LayerTable, body
from flatpunch.files.tables.relaxation import RelaxationTable
from flatpunch.files.tables.steps import ControlTable, HistoryTable
from flatpunch.fit.adhesion.model import adhesive_method
from flatpunch.fit.elastic.model import method_for
from flatpunch.fit.fitting import check_free
from flatpunch.fit.measured.columns import STIFFNESS
from flatpunch.fit.parameters.sample import Sample
from flatpunch.fit.parameters.settings import Free, Settings
from flatpunch.fit.report.quantities import quantity, unit_of

_DIMENSIONS = {
    "young": si.PRESSURE,
    "thickness": si.LENGTH,
    "radius": si.LENGTH,
    "inclination": si.ANGLE,
    "half_opening_angle": si.ANGLE,
    "poisson": None,
    "work_of_adhesion": si.WORK_OF_ADHESION,
    "time": si.TIME,
    "times": si.TIME,
    "equilibrium": None,
    "exponent": None,
    "weights": None,
}


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
    work_of_adhesion, range_of_action : float or None
        [J/m^2], [m].
    relaxation : object or None
        How the medium relaxes.
    film : mapping
        Tip and machine of a nanoindentation test, from [film].
    """

    title: str
    medium: Any
    indenter: Any
    free: Mapping[str, Free]
    settings: Settings
    reading: Mapping[str, Any] = field(default_factory=dict)
    work_of_adhesion: float | None = None
    range_of_action: float | None = None
    relaxation: Any = None
    film: Mapping[str, Any] = field(default_factory=dict)

    @property
    def sample(self) -> Sample:
        """Medium, tip and what goes with them."""
        return Sample(self.medium, self.indenter, self.work_of_adhesion, self.range_of_action, self.relaxation)

    @property
    def arguments(self) -> dict[str, Any]:
        """What `fit` takes by name, after the curve, medium, indenter and free."""
        more = {
            name: value
            for name in ("work_of_adhesion", "range_of_action", "relaxation")
            if (value := getattr(self, name)) is not None
        }
        return {**more, **asdict(self.settings)}


DRAG = si.Dimension("drag", "N s/m", "1 pN s/um", ("N s/m", "pN s/um", "nN s/um"))


def _drag(given: Any) -> Any:
    """0, "free", or a value [N s/m]."""
    if given is None:
        return 0.0
    return "free" if given == "free" or isinstance(given, dict) else si.named_si("drag", given, DRAG)


class ContactLimits(Table):
    """contact = { min = ..., max = ... }: between which tip positions the contact point is looked for."""

    min: Length | None = None
    max: Length | None = None

    def build(self, folder: Path) -> tuple[float | None, float | None]:
        """Return the limits."""
        return (self.min, self.max)


class FitTable(Table):
    """[fit]: how to fit."""

    contact: Literal["free"] | Length | ContactLimits = "free"
    drag: Literal["free"] | str | dict[str, str] | None = None
    baseline: str = "constant"
    loss: str = "linear"
    adhesion: str = "refuse"
    depth_to: Length | None = None
    force_to: Force | None = None
    level: Number = 0.95
    segment: str = "auto"

    def build(self, folder: Path) -> dict[str, Any]:
        """Return fields of `Settings`; the method comes from the top of the file."""
        found = {name: getattr(self, name) for name in type(self).model_fields}
        if isinstance(self.contact, ContactLimits):
            found["contact"] = (self.contact.min, self.contact.max)
        found["drag"] = _drag(self.drag)
        Settings(**found)
        return found


class CurveTable(Table):
    """[curve]: how to read the curve."""

    columns: dict[str, str | int] = Field(default={})
    units: dict[str, str] = Field(default={})
    decimal: Literal[".", ","] = "."
    sheet: str | None = None
    spring_constant: str | dict[str, str] | None = None
    sensitivity: str | dict[str, str] | None = None
    index: Count | None = None
    skip_nan: Switch = False
    flip: Switch = False

    def build(self, folder: Path) -> dict[str, Any]:
        """Return keyword arguments of `read_curve`."""
        found = {name: getattr(self, name) for name in ("columns", "units", "decimal", "sheet", "skip_nan", "flip")}
        if self.index is not None:
            found["index"] = self.index
        spread = {}
        for name in ("spring_constant", "sensitivity"):
            given = getattr(self, name)
            if given is None:
                continue
            value, std = _with_std(name, given)
            found[name] = si.named_si(name, value, STIFFNESS) if name == "spring_constant" else _sensitivity(value)
            if std:
                spread[name] = std
        if spread:
            found["calibration"] = spread
        return found


def _with_std(name: str, given: Any) -> tuple[str, float]:
    """Value as text, and its relative standard deviation."""
    if isinstance(given, str):
        return given, 0.0
    if not set(given) <= {"value", "std"} or "value" not in given:
        raise ValueError(f'{name} with its uncertainty is written {{ value = "0.05 N/m", std = "10 %" }}.')
    match = re.fullmatch(r"\s*([\d.eE+-]+)\s*%\s*", given.get("std", "0 %"))
    if match is None or not 0 <= float(match[1]) < 100:
        raise ValueError(f"{name}.std = {given['std']!r} must be a percentage such as '10 %'.")
    return given["value"], float(match[1]) / 100


def _sensitivity(value: str) -> float:
    """Deflection per volt or ampere, SI; a bare length is per volt."""
    for unit, dimension in (("m/V", "sensitivity"), ("m/A", "sensitivity"), ("m", "sensitivity")):
        try:
            return si.to_si(value, si.Dimension(dimension, unit, "70 nm/V", ("nm/V", "um/V", "nm/nA")))
        except ValueError as error:
            reason = error
    raise ValueError(
        f"sensitivity = {value!r} must be a length per voltage or current, such as '70 nm/V' or '70 nm/nA' ({reason})"
    )


class FilmTable(Table):
    """[film]: tip and machine of a nanoindentation test, for `flatpunch fit-film`."""

    area_coefficients: list[Number] = Field(default=[])
    beta: Number = 1.034
    epsilon: Number = 0.75
    frame: str | None = None
    fit_frame: Switch = False
    depth_min: Length = 0.0
    depth_max: Length | None = None

    def build(self, folder: Path) -> dict[str, Any]:
        """Return what `fit_film` and `Tip` take."""
        frame = (
            si.named_si("frame", self.frame, si.Dimension("compliance", "m/N", "200 nm/N", ("m/N", "nm/mN")))
            if self.frame
            else 0.0
        )
        return {
            "coefficients": list(self.area_coefficients),
            "beta": self.beta,
            "epsilon": self.epsilon,
            "frame": frame,
            "fit_frame": self.fit_frame,
            "depths": (self.depth_min, math.inf if self.depth_max is None else self.depth_max),
        }


class FitCaseTable(Table):
    """The whole file."""

    title: str = ""
    method: str = "auto"
    angles: Count = 360
    layers: list[LayerTable] = Field(default=[])
    base: BaseTable | None = None
    upper: BodyTable | None = None
    lower: BodyTable | None = None
    indenter: IndenterTable
    work_of_adhesion: WorkOfAdhesion | None = None
    range_of_action: Length | None = None
    relaxation: RelaxationTable | None = None
    control: ControlTable | None = None
    history: HistoryTable | None = None
    fit: FitTable | None = None
    curve: CurveTable | None = None
    film: FilmTable | None = None

    def build(self, folder: Path) -> FitCase:
        """Return the case, still without free parameters."""
        method: Any = self.method  # a text until it is checked here
        settings = Settings(method=method, **(self.fit.built if self.fit else {}))
        method_for(self.indenter.built, method)
        case = FitCase(
            self.title,
            body(self.layers, self.base, self.upper, self.lower),
            self.indenter.built,
            {},
            settings,
            self.curve.built if self.curve else {},
            self.work_of_adhesion,
            self.range_of_action,
            self.relaxation.built if self.relaxation else None,
            self.film.built if self.film else {},
        )
        # whether its parts go together
        sample = case.sample
        if sample.work_of_adhesion is not None:
            adhesive_method(sample.indenter, method)
        _check_segment(case)
        return case


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
    """
    path = Path(path)
    data = parsed(case_text(path), path)
    try:
        plain, found = _split(data)
    except ValueError as error:
        raise CaseError(f"{path}: {error}") from None
    case: FitCase = validated(FitCaseTable, plain, path, folder=path.parent).built
    known = case.sample.names
    for name in found:
        if name not in known:
            raise CaseError(f"{path}: {name} cannot be fitted; in this case one can fit {', '.join(known)}.")
    try:
        case = replace(case, free=found)
        check_free(case.sample, found)
    except ValueError as error:
        raise CaseError(f"{path}: {error}") from None
    return case


def _check_segment(case: FitCase) -> None:
    """Refuse segments that the physics has no use for."""
    known = ("auto", "retract", "both") if case.work_of_adhesion is not None else ("auto", "approach")
    known = ("auto", "both") if case.relaxation is not None else known
    if case.settings.segment not in known:
        raise ValueError(
            f"segment = {case.settings.segment!r} does not go with this case; it is {' or '.join(map(repr, known))}."
        )


def is_fit_case(path: str | Path) -> bool:
    """Whether a case file looks for something: a value { fit = ... }, or a table [fit] or [curve]."""
    try:
        data = parsed(case_text(path), Path(path))
    except CaseError:
        # unreadable files are told by whoever reads them
        return False
    return "fit" in data or "curve" in data or _looks_for(data)


def _looks_for(value: Any) -> bool:
    if isinstance(value, dict):
        return "fit" in value or any(_looks_for(v) for v in value.values())
    return isinstance(value, list) and any(_looks_for(v) for v in value)


def describe_fit(case: FitCase) -> Iterator[str]:
    """Yield lines that say what a case would fit."""
    settings = case.settings
    yield from describe_sample(
        case.title, case.medium, case.indenter, case.work_of_adhesion, case.range_of_action, case.relaxation
    )
    for i, (name, free) in enumerate(case.free.items()):
        unit = unit_of(name)
        limits = [quantity(v, unit) if v is not None else "" for v in (free.minimum, free.maximum)]
        between = f", between {limits[0] or 'any'} and {limits[1] or 'any'}" if any(limits) else ""
        yield f"{'Fitted' if i == 0 else '':<9} {name}, from {quantity(case.sample.value(name), unit)}{between}"
    if not case.free:
        yield "Fitted    nothing of the case; write { fit = ... } in place of a value"
    contact = "free" if settings.contact == "free" else quantity(settings.contact, "m")
    yield f"Curve     contact {contact}, baseline {settings.baseline}, loss {settings.loss}, segment {_segment(case)}"
    method = adhesive_method(case.indenter, settings.method) if case.work_of_adhesion is not None else None
    chosen = method or method_for(case.indenter, settings.method)
    yield f"Method    {chosen if isinstance(chosen, str) else chosen.name}"


def _segment(case: FitCase) -> str:
    if case.settings.segment != "auto":
        return case.settings.segment
    return "retract" if case.work_of_adhesion is not None else "both" if case.relaxation is not None else "approach"


def _split(data: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Free]]:
    """Separate { fit = ..., min = ..., max = ... } from a file: the file with the starts in their place, and what is free."""
    plain = copy.deepcopy(data)
    found: dict[str, Free] = {}
    for prefix, table in _places(plain):
        for name, value in table.items():
            for label, where, key, wanted in _wanted(f"{prefix}{name}", table, name, value):
                label, found_free = _free(label, name, wanted)
                found[label] = found_free
                where[key] = wanted["fit"]
    return plain, found


def _wanted(label: str, table: Any, name: Any, value: Any) -> list[tuple[str, Any, Any, Mapping[str, Any]]]:
    """Fitted values in a field: itself, or entries of its list."""
    if isinstance(value, dict) and "fit" in value:
        return [(label, table, name, value)]
    if isinstance(value, list):
        return [(f"{label}[{i}]", value, i, v) for i, v in enumerate(value) if isinstance(v, dict) and "fit" in v]
    return []


def _places(plain: dict[str, Any]) -> list[tuple[str, Any]]:
    """Tables in which something can be fitted, with what their names begin with."""
    places: list[tuple[str, Any]] = []
    for prefix, body_ in (("", plain), ("upper.", plain.get("upper")), ("lower.", plain.get("lower"))):
        if isinstance(body_, dict):
            places += [(f"{prefix}layers[{i}].", table) for i, table in enumerate(_tables(body_.get("layers")))]
            places.append((f"{prefix}base.", body_.get("base")))
    places += [(f"{name}.", plain.get(name)) for name in ("indenter", "relaxation")]
    return [(prefix, table) for prefix, table in [*places, ("", plain)] if isinstance(table, dict)]


def _tables(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def _free(path: str, name: str, value: Mapping[str, Any]) -> tuple[str, Free]:
    unknown = set(value) - {"fit", "min", "max"}
    if unknown:
        raise ValueError(
            f"{path}.{min(unknown)} is no known field; a fitted value is written {{ fit = ..., min = ..., max = ... }}."
        )
    if name not in _DIMENSIONS:
        raise ValueError(f"{path} cannot be fitted; one can fit {', '.join(sorted(_DIMENSIONS))}.")
    limits = [_limit(f"{path}.{key}", name, value.get(key)) for key in ("min", "max")]
    if name == "half_opening_angle":
        limits = [None if v is None else math.pi / 2 - v for v in reversed(limits)]
        path = path.replace("half_opening_angle", "inclination")
    return path, Free(None, *limits)


def _limit(path: str, name: str, value: Any) -> float | None:
    if value is None:
        return None
    dimension = _DIMENSIONS[name]
    if dimension is None:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ValueError(f"{path} = {value!r} must be a plain number.")
        return float(value)
    return si.named_si(path, value, dimension)
