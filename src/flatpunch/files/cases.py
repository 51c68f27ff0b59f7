"""Case files: TOML with units, checked field by field, turned into a medium, an indenter and the steps to solve."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationError

from flatpunch._validation import Array, positive, values
from flatpunch.contact import METHODS, default_method
from flatpunch.files.indenter_tables import IndenterTable
from flatpunch.files.media_tables import BaseTable, BodyTable, LayerTable, body
from flatpunch.files.tables import CaseError, Count, Force, Length, Table, explain


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
    method : str
        Contact method, passed on to `indent`.
    angles : int
        Number of polar angles of the contour.
    """

    title: str
    medium: Any
    indenter: Any
    control: str
    values: Array
    method: str
    angles: int


class _RangeTable(Table):
    """Evenly spaced steps: { start, stop, points, spacing }."""

    start: float
    stop: float
    points: Count
    spacing: Literal["linear", "log"] = "linear"

    def build(self, folder: Path) -> Array:
        """Return the steps."""
        if self.points < 2:
            raise ValueError(f"points = {self.points} must be 2 or more; for a single step write the quantity itself.")
        if self.start == self.stop:
            raise ValueError("start and stop are equal; for a single step write the quantity itself.")
        if self.spacing == "linear":
            return np.linspace(self.start, self.stop, self.points)
        for name in ("start", "stop"):
            positive(name, getattr(self, name), "spacing = 'log' has no zero; start from a small value.")
        return np.geomspace(self.start, self.stop, self.points)


class LengthRange(_RangeTable):
    """Range of depths or radii."""

    start: Length
    stop: Length


class ForceRange(_RangeTable):
    """Range of forces."""

    start: Force
    stop: Force


def _kind_of_steps(value: Any) -> str:
    return "a range" if isinstance(value, dict) else "a list" if isinstance(value, list) else "a quantity"


LengthSteps = Annotated[
    Annotated[Length, Tag("a quantity")]
    | Annotated[list[Length], Tag("a list")]
    | Annotated[LengthRange, Tag("a range")],
    Discriminator(_kind_of_steps),
]
ForceSteps = Annotated[
    Annotated[Force, Tag("a quantity")] | Annotated[list[Force], Tag("a list")] | Annotated[ForceRange, Tag("a range")],
    Discriminator(_kind_of_steps),
]


class ControlTable(Table):
    """[control]: exactly one of depth, force and radius, each a quantity, a list of quantities or a range."""

    depth: LengthSteps | None = None
    force: ForceSteps | None = None
    radius: LengthSteps | None = None

    def build(self, folder: Path) -> tuple[str, Array]:
        """Return the name of the given quantity and its steps."""
        given = {name: value for name in type(self).model_fields if (value := getattr(self, name)) is not None}
        if len(given) != 1:
            found = " and ".join(given) if given else "none"
            raise ValueError(f"exactly one of depth, force and radius must be given, found {found}.")
        ((name, value),) = given.items()
        return name, values(name, value.built if isinstance(value, _RangeTable) else value)


class CaseTable(Table):
    """The whole file."""

    title: str = ""
    method: str | None = None
    angles: Count = 360
    layers: list[LayerTable] = Field(default=[])
    base: BaseTable | None = None
    upper: BodyTable | None = None
    lower: BodyTable | None = None
    indenter: IndenterTable
    control: Annotated[ControlTable, Field(description="a table [control] with one of depth, force and radius")]

    def build(self, folder: Path) -> Case:
        """Return the case."""
        if self.method is not None and self.method not in METHODS:
            raise ValueError(f"method = {self.method!r} is unknown; it is one of {', '.join(map(repr, METHODS))}.")
        if self.angles < 8:
            raise ValueError(
                f"angles = {self.angles} must be 8 or more: the outline is sampled at that many polar angles."
            )
        control, steps = self.control.built
        medium = body(self.layers, self.base, self.upper, self.lower)
        method = self.method or default_method(self.indenter.built)
        return Case(self.title, medium, self.indenter.built, control, steps, method, self.angles)


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
    return _case(data, path)


def _case(data: dict[str, Any], path: Path) -> Case:
    try:
        table = CaseTable.model_validate(data, context={"folder": path.parent})
    except ValidationError as error:
        raise CaseError("\n".join(f"{path}: {line}" for line in explain(error.errors(), data).splitlines())) from None
    case: Case = table.built
    return case
