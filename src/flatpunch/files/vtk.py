"""Fields and maps of rough contacts as VTK files, for ParaView and other programs: .vtu by meshio, .vts by pyvista.

Coordinates and components are those of the result: z into the material, tension positive.
"""

from __future__ import annotations

import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch._support.endings import FIELDS
from flatpunch.files.maps import as_points

if TYPE_CHECKING:
    import xarray as xr

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
