"""Tables of a fit's case file, and { fit = ..., min = ..., max = ..., each = true } in the place of a value that is fitted.

[fit] is how to fit, [curve] and [[curves]] how to read, [film] tip and machine of a nanoindentation test, [correct] a reported
modulus; [priors], [posterior] and [plan] are about what is known beforehand.
"""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from flatpunch._support.checks import BadValue, positive, shown
from flatpunch._support.declared import Place, a_ratio
from flatpunch._support.paths import Plain, put
from flatpunch.files import units as si
from flatpunch.files.tables.fields import Count, Force, Length, Number, Pressure, Switch, Table
from flatpunch.files.tables.indenters import IndenterTable
from flatpunch.fits.films.oliver_pharr import Tip
from flatpunch.fits.measured.columns import STIFFNESS
from flatpunch.fits.parameters.sample import Numbers, Sample
from flatpunch.fits.parameters.settings import Free, Settings
from flatpunch.fits.report.posterior import LogNormal, Normal, Prior, Uniform
from flatpunch.media.material import POISSON

FRAME = si.Dimension("compliance", "m/N", "200 nm/N", ("m/N", "nm/mN"))
DRAG = si.Dimension("drag", "N s/m", "1 pN s/um", ("N s/m", "pN s/um", "nN s/um"))
_SETTINGS = {"fit", "curve", "curves", "film", "correct", "priors", "posterior", "plan"}
"""Tables that say how to fit."""
_NUDGE = 1e-3
"""Relative change of a value of a file that shows which number it is."""


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
        """Return path, indenter, values as in the file, and those keyword arguments of `read_curve` that are given here."""
        reading = CurveTable.build(self, folder)
        given = {name for name in self.model_fields_set if name in reading}
        return {
            "path": folder / self.file,
            "indenter": self.indenter.built if self.indenter else None,
            "values": self.values,
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
    beta: Number = Tip.beta
    epsilon: Number = Tip.epsilon
    frame: str | None = None
    fit_frame: Switch = False
    imprint: Number = 0.0
    fit_imprint: Switch = False
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


_RELATIVE = Place("relative", 0.0, a_ratio("relative standard deviation"), None)


def prior_of(number: Place, table: Any) -> Prior:
    """A prior as it stands in [priors]: { mean, std }, { median, relative } or { min, max } of a parameter."""
    fields, name = set(table) if isinstance(table, Mapping) else set(), number.path

    def value(field: str) -> float:
        return value_in_si(_RELATIVE if field == "relative" else number, table[field], f"priors: {name}.{field}")

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


def split(data: Plain) -> tuple[Plain, dict[str, Plain]]:
    """Separate { fit = ..., min = ..., max = ..., each = true } from a file.

    Returns the file with the starts in their place, and what was there by its place, "layers[0].young".
    """
    plain, found = copy.deepcopy(data), {}

    def walk(thing: Any, way: str) -> None:
        for key, value in list(thing.items() if isinstance(thing, dict) else enumerate(thing)):
            here = f"{way}[{key}]" if isinstance(key, int) else f"{way}.{key}".removeprefix(".")
            if here in _SETTINGS or not isinstance(value, (dict, list)):
                continue
            if isinstance(value, dict) and "fit" in value:
                found[here], thing[key] = value, value["fit"]
            else:
                walk(value, here)

    walk(plain, "")
    return plain, found


def freed(plain: Plain, called: str, wanted: Plain, sample: Callable[[Plain], Sample]) -> tuple[str, Free]:
    """Name and limits of the number that a value of a file is: the one that changes with it; `sample` makes a case of a file."""
    if unknown := set(wanted) - {"fit", "min", "max", "each"}:
        raise ValueError(
            f"{called}.{min(unknown)} is no known field; a fitted value is written {{ fit = ..., min = ..., max = ... }}."
        )
    if not isinstance(wanted.get("each", False), bool):
        raise BadValue(f"{called}.each", repr(wanted["each"]), "must be true or false.")

    def numbers(value: object) -> Numbers:
        changed = copy.deepcopy(plain)
        put(changed, called, value)
        return sample(changed).numbers

    here, rises = numbers(wanted["fit"]), True
    near = Numbers()
    for share in (_NUDGE, -_NUDGE):
        with suppress(ValueError):
            nudged, rises = _nudged(called, wanted["fit"], share)
            near = numbers(nudged)
            break
    moved = [n for n in here.keys() & near.keys() if here[n].value != near[n].value and n not in here.members]
    if len(moved) != 1:
        why = f"it moves {', '.join(sorted(moved))}, which fit(...) fits by their names" if moved else "it is no number"
        raise ValueError(f"{called} cannot be fitted: {why}. One can fit {', '.join(here)}.")
    (name,) = moved
    itself = False
    with suppress(ValueError):
        itself = math.isclose(value_in_si(here[name], wanted["fit"], called), here[name].value)

    def limit(key: str) -> float | None:
        if key not in wanted:
            return None
        given = wanted[key]
        return value_in_si(here[name], given, f"{called}.{key}") if itself else numbers(given)[name].value

    limits = [limit("min"), limit("max")]
    falls = (near[name].value > here[name].value) != rises
    return name, Free(None, *(reversed(limits) if falls else limits))


def _nudged(called: str, given: object, share: float) -> tuple[object, bool]:
    """A value of a file that is larger in size by a share, and whether it is larger."""
    match = re.fullmatch(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)(.*)", str(given))
    if match is None or isinstance(given, bool):
        raise BadValue(
            called, shown(given), "is no number; a fitted value is written { fit = ..., min = ..., max = ... }."
        )
    before = float(match[1])
    value = before * (1 + share) or share
    return (f"{value!r}{match[2]}" if isinstance(given, str) else value), value > before


def value_in_si(number: Place, given: object, called: str) -> float:
    """Value of a number as it stands in a file, SI; messages say `called`."""
    dimension = si.BY_UNIT.get(number.number.unit or "")
    if dimension is not None:
        return si.named_si(called, given, dimension)
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        raise BadValue(called, repr(given), "must be a plain number.")
    return float(given)


def share_of(given: object) -> float | None:
    """A percentage as a share; None for anything else."""
    match = re.fullmatch(r"\s*([\d.eE+-]+)\s*%\s*", given) if isinstance(given, str) else None
    return float(match[1]) / 100 if match else None
