"""Tables of a fit's case file: [fit] says how to fit, [curve] how to read, [film] tip and machine of a nanoindentation test."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from pydantic import Field

from flatpunch._support.checks import BadValue, poisson_ratio, positive
from flatpunch._support.paths import Plain
from flatpunch.files import units as si
from flatpunch.files.tables.fields import Count, Force, Length, Number, Pressure, Switch, Table
from flatpunch.files.tables.indenters import IndenterTable
from flatpunch.fit.cases.values import value_in_si
from flatpunch.fit.measured.columns import STIFFNESS
from flatpunch.fit.parameters.settings import Settings

DRAG = si.Dimension("drag", "N s/m", "1 pN s/um", ("N s/m", "pN s/um", "nN s/um"))


def _drag(given: object) -> Literal["free"] | float:
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
    baseline: str = "auto"
    loss: str = "linear"
    adhesion: str = "refuse"
    depth_to: Length | None = None
    force_to: Force | None = None
    level: Number = 0.95
    segment: str = "auto"
    direction: str = "auto"

    def build(self, folder: Path) -> Plain:
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

    def build(self, folder: Path) -> Plain:
        """Return keyword arguments of `read_curve`."""
        found = {name: getattr(self, name) for name in ("columns", "units", "decimal", "sheet", "skip_nan", "flip")}
        if self.index is not None:
            found["index"] = self.index
        spread = {}
        for name in ("spring_constant", "sensitivity"):
            given = getattr(self, name)
            if given is None:
                continue
            in_si = _spring_constant if name == "spring_constant" else _sensitivity
            found[name], std = _with_std(name, given, in_si)
            if std:
                spread[name] = std
        if spread:
            found["calibration"] = spread
        return found


def _with_std(name: str, given: str | Plain, in_si: Callable[[str], float]) -> tuple[float, float]:
    """Value, SI, and its relative standard deviation, which is given as a percentage or in the value's unit."""
    if isinstance(given, str):
        return in_si(given), 0.0
    if not set(given) <= {"value", "std"} or "value" not in given:
        raise ValueError(f'{name} with its uncertainty is written {{ value = "0.05 N/m", std = "10 %" }}.')
    value, std = in_si(given["value"]), given.get("std", "0 %")
    match = re.fullmatch(r"\s*([\d.eE+-]+)\s*%\s*", std)
    try:
        relative = float(match[1]) / 100 if match is not None else in_si(std) / value
    except ValueError:
        relative = math.nan
    if not 0 <= relative < 1:
        raise BadValue(
            f"{name}.std",
            repr(std),
            "must be a percentage such as '10 %', or have the unit of the value and be smaller than it.",
        )
    return value, relative


def _spring_constant(value: str) -> float:
    """Spring constant [N/m]."""
    return si.named_si("spring_constant", value, STIFFNESS)


def _sensitivity(value: str) -> float:
    """Deflection per volt or ampere, SI; a bare length is per volt."""
    for unit, dimension in (("m/V", "sensitivity"), ("m/A", "sensitivity"), ("m", "sensitivity")):
        try:
            return si.to_si(value, si.Dimension(dimension, unit, "70 nm/V", ("nm/V", "um/V", "nm/nA")))
        except ValueError as error:
            reason = error
    raise BadValue(
        "sensitivity",
        repr(value),
        f"must be a length per voltage or current, such as '70 nm/V' or '70 nm/nA' ({reason})",
    )


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
            "reading": {name: reading[name] for name in reading if name in given or name == "calibration"},
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
            "reported_poisson": None if self.poisson is None else poisson_ratio("poisson", self.poisson),
            "over": self.over,
        }


class FilmTable(Table):
    """[film]: tip and machine of a nanoindentation test, for `flatpunch fit-film`."""

    area_coefficients: list[Number] = Field(default=[])
    beta: Number = 1.034
    epsilon: Number = 0.75
    frame: str | None = None
    fit_frame: Switch = False
    depth_min: Length = 0.0
    depth_max: Length | None = None

    def build(self, folder: Path) -> Plain:
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
