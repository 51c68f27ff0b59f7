"""Maps of heights from files: NumPy archives and matrices, texts, and the formats of microscopes through SurfaceTopography."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flatpunch._support.checks import Array, BadValue, Flags, Indices
from flatpunch._support.prefixes import text
from flatpunch._support.reading import UNPACKED, archived_arrays, content, stored_array
from flatpunch.files import units
from flatpunch.indenters.measured.height_grid import FEWEST

_MISSING = ("", "nan", "NaN", "NAN", "BAD", "Bad", "bad", "---", "***", "No Data", "-nan", "inf", "-inf")
"""Cells of a text that stand for a height that was not measured."""

_SEPARATORS = ((";", "."), (";", ","), ("\t", "."), ("\t", ","), (",", "."), (r"\s+", "."), (r"\s+", ","))
"""Separators of columns and decimal marks of texts, in the order in which they are tried."""

_TITLE = re.compile(r"(?<![a-z])(x|y|z|height)\w*\s*[\[(/]\s*([^\s\]),;]+)", re.IGNORECASE)
"""A column's title with its unit: "X [um]", "y(nm)", "z/nm"."""

_EXTENT = re.compile(r"(width|height|value units)\s*[:=]\s*([^\s].*?)\s*$", re.IGNORECASE)
"""What Gwyddion writes over a matrix: the lengths of the map and the unit of its heights."""


_NO_HEIGHTS = ("phase", "amplitude", "deflection", "friction", "lateral", "current", "error", "potential")
"""Words in names of channels that hold no heights, though some instruments give them in metres."""


class Scan(NamedTuple):
    """Coordinates of columns and rows and heights [m], shapes (nx,), (ny,) and (ny, nx); missing heights are NaN."""

    x: Array
    y: Array
    z: Array


class Wanted(NamedTuple):
    """What the caller states of a file: the channel, distance of points [m] and length unit [m] that it may lack."""

    channel: int | None
    spacing: float | None
    unit: str | None

    @property
    def metre(self) -> float | None:
        """The unit [m]."""
        return None if self.unit is None else units.named_si("unit", f"1 {self.unit}", units.LENGTH)

    def distance(self, name: str) -> float:
        """The distance of points [m], which the file lacks."""
        if self.spacing is None:
            raise ValueError(f"{name} does not state the distance of its points. Give it in metres: spacing=.")
        return self.spacing

    def length(self, name: str, head: Sequence[str] = ()) -> float:
        """The length unit [m], which the file lacks, `head` being what stands above its numbers."""
        if self.metre is None:
            other = next((word for word in _NO_HEIGHTS if any(word in line.lower() for line in head)), None)
            found = f"names {other!r} above its numbers, and " if other else ""
            remedy = "If they are heights all the same, give it" if other else "Give it"
            raise ValueError(f"{name} {found}does not state the unit of its heights. {remedy}: unit='nm', for example.")
        return self.metre

    def check_needed(self, name: str, *, spacing: bool, unit: bool) -> None:
        """Refuse what the file states itself."""
        for called, value, needed in (("spacing", self.spacing, spacing), ("unit", self.unit, unit)):
            if value is not None and not needed:
                raise BadValue(called, repr(value), f"is not needed: {name} states its own. Leave it out.")


def numbers_of(path: Path, wanted: Wanted) -> Scan | None:
    """Read a map from a NumPy file or a text; None for any other format, `Unreadable` for what is no file or too large."""
    ending = path.suffix.lower()
    if ending == ".npz":
        return _archive(path, wanted)
    if ending == ".npy":
        return _matrix(path.name, _numbers(path.name, stored_array(content(path, UNPACKED))), wanted)
    return _from_text(path, wanted)


def _archive(path: Path, wanted: Wanted) -> Scan:
    arrays = archived_arrays(content(path, UNPACKED), "xyz")
    for name in "xyz":
        if name not in arrays:
            raise ValueError(f"{path.name} has no array {name}; it must hold x, y and z in metres.")
    wanted.check_needed(path.name, spacing=False, unit=False)
    return Scan(*(_numbers(path.name, arrays[name]) for name in "xyz"))


def _numbers(name: str, array: NDArray[Any]) -> Array:
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name} holds an array of {array.dtype}; heights and coordinates are numbers.")
    return np.asarray(array, dtype=float)


def _matrix(name: str, z: Array, wanted: Wanted, head: Sequence[str] = ()) -> Scan:
    if z.ndim != 2:
        raise ValueError(f"{name} holds an array of shape {z.shape}; heights are a matrix (ny, nx).")
    step, metre, (ny, nx) = wanted.distance(name), wanted.length(name, head), z.shape
    return Scan(np.asarray(step * np.arange(nx)), np.asarray(step * np.arange(ny)), z * metre)


