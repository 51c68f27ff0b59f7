"""Case files of rough surfaces and of asperities: TOML with units, as `flatpunch rough` solves them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flatpunch._support.checks import Array
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch._support.reading import as_path
from flatpunch.files.cases import case_text, parsed
from flatpunch.files.descriptions import control_words, describe_bodies, words
from flatpunch.files.tables.fields import CaseError, validated
from flatpunch.files.tables.media import SampleTable
from flatpunch.files.tables.rough import AsperitiesTable, RoughControlTable, SurfaceTable
from flatpunch.media import Body
from flatpunch.rough import asperities, rough_contact
from flatpunch.rough.solution import required
from flatpunch.surfaces import Topography
from flatpunch.surfaces.heights import tilt_note

if TYPE_CHECKING:
    import xarray as xr

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
    """

    title: str
    medium: Body
    surface: Topography | None
    asperities: tuple[Any, Any, Any] | None
    control: str
    values: Array

    def solve(self, *, last: bool = False) -> xr.Dataset:
        """Solve all steps, or the last of a surface with pressure, gap and displacement on its cells."""
        steps: Plain = {self.control: self.values[-1] if last else self.values}
        if self.surface is not None:
            return rough_contact(self.medium, self.surface, fields=last, **steps)
        assert self.asperities is not None
        return asperities(self.medium, *self.asperities, **steps)


class RoughTable(SampleTable):
    """The whole file."""

    title: str = ""
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
        return RoughCase(
            self.title,
            self.body(),
            None if self.surface is None else self.surface.built,
            None if self.asperities is None else self.asperities.built,
            control,
            steps,
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
