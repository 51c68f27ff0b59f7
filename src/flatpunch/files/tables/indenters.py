"""Tables of a case file that describe the indenter: one for each kind, made of the constructors of the tips."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from flatpunch import indenters
from flatpunch._support.checks import BadValue, positive, shown
from flatpunch._support.declared import arguments
from flatpunch._support.reading import UNPACKED, Unreadable, text_content
from flatpunch.files import units
from flatpunch.files.height_maps import read_height_map
from flatpunch.files.tables.fields import Angle, Count, Length, Number, Switch, Table
from flatpunch.files.tables.made import Made, chosen, kinds_in, table_of
from flatpunch.indenters.profile import Indenter


class TiltedTable(Made):
    """Tips that may be tilted against the surface."""

    section: ClassVar[str] = "indenter"
    tilt_x: Angle | None = None
    tilt_y: Angle | None = None

    def build(self, folder: Path) -> Indenter:
        """Return the indenter."""
        return self.tilted(self.made())

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
        """Return the sharp tip rounded or cut off, and tilted."""
        sharp = self.made()
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


class _ProfileTable(Made):
    """Measured round profile: two lists of lengths, or a CSV file next to the case file."""

    file: str | None = None

    def build(self, folder: Path) -> Indenter:
        given = {name: getattr(self, name) for name in arguments(indenters.RadialProfile)}
        r, f = given["r"], given["f"]
        if (self.file is None) == (r is None) or (r is None) != (f is None):
            raise ValueError("give either file (a CSV with the columns r and f) or both lists r and f.")
        if self.file is not None:
            given["r"], given["f"] = read_profile(folder / self.file)
        return indenters.RadialProfile(**given)

    @classmethod
    def proposed(cls) -> set[str]:
        return {"r", "f"}


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
        others = [name for name in type(self).model_fields if name not in ("kind", "file", "tilt_x", "tilt_y")]
        try:
            tip = read_height_map(folder / self.file, **{name: getattr(self, name) for name in others})
        except ImportError as error:
            raise ValueError(str(error)) from None
        return self.tilted(tip)


def read_profile(path: Path) -> tuple[list[float], list[float]]:
    """Read (r, f) from a CSV file whose first line names both columns with their units: "r [um], f [nm]".

    Lines that start with # are comments.
    """
    try:
        text = text_content(path, UNPACKED)
    except Unreadable as error:
        raise BadValue("file", shown(path.name), f"is {error}. Give its path relative to the case file.") from None
    lines = [
        (n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(lines) < 3:
        raise BadValue(
            "file",
            shown(path.name),
            f"has {len(lines)} lines that are no comments; a header and two or more points are needed.",
        )
    scales = [
        _column_scale(cell, name, path.name) for cell, name in zip(_cells(lines[0], path.name), "rf", strict=True)
    ]
    r, f = [], []
    for line in lines[1:]:
        cells = _cells(line, path.name)
        try:
            first, second = map(float, cells)
        except ValueError:
            raise BadValue(
                "file", shown(path.name), f"has no two numbers in line {line[0]}: {shown(line[1].strip())}."
            ) from None
        r.append(first * scales[0])
        f.append(second * scales[1])
    return r, f


def _cells(line: tuple[int, str], name: str) -> list[str]:
    cells = [cell.strip() for cell in line[1].split(",")]
    if len(cells) != 2:
        raise BadValue(
            "file",
            shown(name),
            f"has {len(cells)} columns in line {line[0]}; two are needed, r and f, with a comma between.",
        )
    return cells


def _column_scale(cell: str, expected: str, name: str) -> float:
    """Length of one unit of a column [m], from a heading such as "r [um]" or "radius (um)"."""
    words = {"r": "r|radius", "f": "f|height"}[expected]
    found = re.fullmatch(rf"(?:{words})\s*(?:\[(.*)\]|\((.*)\))", cell)
    if found is None:
        raise BadValue(
            "file",
            shown(name),
            f"has the column heading {shown(cell)}; the first line must read like 'r [um], f [nm]' or 'radius "
            "(um), height (nm)'.",
        )
    try:
        return units.to_si(f"1 {found[1] or found[2]}", units.LENGTH)
    except ValueError as error:
        raise BadValue("file", shown(name), f"has the column heading {shown(cell)}, whose unit {error}") from None


def kinds() -> dict[str, type[Table]]:
    """Tables of all kinds of tips: those that are marked in their own files, and those of measured ones."""
    made = kinds_in("indenter", {"": Made, "tilts": TiltedTable, "wears": WornTable})
    return {**made, "radial-profile": _PROFILE, "height-map": HeightMapTable}


_PROFILE = table_of("radial-profile", "indenter", [indenters.RadialProfile], _ProfileTable, {"r", "f"})
# each tip marks itself when it is loaded
_ = [getattr(indenters, name) for name in indenters.__all__]

_NEEDED = "a table [indenter] such as kind = 'sphere', radius = '5 um'"
IndenterTable = Annotated[Table, chosen(kinds), Field(description=_NEEDED)]
