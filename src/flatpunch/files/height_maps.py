"""Tips and rough surfaces from measured maps of heights."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from flatpunch._support.checks import Array, instance, one_of, positive, switch, whole
from flatpunch._support.prefixes import text
from flatpunch._support.reading import Unreadable, as_path, check_archive, is_file, shown_path
from flatpunch.files import units
from flatpunch.files.scans import Scan, Wanted, numbers_of, read_channel
from flatpunch.indenters import HeightMap
from flatpunch.surfaces import Topography
from flatpunch.surfaces.heights import interpolated, on_square_cells, plane


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
    spacing: float | None = None,
    unit: str | None = None,
) -> HeightMap:
    """Read a height map as an indenter.

    Parameters
    ----------
    path : str or Path
        `.npz` with the arrays x (nx,), y (ny,) and z (ny, nx) in metres; a matrix of heights as `.npy` or text, rows along y;
        a text of columns x, y, z with units in their heads, `X [um]  Y [um]  Z [nm]`; or any file that SurfaceTopography opens
        (gwy, nc, opd, sdf, spm, top, x3p, ...), which needs `pip install flatpunch[topography]`. Where the file has no
        coordinates, x and y start at zero in one corner of the scan.
    apex, level, smoothing, near, reach
        As for `HeightMap`; lengths in metres.
    channel : int, optional
        Which channel of the file, counted from 0; the first one that holds heights if not given. Channels of anything else,
        such as phase or deflection, are refused.
    height_scale : float
        Factor on the heights, > 0, where the file's calibration is off.
    spacing : float, optional
        Distance of neighbouring points [m], > 0, where the file does not state it.
    unit : str, optional
        Unit of the lengths of the file, such as "nm", where the file does not state it.

    Raises
    ------
    ValueError
        If the file is not readable, is no map of heights, or does not state a unit or distance that is not given either.
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
    x, y, z = _scan(path, channel, spacing, unit)
    z = z * positive("height_scale", height_scale, unit="1")
    return HeightMap(x, y, z, apex=apex, level=level, smoothing=smoothing, near=near, reach=reach)


def read_topography(
    path: str | Path,
    *,
    periodic: bool | tuple[bool, bool] = True,
    peaks: Literal["highest", "lowest"] = "highest",
    level: bool = False,
    fill: bool = False,
    resample: bool = False,
    channel: int | None = None,
    height_scale: float = 1.0,
    spacing: float | None = None,
    unit: str | None = None,
) -> Topography:
    """Read a measured surface.

    Parameters
    ----------
    path : str or Path
        As for `read_height_map`; the points must be evenly spaced, equally along x and y, unless `resample` is given.
    periodic
        As for `Topography`.
    peaks : "highest" or "lowest"
        Which end of the heights points towards the elastic body: the highest points of a scan, or the lowest of a replica.
    level : bool
        Subtract the plane that fits the whole map best: the tilt of the mount.
    fill : bool
        Interpolate missing heights linearly between the points around them; those at the border take the nearest height.
    resample : bool
        Interpolate the heights by bicubic splines on square cells of the smaller distance of points.
    channel, height_scale, spacing, unit
        As for `read_height_map`.

    Raises
    ------
    ValueError
        If the file is not readable, is no map of heights, or does not state a unit or distance that is not given either; without
        `fill` and `resample`, if heights are missing or the points are not square cells.
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
    level, fill, resample = switch("level", level), switch("fill", fill), switch("resample", resample)
    scale = positive("height_scale", height_scale, unit="1")
    sign = 1 if one_of("peaks", peaks, ("highest", "lowest")) == "highest" else -1
    name = as_path("path", path).name
    scan = _ascending(name, _scan(path, channel, spacing, unit))
    if np.isnan(scan.z).any():
        scan = _filled(name, scan, fill=fill)
    if level:
        scan = scan._replace(z=scan.z - plane(*scan))
    heights, side = on_square_cells(*scan) if resample else _square(name, scan)
    return Topography(sign * scale * heights, side, periodic)


def _scan(path: str | Path, channel: int | None, spacing: float | None, unit: str | None) -> Scan:
    """The map of a file of any format."""
    path = as_path("path", path)
    if channel is not None:
        channel = whole("channel", channel, 0, "It is counted from 0.")
    if spacing is not None:
        spacing = positive("spacing", spacing, "It is the distance of two points.", unit="m")
    if unit is not None:
        instance("unit", unit, (str,), "a text such as 'nm'")
        units.named_si("unit", f"1 {unit}", units.LENGTH)
    if not is_file(path):
        raise ValueError(f"{shown_path(path)} is no file; the height map is read from there.")
    wanted = Wanted(channel, spacing, unit)
    try:
        check_archive(path)
        return numbers_of(path, wanted) or read_channel(path, wanted)
    except Unreadable as error:
        raise ValueError(f"{shown_path(path)} is {error}.") from None


def _ascending(name: str, scan: Scan) -> Scan:
    """The map with ascending coordinates, and missing heights as NaN."""
    x, y, z = scan
    if z.shape != (y.size, x.size) or min(z.shape) < 2:
        raise ValueError(
            f"{name} has heights of shape {z.shape} for {y.size} values of y and {x.size} of x; it must be (ny, nx)."
        )
    columns, rows = np.argsort(x), np.argsort(y)
    if not all((np.diff(np.sort(axis)) > 0).all() for axis in (x, y)):
        raise ValueError(f"{name} has equal or missing coordinates; those of a map increase or decrease strictly.")
    z = z[np.ix_(rows, columns)]
    return Scan(x[columns], y[rows], np.where(np.isfinite(z), z, np.nan))


def _filled(name: str, scan: Scan, *, fill: bool) -> Scan:
    missing = np.isnan(scan.z)
    if not fill or missing.all():
        j, i = np.argwhere(missing)[0]
        raise ValueError(
            f"{name} has {int(missing.sum())} missing heights of {missing.size}, the first in row {j}, column {i}. fill=True "
            "interpolates them between the points around; or cut the map to where it was measured."
        )
    return scan._replace(z=interpolated(*scan))


def _square(name: str, scan: Scan) -> tuple[Array, float]:
    """Heights and distance of points that are square cells already."""
    steps = np.concatenate([np.diff(scan.x), np.diff(scan.y)])
    side = float(steps.mean())
    # coordinates of instruments are rounded
    if np.ptp(steps) > 1e-3 * side:
        raise ValueError(
            f"{name} has points between {text(float(steps.min()), 'm')} and {text(float(steps.max()), 'm')} apart; a topography "
            "has square cells. resample=True interpolates them."
        )
    return scan.z, side
