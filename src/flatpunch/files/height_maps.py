"""Height maps from files: NumPy archives, and every format that the package SurfaceTopography reads (an optional extra)."""

from __future__ import annotations

import io
import zlib
from pathlib import Path
from typing import Any, Literal
from zipfile import BadZipFile

import numpy as np

from flatpunch._support.checks import Array, positive, whole
from flatpunch._support.kinds import one_of
from flatpunch._support.prefixes import text
from flatpunch._support.reading import UNPACKED, Unreadable, as_path, check_archive, content, is_file, shown_path
from flatpunch.files import units
from flatpunch.indenters import HeightMap
from flatpunch.surfaces import Topography


def read_height_map(
    path: str | Path,
    *,
    apex: Literal["lowest", "highest"] = "lowest",
    level: bool = False,
    smoothing: float = 0.0,
    near: tuple[float, float] | None = None,
    reach: float | Literal["usable"] | None = None,
    channel: int | None = None,
    height_scale: float = 1.0,
) -> HeightMap:
    """Read a height map as an indenter.

    Parameters
    ----------
    path : str or Path
        `.npz` with the arrays x (nx,), y (ny,) and z (ny, nx) in metres, or any file that SurfaceTopography opens (gwy, nc, opd,
        sdf, spm, top, x3p, ...), which needs `pip install flatpunch[topography]`. There x and y start at zero in one corner of
        the scan.
    apex, level, smoothing, near, reach
        As for `HeightMap`; lengths in metres.
    channel : int, optional
        Which channel of the file, counted from 0; its default channel if not given.
    height_scale : float
        Factor on the heights, > 0, where the file's calibration is off.

    Raises
    ------
    ValueError
        If the file is not readable, is no map, or has no length unit.
    ImportError
        If SurfaceTopography is needed and not installed.

    See Also
    --------
    HeightMap : From arrays.

    Examples
    --------
    >>> x = np.linspace(-1e-6, 1e-6, 81)
    >>> np.savez("tip.npz", x=x, y=x, z=(x**2 + 2 * x[:, None] ** 2) / 2e-6)
    >>> tip = fp.read_height_map("tip.npz")
    >>> print(f"{float(tip.height(np.array(0.5e-6), np.array(0.0))) * 1e9:.0f} nm above the apex")
    125 nm above the apex
    """
    path = _checked(path)
    if channel is not None:
        channel = whole("channel", channel, 0, "It is counted from 0.")
    x, y, z = _arrays_of(path, channel)
    z = z * positive("height_scale", height_scale, unit="1")
    return HeightMap(x, y, z, apex=apex, level=level, smoothing=smoothing, near=near, reach=reach)


def read_topography(
    path: str | Path,
    *,
    periodic: bool | tuple[bool, bool] = True,
    peaks: Literal["highest", "lowest"] = "highest",
    channel: int | None = None,
    height_scale: float = 1.0,
) -> Topography:
    """Read a measured surface.

    Parameters
    ----------
    path : str or Path
        As for `read_height_map`; the points must be evenly spaced, equally along x and y.
    periodic
        As for `Topography`.
    peaks : "highest" or "lowest"
        Which end of the heights points towards the elastic body: the highest points of a scan, or the lowest of a replica.
    channel, height_scale
        As for `read_height_map`.

    Raises
    ------
    ValueError
        If the file is not readable, is no map, has no length unit, missing values, or points that are not square cells.
    ImportError
        If SurfaceTopography is needed and not installed.

    See Also
    --------
    Topography : From arrays.
    read_height_map : A tip.

    Examples
    --------
    >>> x = np.linspace(0, 1e-6, 32)
    >>> np.savez("scan.npz", x=x, y=x, z=1e-8 * np.random.default_rng(0).random((32, 32)))
    >>> fp.read_topography("scan.npz").shape
    (32, 32)
    """
    path = _checked(path)
    if channel is not None:
        channel = whole("channel", channel, 0, "It is counted from 0.")
    x, y, z = (np.asarray(each, dtype=float) for each in _arrays_of(path, channel))
    sign = 1 if one_of("peaks", peaks, ("highest", "lowest")) == "highest" else -1
    steps = np.concatenate([np.diff(x), np.diff(y)]) if x.size > 1 and y.size > 1 else np.zeros(1)
    spacing = float(np.abs(steps).mean())
    # coordinates of instruments are rounded
    if not spacing > 0 or np.ptp(np.abs(steps)) > 1e-3 * spacing:
        raise ValueError(
            f"{path.name} has points between {text(float(np.abs(steps).min()), 'm')} and "
            f"{text(float(np.abs(steps).max()), 'm')} apart; a topography has square cells. Resample it first."
        )
    scale = positive("height_scale", height_scale, unit="1")
    return Topography(sign * scale * z, spacing, periodic)


