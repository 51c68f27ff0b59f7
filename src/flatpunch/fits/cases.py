"""Tables of a fit's case file, and { fit = ..., min = ..., max = ..., each = true } in the place of a value that is fitted.

[fit] is how to fit, [curve] and [[curves]] how to read, [film] tip and machine of a nanoindentation test, [correct] a reported
modulus; [priors], [posterior] and [plan] are about what is known beforehand.
"""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from flatpunch._support.checks import BadValue, positive, shown
from flatpunch._support.paths import Plain
from flatpunch.files import units as si
from flatpunch.files.tables.fields import Count, Force, Length, Number, Pressure, Switch, Table
from flatpunch.files.tables.indenters import IndenterTable
from flatpunch.fits.measured.columns import STIFFNESS
from flatpunch.fits.parameters.priors import LogNormal, Normal, Prior, Uniform
from flatpunch.fits.parameters.settings import Free, Settings
from flatpunch.fits.report.quantities import unit_of
from flatpunch.media.material import POISSON

FRAME = si.Dimension("compliance", "m/N", "200 nm/N", ("m/N", "nm/mN"))
DRAG = si.Dimension("drag", "N s/m", "1 pN s/um", ("N s/m", "pN s/um", "nN s/um"))
_ANGLES = ("inclination", "half_opening_angle")
PARAMETERS = {
    "young",
    "thickness",
    "radius",
    *_ANGLES,
    "poisson",
    "work_of_adhesion",
    "interface_normal",
    "interface_shear",
}
PARAMETERS |= {"time", "times", "equilibrium", "exponent", "weights"}
"""Words of a case file for what can be fitted."""
BESIDE = {"contact", "baseline", "tilt", "spring_constant", "sensitivity", "relative"}
"""Numbers that a fit or a prior has beside the parameters."""


class ContactLimits(Table):
    """contact = { min = ..., max = ... }: between which tip positions the contact point is looked for."""

    min: Length | None = None
    max: Length | None = None

    def build(self, folder: Path) -> tuple[float | None, float | None]:
        """Return the limits."""
        return (self.min, self.max)


class FitTable(Table):
    """[fit]: how to fit."""

    describes = dict

    contact: Literal["free"] | Length | ContactLimits = "free"
    drag: Literal["free"] | str | dict[str, str] | None = None
    baseline: str = "auto"
    loss: str = "linear"
    adhesion: str = "refuse"
    depth_to: Length | None = None
    force_to: Force | None = None
    level: Number = Settings().level
    segment: str = "auto"
    direction: str = "auto"

    def build(self, folder: Path) -> Plain:
        """Return fields of `Settings`; the method comes from the top of the file."""
        found: Plain = self.described()
        if isinstance(self.contact, ContactLimits):
            found["contact"] = (self.contact.min, self.contact.max)
        free = self.drag == "free" or isinstance(self.drag, dict)
        found["drag"] = "free" if free else si.named_si("drag", self.drag, DRAG) if self.drag is not None else 0.0
        Settings(**found)
        return found


class CurveTable(Table):
    """[curve]: how to read the curve."""

    describes = dict

    columns: dict[str, str | int] = Field(default={})
    units: dict[str, str] = Field(default={})
    decimal: Literal[".", ","] = "."
    sheet: str | None = None
    spring_constant: str | dict[str, str] | None = None
    sensitivity: str | dict[str, str] | None = None
    index: Count | None = None
    skip_nan: Switch = False
    flip: Switch = False

    def build(self, folder: Path) -> Plain:
        """Return keyword arguments of `read_curve`."""
        found: Plain = self.described(but=("index", *_WITH_STD))
        found |= {} if self.index is None else {"index": self.index}
        spread = {}
        for name, in_si in _WITH_STD.items():
            if (given := getattr(self, name)) is not None:
                found[name], spread[name] = _with_std(name, given, in_si)
        spread = {name: std for name, std in spread.items() if std}
        return found | ({"calibration": spread} if spread else {})


def _with_std(name: str, given: str | Plain, in_si: Callable[[str], float]) -> tuple[float, float]:
    """Value, SI, and its relative standard deviation, which is given as a percentage or in the value's unit."""
    if isinstance(given, str):
        return in_si(given), 0.0
    if not set(given) <= {"value", "std"} or "value" not in given:
        raise ValueError(f'{name} with its uncertainty is written {{ value = "0.05 N/m", std = "10 %" }}.')
    value, std = in_si(given["value"]), given.get("std", "0 %")
    try:
        relative = in_si(std) / value if (share := share_of(std)) is None else share
    except ValueError:
        relative = math.nan
    if not 0 <= relative < 1:
        raise BadValue(
            f"{name}.std",
            repr(std),
            "must be a percentage such as '10 %', or have the unit of the value and be smaller than it.",
        )
    return value, relative