def _from_text(path: Path, wanted: Wanted) -> Scan | None:
    """Matrix or columns x, y, z of a text; None for what is no head with equally long rows of numbers below it."""
    raw = content(path, UNPACKED)
    if b"\0" in raw:
        return None
    try:
        whole_text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        whole_text = raw.decode("latin-1")
    lines = whole_text.splitlines()
    first = next(((i, form) for i, line in enumerate(lines[:1000]) if (form := _form(line))), None)
    table = None if first is None else _table(lines[first[0] :], *first[1])
    if first is None or table is None:
        return None
    head = lines[: first[0]]
    if table.shape[1] == 3:
        return _columns(path.name, table, head, wanted)
    stated = {
        kind.lower(): value for line in head if (match := _EXTENT.search(line)) for kind, value in [match.groups()]
    }
    if not {"width", "height"} <= stated.keys():
        return _matrix(path.name, table, wanted, head)
    wanted.check_needed(path.name, spacing=False, unit="value units" not in stated)
    across, along = (units.named_si(f"{path.name}: {side}", stated[side], units.LENGTH) for side in ("width", "height"))
    unit = stated.get("value units")
    metre = wanted.length(path.name, head) if unit is None else _metre(path.name, unit)
    ny, nx = table.shape
    # rows of images run downwards; as for other formats of microscopes y begins at the first row
    return Scan(across / nx * np.arange(nx), along / ny * np.arange(ny), metre * table)


def _metre(name: str, unit: str) -> float:
    """A unit in the head of a text [m]."""
    try:
        return units.to_si(f"1 {unit}", units.LENGTH)
    except ValueError as error:
        raise ValueError(f"{name} holds values in {unit!r}, which {error} A height map holds lengths.") from None


def _form(line: str) -> tuple[str, str] | None:
    """Separator and decimal mark of a row of three numbers or more; None for any other line."""
    for separator, mark in _SEPARATORS:
        cells = re.split(separator, line.strip()) if separator == r"\s+" else line.strip().split(separator)
        cells = [cell.strip().replace(mark, ".") for cell in cells]
        numbers = [cell for cell in cells if cell not in _MISSING]
        if len(cells) >= 3 and numbers and all(_is_number(cell) for cell in numbers):
            return separator, mark
    return None


def _is_number(cell: str) -> bool:
    return re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", cell) is not None


def _table(lines: list[str], separator: str, mark: str) -> Array | None:
    """Rows of numbers, or None where they are no table."""
    import pandas as pd

    try:
        frame = pd.read_csv(
            io.StringIO("\n".join(lines)),
            sep=separator,
            decimal=mark,
            header=None,
            na_values=list(_MISSING),
            skipinitialspace=True,
            dtype=float,
        )
    except ValueError:
        return None
    table = frame.to_numpy(dtype=float)
    # a separator at the end of each row
    table = table[:, :-1] if table.shape[1] > 3 and np.isnan(table[:, -1]).all() else table
    return table if table.shape[1] == 3 or table.shape[1] >= FEWEST else None


def _columns(name: str, table: Array, head: list[str], wanted: Wanted) -> Scan:
    """A map from columns x, y, z in any order; points that are missing are NaN."""
    titles = [found for line in head if len(found := _TITLE.findall(line)) == 3]
    wanted.check_needed(name, spacing=False, unit=not titles)
    factors = [_metre(name, unit) for _, unit in titles[-1]] if titles else 3 * [wanted.length(name, head)]
    x, y, z = (table * factors).T
    known: Flags = ~(np.isnan(x) | np.isnan(y))
    (columns, i), (rows, j) = (_levels(name, axis[known]) for axis in (x, y))
    heights = np.full((rows.size, columns.size), np.nan)
    if np.unique(j * columns.size + i).size < i.size:
        raise ValueError(
            f"{name} is no grid, or has several heights at one point (x, y). Cut it to one map, or resample it."
        )
    heights[j, i] = z[known]
    return Scan(columns, rows, heights)


def _levels(name: str, along: Array) -> tuple[Array, Indices]:
    """Coordinates of the columns or rows of a grid [m], and to which of them each point belongs."""
    order = np.argsort(along)
    steps = np.diff(along[order])
    # coordinates of instruments are rounded: distances within a column are a small part of those between two
    new = steps > 0.05 * np.ptp(along) / np.sqrt(along.size)
    number = np.empty(along.size, dtype=int)
    number[order] = np.concatenate([[0], np.cumsum(new)])
    count = number.max() + 1
    levels: Array = np.bincount(number, along) / np.bincount(number)
    if count < FEWEST or count > along.size / 2:
        raise ValueError(
            f"{name} has points on {count} different coordinates, {along.size} points in all; they are no grid of columns and "
            f"rows at distances such as {text(float(np.ptp(along)) / np.sqrt(along.size), 'm')}. Resample them."
        )
    return levels, number


