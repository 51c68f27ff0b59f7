"""Tables of a case file for the tips that people own: standard diamonds, AFM tips, worn and tilted ones, area functions, maps."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field

from flatpunch import indenters
from flatpunch.files.height_maps import read_height_map
from flatpunch.files.tables.fields import Angle, Count, Length, Number, Switch, Table


class TiltedTable(Table):
    """Tips that may be tilted against the surface."""

    section: ClassVar[str] = "indenter"
    tilt_x: Angle | None = None
    tilt_y: Angle | None = None

    def tilted(self, tip: Any) -> Any:
        """Return the tip with the tilt of the table."""
        if self.tilt_x is None and self.tilt_y is None:
            return tip
        return indenters.Tilted(tip, self.tilt_x or 0.0, self.tilt_y or 0.0)


class WornTable(TiltedTable):
    """Pointed tips, which may be rounded or flat at the end: by a sphere of `tip_radius`, or cut off by `height_removed`."""

    tip_radius: Length | None = None
    height_removed: Length | None = None

    def worn(self, sharp: Any) -> Any:
        """Return the sharp tip rounded or cut off, and tilted."""
        if self.tip_radius is not None and self.height_removed is not None:
            raise ValueError("give tip_radius (rounded) or height_removed (flat), not both.")
        if self.height_removed is not None:
            # what is cut off after tilting has a level flat, which is how tips wear
            return indenters.Truncated(self.tilted(sharp), self.height_removed)
        return self.tilted(
            sharp if self.tip_radius is None else indenters.Rounded(sharp, self.tip_radius, true_sphere=True)
        )


class VickersTable(WornTable):
    """Square diamond, 136 degrees between opposite faces."""

    kind: Literal["vickers"]

    def build(self, folder: Path) -> Any:
        """Return the indenter."""
        return self.worn(indenters.Vickers())


class BerkovichTable(WornTable):
    """Three-sided diamond, 65.27 degrees between axis and face, or 65.03 with modified = false."""

    kind: Literal["berkovich"]
    modified: Switch = True

    def build(self, folder: Path) -> Any:
        """Return the indenter."""
        return self.worn(indenters.Berkovich(modified=self.modified))


class CubeCornerTable(WornTable):
    """Three faces at right angles."""

    kind: Literal["cube-corner"]

    def build(self, folder: Path) -> Any:
        """Return the indenter."""
        return self.worn(indenters.CubeCorner())


class KnoopTable(WornTable):
    """Rhombic diamond, 172.5 and 130 degrees between opposite edges, long along x."""

    kind: Literal["knoop"]

    def build(self, folder: Path) -> Any:
        """Return the indenter."""
        return self.worn(indenters.Knoop())


class AfmPyramidTable(WornTable):
    """Four-sided AFM tip by the half opening angles of its data sheet."""

    kind: Literal["afm-pyramid"]
    front: Angle
    back: Angle
    side: Angle

    def build(self, folder: Path) -> Any:
        """Return the indenter."""
        return self.worn(indenters.AfmPyramid(self.front, self.back, self.side))


class SuperellipseTable(Table):
    """f = height_at_axes (|x/half_x|^power + |y/half_y|^power)^(exponent/power)."""

    section: ClassVar[str] = "indenter"
    kind: Literal["superellipse"]
    half_x: Length
    half_y: Length
    height_at_axes: Length
    power: Number = 4.0
    exponent: Number = 2.0

    def build(self, folder: Path) -> Any:
        """Return the indenter."""
        return indenters.Superellipse(self.half_x, self.half_y, self.height_at_axes, self.power, self.exponent)


class EllipsoidTable(TiltedTable):
    """True ellipsoid, by its half-axes."""

    kind: Literal["ellipsoid"]
    half_x: Length
    half_y: Length
    half_z: Length

    def build(self, folder: Path) -> Any:
        """Return the indenter."""
        return self.tilted(indenters.Ellipsoid(self.half_x, self.half_y, self.half_z))


class AreaFunctionTable(Table):
    """Body of revolution of the area function C0 h^2 + C1 h + C2 h^(1/2) + ..., h in units of `unit`."""

    section: ClassVar[str] = "indenter"
    kind: Literal["area-function"]
    coefficients: list[Number] = Field(description="a list of numbers such as [24.5, 300.0]")
    unit: Length
    limit: Length
    start: Length = 0.0

    def build(self, folder: Path) -> Any:
        """Return the indenter."""
        return indenters.AreaFunction(tuple(self.coefficients), self.limit, self.unit, self.start)


class HeightMapTable(TiltedTable):
    """Measured map of a tip or of an asperity."""

    kind: Literal["height-map"]
    file: str
    apex: Literal["lowest", "highest"] = "lowest"
    level: Switch = False
    smoothing: Length = 0.0
    near: list[Length] | None = None
    reach: Length | Literal["usable"] | None = None
    channel: Count | None = None
    height_scale: Number = 1.0

    def build(self, folder: Path) -> Any:
        """Return the indenter."""
        if self.near is not None and len(self.near) != 2:
            raise ValueError(f"near has {len(self.near)} entries; it is a point, two lengths [x, y].")
        try:
            tip = read_height_map(
                folder / self.file,
                apex=self.apex,
                level=self.level,
                smoothing=self.smoothing,
                near=None if self.near is None else (self.near[0], self.near[1]),
                reach=self.reach,
                channel=self.channel,
                height_scale=self.height_scale,
            )
        except ImportError as error:
            raise ValueError(str(error)) from None
        return self.tilted(tip)


TIP_TABLES = (
    VickersTable
    | BerkovichTable
    | CubeCornerTable
    | KnoopTable
    | AfmPyramidTable
    | SuperellipseTable
    | EllipsoidTable
    | AreaFunctionTable
    | HeightMapTable
)
"""All of them, one of which a case file chooses by `kind`."""