def _sensitivity(value: str) -> float:
    """Deflection per volt or ampere, SI; a bare length is per volt."""
    for unit in ("m/V", "m/A", "m"):
        try:
            return si.to_si(value, si.Dimension("sensitivity", unit, "70 nm/V", ("nm/V", "um/V", "nm/nA")))
        except ValueError as error:
            reason = error
    raise BadValue(
        "sensitivity",
        repr(value),
        f"must be a length per voltage or current, such as '70 nm/V' or '70 nm/nA' ({reason})",
    )


_WITH_STD: dict[str, Callable[[str], float]] = {
    "spring_constant": lambda value: si.named_si("spring_constant", value, STIFFNESS),
    "sensitivity": _sensitivity,
}
"""Fields of [curve] that may have a standard deviation, and how they are read."""


class OneCurveTable(CurveTable):
    """[[curves]]: one curve of a joint fit, and how its measurement differs from the others."""

    file: str
    indenter: IndenterTable | None = None
    values: Plain = Field(default={})

    def build(self, folder: Path) -> Plain:
        """Return path, indenter, values [SI], and those keyword arguments of `read_curve` that are given here."""
        reading = CurveTable.build(self, folder)
        given = {name for name in self.model_fields_set if name in reading}
        return {
            "path": folder / self.file,
            "indenter": self.indenter.built if self.indenter else None,
            "values": {name: value_in_si(name, value) for name, value in self.values.items()},
            "reading": {
                name: reading[name]
                for name in reading
                if name in given & set(CurveTable.model_fields) or name == "calibration"
            },
        }


class CorrectTable(Table):
    """[correct]: the half-space modulus that a program reported, for `flatpunch correct`."""

    reported: Pressure
    depth: Length
    model: Literal["hertz", "sneddon", "flat", "bilodeau", "rico", "oliver-pharr"] | None = None
    poisson: Number | None = None
    over: Literal["curve", "depth"] = "curve"

    def build(self, folder: Path) -> Plain:
        """Return keyword arguments of `correct`."""
        return {
            "reported": positive("reported", self.reported, unit="Pa"),
            "depth": positive("depth", self.depth, unit="m"),
            "model": self.model,
            "reported_poisson": None if self.poisson is None else POISSON.checked("poisson", self.poisson),
            "over": self.over,
        }


class FilmTable(Table):
    """[film]: tip and machine of a nanoindentation test, for `flatpunch fit-film`."""

    describes = dict

    area_coefficients: list[Number] = Field(default=[])
    beta: Number = 1.034
    epsilon: Number = 0.75
    frame: str | None = None
    fit_frame: Switch = False
    depth_min: Length = 0.0
    depth_max: Length | None = None

    def build(self, folder: Path) -> Plain:
        """Return what `fit_film` and `Tip` take."""
        found: Plain = self.described(but=("depth_min", "depth_max"))
        found["frame"] = si.named_si("frame", self.frame, FRAME) if self.frame else 0.0
        return found | {"depths": (self.depth_min, math.inf if self.depth_max is None else self.depth_max)}


class PosteriorTable(Table):
    """[posterior]: how many draws, and the seed of the random numbers."""

    describes = dict
    draws: Count = 10_000
    seed: Count = 0


class PlanTable(Table):
    """[plan]: the curve that will be measured, for `flatpunch check`; several depths and tips make a table."""

    describes = dict
    depth: Length | list[Length]
    indenters: dict[str, IndenterTable] = Field(default={})
    noise: Force
    points: Count = 1000
    before: Length | None = None
    spring_constant: str | None = None

    def build(self, folder: Path) -> Plain:
        """Return arguments of `planned`."""
        found: Plain = self.described(but=("indenters", "spring_constant"))
        if self.indenters:
            found["indenters"] = {name: table.built for name, table in self.indenters.items()}
        if self.spring_constant is not None:
            found["spring_constant"] = _WITH_STD["spring_constant"](self.spring_constant)
        return found


