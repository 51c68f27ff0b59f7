"""A family of your own: a medium as in a case file, and which of its values are parameters.

name = "gel-on-pdms"

[[layers]]
young = "1 kPa"
poisson = 0.5
thickness = "1 um"

[base]
kind = "half-space"
young = "1 MPa"
poisson = 0.5

[parameters.gel]
path = "layers.0.young"
min = "0.1 kPa"
max = "100 kPa"
scale = "log"
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from atlas_tables.families import BETA_RANGE, Family
from flatpunch._support.paths import entries, put
from flatpunch.atlas.panel import Parameter
from flatpunch.files import units
from flatpunch.files.cases import case_text, parsed
from flatpunch.files.tables.fields import CaseError, Number, Table, validated
from flatpunch.files.tables.media import SampleTable
from flatpunch.sweeps.axes import dimension_of

_OWN = ("name", "title", "tolerance", "responses", "beta", "parameters")

Value = Annotated[Any, BeforeValidator(lambda value: value)]


class RangeTable(Table):
    """[beta]: punch radius over the length of the medium."""

    min: Number = BETA_RANGE[0]
    max: Number = BETA_RANGE[1]

    def build(self, folder: Path) -> Any:
        """Return the range, which the family checks."""
        return self.min, self.max


class ParameterTable(Table):
    """[parameters.<name>]: which value of the medium it is, and its range, in the units of that value."""

    path: str
    min: Value
    max: Value
    scale: Literal["linear", "log", "upper"] = "linear"
    shift: Number = 1e-3
    meaning: str = ""

    def build(self, folder: Path) -> Any:
        """Return itself: the range is read with the medium."""
        return self


class FamilyTable(SampleTable):
    """The whole file."""

    name: str
    title: str = ""
    tolerance: Number = 1e-9
    responses: bool = False
    beta: RangeTable = Field(default=RangeTable())
    parameters: dict[str, ParameterTable] = Field(default={})

    def build(self, folder: Path) -> Any:
        """Return the medium as written."""
        if not 1e-13 <= self.tolerance <= 1e-3:
            raise ValueError(f"tolerance = {self.tolerance:g} must lie between 1e-13 and 1e-3.")
        if not self.name.replace("-", "").replace("_", "").isalnum():
            raise ValueError(f"name = {self.name!r} becomes a file name: letters, digits, '-' and '_' only.")
        return self.body()


@dataclass(frozen=True)
class FileMedium:
    """Values of the parameters -> medium; can be sent to other processes.

    Parameters
    ----------
    tables : str
        The tables of the medium, as JSON.
    paths : tuple of (name, path, unit)
        Path of each parameter.
    folder : Path
        Where files named in the tables are looked for.
    """

    tables: str
    paths: tuple[tuple[str, str, str], ...]
    folder: Path

    def __call__(self, **values: float) -> Any:
        """Return the medium with these parameters in SI units."""
        data = json.loads(self.tables)
        for name, path, unit in self.paths:
            value = float(values[name])
            put(data, path, f"{value!r} {unit}" if unit else value)
        return validated(FamilyTable, {"name": "family", **data}, "family", folder=self.folder).built


def read_family(path: str | Path) -> tuple[Family, str]:
    """Read and check a family file.

    Parameters
    ----------
    path : path
        TOML file.

    Returns
    -------
    Family, str
        The family, and the text of the file.

    Raises
    ------
    CaseError
        If it describes no family; all problems found, one a line.
    """
    path, text = Path(path), case_text(path)
    return family_from(text, path), text


def family_from(text: str, path: Path) -> Family:
    """Family that a text describes; `path` is what messages call it, and where its files are looked for."""
    data = parsed(text, path)
    table = validated(FamilyTable, data, path, folder=path.parent)
    medium = {key: value for key, value in data.items() if key not in _OWN}
    there = dict(entries(medium))
    try:
        found = [_parameter(name, entry, there) for name, entry in table.parameters.items()]
        make = FileMedium(json.dumps(medium), tuple((p.name, way, p.unit) for p, way in found), path.parent)
        family = Family(
            table.name,
            table.title or table.name,
            tuple(p for p, _ in found),
            make,
            tolerance=table.tolerance,
            responses=table.responses,
            beta=table.beta.built,
        )
        for ends in ([p.low for p in family.parameters], [p.high for p in family.parameters]):
            # both ends of the ranges must be media
            make(**{p.name: value for p, value in zip(family.parameters, ends, strict=True)})
    except (ValueError, TypeError) as error:
        raise CaseError(f"{path}: {error}") from None
    return family


def _parameter(name: str, table: ParameterTable, there: Mapping[str, Any]) -> tuple[Parameter, str]:
    if table.path not in there:
        raise ValueError(
            f"parameters.{name}: path = {table.path!r} is no value of the medium. It has {', '.join(there)}; write a value of "
            "the usual size there, the parameter replaces it."
        )
    current = there[table.path]
    dimension = dimension_of(current)
    if dimension is None and (isinstance(current, (str, bool)) or not isinstance(current, (int, float))):
        raise ValueError(f"parameters.{name}: path = {table.path!r} holds {current!r}, which is no number.")
    low, high = (_number(f"parameters.{name}: {end}", getattr(table, end), dimension) for end in ("min", "max"))
    unit = dimension.unit if dimension else ""
    shift = table.shift if table.scale == "upper" else 0.0
    return Parameter(
        name, table.meaning or f"{table.path} of the medium", low, high, table.scale, shift, unit
    ), table.path


def _number(name: str, value: Any, dimension: units.Dimension | None) -> float:
    if dimension is not None:
        return units.named_si(name, value, dimension)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{name} = {value!r} must be a plain number, as the value of the medium is.")
    return float(value)
