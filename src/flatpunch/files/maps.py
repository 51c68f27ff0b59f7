"""Maps of a rough contact at its last step, for other programs: arrays of NumPy, the gap as heights, points for `vtk`."""

from __future__ import annotations

import io

import numpy as np
import xarray as xr

from flatpunch._support.endings import RESULTS, listed
from flatpunch._support.paths import Plain

NAMES = ("pressure", "gap", "displacement")


def maps_of(result: xr.Dataset) -> xr.Dataset:
    """Pressure, gap and displacement over (y, x) at the last step; ValueError if the result has none."""
    if not {"y", "x"} <= set(result.dims) or not set(NAMES) <= set(result.variables):
        raise ValueError(
            f"this result has no maps, which `rough_contact(..., fields=True)` returns. Write it as {listed(RESULTS)}."
        )
    maps = result[list(NAMES)]
    return (maps.isel(step=-1, drop=True) if "step" in maps.dims else maps).transpose("y", "x")


def arrays(result: xr.Dataset) -> bytes:
    """A .npz file with x (nx,), y (ny,) [m], pressure [Pa], gap and displacement [m], shape (ny, nx)."""
    maps, file = maps_of(result), io.BytesIO()
    named: Plain = {name: maps[name].values for name in ("x", "y", *NAMES)}
    np.savez(file, **named)
    return file.getvalue()


def gap_text(result: xr.Dataset) -> bytes:
    """The gap as a matrix of heights with the head that Gwyddion writes: lengths of the map and units; rows along y."""
    maps, file = maps_of(result), io.StringIO()
    width, height = (float(np.ptp(c)) * c.size / (c.size - 1) for c in (maps["x"].values, maps["y"].values))
    file.write(f"# Channel: gap\n# Width: {width!r} m\n# Height: {height!r} m\n# Value units: m\n")
    # 17 digits read back to the same number
    np.savetxt(file, maps["gap"].values, fmt="%.17g")
    return file.getvalue().encode()


def as_points(result: xr.Dataset) -> xr.Dataset:
    """The maps at points (x, y, z = 0) of the undeformed surface, in the form of `fields`."""
    maps = maps_of(result)
    x, y = np.meshgrid(maps["x"].values, maps["y"].values)
    values = {"x": x, "y": y, "z": np.zeros_like(x), **{name: maps[name].values for name in NAMES}}
    return xr.Dataset({name: (("axis_0", "axis_1"), each) for name, each in values.items()})