def _checked(path: str | Path) -> Path:
    """The path of a file that is there and no archive of endless size."""
    path = as_path("path", path)
    if not is_file(path):
        raise ValueError(f"{shown_path(path)} is no file; the height map is read from there.")
    try:
        check_archive(path)
    except Unreadable as error:
        raise ValueError(f"{shown_path(path)} is {error}.") from None
    return path


def _arrays_of(path: Path, channel: int | None) -> tuple[Array, Array, Array]:
    return _from_archive(path) if path.suffix.lower() == ".npz" else _from_topography(path, channel)


def _from_archive(path: Path) -> tuple[Array, Array, Array]:
    try:
        # of bytes: from a damaged file NumPy leaves an open one behind
        with np.load(io.BytesIO(content(path, UNPACKED)), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in "xyz" if name in archive}
    # what NumPy, `zipfile` and `zlib` raise on damaged archives: sizes that overflow, unknown kinds of compression
    except (OSError, EOFError, ValueError, MemoryError, ArithmeticError, NotImplementedError, BadZipFile, zlib.error):
        raise ValueError(
            f"{path.name} is no readable NumPy archive; numpy.savez(path, x=x, y=y, z=z) writes one."
        ) from None
    for name in "xyz":
        if name not in arrays:
            raise ValueError(f"{path.name} has no array {name}; it must hold x, y and z in metres.")
    return arrays["x"], arrays["y"], arrays["z"]


def _from_topography(path: Path, channel: int | None) -> tuple[Array, Array, Array]:
    try:
        from SurfaceTopography import open_topography
        from SurfaceTopography.Exceptions import ReadFileError, UnknownFileFormat
    except ImportError:
        raise ImportError(
            f"Reading {path.name} needs the package SurfaceTopography: pip install 'flatpunch[topography]'. Without it a .npz "
            "file with the arrays x, y and z in metres can be read."
        ) from None
    try:
        with open_topography(str(path)) as reader:
            topography = reader.topography() if channel is None else reader.topography(channel_index=channel)
            return _arrays(topography, path.name)
    except _NoHeightMap:
        raise
    except (Exception, ReadFileError, UnknownFileFormat):  # its readers raise any type on damaged files
        raise ValueError(
            f"{path.name} is not readable as a height map: damaged, or of a format that SurfaceTopography does not know. "
            "Export it anew, or as a .npz with x, y and z in metres."
        ) from None


class _NoHeightMap(ValueError):
    """A scan that is readable, but no height map."""


def _arrays(topography: Any, name: str) -> tuple[Array, Array, Array]:
    if topography.dim != 2:
        raise _NoHeightMap(
            f"{name} holds a line scan; a height map is needed. A round tip from a line is RadialProfile."
        )
    if topography.unit is None:
        raise _NoHeightMap(f"{name} does not say in which unit its lengths are; convert it to a .npz in metres.")
    metre = units.to_si(f"1 {topography.unit}", units.LENGTH)
    heights: Array = np.ma.filled(np.ma.asarray(topography.heights(), dtype=float), np.nan)
    spacing = metre * np.asarray(topography.physical_sizes) / topography.nb_grid_pts
    x, y = (step * np.arange(count) for step, count in zip(spacing, heights.shape, strict=True))
    return x, y, metre * heights.T