def read_channel(path: Path, wanted: Wanted) -> Scan:
    """The map of the channel that is wanted, or of the first one that holds heights."""
    try:
        from SurfaceTopography import open_topography
        from SurfaceTopography.Exceptions import CannotDetectFileFormat, CorruptFile
    except ImportError:
        raise ImportError(
            f"Reading {path.name} needs the package SurfaceTopography: pip install 'flatpunch[topography]'. Without it a .npz "
            "file with the arrays x, y and z in metres, a .npy file or a text of heights can be read."
        ) from None
    try:
        with open_topography(str(path)) as reader:
            channel = _chosen(path.name, list(reader.channels), wanted.channel)
            _check_size(path.name, channel)
            sizes, unit = _sizes(path.name, channel, wanted)
            found = channel.topography(physical_sizes=sizes, unit=unit)
            return _arrays(found, units.to_si(f"1 {found.unit}", units.LENGTH))
    except _Refused as refused:
        raise ValueError(str(refused)) from None
    except CannotDetectFileFormat:
        raise ValueError(
            f"{path.name} is of no format that is read here: no text with rows of numbers, and none that SurfaceTopography "
            "opens. Export it as text, or as a .npz with x, y and z in metres."
        ) from None
    # its readers raise any type on damaged files
    except (Exception, CorruptFile) as error:
        reason = next(iter(str(error).splitlines()), "") or type(error).__name__
        raise ValueError(
            f"SurfaceTopography cannot read a height map from {path.name}: {reason[:200]} Export it as text, or as a .npz with "
            "x, y and z in metres."
        ) from None


class _Refused(Exception):
    """A file that is read, but holds no map of heights; its message is shown."""


def _kind(channel: Any) -> str:
    name = str(channel.name).lower()
    return next((word for word in _NO_HEIGHTS if word in name), str(channel.data_kind.value))


def _chosen(name: str, channels: list[Any], index: int | None) -> Any:
    maps = [
        each for each in channels if _kind(each) == "height" and min(each.nb_grid_pts or (0,)) > 1 and each.dim == 2
    ]
    listed = ", ".join(f"{each.index} ({each.name})" for each in maps)
    if index is not None and index >= len(channels):
        raise _Refused(
            f"channel = {index} is not in {name}, which has {len(channels)}. Channels of heights: {listed or 'none'}."
        )
    if index is None and maps:
        return maps[0]
    channel = channels[index or 0]
    if _kind(channel) != "height":
        raise _Refused(
            f"{name}: channel {channel.index}, {channel.name!r}, holds no heights but the kind '{_kind(channel)}'"
            f"{f' in {channel.data_unit}' if channel.data_unit else ''}. Channels of heights: {listed or 'none'}."
        )
    if channel not in maps:
        held = "a line scan" if channel.dim == 1 else "no map of heights"
        raise _Refused(f"{name} holds {held}; a height map is needed. A round tip from a line is RadialProfile.")
    return channel


def _check_size(name: str, channel: Any) -> None:
    """Refuse maps that files with compression unpack to more than can be read."""
    if (size := np.dtype(float).itemsize * math.prod(channel.nb_grid_pts)) > UNPACKED:
        raise _Refused(
            f"{name}: channel {channel.index}, {channel.name!r}, unpacks to {size / 1e6:.4g} MB; at most {UNPACKED / 1e6:g} MB "
            "are read. Cut the map, or export every second row and column."
        )


def _sizes(name: str, channel: Any, wanted: Wanted) -> tuple[tuple[float, ...] | None, str | None]:
    """Lengths in the unit of the channel, and the unit, where the file states none."""
    lacks_size, lacks_unit = channel.physical_sizes is None, channel.unit is None
    try:
        wanted.check_needed(name, spacing=lacks_size, unit=lacks_unit)
        metre = wanted.length(name) if lacks_unit else units.to_si(f"1 {channel.unit}", units.LENGTH)
        step = wanted.distance(name) / metre if lacks_size else 0.0
    except (BadValue, ValueError) as error:
        raise _Refused(str(error)) from None
    return tuple(step * n for n in channel.nb_grid_pts) if lacks_size else None, wanted.unit if lacks_unit else None


def _arrays(topography: Any, metre: float) -> Scan:
    heights: Array = np.ma.filled(np.ma.asarray(topography.heights(), dtype=float), np.nan)
    spacing = metre * np.asarray(topography.physical_sizes) / topography.nb_grid_pts
    x, y = (step * np.arange(count) for step, count in zip(spacing, heights.shape, strict=True))
    return Scan(x, y, metre * heights.T)
