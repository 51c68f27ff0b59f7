"""Results for other programs: maps of a rough contact as arrays of NumPy, its gap as heights, fields and maps as VTK files.

Maps are those of the last step. .vtu is written by meshio, .vts by pyvista, for ParaView and other programs. Coordinates and
components are those of the result: z into the material, tension positive.
"""

from __future__ import annotations

import io
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array, Indices
from flatpunch._support.endings import FIELDS, RESULTS, listed
from flatpunch._support.paths import Plain

if TYPE_CHECKING:
    import xarray as xr

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


_TENSOR = (("xx", "xy", "xz"), ("xy", "yy", "yz"), ("xz", "yz", "zz"))


def vtk_bytes(result: xr.Dataset, kind: str) -> bytes:
    """Return what `fields`, or `rough_contact` with fields, returned as the bytes of a file of a kind, ".vtu" or ".vts".

    Unstructured files hold lines, faces or bricks between the points of a grid, and a list of points as such; structured ones a
    grid. ValueError if the result has neither, a structured file is asked for points that are no grid, or the library is not
    installed.
    """
    if "gap" in result.variables:
        result = as_points(result)
    elif not {"x", "y", "z", "stress", "displacement"} <= set(result.variables):
        raise ValueError(f"{kind} files hold fields, as `fields` returns them; this result has no stresses at points.")
    points = np.stack([result[name].values.ravel() for name in "xyz"], axis=1)
    shape = tuple(n for n in result["x"].shape if n > 1)
    gridded = "point" not in result["x"].dims
    data = _point_data(result)
    if kind == ".vts" and not gridded:
        raise ValueError("a .vts file holds a grid of points; give x, y, z that broadcast to one, or write .vtu.")
    check_library(kind)
    # both libraries choose the format by the ending of the file
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"fields{kind}"
        if kind == ".vtu":
            _unstructured(path, points, shape if gridded else (), data)
        else:
            _structured(path, points, shape, data)
        return path.read_bytes()


def check_library(kind: str) -> None:
    """Refuse a kind of file whose library is not installed."""
    if find_spec(FIELDS[kind]) is None:
        raise ValueError(f"{kind} files need {FIELDS[kind]}: pip install 'flatpunch[vtk]'.")


def _point_data(result: xr.Dataset) -> dict[str, Array]:
    """Values at the points: scalars, vectors, and the stress as a tensor of nine components."""
    places = result["x"].dims
    data: dict[str, Array] = {}
    for name, variable in result.data_vars.items():
        if name in ("x", "y", "z") or set(places) - set(variable.dims):
            continue
        if name == "stress":
            parts = [variable.sel(component=one).values.ravel() for row in _TENSOR for one in row]
            data["stress"] = np.stack(parts, axis=1)
            continue
        (*rest,) = (dim for dim in variable.dims if dim not in places)
        values = variable.transpose(*places, *rest).values
        data[str(name)] = values.reshape(int(np.prod(result["x"].shape)), -1)
        if not rest:
            data[str(name)] = data[str(name)][:, 0]
    return data


def _unstructured(path: Path, points: Array, shape: tuple[int, ...], data: dict[str, Array]) -> None:
    import meshio

    meshio.Mesh(points, [_cells(points.shape[0], shape)], point_data=data).write(path)


def _cells(count: int, shape: tuple[int, ...]) -> tuple[str, Indices]:
    """Cells between the points of a grid in their order; single points where there is none."""
    if not shape:
        return "vertex", np.arange(count)[:, None]
    number = np.arange(count).reshape(shape)
    corners = [number]
    # every axis doubles the corners: the second half goes around the other way
    for axis in range(len(shape)):
        low, high = ([np.take(each, ends, axis) for each in corners] for ends in _ends(shape[axis]))
        corners = [*low, *high] if axis != 1 else [*low, *high[::-1]]
    return ("line", "quad", "hexahedron")[len(shape) - 1], np.stack([each.ravel() for each in corners], axis=1)


def _ends(count: int) -> tuple[Indices, Indices]:
    return np.arange(count - 1), np.arange(1, count)


def _structured(path: Path, points: Array, shape: tuple[int, ...], data: dict[str, Array]) -> None:
    import pyvista

    grid: Any = pyvista.StructuredGrid()
    grid.points = points
    # VTK counts the first index fastest
    grid.dimensions = (*shape[::-1], *(1 for _ in range(3 - len(shape))))
    for name, values in data.items():
        grid.point_data[name] = values
    grid.save(path)
