"""Case files of rough surfaces and of asperities: TOML with units, as `flatpunch rough` solves them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from flatpunch._support.checks import Array, values
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch._support.reading import as_path
from flatpunch.files.cases import case_text, parsed
from flatpunch.files.descriptions import control_words, describe_bodies, words
from flatpunch.files.height_maps import read_topography
from flatpunch.files.tables.fields import CaseError, Count, Length, Number, Pressure, Switch, Table, validated
from flatpunch.files.tables.indenters import IndenterTable
from flatpunch.files.tables.media import SampleTable
from flatpunch.files.tables.steps import ForceSteps, LengthSteps, RangeTable, kind_of_steps, only_one, steps_of
from flatpunch.media import Body
from flatpunch.rough import asperities, rough_contact
from flatpunch.rough.solution import required
from flatpunch.surfaces import Topography, self_affine
from flatpunch.surfaces.heights import tilt_note

if TYPE_CHECKING:
    import xarray as xr


class _SurfaceTable(Table):
    """Surfaces that repeat along both axes, none, or x or y alone."""

    section: ClassVar[str] = "surface"
    periodic: Switch | Literal["x", "y"] = True

    def made(self, make: Callable[..., Topography], first: object) -> Topography:
        """The surface that a function makes of its first argument and the other fields by name, with its ends."""
        kept = [name for name in type(self).model_fields if name not in ("kind", "periodic", "cells", "file")]
        rough = make(first, **{name: value for name in kept if (value := getattr(self, name)) is not None})
        along = self.periodic if isinstance(self.periodic, bool) else (self.periodic == "x", self.periodic == "y")
        return Topography(rough.heights, rough.spacing, along)


class SelfAffineTable(_SurfaceTable):
    """Random self-affine surface."""

    kind: Literal["self-affine"]
    cells: Count
    spacing: Length
    hurst: Number | None = None
    rms_height: Length | None = None
    rms_slope: Number | None = None
    roll_off: Length | None = None
    cut_off: Length | None = None
    seed: Count | None = None

    def build(self, folder: Path) -> Topography:
        """Return the surface."""
        return self.made(self_affine, self.cells)


class MeasuredTable(_SurfaceTable):
    """Measured surface from a file."""

    kind: Literal["file"]
    file: str
    peaks: Literal["highest", "lowest"] = "highest"
    level: Switch = False
    fill: Switch = False
    resample: Switch = False
    channel: Count | None = None
    height_scale: Number = 1.0
    spacing: Length | None = None
    unit: str | None = None

    def build(self, folder: Path) -> Topography:
        """Return the surface."""
        try:
            return self.made(read_topography, folder / self.file)
        except ImportError as error:
            raise ValueError(str(error)) from None


SurfaceTable = Annotated[
    SelfAffineTable | MeasuredTable,
    Field(
        discriminator="kind",
        description="a table [surface] such as kind = 'self-affine', cells = 256, spacing = '10 nm'",
    ),
]


class AsperitiesTable(Table):
    """Equal tips at given places."""

    section: ClassVar[str] = "asperities"
    tip: IndenterTable
    positions: list[list[Length]]
    heights: list[Length] = Field(default=[])

    def build(self, folder: Path) -> tuple[Any, list[list[float]], Any]:
        """Return the tip, places and heights."""
        for i, place in enumerate(self.positions):
            if len(place) != 2:
                raise ValueError(f"positions[{i}] has {len(place)} entries; it is a point, two lengths [x, y].")
        return self.tip.built, self.positions, self.heights or 0.0


class PressureRange(RangeTable):
    """Range of mean pressures."""

    start: Pressure
    stop: Pressure


PressureSteps = Annotated[
    Annotated[Pressure, Tag("a quantity")]
    | Annotated[list[Pressure], Tag("a list")]
    | Annotated[PressureRange, Tag("a range")],
    Discriminator(kind_of_steps),
]


class RoughControlTable(Table):
    """[control]: exactly one of pressure, force and depth, each a quantity, a list of quantities or a range."""

    pressure: PressureSteps | None = None
    force: ForceSteps | None = None
    depth: LengthSteps | None = None

    def build(self, folder: Path) -> tuple[str, Array]:
        """Return the name of the given quantity and its steps."""
        name, value = only_one(self, ("pressure", "force", "depth"))
        return name, values(name, steps_of(value))


_TABLES = {"surface", "asperities"}
"""Tables of which a case file of this kind has one."""


@readable
@dataclass(frozen=True)
class RoughCase:
    """What a case file of a rough surface asks for, in SI units.

    Attributes
    ----------
    title : str
        One line for tables and pictures.
    medium : object
        The elastic body.
    surface : Topography or None
        The rough surface.
    asperities : tuple or None
        Tip, places and heights, in the place of a surface.
    control : {"pressure", "force", "depth"}
        The quantity that is given.
    values : ndarray, shape (steps,)
        Its values [Pa], [N] or [m].
    hardness : float or None
        Largest pressure on a surface [Pa].
    """

    title: str
    medium: Body
    surface: Topography | None
    asperities: tuple[Any, Any, Any] | None
    control: str
    values: Array
    hardness: float | None = None

    def solve(self, *, last: bool = False) -> xr.Dataset:
        """Solve all steps, or the last of a surface with pressure, gap and displacement on its cells."""
        steps: Plain = {self.control: self.values[-1] if last else self.values}
        if self.surface is not None:
            return rough_contact(self.medium, self.surface, hardness=self.hardness, fields=last, **steps)
        assert self.asperities is not None
        return asperities(self.medium, *self.asperities, **steps)


class RoughTable(SampleTable):
    """The whole file."""

    title: str = ""
    hardness: Pressure | None = None
    surface: SurfaceTable | None = None
    asperities: AsperitiesTable | None = None
    control: RoughControlTable

    def build(self, folder: Path) -> RoughCase:
        """Return the case."""
        if (self.surface is None) == (self.asperities is None):
            found = "none" if self.surface is None else "both"
            raise ValueError(f"give either a table [surface] or a table [asperities]; found {found}.")
        control, steps = self.control.built
        if self.asperities is not None and control == "pressure":
            raise ValueError("control.pressure belongs to a [surface]; asperities take a force or a depth.")
        if self.asperities is not None and self.hardness is not None:
            raise ValueError("hardness belongs to a [surface]; asperities are elastic.")
        return RoughCase(
            self.title,
            self.body(),
            None if self.surface is None else self.surface.built,
            None if self.asperities is None else self.asperities.built,
            control,
            steps,
            self.hardness,
        )


def is_rough_case(path: str | Path) -> bool:
    """Whether a case file has a table [surface] or [asperities]; unreadable files are left to their reader."""
    try:
        return bool(_TABLES & set(parsed(case_text(path), Path(path))))
    except CaseError:
        return False


def describe_rough(case: RoughCase) -> Iterator[str]:
    """Yield lines that say what a case of a rough surface would solve."""
    yield f"Case      {case.title or '(no title)'}"
    yield from describe_bodies(case.medium)
    if case.surface is None:
        assert case.asperities is not None
        tip, places, _ = case.asperities
        yield f"Tips      {len(places)} times {words(tip)}"
    else:
        rough, (ny, nx) = case.surface, case.surface.shape
        along = [axis for axis, repeats in zip("xy", rough.periodic, strict=True) if repeats]
        repeats = f"repeats along {' and '.join(along)}" if along else "ends at its border"
        yield f"Surface   {nx} x {ny} cells of {text(rough.spacing, 'm')}, {repeats}"
        yield f"          rms height {text(rough.rms_height, 'm')}, rms slope {rough.rms_slope:.3g}"
        yield from (f"          {note}" for note in tilt_note(rough.heights, rough.spacing, rough.periodic))
    if case.hardness is not None:
        yield f"Hardness  {text(case.hardness, 'Pa')}"
    yield f"Control   {control_words(case.control, case.values)}"
    if case.surface is not None:
        yield f"Takes     at most {required(case.surface) / 1e6:.0f} MB of memory"


def read_rough_case(path: str | Path) -> RoughCase:
    """Read and check a case file with a table [surface] or [asperities]; CaseError lists all problems, one a line."""
    path = as_path("path", path)
    data = parsed(case_text(path), path)
    if not _TABLES & set(data):
        raise CaseError(f"{path} has neither [surface] nor [asperities]: solve it with `flatpunch solve {path}`.")
    case: RoughCase = validated(RoughTable, data, path, folder=path.parent).built
    return case