def prior_of(name: str, table: Any) -> Prior:
    """A prior as it stands in [priors]: { mean, std }, { median, relative } or { min, max } of a parameter."""
    fields = set(table) if isinstance(table, Mapping) else set()

    def value(field: str) -> float:
        return value_in_si("relative" if field == "relative" else name, table[field], f"priors: {name}.{field}")

    if fields == {"mean", "std"}:
        mean, share = value("mean"), share_of(table["std"])
        return Normal(mean, value("std") if share is None else share * abs(mean))
    if fields == {"median", "relative"}:
        return LogNormal(value("median"), value("relative"))
    if fields == {"min", "max"}:
        return Uniform(value("min"), value("max"))
    raise ValueError(
        f'priors: {name} = {shown(table)} must be {{ mean = "1 um", std = "50 nm" }} (or std = "5 %"), '
        '{ median = "1 um", relative = 0.05 } or { min = ..., max = ... }.'
    )


def split(data: Plain) -> tuple[Plain, dict[str, Free], tuple[str, ...]]:
    """Separate { fit = ..., min = ..., max = ..., each = true } from a file.

    Returns the file with the starts in their place, the free parameters, and which of them each curve of a joint fit has for
    itself.
    """
    plain = copy.deepcopy(data)
    found: dict[str, Free] = {}
    own: list[str] = []
    for prefix, table in _places(plain):
        for name, value in table.items():
            places: list[tuple[str, Any, str | int, Any]]
            if isinstance(value, list):
                places = [(f"{prefix}{name}[{i}]", value, i, entry) for i, entry in enumerate(value)]
            else:
                places = [(f"{prefix}{name}", table, name, value)]
            for label, where, key, wanted in places:
                if isinstance(wanted, dict) and "fit" in wanted:
                    path, found_free = _free(label, name, wanted)
                    found[path], where[key] = found_free, wanted["fit"]
                    own += [path] if wanted.get("each") else []
    return plain, found, tuple(own)


def value_in_si(name: str, given: object, called: str = "") -> float:
    """Value of a parameter, or of a number that a fit has beside them, as it stands in a file, SI; messages say `called`."""
    word = _word(name)
    if word not in PARAMETERS and not (called and word in BESIDE):
        raise BadValue(name, "", f"is no parameter; parameters end in {', '.join(sorted(PARAMETERS))}.")
    dimension = si.BY_UNIT.get(
        "rad" if word in _ANGLES else "" if word == "relative" else unit_of(word.replace("interface_", ""))
    )
    if dimension is not None:
        return si.named_si(called or name, given, dimension)
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        raise BadValue(called or name, repr(given), "must be a plain number.")
    return float(given)


def _word(name: str) -> str:
    """The word of a case file for a parameter: interface_normal for layers[0].bonded.normal."""
    return name.replace("bonded.", "interface_").split(".")[-1].split("[")[0]


def share_of(given: object) -> float | None:
    """A percentage as a share; None for anything else."""
    match = re.fullmatch(r"\s*([\d.eE+-]+)\s*%\s*", given) if isinstance(given, str) else None
    return float(match[1]) / 100 if match else None


def _places(plain: Plain) -> Iterator[tuple[str, Plain]]:
    """Tables in which something can be fitted, with what their names begin with."""
    for prefix, body in (("", plain), ("upper.", plain.get("upper")), ("lower.", plain.get("lower"))):
        if isinstance(body, dict):
            layers = body.get("layers")
            tables = [(f"layers[{i}].", table) for i, table in enumerate(layers if isinstance(layers, list) else [])]
            tables.append(("base.", body.get("base")))
            yield from ((prefix + name, table) for name, table in tables if isinstance(table, dict))
    more = (("indenter.", plain.get("indenter")), ("relaxation.", plain.get("relaxation")), ("", plain))
    yield from ((prefix, table) for prefix, table in more if isinstance(table, dict))


def _free(path: str, name: str, value: Plain) -> tuple[str, Free]:
    """Name and limits of a fitted value."""
    if unknown := set(value) - {"fit", "min", "max", "each"}:
        raise ValueError(
            f"{path}.{min(unknown)} is no known field; a fitted value is written {{ fit = ..., min = ..., max = ... }}."
        )
    if name not in PARAMETERS:
        raise ValueError(f"{path} cannot be fitted; one can fit {', '.join(sorted(PARAMETERS))}.")
    if not isinstance(value.get("each", False), bool):
        raise BadValue(f"{path}.each", repr(value["each"]), "must be true or false.")
    limits = [value_in_si(name, value[key], f"{path}.{key}") if key in value else None for key in ("min", "max")]
    if name == "half_opening_angle":
        limits = [None if v is None else math.pi / 2 - v for v in reversed(limits)]
        path = path.replace("half_opening_angle", "inclination")
    return path.replace("interface_", "bonded."), Free(None, *limits)
