"""Tables of a case file that describe the indenter: one model per `kind`."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from flatpunch import indenters
from flatpunch._support.checks import BadValue, positive, shown
from flatpunch._support.reading import Unreadable, content
from flatpunch.files import units
from flatpunch.files.tables.fields import Angle, Count, Curvature, Length, Number, Table
from flatpunch.files.tables.tips import TIP_TABLES, WornTable
from flatpunch.indenters.profile import Indenter


class ParaboloidTable(Table):
    """f = r^2 / (2 radius)."""

    describes: ClassVar[type] = indenters.Paraboloid
    section: ClassVar[str] = "indenter"
    kind: Literal["paraboloid"]
    radius: Length


class SphereTable(Table):
    """True sphere, up to its equator."""

    describes: ClassVar[type] = indenters.Sphere
    section: ClassVar[str] = "indenter"
    kind: Literal["sphere"]
    radius: Length


class CylinderTable(Table):
    """Cylinder with a flat end."""

    describes: ClassVar[type] = indenters.Cylinder
    section: ClassVar[str] = "indenter"
    kind: Literal["cylinder"]
    radius: Length


class EllipticTable(Table):
    """f = A x^2 + B y^2, by A and B or by the two radii of curvature, A = 1/(2 radius_x)."""

    section: ClassVar[str] = "indenter"
    kind: Literal["elliptic-paraboloid"]
    A: Curvature | None = None
    B: Curvature | None = None
    radius_x: Length | None = None
    radius_y: Length | None = None

    def build(self, folder: Path) -> Indenter:
        """Return the indenter."""
        curvatures, radii = (self.A, self.B), (self.radius_x, self.radius_y)
        by_curvature, by_radius = None not in curvatures, None not in radii
        if by_curvature == by_radius or any(value is not None for value in (radii if by_curvature else curvatures)):
            raise ValueError(
                "give either A and B (f = A x^2 + B y^2) or radius_x and radius_y, and only one of the two pairs."
            )
        if self.A is not None and self.B is not None:
            return indenters.EllipticParaboloid(self.A, self.B)
        x, y = (positive(name, getattr(self, name), "The tip is convex.") for name in ("radius_x", "radius_y"))
        return indenters.EllipticParaboloid(0.5 / x, 0.5 / y)


class _Inclined(WornTable):
    """Faces given by their inclination to the surface, or by the half opening angle between axis and face."""

    inclination: Angle | None = None
    half_opening_angle: Angle | None = None

    def angle(self) -> float:
        """Inclination [rad]."""
        if (self.inclination is None) == (self.half_opening_angle is None):
            raise ValueError(
                "give either inclination (between the surface and a face) or half_opening_angle (between the axis and a face)."
            )
        if self.inclination is not None:
            return self.inclination
        assert self.half_opening_angle is not None
        if not 0 < self.half_opening_angle < math.pi / 2:
            raise BadValue("half_opening_angle", repr(self.half_opening_angle), "must lie between 0 and 90 degrees.")
        return math.pi / 2 - self.half_opening_angle


class ConeTable(_Inclined):
    """f = tan(inclination) r."""

    section: ClassVar[str] = "indenter"
    kind: Literal["cone"]

    def build(self, folder: Path) -> Indenter:
        """Return the indenter."""
        return self.worn(indenters.Cone(self.angle()))


class PyramidTable(_Inclined):
    """f = tan(inclination) times the largest distance along a face normal."""

    section: ClassVar[str] = "indenter"
    kind: Literal["pyramid"]
    sides: Count

    def build(self, folder: Path) -> Indenter:
        """Return the indenter."""
        return self.worn(indenters.Pyramid(self.sides, self.angle()))


class PowerLawTable(Table):
    """f = height (r / radius)^exponent, times a factor over the polar angle if `angles` and `factors` are given."""

    section: ClassVar[str] = "indenter"
    kind: Literal["power-law"]
    exponent: Number
    radius: Length
    height: Length
    angles: list[Angle] | None = None
    factors: list[Number] | None = None
    corners: list[Angle] = Field(default=[])

    def build(self, folder: Path) -> Indenter:
        """Return the indenter."""
        if (self.angles is None) != (self.factors is None):
            raise ValueError("angles and factors belong together: one factor for each polar angle of one turn.")
        for name in ("radius", "height"):
            positive(f"PowerLaw.{name}", getattr(self, name))
        psi = self.height / self.radius**self.exponent
        if self.angles is None or self.factors is None:
            return indenters.PowerLaw(self.exponent, psi)
        return indenters.PowerLaw(self.exponent, (self.angles, [psi * factor for factor in self.factors]), self.corners)


class ProfileTable(Table):
    """Measured round profile: two lists of lengths, or a CSV file next to the case file."""

    section: ClassVar[str] = "indenter"
    kind: Literal["radial-profile"]
    r: list[Length] | None = None
    f: list[Length] | None = None
    kinks: list[Length] = Field(default=[])
    smoothing: Length = 0.0
    file: str | None = None

    def build(self, folder: Path) -> Indenter:
        """Return the indenter."""
        if (self.file is None) == (self.r is None) or (self.r is None) != (self.f is None):
            raise ValueError("give either file (a CSV with the columns r and f) or both lists r and f.")
        r, f = (self.r, self.f) if self.file is None else read_profile(folder / self.file)
        radii, heights = np.asarray(r, dtype=float), np.asarray(f, dtype=float)
        return indenters.RadialProfile(radii, heights, self.kinks, smoothing=self.smoothing)


def read_profile(path: Path) -> tuple[list[float], list[float]]:
    """Read (r, f) from a CSV file whose first line names both columns with their units: "r [um], f [nm]".

    Lines that start with # are comments.
    """
    try:
        # largest CSV file of a profile [bytes]
        text = content(path, 20_000_000).decode("utf-8")
    except UnicodeDecodeError:
        raise BadValue("file", shown(path.name), "is no text file; a profile is CSV in UTF-8.") from None
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


IndenterTable = Annotated[
    ParaboloidTable
    | EllipticTable
    | SphereTable
    | ConeTable
    | PyramidTable
    | PowerLawTable
    | ProfileTable
    | CylinderTable
    | TIP_TABLES,
    Field(discriminator="kind", description="a table [indenter] such as kind = 'sphere', radius = '5 um'"),
]
