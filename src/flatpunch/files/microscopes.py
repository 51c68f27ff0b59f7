"""Channels of heights in the formats of microscopes, read by the package SurfaceTopography (an optional extra)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, BadValue
from flatpunch.files import units
from flatpunch.files.scans import Scan, Wanted

_NO_HEIGHTS = ("phase", "amplitude", "deflection", "friction", "lateral", "current", "error", "potential")
"""Words in names of channels that hold no heights, though some instruments give them in metres."""


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
    """Kind of a channel, "height" among them."""
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
