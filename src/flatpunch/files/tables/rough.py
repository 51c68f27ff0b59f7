"""Tables of a case file for rough surfaces: [surface], [asperities], and the [control] of their contacts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from flatpunch._support.checks import Array, values
from flatpunch.files.height_maps import read_topography
from flatpunch.files.tables.fields import Count, Length, Number, Pressure, Switch, Table
from flatpunch.files.tables.indenters import IndenterTable
from flatpunch.files.tables.steps import ForceSteps, LengthSteps, RangeTable, kind_of_steps, only_one, steps_of
from flatpunch.surfaces import Topography, self_affine


class _SurfaceTable(Table):
    """Surfaces that repeat along both axes, none, or x or y alone."""

    section: ClassVar[str] = "surface"
    periodic: Switch | Literal["x", "y"] = True

    def ended(self, rough: Topography) -> Topography:
        """Return the surface with the borders of the table."""
        along = self.periodic if isinstance(self.periodic, bool) else (self.periodic == "x", self.periodic == "y")
        return Topography(rough.heights, rough.spacing, along)


class SelfAffineTable(_SurfaceTable):
    """Random self-affine surface."""

    kind: Literal["self-affine"]
    cells: Count
    spacing: Length
    hurst: Number = 0.8
    rms_height: Length | None = None
    rms_slope: Number | None = None
    roll_off: Length | None = None
    cut_off: Length | None = None
    seed: Count = 0

    def build(self, folder: Path) -> Topography:
        """Return the surface."""
        names = ("hurst", "rms_height", "rms_slope", "roll_off", "cut_off", "seed")
        return self.ended(self_affine(self.cells, self.spacing, **{name: getattr(self, name) for name in names}))


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
        given = {
            name: getattr(self, name) for name in type(self).model_fields if name not in ("kind", "file", "periodic")
        }
        try:
            rough = read_topography(folder / self.file, **given)
        except ImportError as error:
            raise ValueError(str(error)) from None
        return self.ended(rough)


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
