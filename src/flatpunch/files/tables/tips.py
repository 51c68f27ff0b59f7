"""Tables of a case file for the tips that people own: standard diamonds, AFM tips, worn and tilted ones, area functions, maps."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import ClassVar, Literal

from pydantic import Field

from flatpunch import indenters
from flatpunch._support.checks import positive
from flatpunch.files.height_maps import read_height_map
from flatpunch.files.tables.fields import Angle, Count, Length, Number, Switch, Table
from flatpunch.indenters.profile import Indenter


class TiltedTable(Table):
    """Tips that may be tilted against the surface."""

    section: ClassVar[str] = "indenter"
    tilt_x: Angle | None = None
    tilt_y: Angle | None = None

    def build(self, folder: Path) -> Indenter:
        """Return the indenter."""
        return self.tilted(self.described(TiltedTable.model_fields))

    def tilted(self, tip: Indenter) -> Indenter:
        """Return the tip with the tilt of the table."""
        if self.tilt_x is None and self.tilt_y is None:
            return tip
        return indenters.Tilted(tip, self.tilt_x or 0.0, self.tilt_y or 0.0)


class WornTable(TiltedTable):
    """Pointed tips, which may be rounded or flat at the end: by a sphere of `tip_radius`, or cut off by `height_removed`."""

    tip_radius: Length | None = None
    true_sphere: Switch | None = None
    height_removed: Length | None = None

    def build(self, folder: Path) -> Indenter:
        """Return the indenter."""
        return self.worn(self.described(WornTable.model_fields))

    def worn(self, sharp: indenters.Pyramid | indenters.FacetedPyramid | indenters.Cone) -> Indenter:
        """Return the sharp tip rounded or cut off, and tilted."""
        if self.tip_radius is not None and self.height_removed is not None:
            raise ValueError("give tip_radius (rounded) or height_removed (flat), not both.")
        if self.true_sphere is not None and self.tip_radius is None:
            raise ValueError("true_sphere has no meaning without tip_radius: it is the form of the rounding.")
        if self.height_removed is not None:
            # what is cut off after tilting has a level flat, which is how tips wear
            return indenters.Truncated(self.tilted(sharp), self.height_removed)
        if self.tip_radius is None:
            return self.tilted(sharp)
        positive("tip_radius", self.tip_radius)
        cap = {} if self.true_sphere is None else {"true_sphere": self.true_sphere}
        return self.tilted(indenters.Rounded(sharp, self.tip_radius, **cap))


class VickersTable(WornTable):
    """Square diamond, 136 degrees between opposite faces."""

    describes: ClassVar[Callable[..., Indenter]] = staticmethod(indenters.Vickers)
    kind: Literal["vickers"]


class BerkovichTable(WornTable):
    """Three-sided diamond, 65.27 degrees between axis and face, or 65.03 with modified = false."""

    describes: ClassVar[Callable[..., Indenter]] = staticmethod(indenters.Berkovich)
    kind: Literal["berkovich"]
    modified: Switch = True


class CubeCornerTable(WornTable):
    """Three faces at right angles."""

    describes: ClassVar[Callable[..., Indenter]] = staticmethod(indenters.CubeCorner)
    kind: Literal["cube-corner"]


class KnoopTable(WornTable):
    """Rhombic diamond, 172.5 and 130 degrees between opposite edges, long along x."""

    describes: ClassVar[Callable[..., Indenter]] = staticmethod(indenters.Knoop)
    kind: Literal["knoop"]


class AfmPyramidTable(WornTable):
    """Four-sided AFM tip by the half opening angles of its data sheet."""

    describes: ClassVar[Callable[..., Indenter]] = staticmethod(indenters.AfmPyramid)
    kind: Literal["afm-pyramid"]
    front: Angle
    back: Angle
    side: Angle


class SuperellipseTable(Table):
    """f = height_at_axes (|x/half_x|^power + |y/half_y|^power)^(exponent/power)."""

    describes: ClassVar[type] = indenters.Superellipse
    section: ClassVar[str] = "indenter"
    kind: Literal["superellipse"]
    half_x: Length
    half_y: Length
    height_at_axes: Length
    power: Number = 4.0
    exponent: Number = 2.0


class EllipsoidTable(TiltedTable):
    """True ellipsoid, by its half-axes."""

    describes: ClassVar[type] = indenters.Ellipsoid
    kind: Literal["ellipsoid"]
    half_x: Length
    half_y: Length
    half_z: Length


class RollerTable(Table):
    """Roller of finite length, with a crown or rounded ends."""

    section: ClassVar[str] = "indenter"
    describes: ClassVar[type] = indenters.Roller
    kind: Literal["roller"]
    radius: Length
    length: Length
    crown: Length | None = None
    end_radius: Length | None = None


class RoundedPunchTable(Table):
    """Flat punch of polygonal planform with rounded edges."""

    section: ClassVar[str] = "indenter"
    describes: ClassVar[type] = indenters.RoundedPunch
    kind: Literal["rounded-punch"]
    half_width: Length
    corner_radius: Length
    sides: Count = 4


class AreaFunctionTable(Table):
    """Body of revolution of the area function C0 h^2 + C1 h + C2 h^(1/2) + ..., h in units of `unit`."""

    describes: ClassVar[type] = indenters.AreaFunction
    section: ClassVar[str] = "indenter"
    kind: Literal["area-function"]
    coefficients: list[Number] = Field(description="a list of numbers such as [24.5, 300.0]")
    unit: Length
    limit: Length
    start: Length = 0.0


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

    def build(self, folder: Path) -> Indenter:
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
    | RollerTable
    | RoundedPunchTable
    | AreaFunctionTable
    | HeightMapTable
)
"""All of them, one of which a case file chooses by `kind`."""
