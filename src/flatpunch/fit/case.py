"""Case files of a fit: like those of `solve`, with { fit = "5 kPa", min = ..., max = ... } where a value is looked for.

Two more tables: [fit] says how to fit, [curve] how to read the curve; both may be left out, and so may [control].
"""

from __future__ import annotations

import copy
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError

from flatpunch.files import CaseError
from flatpunch.files import units as si
from flatpunch.files.indenter_tables import IndenterTable
from flatpunch.files.media_tables import BaseTable, LayerTable, body
from flatpunch.files.steps import ControlTable
from flatpunch.files.tables import Count, Force, Length, Number, Switch, Table, explain
from flatpunch.fit.columns import STIFFNESS
from flatpunch.fit.scaling import parameter_names
from flatpunch.fit.settings import Free, Settings

_DIMENSIONS = {
    "young": si.PRESSURE,
    "thickness": si.LENGTH,
    "radius": si.LENGTH,
    "inclination": si.ANGLE,
    "half_opening_angle": si.ANGLE,
    "poisson": None,
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
    """

    title: str
    medium: Any
    indenter: Any
    free: Mapping[str, Free]
    settings: Settings
    reading: Mapping[str, Any] = field(default_factory=dict)


class FitTable(Table):
    """[fit]: how to fit."""

    contact: Literal["free"] | Length = "free"
    baseline: str = "constant"
    loss: str = "linear"
    adhesion: str = "refuse"
    depth_to: Length | None = None
    force_to: Force | None = None
    level: Number = 0.95

    def build(self, folder: Path) -> dict[str, Any]:
        """Return fields of `Settings`; the method comes from the top of the file."""
        found = {name: getattr(self, name) for name in type(self).model_fields}
        Settings(**found)
        return found


class CurveTable(Table):
    """[curve]: how to read the curve."""

    columns: dict[str, str | int] = Field(default={})
    units: dict[str, str] = Field(default={})
    decimal: Literal[".", ","] = "."
    sheet: str | None = None
    spring_constant: str | None = None
    sensitivity: str | None = None
    skip_nan: Switch = False
    flip: Switch = False

    def build(self, folder: Path) -> dict[str, Any]:
        """Return keyword arguments of `read_curve`."""
        found = {name: getattr(self, name) for name in ("columns", "units", "decimal", "sheet", "skip_nan", "flip")}
        if self.spring_constant is not None:
            found["spring_constant"] = _quantity("spring_constant", self.spring_constant, STIFFNESS)
        if self.sensitivity is not None:
            per_volt = self.sensitivity.replace("/V", "").strip()
            found["sensitivity"] = _quantity("sensitivity", per_volt, si.LENGTH)
        return found


class FitCaseTable(Table):
    """The whole file."""

    title: str = ""
    method: str = "auto"
    angles: Count = 360
    layers: list[LayerTable] = Field(default=[])
    base: BaseTable
    indenter: IndenterTable
    control: ControlTable | None = None
    fit: FitTable | None = None
    curve: CurveTable | None = None

    def build(self, folder: Path) -> FitCase:
        """Return the case, still without free parameters."""
        settings = Settings(method=self.method, **(self.fit.built if self.fit else {}))
        medium = body(self.layers, self.base, None, None)
        return FitCase(self.title, medium, self.indenter.built, {}, settings, self.curve.built if self.curve else {})


def _quantity(name: str, value: str, dimension: si.Dimension) -> float:
    try:
        return si.to_si(value, dimension)
    except ValueError as error:
        raise ValueError(f"{name} = {value!r} {error}") from None


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
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CaseError(
            f"{path}: not readable ({error.strerror or error}). Give the path of a case file in TOML."
        ) from None
    except UnicodeDecodeError:
        raise CaseError(f"{path}: not a text file. A case file is TOML in UTF-8.") from None
    except tomllib.TOMLDecodeError as error:
        raise CaseError(f"{path}: not valid TOML: {error}. Texts and quantities stand in quotation marks.") from None
    try:
        plain, found = _split(data)
        table = FitCaseTable.model_validate(plain, context={"folder": path.parent})
    except ValidationError as error:
        raise CaseError("\n".join(f"{path}: {line}" for line in explain(error.errors(), plain).splitlines())) from None
    except ValueError as error:
        raise CaseError(f"{path}: {error}") from None
    case: FitCase = table.built
    known = parameter_names(case.medium, case.indenter)
    for name in found:
        if name not in known:
            raise CaseError(f"{path}: {name} cannot be fitted; in this case one can fit {', '.join(known)}.")
    return FitCase(case.title, case.medium, case.indenter, found, case.settings, case.reading)


def _split(data: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Free]]:
    """Separate { fit = ..., min = ..., max = ... } from a file: the file with the starts in their place, and what is free."""
    plain = copy.deepcopy(data)
    found: dict[str, Free] = {}
    places: list[tuple[str, Any]] = [(f"layers[{i}]", table) for i, table in enumerate(_tables(plain.get("layers")))]
    places += [(name, plain.get(name)) for name in ("base", "indenter")]
    for prefix, table in places:
        if not isinstance(table, dict):
            continue
        for name, value in table.items():
            if isinstance(value, dict) and "fit" in value:
                label, free = _free(f"{prefix}.{name}", name, value)
                found[label] = free
                table[name] = value["fit"]
    return plain, found


def _tables(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def _free(path: str, name: str, value: Mapping[str, Any]) -> tuple[str, Free]:
    unknown = set(value) - {"fit", "min", "max"}
    if unknown:
        raise ValueError(
            f"{path}.{min(unknown)} is no known field; a fitted value is written {{ fit = ..., min = ..., max = ... }}."
        )
    if name not in _DIMENSIONS:
        raise ValueError(f"{path} cannot be fitted; one can fit {', '.join(_DIMENSIONS)}.")
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
    try:
        return si.to_si(value, dimension)
    except ValueError as error:
        raise ValueError(f"{path} = {value!r} {error}") from None
